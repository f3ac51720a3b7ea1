#include "host-sim/identify/squares.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace plenum::host::identify {
namespace {

constexpr std::size_t kBlock =
    256;  ///< ticks of one pass over the one-step error: its terms stay in the first cache

using Row = Eigen::ArrayXd;

/// s, r and what follows from them for a run of ticks, one array a quantity so that the loops vectorise.
///   p_end = s + (p - s) decay,   y = s + (p - s) seen,   p_end = s + (y - s) unseen
struct Terms {
  explicit Terms(std::size_t most)
      : by_s(static_cast<Eigen::Index>(most), 4), by_r(static_cast<Eigen::Index>(most), 6) {
    for (Row* row : {&s, &decay, &seen, &unseen, &decay_by_r, &seen_by_r, &unseen_by_r}) {
      row->resize(static_cast<Eigen::Index>(most));
    }
  }
  Row s;
  Row decay, seen, unseen;
  Row decay_by_r, seen_by_r, unseen_by_r;
  Eigen::ArrayXXd by_s;  ///< ds by c1, c2, c3, c4
  Eigen::ArrayXXd by_r;  ///< dr by c1, e5, d, e7, c8, c9
};

/// Columns of by_s and by_r in the order of Shape; -1: no dependence.
constexpr std::array<int, kFree> kColumnOfS{0, 1, 2, 3, -1, -1, -1, -1, -1};
constexpr std::array<int, kFree> kColumnOfR{0, -1, -1, -1, 1, 2, 3, 4, 5};

using Chunk = Eigen::Map<const Eigen::ArrayXd>;

Chunk chunk(const std::vector<double>& values, std::size_t first, std::size_t n) {
  return {values.data() + first, static_cast<Eigen::Index>(n)};
}

template <bool kWithSlopes>
void evaluate(const Shape& q, const Bench& bench, std::size_t first, std::size_t n, Terms& out) {
  const Ticks& ticks = *bench.ticks;
  const double c_b = 0.5 * (bench.supply_kPa + bench.ambient_kPa);
  const double c_s = 0.5 * (bench.supply_kPa - bench.ambient_kPa);
  const double gamma = bench.c_gamma_V;
  const double h = ticks.period_s;
  const double share = ticks.average_s / h;
  const double by_mean = 1.0 / bench.mean_volume_mL;
  const double* u = ticks.command_V.data() + first;
  const double* v = ticks.volume_mL.data() + first;
  const double* v_rate = ticks.volume_rate_mL_s.data() + first;
  const double c1 = q[0], c2 = q[1], c3 = q[2], c4 = q[3], e5 = q[4], d = q[5], e7 = q[6], c8 = q[7],
               c9 = q[8];
  const auto count = static_cast<Eigen::Index>(n);
  double* x = out.decay_by_r.data();  // r h for now
  double* s = out.s.data();
  for (std::size_t i = 0; i < n; ++i) {
    const double U = u[i] - c1;
    const double cubic = c2 + c3 * U * U;
    const double g_root = 1.0 / std::sqrt(cubic * cubic * U * U + 1.0);
    const double k_root = std::sqrt(U * U + gamma * gamma);
    const double k = k_root - gamma + c9 + c8 * U;
    const double w = v[i] * by_mean - 1.0;
    const double inverse = 1.0 / (1.0 + d * w);
    const double r = (e7 * k + e5 * v_rate[i]) * inverse;
    s[i] = c_b + c_s * cubic * U * g_root + c4 * v_rate[i];
    x[i] = r * h;
    if constexpr (kWithSlopes) {
      const double g_slope = c_s * g_root * g_root * g_root;
      const auto row = static_cast<Eigen::Index>(i);
      out.by_s.coeffRef(row, 0) = -g_slope * (c2 + 3.0 * c3 * U * U);
      out.by_s.coeffRef(row, 1) = g_slope * U;
      out.by_s.coeffRef(row, 2) = g_slope * U * U * U;
      out.by_s.coeffRef(row, 3) = v_rate[i];
      const double gain = e7 * inverse;
      out.by_r.coeffRef(row, 0) = -gain * (U / k_root + c8);
      out.by_r.coeffRef(row, 1) = v_rate[i] * inverse;
      out.by_r.coeffRef(row, 2) = -r * w * inverse;
      out.by_r.coeffRef(row, 3) = k * inverse;
      out.by_r.coeffRef(row, 4) = gain * U;
      out.by_r.coeffRef(row, 5) = gain;
    }
  }
  const auto limited = out.decay_by_r.head(count).max(kLeastExponent).min(kGreatestExponent).eval();
  out.decay.head(count) = (-limited).exp();
  const double* decay = out.decay.data();
  const Row shared_decay = share == 0.0 || share == 1.0 ? Row() : Row((-share * limited).exp());
  const double* partial = share == 1.0 ? decay : shared_decay.data();
  for (std::size_t i = 0; i < n; ++i) {
    // mean = (e^z - 1)/z with z = r a, its inverse, and the slopes of both; near 0 by their series.
    const double z = share * limited[static_cast<Eigen::Index>(i)];
    const bool inside = x[i] > kLeastExponent && x[i] < kGreatestExponent;
    const double slope_h = inside ? h : 0.0;
    double mean = 1.0, inverse = 1.0, mean_slope = 0.5;
    if (share > 0.0) {
      const bool tiny = std::abs(z) < 1e-5;
      const double z_safe = tiny ? 1.0 : z;
      const double growth = 1.0 / partial[i];
      mean = tiny ? 1.0 + 0.5 * z : (growth - 1.0) / z_safe;
      mean_slope = tiny ? 0.5 + z / 3.0 : (growth - mean) / z_safe;
      inverse = 1.0 / mean;
    }
    out.seen.data()[i] = decay[i] * mean;
    out.unseen.data()[i] = inverse;
    if constexpr (kWithSlopes) {
      out.seen_by_r.data()[i] = slope_h * decay[i] * (share * mean_slope - mean);
      out.unseen_by_r.data()[i] = -slope_h * share * mean_slope * inverse * inverse;
      out.decay_by_r.data()[i] = -slope_h * decay[i];
    }
  }
}

/// Calls visit(first, n): runs of n ticks within one log.
template <typename Visit>
void for_each_run(const Ticks& ticks, std::size_t longest, Visit visit) {
  for (std::size_t log = 0; log + 1 < ticks.begin.size(); ++log) {
    const std::size_t last = ticks.begin[log + 1] - 1;  // the tick of the last row ends in no sample
    for (std::size_t first = ticks.begin[log]; first < last; first += longest) {
      visit(first, std::min(longest, last - first));
    }
  }
}

/// One-step errors of a run whose terms start one tick before it: p(t_i) from y_i by tick i-1, y_(i+1) by
/// tick i.
struct OneStep {
  const Terms& t;
  Chunk y;     ///< y_i
  Chunk next;  ///< y_(i+1)
  Eigen::Index n;

