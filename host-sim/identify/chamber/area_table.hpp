// The areas of both ports over the command, straight from logs: what a free-run fit starts from, whatever the valve.
//
//   y_(k+1) - y_k = h (c f_(k-1) + (1 - c) f_k),   c = a/(2 h)                                       (T1)
//   f = n (R T (A(u) phi(P_c, p) - B(u) phi(p, P_r)) - v' p)/v                                       (T2)
//   A(u), B(u): straight between their values at kMostNodes commands, none below 0
//
// y the logged pressure, a mean over the averaging time a; f the pressure's rate over tick k [Pa/s], (T2) taken at the
// pressure in the middle of the tick; phi the thin plate's flow over a square metre; A, B areas [m2]. (T1) is linear in the
// areas: one bounded least-squares problem, without a start and without a second minimum. The nodes are as dense as the
// commands. Where no command was, a slight price on bending carries the curve on.
//
// The figures of a valve (and of area_shape) that come nearest to the table, in the errors of (T1), are then sought from
// openings all over the commands: a gain a port, a dead band however wide. That costs no pass over the logs.
//
// Source: (4) of "Modeling and Identification of Pneumatic Actuators". Limits: a tick in which the pressure goes most of its
// way is described by its mean alone, so that large areas come out too small: a start, not a result.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::identify::chamber {

inline constexpr Eigen::Index kMostNodes = 31;

struct AreaTable {
  std::vector<double> command_V;  ///< of the nodes, rising
  Eigen::VectorXd area_m2;        ///< A at the nodes, then B
  Eigen::MatrixXd weight;         ///< of the squared error of the areas, in Pa^2/m4

  /// What the figures err by, against the table [Pa^2].
  double squares(const effects::Figures& figures, effects::EffectSet on) const;
};

/// From the fitted rows of the scene's records.
AreaTable area_table(const Scene& scene);

/// `base` with the figures of the valve, and those of area_shape when that is in `on`, that come nearest to the table.
effects::Figures nearest_valve(const AreaTable& table, const effects::Figures& base, effects::EffectSet on);

}  // namespace plenum::host::identify::chamber
