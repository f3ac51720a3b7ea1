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

/// Means over whole blocks of the rows first .. last - 1, less the mean of all of these.
Eigen::VectorXd block_means(const std::vector<double>& values, std::size_t first, std::size_t last,
                            std::size_t block) {
  Eigen::VectorXd means(static_cast<Eigen::Index>((last - first) / block));
  auto at = values.begin() + static_cast<std::ptrdiff_t>(first);
  for (double& mean : means) {
    const auto end = at + static_cast<std::ptrdiff_t>(block);
    mean = std::accumulate(at, end, 0.0) / static_cast<double>(block);
    at = end;
  }
  if (means.size() > 0) means.array() -= means.mean();
  return means;
}

double squares_left(const Eigen::MatrixXd& by, const Eigen::VectorXd& of) {
  return (of - by * by.colPivHouseholderQr().solve(of)).squaredNorm();
}

struct Prediction {
  double part = 0.0;      ///< of the command in it: chi-square of 2 degrees of freedom for none
  double left_kPa = 0.0;  ///< RMS of its errors
};
Prediction predict_blocks(const Ticks& ticks, std::size_t block) {
  std::vector<std::array<double, 4>> rows;  // Y_(b+1), Y_b, U_b, U_(b-1)
  for (std::size_t log = 0; log + 1 < ticks.begin.size(); ++log) {
    const std::size_t first = ticks.begin[log];
    const std::size_t last = ticks.begin[log + 1];
    const Eigen::VectorXd y = block_means(ticks.pressure_kPa, first, last, block);
    const Eigen::VectorXd u = block_means(ticks.command_V, first, last, block);
    for (Eigen::Index b = 1; b + 1 < y.size(); ++b) rows.push_back({y[b + 1], y[b], u[b], u[b - 1]});
  }
  if (rows.size() < kFewestBlocks + ticks.begin.size()) return {};
  const auto count = static_cast<Eigen::Index>(rows.size());
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;
  const Eigen::Map<const Rows> table(rows.front().data(), count, 4);
  const double without = squares_left(table.middleCols(1, 1), table.col(0));
  const double with = squares_left(table.rightCols(3), table.col(0));
  const double freedom = static_cast<double>(rows.size()) - 3.0 - static_cast<double>(ticks.begin.size() - 1);
  return {freedom * (without - with) / std::max(with, 1e-300),
          std::sqrt(with / static_cast<double>(rows.size()))};
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