  auto before(const Row& row) const { return row.head(n); }
  auto now(const Row& row) const { return row.segment(1, n); }
  Row start_kPa() const { return before(t.s) + (y - before(t.s)) * before(t.unseen); }
  Row error(const Row& start) const { return now(t.s) + (start - now(t.s)) * now(t.seen) - next; }
};

template <typename Visit>
void for_each_one_step(const Bench& bench, Visit visit) {
  std::size_t block = 0;
  for_each_run(*bench.ticks, kBlock, [&](std::size_t first, std::size_t n) {
    if (block++ % bench.every != 0) return;
    // The first tick of a log has none before it: its sample starts the second.
    const auto& begin = bench.ticks->begin;
    const std::size_t skip = std::binary_search(begin.begin(), begin.end(), first) ? 1 : 0;
    if (n > skip) visit(first + skip, n - skip);
  });
}

double one_step_squares(const Shape& shape, const Bench& bench) {
  Terms terms(kBlock + 1);
  double sum = 0.0;
  for_each_one_step(bench, [&](std::size_t first, std::size_t n) {
    evaluate<false>(shape, bench, first - 1, n + 1, terms);
    const OneStep errors{terms, chunk(bench.ticks->pressure_kPa, first, n),
                         chunk(bench.ticks->pressure_kPa, first + 1, n), static_cast<Eigen::Index>(n)};
    sum += errors.error(errors.start_kPa()).square().sum();
  });
  return sum;
}

Gram one_step_gram(const Shape& shape, const Bench& bench) {
  Terms t(kBlock + 1);
  Eigen::Matrix<double, Eigen::Dynamic, kFree + 1> block(static_cast<Eigen::Index>(kBlock), kFree + 1);
  Gram sum = Gram::Zero();
  for_each_one_step(bench, [&](std::size_t first, std::size_t ticks) {
    evaluate<true>(shape, bench, first - 1, ticks + 1, t);
    const auto n = static_cast<Eigen::Index>(ticks);
    const OneStep errors{t, chunk(bench.ticks->pressure_kPa, first, ticks),
                         chunk(bench.ticks->pressure_kPa, first + 1, ticks), n};
    const Row start = errors.start_kPa();
    const Row by_s = 1.0 - errors.now(t.seen);
    const Row by_r = (start - errors.now(t.s)) * errors.now(t.seen_by_r);
    const Row by_s_before = errors.now(t.seen) * (1.0 - errors.before(t.unseen));
    const Row by_r_before =
        errors.now(t.seen) * (errors.y - errors.before(t.s)) * errors.before(t.unseen_by_r);
    for (std::size_t p = 0; p < kFree; ++p) {
      auto column = block.col(static_cast<Eigen::Index>(p)).head(n).array();
      if (kColumnOfS[p] >= 0) {
        const auto ds = t.by_s.col(kColumnOfS[p]);
        column = by_s * ds.segment(1, n) + by_s_before * ds.head(n);
      } else {
        column.setZero();
      }
      if (kColumnOfR[p] >= 0) {
        const auto dr = t.by_r.col(kColumnOfR[p]);
        column += by_r * dr.segment(1, n) + by_r_before * dr.head(n);
      }
    }
    block.col(kFree).head(n) = errors.error(start).matrix();
    sum.noalias() += block.topRows(n).transpose() * block.topRows(n);
  });
  return sum;
}

/// The initial pressure of a stretch that fits its samples best. The prediction is offset + influence p0.
double best_start_kPa(const Terms& t, Chunk next, std::size_t n) {
  double offset = 0.0, influence = 1.0, along = 0.0, square = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double seen = influence * t.seen[k];
    along += seen * (next[k] - (t.s[k] + (offset - t.s[k]) * t.seen[k]));
    square += seen * seen;
    offset = t.s[k] + (offset - t.s[k]) * t.decay[k];
    influence *= t.decay[k];
  }
  return along / square;
}

