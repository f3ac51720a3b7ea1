#include "host-sim/identify/tick_kernel.hpp"

namespace plenum::host::identify {
namespace PLENUM_KERNEL {
namespace {

/// e^x for |x| <= 700, error below 2 units in the last place; a loop over it vectorises, one over the
/// library's does not. x = n ln 2 + f, |f| <= ln 2/2, ln 2 in two parts; e^f by its series to f^13 (Horner);
/// 2^n put into the exponent's bits.
inline double exponential(double x) {
  const double scaled = x * 1.4426950408889634;
  const int whole = static_cast<int>(scaled + (scaled < 0.0 ? -0.5 : 0.5));
  const double n = whole;
  const double f = (x - n * 0.693147180369123816490) - n * 1.90821492927058770002e-10;
  double e = 1.0 / 6227020800.0;
  e = e * f + 1.0 / 479001600.0;
  e = e * f + 1.0 / 39916800.0;
  e = e * f + 1.0 / 3628800.0;
  e = e * f + 1.0 / 362880.0;
  e = e * f + 1.0 / 40320.0;
  e = e * f + 1.0 / 5040.0;
  e = e * f + 1.0 / 720.0;
  e = e * f + 1.0 / 120.0;
  e = e * f + 1.0 / 24.0;
  e = e * f + 1.0 / 6.0;
  e = e * f + 0.5;
  e = e * f + 1.0;
  e = e * f + 1.0;
  const auto exponent = static_cast<unsigned long long>(static_cast<long long>(whole) + 1023);
  return e * __builtin_bit_cast(double, exponent << 52U);
}

/// s, x = r h (into decay_by_r) and, with slopes, their derivatives.
template <bool kRepaired, bool kSlopes>
void steady_and_exponent(const KernelInput& in, std::size_t n, KernelTerms& out) {
  const double c1 = in.shape[0], c2 = in.shape[1], c3 = in.shape[2], c4 = in.shape[3], e5 = in.shape[4],
               d = in.shape[5], e7 = in.shape[6], c8 = in.shape[7], c9 = in.shape[8];
  const double c_b = in.c_b_kPa, c_s = in.c_s_kPa, gamma = in.c_gamma_V, h = in.period_s;
  const double per_volume = in.per_mean_volume_mL, pole = in.pole;
  const double* __restrict u = in.command_V, * __restrict v = in.volume_mL, * __restrict v_rate = in.volume_rate_mL_s;
  double* __restrict s = out.s, * __restrict x = out.decay_by_r;
  double* __restrict s1 = out.by_s[0], * __restrict s2 = out.by_s[1], * __restrict s3 = out.by_s[2], * __restrict s4 = out.by_s[3];
  double* __restrict s5 = out.by_s[4], * __restrict s7 = out.by_s[6], * __restrict s8 = out.by_s[7], * __restrict s9 = out.by_s[8];
  double* __restrict r1 = out.by_r[0], * __restrict r5 = out.by_r[4], * __restrict rd = out.by_r[5], * __restrict r7 = out.by_r[6], * __restrict r8 = out.by_r[7], * __restrict r9 = out.by_r[8];
  for (std::size_t i = 0; i < n; ++i) {
    const double U = u[i] - c1;
    const double U2 = U * U;
    const double cubic = c2 + c3 * U2;
    const double g_root = 1.0 / __builtin_sqrt(cubic * cubic * U2 + 1.0);
    const double k_root = __builtin_sqrt(U2 + gamma * gamma);
    const double k = k_root - gamma + c9 + c8 * U;
    const double w = v[i] * per_volume - 1.0;
    const double inverse = 1.0 / (1.0 + d * w);
    const double s0 = c_b + c_s * cubic * U * g_root;
    double sum = e7 * k + e5 * v_rate[i];
    double per_sum = 0.0;
    if constexpr (kRepaired) {
      const double least = pole * e7 * k;
      sum = sum >= 0.0 ? (sum > least ? sum : least) : (sum < -least ? sum : -least);
      per_sum = 1.0 / sum;
      s[i] = e7 * k * s0 * per_sum;
    } else {
      s[i] = s0 + c4 * v_rate[i];
    }
    const double r = sum * inverse;
    x[i] = r * h;
    if constexpr (kSlopes) {
      const double g_slope = c_s * g_root * g_root * g_root;
      const double gain = e7 * inverse;
      const double k_slope = U / k_root + c8;
      const double by_s0 = kRepaired ? e7 * k * per_sum : 1.0;
      s1[i] = -by_s0 * g_slope * (c2 + 3.0 * c3 * U2);
      s2[i] = by_s0 * g_slope * U;
      s3[i] = by_s0 * g_slope * U * U2;
      if constexpr (kRepaired) {
        const double by_a = (s0 - s[i]) * per_sum;
        s1[i] -= by_a * e7 * k_slope;
        s5[i] = -s[i] * v_rate[i] * per_sum;
        s7[i] = by_a * k;
        s8[i] = by_a * e7 * U;
        s9[i] = by_a * e7;
      } else {
        s4[i] = v_rate[i];
      }
      r1[i] = -gain * k_slope;
      r5[i] = v_rate[i] * inverse;
      rd[i] = -r * w * inverse;
      r7[i] = k * inverse;
      r8[i] = gain * U;
      r9[i] = gain;
    }
  }
}

/// decay, seen, unseen and their slopes from x. kAveraged: the averaging time is not 0.
template <bool kSlopes, bool kAveraged>
void decays(const KernelInput& in, std::size_t n, KernelTerms& out) {
  const double h = in.period_s, share = in.share, least = in.least, greatest = in.greatest;
  double* __restrict x_then_slope = out.decay_by_r, * __restrict decay = out.decay, * __restrict seen = out.seen, * __restrict unseen = out.unseen, * __restrict seen_by_r = out.seen_by_r, * __restrict unseen_by_r = out.unseen_by_r;
  for (std::size_t i = 0; i < n; ++i) {
    const double raw = x_then_slope[i];
    const double above = raw > least ? raw : least;
    const double x = above < greatest ? above : greatest;
    const double slope = x == raw ? h : 0.0;
    const double fall = exponential(-x);
    double mean = 1.0, mean_slope = 0.5;
    if constexpr (kAveraged) {
      // (e^z - 1)/z and its derivative; near 0 by their series.
      const double z = share * x;
      const bool tiny = __builtin_fabs(z) < 1e-3;
      const double growth = exponential(z);
      const double per_z = 1.0 / (tiny ? 1.0 : z);
      const double series = 1.0 + z * (1.0 / 2 + z * (1.0 / 6 + z * (1.0 / 24 + z * (1.0 / 120))));
      const double slope_series = 1.0 / 2 + z * (1.0 / 3 + z * (1.0 / 8 + z * (1.0 / 30)));
      mean = tiny ? series : (growth - 1.0) * per_z;
      mean_slope = tiny ? slope_series : (growth - mean) * per_z;
    }
    const double inverse = 1.0 / mean;
    decay[i] = fall;
    seen[i] = fall * mean;
    unseen[i] = inverse;
    if constexpr (kSlopes) {
      seen_by_r[i] = slope * fall * (share * mean_slope - mean);
      unseen_by_r[i] = -slope * share * mean_slope * inverse * inverse;
      x_then_slope[i] = -slope * fall;
    }
  }
}

template <bool kSlopes>
void terms_of(const KernelInput& in, std::size_t n, KernelTerms& out) {
  if (in.repaired) {
    steady_and_exponent<true, kSlopes>(in, n, out);
  } else {
    steady_and_exponent<false, kSlopes>(in, n, out);
  }
  if (in.share > 0.0) {
    decays<kSlopes, true>(in, n, out);
  } else {
    decays<kSlopes, false>(in, n, out);
  }
}

void terms(const KernelInput& in, std::size_t n, bool slopes, KernelTerms& out) {
  if (slopes) {
    terms_of<true>(in, n, out);
  } else {
    terms_of<false>(in, n, out);
  }
}

double one_step_squares(const KernelTerms& t, const double* __restrict y, std::size_t n) {
  const double* __restrict s = t.s, * __restrict seen = t.seen, * __restrict unseen = t.unseen;
  double sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double start = s[i] + (y[i] - s[i]) * unseen[i];
    const double error = s[i + 1] + (start - s[i + 1]) * seen[i + 1] - y[i + 1];
    sum += error * error;
  }
  return sum;
}

void one_step_gram(const KernelTerms& t, const double* __restrict y, std::size_t n, double* columns,
                   std::size_t stride, double* __restrict gram) {
  // e = s1 + (p - s1) seen1 - y1, p = s0 + (y0 - s0) unseen0; 0: the tick before, 1: this tick.
  double* __restrict by_s1 = columns + 10 * stride, * __restrict by_r1 = columns + 11 * stride, * __restrict by_s0 = columns + 12 * stride, * __restrict by_r0 = columns + 13 * stride, * __restrict error = columns + 9 * stride;
  const double* __restrict s = t.s, * __restrict seen = t.seen, * __restrict unseen = t.unseen, * __restrict seen_by_r = t.seen_by_r, * __restrict unseen_by_r = t.unseen_by_r;
  for (std::size_t i = 0; i < n; ++i) {
    const double s0 = s[i], s1 = s[i + 1], seen1 = seen[i + 1];
    const double start = s0 + (y[i] - s0) * unseen[i];
    error[i] = s1 + (start - s1) * seen1 - y[i + 1];
    by_s1[i] = 1.0 - seen1;
    by_r1[i] = (start - s1) * seen_by_r[i + 1];
    by_s0[i] = seen1 * (1.0 - unseen[i]);
    by_r0[i] = seen1 * (y[i] - s0) * unseen_by_r[i];
  }
  const auto through = [&](const double* __restrict slope, const double* __restrict now,
                           const double* __restrict before, double* __restrict column) {
    for (std::size_t i = 0; i < n; ++i) column[i] = now[i] * slope[i + 1] + before[i] * slope[i];
  };
  for (std::size_t p = 0; p < 9; ++p) {
    const double* __restrict ds = t.by_s[p], * __restrict dr = t.by_r[p];
    double* __restrict column = columns + p * stride;
    if (ds != nullptr && dr != nullptr) {
      for (std::size_t i = 0; i < n; ++i) {
        column[i] = by_s1[i] * ds[i + 1] + by_s0[i] * ds[i] + by_r1[i] * dr[i + 1] + by_r0[i] * dr[i];
      }
    } else if (ds != nullptr) {
      through(ds, by_s1, by_s0, column);
    } else if (dr != nullptr) {
      through(dr, by_r1, by_r0, column);
    } else {
      for (std::size_t i = 0; i < n; ++i) column[i] = 0.0;
    }
  }
  for (std::size_t a = 0; a < 10; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      const double* __restrict left = columns + a * stride, * __restrict right = columns + b * stride;
      double sum = 0.0;
      for (std::size_t i = 0; i < n; ++i) sum += left[i] * right[i];
      gram[a * 10 + b] += sum;
    }
  }
}

}  // namespace

extern const Kernel kTickKernel;
const Kernel kTickKernel{terms, one_step_squares, one_step_gram};

}  // namespace PLENUM_KERNEL
}  // namespace plenum::host::identify
