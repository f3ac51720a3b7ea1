// Friction out of a cylinder that a test bench pulls to and fro at a regulated pressure.
//
//   F = A p + F_0 + (F_c + F_s exp(-|v|/v_s)) sgn(v) + F_v v                       (22) without inertia, (23)
//
// F bench force, with the chamber's pressure for it [N]; A effective area [m2]; p gauge pressure [Pa]; F_0
// zero of the force cell [N]; v velocity towards the pressure, positive [m/s]; the rest as in
// plant/servo/friction.hpp. Each record, at its own pressure, has its own F_c; A, F_0, F_v and F_s are
// common.
//
// v is the slope of a straight line through `half_width` samples on each side. Rows count while the piston
// slides: faster than `slowest_m_s` and away from the ends of the stroke, where the bench turns round.
// Each of F_v, F_s may be left out, and A be known (FrictionTerms). What a record must hold: both directions (else F_c
// and F_0 are one); two pressures, unless A is known (else A and F_0 are one). F_s and v_s need speeds from below to well above v_s;
// `stribeck_shape` says how much of the column of F_s the others cannot imitate (1: none, 0: all).
// Source: "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems" (22), (23).
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace plenum::host::identify::servo {

/// One record of the bench, columns of equal length.
struct PulledRecord {
  std::vector<double> time_s;
  std::vector<double> position_m;
  std::vector<double> pressure_Pa;  ///< gauge
  std::vector<double> force_N;
};

struct SlidingWindow {
  std::size_t half_width = 10;  ///< samples on each side
  double longest_gap_s = 0.05;  ///< between two samples; no slope is drawn across a longer one
  double slowest_m_s = 2e-3;
  double from_m = 1e-3;
  double to_m = 35e-3;
};

/// One instant at which the piston slides.
struct SlidingRow {
  double time_s = 0.0;
  double position_m = 0.0;
  double velocity_m_s = 0.0;
  double pressure_Pa = 0.0;
  double force_N = 0.0;
  double weight = 1.0;  ///< how many samples it stands for
};

/// Throws std::invalid_argument when the columns are empty or differ in length, a value is not finite, or
/// half_width is 0.
std::vector<SlidingRow> sliding_rows(const PulledRecord& record, const SlidingWindow& window);

/// The rows of one record gathered by velocity: means of each interval [i, i + 1) `width_m_s` that holds
/// `least_rows` or more, by rising velocity, weighted with their number. Throws std::invalid_argument
/// for a width not above 0.
std::vector<SlidingRow> gathered(std::span<const SlidingRow> rows, double width_m_s, std::size_t least_rows);

struct FrictionFit {
  double area_m2 = 0.0;
  double area_error_m2 =
      0.0;  ///< standard errors, here and below: errors taken as white, so lower bounds; 0 where held
  double zero_N = 0.0;
  double zero_error_N = 0.0;
  std::vector<double> coulomb_N;  ///< F_c of each record
  std::vector<double> coulomb_error_N;
  double viscous_N_s_m = 0.0;
  double viscous_error_N_s_m = 0.0;
  double stribeck_N = 0.0;  ///< 0 where it was not asked for
  double stribeck_error_N = 0.0;
  double stribeck_shape = 0.0;
  double rms_N = 0.0;    ///< of what is left
  double samples = 0.0;  ///< the weights together
};

/// Which terms of (23) are fitted beside F_c; the others are 0. And the area, where it is known.
struct FrictionTerms {
  bool viscous = true;                            ///< F_v
  std::optional<double> stribeck_velocity_m_s{};  ///< F_s, at this v_s
  std::optional<double> area_m2{};                ///< A is held at this: then one record will do
};

/// Weighted least squares over the records. Throws CannotIdentify when a record slides in one direction only,
/// when none is there, or one only and no area, or one is empty, when there are no more samples than coefficients, or when the
/// rows leave a coefficient open.
FrictionFit fit_friction(std::span<const std::vector<SlidingRow>> records, const FrictionTerms& terms = {});

/// The bench force that a fit predicts for a row of record `record` [N].
double predicted_force_N(const FrictionFit& fit, std::size_t record, const SlidingRow& row,
                         const FrictionTerms& terms = {});

}  // namespace plenum::host::identify::servo