double free_run_squares(const Shape& shape, const Bench& bench) {
  Terms t(bench.stretch);
  double sum = 0.0;
  for_each_run(*bench.ticks, bench.stretch, [&](std::size_t first, std::size_t n) {
    evaluate<false>(shape, bench, first, n, t);
    const Chunk next = chunk(bench.ticks->pressure_kPa, first + 1, n);
    double p = best_start_kPa(t, next, n);
    for (std::size_t i = 0; i < n; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const double error = t.s[k] + (p - t.s[k]) * t.seen[k] - next[k];
      sum += error * error;
      p = t.s[k] + (p - t.s[k]) * t.decay[k];
    }
  });
  return sum;
}

Gram free_run_gram(const Shape& shape, const Bench& bench) {
  constexpr Eigen::Index kStart = kFree + 1;  // column of d y/d p0
  Terms t(bench.stretch);
  Eigen::Matrix<double, kFree + 2, Eigen::Dynamic> block(kFree + 2, static_cast<Eigen::Index>(bench.stretch));
  Gram sum = Gram::Zero();
  for_each_run(*bench.ticks, bench.stretch, [&](std::size_t first, std::size_t n) {
    evaluate<true>(shape, bench, first, n, t);
    const Chunk next = chunk(bench.ticks->pressure_kPa, first + 1, n);
    double p = best_start_kPa(t, next, n);
    double influence = 1.0;
    Eigen::Array<double, kFree, 1> slope = Eigen::Array<double, kFree, 1>::Zero();  // dp by shape
    for (std::size_t i = 0; i < n; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const double away = p - t.s[k];
      Eigen::Array<double, kFree, 1> ds, dr;
      ds << t.by_s(k, 0), t.by_s(k, 1), t.by_s(k, 2), t.by_s(k, 3), 0, 0, 0, 0, 0;
      dr << t.by_r(k, 0), 0, 0, 0, t.by_r(k, 1), t.by_r(k, 2), t.by_r(k, 3), t.by_r(k, 4), t.by_r(k, 5);
      block.col(k).head<kFree>() =
          ((1.0 - t.seen[k]) * ds + t.seen[k] * slope + (away * t.seen_by_r[k]) * dr).matrix();
      block(kFree, k) = t.s[k] + away * t.seen[k] - next[k];
      block(kStart, k) = influence * t.seen[k];
      slope = (1.0 - t.decay[k]) * ds + t.decay[k] * slope + (away * t.decay_by_r[k]) * dr;
      influence *= t.decay[k];
      p = t.s[k] + away * t.decay[k];
    }
    const auto used = block.leftCols(static_cast<Eigen::Index>(n));
    const Eigen::Matrix<double, kFree + 2, kFree + 2> full = used * used.transpose();
    // What a shift of p0 can explain is taken out: the errors are then those left over by the best p0.
    const Eigen::Matrix<double, kFree + 1, 1> along = full.col(kStart).head<kFree + 1>();
    sum += full.topLeftCorner<kFree + 1, kFree + 1>() - along * along.transpose() / full(kStart, kStart);
  });
  return sum;
}

}  // namespace

