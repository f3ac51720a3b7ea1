#include "host-sim/identify/squares.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <vector>

#include "host-sim/identify/tick_kernel.hpp"

namespace plenum::host::identify {

namespace any_machine {
extern const Kernel kTickKernel;
}
#ifdef __x86_64__
namespace x86_64_v3 {
extern const Kernel kTickKernel;
}
#endif

const Kernel& kernel() {
#ifdef __x86_64__
  static const bool v3 = __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0 &&
                         __builtin_cpu_supports("bmi2") != 0;
  if (v3) return x86_64_v3::kTickKernel;
#endif
  return any_machine::kTickKernel;
}

namespace {

constexpr std::size_t kBlock =
    256;  ///< ticks of one pass over the one-step error: its terms stay in the first cache

/// Room for the terms of `most` ticks, and beyond them for the columns of a one-step block.
class Workspace {
 public:
  Workspace(std::size_t most, Form form) : most_(most), room_((kTerms + kColumns) * most) {
    double* next = room_.data();
    const auto take = [&] {
      double* const taken = next;
      next += most_;
      return taken;
    };
    for (double** array : {&terms_.s, &terms_.decay, &terms_.seen, &terms_.unseen, &terms_.decay_by_r,
                           &terms_.seen_by_r, &terms_.unseen_by_r}) {
      *array = take();
    }
    constexpr int kPlaces = static_cast<int>(kFree);
    for (int place = 0; place < kPlaces; ++place)
      if (in_s(form == Form::repaired, place)) terms_.by_s[place] = take();
    for (int place = 0; place < kPlaces; ++place)
      if (in_r(place)) terms_.by_r[place] = take();
    columns_ = next;
  }

  const KernelTerms& fill(const Shape& q, const Bench& bench, std::size_t first, std::size_t n, bool slopes) {
    const Ticks& ticks = *bench.ticks;
    KernelInput in{};
    in.command_V = ticks.command_V.data() + first;
    in.volume_mL = ticks.volume_mL.data() + first;
    in.volume_rate_mL_s = ticks.volume_rate_mL_s.data() + first;
    std::copy(q.begin(), q.end(), std::begin(in.shape));
    in.c_b_kPa = 0.5 * (bench.supply_kPa + bench.ambient_kPa);
    in.c_s_kPa = 0.5 * (bench.supply_kPa - bench.ambient_kPa);
    in.c_gamma_V = bench.c_gamma_V;
    in.period_s = ticks.period_s;
    in.share = ticks.average_s / ticks.period_s;
    in.per_mean_volume_mL = 1.0 / bench.mean_volume_mL;
    in.least = kLeastExponent;
    in.greatest = kGreatestExponent;
    in.pole = kPole;
    in.repaired = bench.form == Form::repaired;
    kernel().terms(in, n, slopes, terms_);
    return terms_;
  }

  double* columns() { return columns_; }
  std::size_t stride() const { return most_; }

