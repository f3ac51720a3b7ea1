#include "host-sim/identify/servo/friction_fit.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify::servo {
namespace {

constexpr double kBar = 1e5;          // columns of order one
constexpr double kMillimetre = 1e-3;  // for a second

double fade(double velocity_m_s, double stribeck_velocity_m_s) {
  return std::copysign(std::exp(-std::abs(velocity_m_s) / stribeck_velocity_m_s), velocity_m_s);
}

}  // namespace

std::vector<SlidingRow> sliding_rows(const PulledRecord& record, const SlidingWindow& window) {
  const std::size_t n = record.time_s.size();
  if (record.position_m.size() != n || record.pressure_Pa.size() != n || record.force_N.size() != n)
    throw std::invalid_argument("pulled record: columns of different lengths, expected equal ones");
  if (n == 0) throw std::invalid_argument("pulled record: no samples, expected some");
  const std::size_t w = window.half_width;
  if (w == 0) throw std::invalid_argument("sliding window: half_width = 0, expected 1 or more");
  std::vector<SlidingRow> rows;
  for (std::size_t i = w; i + w < n; ++i) {
    double mean_t = 0.0;
    bool whole = true;
    for (std::size_t k = i - w; k <= i + w; ++k) {
      mean_t += record.time_s[k];
      whole = whole && (k == i - w || record.time_s[k] - record.time_s[k - 1] <= window.longest_gap_s);
    }
    if (!whole) continue;
    mean_t /= static_cast<double>(2 * w + 1);
    double slope = 0.0;
    double squares = 0.0;
    for (std::size_t k = i - w; k <= i + w; ++k) {
      const double t = record.time_s[k] - mean_t;
      slope += t * record.position_m[k];
      squares += t * t;
    }
    const double v = slope / squares;
    const double x = record.position_m[i];
    if (!std::isfinite(v) || !std::isfinite(record.pressure_Pa[i]) || !std::isfinite(record.force_N[i]))
      throw std::invalid_argument(fmt::format("pulled record: row {} is not finite", i));
    if (std::abs(v) < window.slowest_m_s || x < window.from_m || x > window.to_m) continue;
    rows.push_back({record.time_s[i], x, v, record.pressure_Pa[i], record.force_N[i]});
  }
  return rows;
}

std::vector<SlidingRow> gathered(std::span<const SlidingRow> rows, double width_m_s, std::size_t least_rows) {
  if (!std::isfinite(width_m_s) || !(width_m_s > 0.0))
    throw std::invalid_argument(fmt::format("gathered rows: width_m_s = {}, expected above 0", width_m_s));
  std::map<long, SlidingRow> sums;
  for (const SlidingRow& row : rows) {
    SlidingRow empty;
    empty.weight = 0.0;
    SlidingRow& sum =
        sums.try_emplace(std::lround(std::floor(row.velocity_m_s / width_m_s)), empty).first->second;
    sum.time_s += row.weight * row.time_s;
    sum.position_m += row.weight * row.position_m;
    sum.velocity_m_s += row.weight * row.velocity_m_s;
    sum.pressure_Pa += row.weight * row.pressure_Pa;
    sum.force_N += row.weight * row.force_N;
    sum.weight += row.weight;
  }
  std::vector<SlidingRow> means;
  for (const auto& [interval, sum] : sums) {
    const double n = sum.weight;
    if (n < static_cast<double>(least_rows)) continue;
    means.push_back(
        {sum.time_s / n, sum.position_m / n, sum.velocity_m_s / n, sum.pressure_Pa / n, sum.force_N / n, n});
  }
  return means;
}