Shape to_shape(const Tassa9& model, double mean_volume_mL) {
  const auto& c = model.c;
  const double at_mean = 1.0 + c[5] * mean_volume_mL;
  Shape q;
  q << c[0], c[1], c[2], c[3], c[4] / at_mean, c[5] * mean_volume_mL / at_mean, c[6] / at_mean, c[7], c[8];
  return q;
}

Tassa9 to_model(const Shape& q, const Bench& bench) {
  const double at_mean = 1.0 / (1.0 - q[5]);  // 1 + c6 V
  Tassa9 model;
  model.c = {q[0],           q[1], q[2], q[3], q[4] * at_mean, q[5] * at_mean / bench.mean_volume_mL,
             q[6] * at_mean, q[7], q[8]};
  model.c_gamma_V = bench.c_gamma_V;
  model.supply_kPa = bench.supply_kPa;
  model.ambient_kPa = bench.ambient_kPa;
  return model;
}

Eigen::Matrix<double, kFree, kFree> model_by_shape(const Shape& q, double mean_volume_mL) {
  Eigen::Matrix<double, kFree, kFree> d = Eigen::Matrix<double, kFree, kFree>::Identity();
  const double at_mean = 1.0 / (1.0 - q[5]);
  d(4, 4) = at_mean;
  d(4, 5) = q[4] * at_mean * at_mean;
  d(5, 5) = at_mean * at_mean / mean_volume_mL;
  d(6, 6) = at_mean;
  d(6, 5) = q[6] * at_mean * at_mean;
  return d;
}

Count count_rows(Error error, const Bench& bench) {
  Count count;
  if (error == Error::one_step) {
    for_each_one_step(bench, [&](std::size_t, std::size_t n) { count.rows += n; });
  } else {
    for_each_run(*bench.ticks, bench.stretch, [&](std::size_t, std::size_t n) {
      count.rows += n;
      ++count.eliminated;
    });
  }
  return count;
}

double sum_of_squares(Error error, const Shape& shape, const Bench& bench) {
  return error == Error::one_step ? one_step_squares(shape, bench) : free_run_squares(shape, bench);
}

Gram gram(Error error, const Shape& shape, const Bench& bench) {
  return error == Error::one_step ? one_step_gram(shape, bench) : free_run_gram(shape, bench);
}

}  // namespace plenum::host::identify