 private:
  static constexpr std::size_t kTerms = 20;
  static constexpr std::size_t kColumns = 14;
  std::size_t most_;
  std::vector<double> room_;
  KernelTerms terms_{};
  double* columns_ = nullptr;
};

/// Calls visit(first, n): runs of n ticks within one log, all their commands known.
template <typename Visit>
void for_each_run(const Ticks& ticks, std::size_t longest, Visit visit) {
  for (std::size_t log = 0; log + 1 < ticks.begin.size(); ++log) {
    const std::size_t last = ticks.begin[log + 1] - 1;  // the tick of the last row ends in no sample
    for (std::size_t first = ticks.begin[log] + ticks.unknown; first < last; first += longest) {
      visit(first, std::min(longest, last - first));
    }
  }
}

template <typename Visit>
void for_each_one_step(const Bench& bench, Visit visit) {
  std::size_t block = 0;
  for_each_run(*bench.ticks, kBlock, [&](std::size_t first, std::size_t n) {
    if (block++ % bench.every != 0) return;
    // The first tick of a log that is known has none before it: its sample starts the second.
    const auto& begin = bench.ticks->begin;
    const std::size_t skip =
        std::binary_search(begin.begin(), begin.end(), first - bench.ticks->unknown) ? 1 : 0;
    if (n > skip) visit(first + skip, n - skip);
  });
}

double one_step_squares(const Shape& shape, const Bench& bench) {
  Workspace workspace(kBlock + 1, bench.form);
  double sum = 0.0;
  for_each_one_step(bench, [&](std::size_t first, std::size_t n) {
    const KernelTerms& terms = workspace.fill(shape, bench, first - 1, n + 1, false);
    sum += kernel().one_step_squares(terms, bench.ticks->pressure_kPa.data() + first, n);
  });
  return sum;
}

Gram one_step_gram(const Shape& shape, const Bench& bench) {
  Workspace workspace(kBlock + 1, bench.form);
  Eigen::Matrix<double, kFree + 1, kFree + 1, Eigen::RowMajor> lower;
  lower.setZero();
  for_each_one_step(bench, [&](std::size_t first, std::size_t n) {
    const KernelTerms& terms = workspace.fill(shape, bench, first - 1, n + 1, true);
    kernel().one_step_gram(terms, bench.ticks->pressure_kPa.data() + first, n, workspace.columns(),
                           workspace.stride(), lower.data());
  });
  return lower.selfadjointView<Eigen::Lower>();
}

/// The initial pressure of a stretch that fits its samples best. The prediction is offset + influence p0.
double best_start_kPa(const KernelTerms& t, const double* next, std::size_t n) {
  double offset = 0.0, influence = 1.0, along = 0.0, square = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double seen = influence * t.seen[i];
    along += seen * (next[i] - (t.s[i] + (offset - t.s[i]) * t.seen[i]));
    square += seen * seen;
    offset = t.s[i] + (offset - t.s[i]) * t.decay[i];
    influence *= t.decay[i];
  }
  return along / square;
}

double free_run_squares(const Shape& shape, const Bench& bench) {
  Workspace workspace(bench.stretch, bench.form);
  double sum = 0.0;
  for_each_run(*bench.ticks, bench.stretch, [&](std::size_t first, std::size_t n) {
    const KernelTerms& t = workspace.fill(shape, bench, first, n, false);
    const double* next = bench.ticks->pressure_kPa.data() + first + 1;
    double p = best_start_kPa(t, next, n);
    for (std::size_t i = 0; i < n; ++i) {
      const double error = t.s[i] + (p - t.s[i]) * t.seen[i] - next[i];
      sum += error * error;
      p = t.s[i] + (p - t.s[i]) * t.decay[i];
    }
  });
  return sum;
}

Gram free_run_gram(const Shape& shape, const Bench& bench) {
  constexpr Eigen::Index kStart = kFree + 1;  // column of d y/d p0
  Workspace workspace(bench.stretch, bench.form);
  Eigen::Matrix<double, kFree + 2, Eigen::Dynamic> block(kFree + 2, static_cast<Eigen::Index>(bench.stretch));
  const std::vector<double> none(bench.stretch, 0.0);  // slopes by what a term does not depend on
  Gram sum = Gram::Zero();
  for_each_run(*bench.ticks, bench.stretch, [&](std::size_t first, std::size_t n) {
    const KernelTerms& t = workspace.fill(shape, bench, first, n, true);
    std::array<const double*, kFree> s, r;
    for (std::size_t place = 0; place < kFree; ++place) {
      s[place] = t.by_s[place] != nullptr ? t.by_s[place] : none.data();
      r[place] = t.by_r[place] != nullptr ? t.by_r[place] : none.data();
    }
    const double* next = bench.ticks->pressure_kPa.data() + first + 1;
    double p = best_start_kPa(t, next, n);
    double influence = 1.0;
    Eigen::Array<double, kFree, 1> slope = Eigen::Array<double, kFree, 1>::Zero();  // dp by shape
    for (std::size_t i = 0; i < n; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const double away = p - t.s[i];
      Eigen::Array<double, kFree, 1> ds, dr;
      ds << s[0][i], s[1][i], s[2][i], s[3][i], s[4][i], s[5][i], s[6][i], s[7][i], s[8][i];
      dr << r[0][i], r[1][i], r[2][i], r[3][i], r[4][i], r[5][i], r[6][i], r[7][i], r[8][i];
      block.col(k).head<kFree>() =
          ((1.0 - t.seen[i]) * ds + t.seen[i] * slope + (away * t.seen_by_r[i]) * dr).matrix();
      block(kFree, k) = t.s[i] + away * t.seen[i] - next[i];
      block(kStart, k) = influence * t.seen[i];
      slope = (1.0 - t.decay[i]) * ds + t.decay[i] * slope + (away * t.decay_by_r[i]) * dr;
      influence *= t.decay[i];
      p = t.s[i] + away * t.decay[i];
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
  model.form = bench.form;
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
