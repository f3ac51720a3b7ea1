// The physical model of the servo cylinder fitted to a recording of its command and position.
//
//   minimise  sum_k [x(k) - xhat(k | theta)]^2 over the free run of plant/servo/cylinder.hpp from rest
//   theta: flow gain of inlet and exhaust, null of the valve, F_c, F_s, F_v of (23), moving mass
//
// What a data sheet states (bore, rod, stroke, dead volumes, supply, gas, spool, v_s) is held at `guess`, and
// the seven figures above start there, those that are known as well held. Method: Levenberg-Marquardt in a box (box_solver.hpp) on logarithms of
// the figures, which stay within a factor of kWidest of the guess; the Jacobian by forward differences. A
// free run integrates flow to position: far from the truth it ends at a stop, where nothing can be learnt. So
// the horizon trebles from one second to the whole recording, each fit starting from the last.
// Source: "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems" (1)-(23).
#pragma once

#include <array>
#include <functional>
#include <string_view>
#include <vector>

#include "host-sim/plant/servo/cylinder.hpp"

namespace plenum::host::identify::servo {

/// One 5/3 valve and one cylinder, recorded from rest: command k is held from sample k to k + 1.
struct ServoRecord {
  double period_s = 0.01;
  std::vector<double> commands_V;
  std::vector<double> positions_m;
};

/// The rig: valve (both ports), cylinder and its state at rest before the first command.
struct ServoRig {
  plant::ThinPlateValveConfig valve;
  plant::servo::ServoCylinderConfig cylinder;
};

inline constexpr double kWidest = 4.0;
inline constexpr double kWidestNull_V = 0.2;

inline constexpr std::array<std::string_view, 7> kFittedNames{
    "inlet area for each volt", "exhaust area for each volt", "null",       "Coulomb friction",
    "Stribeck friction",        "viscous friction",           "moving mass"};
/// For each of kFittedNames.
using PerFigure = std::array<bool, kFittedNames.size()>;

struct ServoFit {
  ServoRig rig;        ///< the guess with the seven figures fitted
  double rms_m = 0.0;  ///< of the free run over the whole recording
  std::array<double, 7>
      error{};  ///< standard errors: relative, of the null [V]; errors taken as white; held: 0
  int iterations = 0;
  PerFigure at_bound{};  ///< ended a factor kWidest (kWidestNull_V) from its guess
};

/// A free run, each column as long as its record.
struct ServoRun {
  std::vector<double> positions_m;
  std::vector<double> pressures_1_Pa;
  std::vector<double> pressures_2_Pa;
};
ServoRun free_run(const ServoRig& rig, const ServoRecord& record);

/// Figures that are `held` stay at the guess. Throws std::invalid_argument when the columns differ in length or a value is
/// not finite; CannotIdentify when the piston, or that of the guess, does not move or the recording does not determine a figure, which is named.
ServoFit fit_servo(const ServoRig& guess, const ServoRecord& record, const PerFigure& held = {},
                   const std::function<void(double)>& progress = {});

}  // namespace plenum::host::identify::servo
