// What of a gap is left once the nominal model's valve figures are fitted to it: the part that only a cause explains.
//
// Least squares over the seven valve figures and the initial pressure, starting from the truth, against noise-free
// rows: Levenberg and Marquardt's damping; the Jacobian by differences once, then kept up by Broyden's updates
// (and taken anew where most is absorbed).
// Since it is fitted to the very rows on which it is judged, free of noise, an honest recalibration can hardly come
// out lower. The model's step is kCalibrationStep_s, an error far below the noise.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "host-sim/blind/truth.hpp"

namespace plenum::host::blind {

inline constexpr double kCalibrationStep_s = 2e-4;

class Recalibration {
 public:
  /// `nominal`: the machine with its true valve, without departures and clutter, under these commands.
  Recalibration(Machine nominal, std::vector<double> command_V);

  /// RMS that is left between `pressure_Pa` and the nominal model, fitted [Pa].
  double rest_Pa(const std::vector<double>& pressure_Pa) const;

 private:
  using Figures = Eigen::Matrix<double, 8, 1>;
  using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, 8>;
  struct Search {
    Figures at;
    Eigen::VectorXd error;  ///< wanted less simulated
    Jacobian slopes;
  };
  Eigen::VectorXd simulated(const Figures& change) const;
  Jacobian differences(const Figures& at, const Eigen::VectorXd& there_Pa) const;
  void descend(Search& search, const Eigen::VectorXd& wanted_Pa) const;

  Machine nominal_;
  std::vector<double> command_V_;
  Eigen::VectorXd base_Pa_;
  Jacobian jacobian_;
};

}  // namespace plenum::host::blind