FrictionFit fit_friction(std::span<const std::vector<SlidingRow>> records, const FrictionTerms& terms) {
  if (records.empty()) throw CannotIdentify("friction: no record");
  if (records.size() < 2 && !terms.area_m2)
    throw CannotIdentify(
        "friction: one record, expected two or more pressures to tell area from force zero, or a known area");
  std::size_t count = 0;
  for (std::size_t r = 0; r < records.size(); ++r) {
    if (records[r].empty())
      throw CannotIdentify(fmt::format("friction: record {} has no rows, expected some that slide", r));
    const auto forward = static_cast<std::size_t>(std::count_if(
        records[r].begin(), records[r].end(), [](const SlidingRow& row) { return row.velocity_m_s > 0.0; }));
    if (forward == 0 || forward == records[r].size())
      throw CannotIdentify(fmt::format(
          "friction: record {} slides in one direction only, expected both to tell friction from force zero",
          r));
    count += records[r].size();
  }
  // columns: A [N/bar] unless it is held, F_0, F_c of each record, then F_v [N s/mm] and F_s where they are asked for
  const Eigen::Index zero = terms.area_m2 ? 0 : 1;
  const Eigen::Index coulomb = zero + 1;
  const auto plain = coulomb + static_cast<Eigen::Index>(records.size());
  const Eigen::Index viscous = plain;
  const Eigen::Index stribeck = plain + (terms.viscous ? 1 : 0);
  const Eigen::Index columns = stribeck + (terms.stribeck_velocity_m_s ? 1 : 0);
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(count), columns);
  Eigen::VectorXd y(static_cast<Eigen::Index>(count));
  double samples = 0.0;
  Eigen::Index row = 0;
  for (std::size_t r = 0; r < records.size(); ++r) {
    for (const SlidingRow& slide : records[r]) {
      if (!terms.area_m2) X(row, 0) = slide.pressure_Pa / kBar;
      X(row, zero) = 1.0;
      X(row, coulomb + static_cast<Eigen::Index>(r)) = slide.velocity_m_s > 0.0 ? 1.0 : -1.0;
      if (terms.viscous) X(row, viscous) = slide.velocity_m_s / kMillimetre;
      if (terms.stribeck_velocity_m_s)
        X(row, stribeck) = fade(slide.velocity_m_s, *terms.stribeck_velocity_m_s);
      y[row] = slide.force_N - terms.area_m2.value_or(0.0) * slide.pressure_Pa;
      const double root = std::sqrt(slide.weight);
      X.row(row) *= root;
      y[row++] *= root;
      samples += slide.weight;
    }
  }
  if (!(samples > static_cast<double>(columns)))
    throw CannotIdentify(
        fmt::format("friction: {} samples for {} coefficients, expected more", samples, columns));
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(X);
  qr.setThreshold(1e-9);
  if (qr.rank() < columns)
    throw CannotIdentify(fmt::format(
        "friction: the rows determine {} of {} coefficients; expected different speeds and pressures",
        qr.rank(), columns));
  const Eigen::VectorXd c = qr.solve(y);
  const double squares = (y - X * c).squaredNorm();
  const Eigen::MatrixXd inverse =
      (X.transpose() * X).ldlt().solve(Eigen::MatrixXd::Identity(columns, columns));
  const double variance = squares / (samples - static_cast<double>(columns));
  const auto error = [&](Eigen::Index i) { return std::sqrt(variance * inverse(i, i)); };

  FrictionFit fit;
  fit.area_m2 = terms.area_m2.value_or(c[0] / kBar);
  if (!terms.area_m2) fit.area_error_m2 = error(0) / kBar;
  fit.zero_N = c[zero];
  fit.zero_error_N = error(zero);
  if (terms.viscous) {
    fit.viscous_N_s_m = c[viscous] / kMillimetre;
    fit.viscous_error_N_s_m = error(viscous) / kMillimetre;
  }
  for (Eigen::Index i = coulomb; i < plain; ++i) {
    fit.coulomb_N.push_back(c[i]);
    fit.coulomb_error_N.push_back(error(i));
  }
  if (terms.stribeck_velocity_m_s) {
    fit.stribeck_N = c[stribeck];
    fit.stribeck_error_N = error(stribeck);
    // 1 / (X^T X)^-1 of a column is the square of its part that the other columns do not hold
    fit.stribeck_shape = std::sqrt(1.0 / inverse(stribeck, stribeck)) / X.col(stribeck).norm();
  }
  fit.rms_N = std::sqrt(squares / samples);
  fit.samples = samples;
  return fit;
}

double predicted_force_N(const FrictionFit& fit, std::size_t record, const SlidingRow& row,
                         const FrictionTerms& terms) {
  const double direction = row.velocity_m_s > 0.0 ? 1.0 : -1.0;
  const double stribeck = terms.stribeck_velocity_m_s
                              ? fit.stribeck_N * fade(row.velocity_m_s, *terms.stribeck_velocity_m_s)
                              : 0.0;
  return fit.area_m2 * row.pressure_Pa + fit.zero_N + direction * fit.coulomb_N.at(record) + stribeck +
         fit.viscous_N_s_m * row.velocity_m_s;
}

}  // namespace plenum::host::identify::servo
