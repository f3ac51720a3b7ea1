// The board's own model, in its own scalar, in free run over a log.
#pragma once

#include <cstddef>
#include <vector>

#include "firmware/control/pressure_model.hpp"
#include "host-sim/identify/ticks.hpp"

namespace plenum::bench {

/// An identify::Predictor: started from the measured sample of a row, fed with command, volume and speed of each tick. Lives no
/// longer than model and ticks.
class BoardRun {
 public:
  BoardRun(const control::PressureModel& model, const host::identify::Ticks& ticks)
      : model_(model), ticks_(ticks) {}

  std::vector<double> operator()(std::size_t start, std::size_t rows) const {
    Scalar pressure_kPa = static_cast<float>(ticks_.pressure_kPa[start]);
    if (averaged() && start > 0) pressure_kPa = through_tick_before(start);
    std::vector<double> readings_kPa;
    for (std::size_t row = start; row < start + rows; ++row) {
      const control::Prediction next = tick(row, pressure_kPa);
      readings_kPa.push_back(static_cast<double>(averaged() ? next.mean_kPa : next.end_kPa));
      pressure_kPa = next.end_kPa;
    }
    return readings_kPa;
  }

 private:
  using Scalar = numeric::Scalar;

  bool averaged() const { return ticks_.average_s > 0.0; }

  control::Prediction tick(std::size_t row, Scalar pressure_kPa) const {
    const control::ChamberMotion motion{.volume_mL = static_cast<float>(ticks_.volume_mL[row]),
                                        .volume_rate_mL_s = static_cast<float>(ticks_.volume_rate_mL_s[row])};
    return model_.step(pressure_kPa, static_cast<float>(ticks_.command_V[row]), motion, 1.0F);
  }

  /// The pressure at a row's time, from its sample: the end of the tick whose mean the sample is. The mean rises with the
  /// pressure at the tick's beginning.
  Scalar through_tick_before(std::size_t row) const {
    const auto sample_kPa = static_cast<float>(ticks_.pressure_kPa[row]);
    float low_kPa = 1.0F;
    float high_kPa = 5000.0F;
    for (int i = 0; i < 40; ++i) {
      const float middle_kPa = 0.5F * (low_kPa + high_kPa);
      (tick(row - 1, middle_kPa).mean_kPa < sample_kPa ? low_kPa : high_kPa) = middle_kPa;
    }
    return tick(row - 1, 0.5F * (low_kPa + high_kPa)).end_kPa;
  }

  const control::PressureModel& model_;
  const host::identify::Ticks& ticks_;
};

}  // namespace plenum::bench
