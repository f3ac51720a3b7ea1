#include "host-sim/identify/excitation.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify {
namespace {

constexpr std::array<std::size_t, 4> kBlocks{1, 5, 25, 125};  // ticks
constexpr std::size_t kFewestBlocks = 20;
/// Chi-square of noise is above it once in 5e8 times; a rate that is known to a seventh is below.
constexpr double kLeastPart = 40.0;
constexpr double kStillCommand_V = 1e-6;
constexpr double kStillPressure_kPa = 1e-9;

struct Range {
  double low = 0.0;
  double high = 0.0;
  bool narrower_than(double width) const { return high - low < width; }
};
Range range_of(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {*low, *high};
}

/// Over whole blocks of the rows first .. last - 1.
Eigen::VectorXd means(const std::vector<double>& values, std::size_t first, std::size_t last,
                      std::size_t block) {
  Eigen::VectorXd made(static_cast<Eigen::Index>((last - first) / block));
  auto at = values.begin() + static_cast<std::ptrdiff_t>(first);
  for (double& mean : made) {
    const auto end = at + static_cast<std::ptrdiff_t>(block);
    mean = std::accumulate(at, end, 0.0) / static_cast<double>(block);
    at = end;
  }
  return made;
}

Eigen::VectorXd centred(Eigen::VectorXd values) {
  if (values.size() > 0) values.array() -= values.mean();
  return values;
}

struct Fitted {
  Eigen::VectorXd by;
  double squares_left = 0.0;
};
Fitted fitted(const Eigen::MatrixXd& columns, const Eigen::VectorXd& to) {
  const Eigen::VectorXd by = columns.colPivHouseholderQr().solve(to);
  return {by, (to - columns * by).squaredNorm()};
}

/// Of an isothermal compression from each block to the next [kPa].
Eigen::VectorXd compressions_kPa(const Ticks& ticks, std::size_t first, std::size_t last, std::size_t block) {
  const Eigen::VectorXd pressure_kPa = means(ticks.pressure_kPa, first, last, block);
  const Eigen::VectorXd volume_mL = means(ticks.volume_mL, first, last, block);
  const Eigen::Index steps = std::max<Eigen::Index>(volume_mL.size() - 1, 0);
  return pressure_kPa.head(steps).array() *
         (volume_mL.head(steps).array() / volume_mL.tail(steps).array() - 1.0);
}

struct Prediction {
  double part = 0.0;      ///< of the command in it: chi-square of 2 degrees of freedom for none
  double left_kPa = 0.0;  ///< RMS of its errors
};
Prediction predict_blocks(const Ticks& ticks, std::size_t block) {
  constexpr Eigen::Index kColumns = 6;
  std::vector<std::array<double, kColumns>> rows;  // Y_(b+1), U_(b-1), U_b, Y_b, K_b, K_(b-1)
  for (std::size_t log = 0; log + 1 < ticks.begin.size(); ++log) {
    const std::size_t first = ticks.begin[log];
    const std::size_t last = ticks.begin[log + 1];
    const Eigen::VectorXd y = centred(means(ticks.pressure_kPa, first, last, block));
    const Eigen::VectorXd u = centred(means(ticks.command_V, first, last, block));
    const Eigen::VectorXd k = centred(compressions_kPa(ticks, first, last, block));
    for (Eigen::Index b = 1; b + 1 < y.size(); ++b) {
      rows.push_back({y[b + 1], u[b - 1], u[b], y[b], k[b], k[b - 1]});
    }
  }
  if (rows.size() < kFewestBlocks + ticks.begin.size()) return {};
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, kColumns, Eigen::RowMajor>;
  const Eigen::Map<const Rows> table(rows.front().data(), static_cast<Eigen::Index>(rows.size()), kColumns);
  Fitted without = fitted(table.rightCols(3), table.col(0));
  const bool compressed = without.by.tail(2).sum() > 0.0;
  if (!compressed) without = fitted(table.middleCols(3, 1), table.col(0));
  const Fitted with = fitted(table.middleCols(1, 2 + without.by.size()), table.col(0));
  const auto count = static_cast<double>(rows.size());
  const double freedom =
      count - static_cast<double>(with.by.size()) - static_cast<double>(ticks.begin.size() - 1);
  return {freedom * (without.squares_left - with.squares_left) / std::max(with.squares_left, 1e-300),
          std::sqrt(with.squares_left / count)};
}

void require_answer(const Ticks& ticks) {
  double noise_kPa = 0.0;
  for (const std::size_t block : kBlocks) {
    const Prediction made = predict_blocks(ticks, block);
    if (made.part > kLeastPart) return;
    if (block == kBlocks.front()) noise_kPa = made.left_kPa;
  }
  const Range pressure_kPa = range_of(ticks.pressure_kPa);
  throw CannotIdentify(fmt::format(
      "no excitation: the pressure, {:.6g} to {:.6g} kPa, does not move with the command beyond its "
      "noise of {:.3g} kPa",
      pressure_kPa.low, pressure_kPa.high, noise_kPa));
}

}  // namespace

void require_excitation(const Ticks& ticks) {
  if (range_of(ticks.command_V).narrower_than(kStillCommand_V)) {
    throw CannotIdentify(
        fmt::format("no excitation: the command is {:.6g} V throughout", ticks.command_V.front()));
  }
  if (range_of(ticks.pressure_kPa).narrower_than(kStillPressure_kPa)) {
    throw CannotIdentify(
        fmt::format("no excitation: the pressure is {:.6g} kPa throughout", ticks.pressure_kPa.front()));
  }
  if (const Range volume_mL = range_of(ticks.volume_mL); !(volume_mL.low > 0.0)) {
    throw CannotIdentify(fmt::format("volume is {:.6g} mL, expected above 0", volume_mL.low));
  }
  require_answer(ticks);
}

}  // namespace plenum::host::identify
