#include "host-sim/identify/regulator_valve/piecewise.hpp"

#include <array>
#include <cstddef>
#include <limits>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::identify::regulator_valve {

std::vector<double> predict(const PiecewiseModel& model, const std::vector<double>& screw_m,
                            double start_Pa) {
  plant::require_within("piecewise dead_band_m", model.dead_band_m, 0.0, std::numeric_limits<double>::max());
  std::vector<double> pressure_Pa;
  pressure_Pa.reserve(screw_m.size());
  std::array<double, 3> past{start_Pa, start_Pa, start_Pa};
  double upper_m = screw_m.empty() ? 0.0 : screw_m.front();
  double lower_m = upper_m - model.dead_band_m;
  const CenteredModel* before = nullptr;
  for (const double x_m : screw_m) {
    pressure_Pa.push_back(past[0]);
    const CenteredModel* now = nullptr;
    if (x_m > upper_m || (x_m == upper_m && before != &model.falling)) {
      now = &model.rising;
      upper_m = x_m;
      lower_m = x_m - model.dead_band_m;
    } else if (x_m < lower_m || (x_m == lower_m && before == &model.falling)) {
      now = &model.falling;
      lower_m = x_m;
      upper_m = x_m + model.dead_band_m;
    }
    if (now != before) past = {past[0], past[0], past[0]};
    before = now;
    double next = past[0];
    if (now != nullptr) {
      next = now->mean_pressure_Pa + now->model.b_Pa_m * (x_m - now->mean_screw_m);
      for (std::size_t i = 0; i < 3; ++i) next -= now->model.a[i] * (past[i] - now->mean_pressure_Pa);
    }
    past = {next, past[0], past[1]};
  }
  return pressure_Pa;
}

}  // namespace plenum::host::identify::regulator_valve
