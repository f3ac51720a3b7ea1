// The 9-parameter model of chamber pressure and its repaired form, in double: written a second time, apart from the
// firmware's.
//
//   p' = (s - p) r                                               (6), (10f)
//   s  = c_b + c_s g(c2 U + c3 U^3) + c4 v'   U = u - c1         (10a)-(10c),  g(x) = x/sqrt(x^2 + 1)  (8)
//   r  = (c7 k + c5 v')/(1 + c6 v)                               (10e)
//   k  = sqrt(U^2 + c_gamma^2) - c_gamma + c9 + c8 U             (9), (10d)
//   p(t+h) = s + (p(t) - s) exp(-r h)                            (7), exact for s, r constant over h
//   mean of p over the last a of the tick = s + (p(t+h) - s) (exp(r a) - 1)/(r a)     (integral of (7))
//
// The repaired form (firmware/control/README.md derives it) has no c4: with a = c7 k and s0 = s at v' = 0,
//   s = a s0/(a + c5 v'),   r = (a + c5 v')/(1 + c6 v)
// s has a pole where a + c5 v' = 0, p' = (s - p) r has none: |a + c5 v'| is kept above kPole a, which moves p' by less than
// kPole a p/(1 + c6 v).
//
// Units: p, s [kPa]; u, U [V]; v [mL]; v' [mL/s]; h, a [s]; c1 [V], c2 [1/V], c3 [1/V^3], c4 [kPa s/mL], c5
// [1/mL], c6 [1/mL], c7 [1/(V s)], c8 [1], c9 [V], c_gamma [V]; c_b = (P_c + P_r)/2, c_s = (P_c - P_r)/2
// [kPa].
//
// Range: k > 0 for every command where c9 > c_gamma (1 - sqrt(1 - c8^2)). r may still become negative where a
// chamber shrinks fast behind a nearly sealed valve (c5 v' < -c7 k): (7) then grows exponentially, as
// compression does. Numerics: r h is limited to [kLeastExponent, kGreatestExponent], far outside of what a
// valve does in one tick. Source: Modeling and Identification of Pneumatic Actuators, section IV.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace plenum::host::identify {

inline constexpr std::size_t kFree = 9;  ///< c1..c9
inline constexpr std::size_t kC4 = 3;    ///< place of c4, which the repaired form leaves at 0

inline constexpr double kLeastExponent = -4.0;
inline constexpr double kGreatestExponent = 40.0;
inline constexpr double kPole = 1e-7;

enum class Form { published, repaired };

/// The kind of its images and model files: "tassa9", "tassa9r".
std::string_view kind_of(Form form);
/// Throws std::invalid_argument for another kind.
Form form_of(std::string_view kind);
/// Whether the form has c_(place + 1).
constexpr bool has_parameter(Form form, std::size_t place) {
  return form == Form::published || place != kC4;
}

struct Tassa9 {
  std::array<double, kFree> c{5.0, 1.0, 1.0, 0.0, 0.0, 0.0, 10.0, 0.0, 0.1};  ///< c[0] is c1
  double c_gamma_V = 0.1;
  double supply_kPa = 700.0;     ///< P_c
  double ambient_kPa = 101.325;  ///< P_r
  double dead_time_s = 0.0;      ///< of the valve: a command acts so much later (ticks.hpp)
  Form form = Form::published;

  /// In the order in which they cross the bus: c1..c9, c_gamma, P_c, P_r, without what the form does not have, dead time.
  std::vector<double> image() const;
  /// Throws std::invalid_argument for another number of values than image() has; the last may be left out.
  static Tassa9 from_image(std::span<const double> values, Form form = Form::published);
};

/// s [kPa] and r [1/s] of (10).
struct SteadyAndRate {
  double steady_kPa;
  double rate_per_s;
};

SteadyAndRate steady_and_rate(const Tassa9& model, double command_V, double volume_mL,
                              double volume_rate_mL_s);

/// (7), and the mean over the last `average_s` of the step (0: the end itself).
struct Step {
  double end_kPa;
  double mean_kPa;
};

Step step(const SteadyAndRate& at, double pressure_kPa, double period_s, double average_s);

/// The pressure at the end of a tick whose mean over its last `average_s` was `mean_kPa`: step() solved for
/// the end.
double end_from_mean(const SteadyAndRate& at, double mean_kPa, double period_s, double average_s);

}  // namespace plenum::host::identify
