#include "host-sim/reproduce/proportional_valve/identified_valve.hpp"

#include <algorithm>
#include <cmath>

#include "host-sim/identify/orifice/filter.hpp"
#include "host-sim/identify/orifice/vessel_run.hpp"
#include "host-sim/plant/runge_kutta.hpp"

namespace plenum::host::reproduce::proportional_valve {
namespace {

using namespace identify::orifice;
using plant::EllipsePort;

constexpr std::size_t kFittedRows = 1000;

double mae_kPa(const OrificeFit& fit, const VesselRecord& record) {
  return 1e-3 *
         mean_absolute_error(free_run(fit.port_1_s(), record, record.vessel_Pa.front()), record.vessel_Pa);
}

EllipsePort looked_up(const IdentifiedSeries& identified, double command_V) {
  const std::vector<IdentifiedRow>& rows = identified.rows;
  const auto port_of = [](const IdentifiedRow& row) { return row.rate_fit.port_1_s(); };
  const double place = (command_V - rows.front().row.command_V) / plant::kMpyeStep_V;
  if (place <= 0.0) {
    EllipsePort port = port_of(rows.front());
    port.choked_kg_s_Pa *= std::max(1.0 + place, 0.0);
    return port;
  }
  const auto last = static_cast<double>(rows.size() - 1);
  if (place >= last) {
    EllipsePort port = port_of(rows.back());
    port.choked_kg_s_Pa *= std::max(1.0 - (place - last), 0.0);
    return port;
  }
  const auto i = static_cast<std::size_t>(place);
  const EllipsePort low = port_of(rows[i]);
  const EllipsePort high = port_of(rows[i + 1]);
  const double w = place - static_cast<double>(i);
  return {std::lerp(low.choked_kg_s_Pa, high.choked_kg_s_Pa, w),
          std::lerp(low.critical_ratio, high.critical_ratio, w),
          std::lerp(low.cracking_ratio, high.cracking_ratio, w),
          std::lerp(low.subsonic_index, high.subsonic_index, w)};
}

}  // namespace

OrificeFit fit_pressures(const VesselRecord& record, const Vessel& vessel) {
  const VesselRecord steady = steady_far_side(record);
  const std::size_t block = std::max<std::size_t>(record.time_s.size() / kFittedRows, 1);
  if (block == 1) return fit_orifice(steady, vessel);
  return fit_orifice(block_means(steady, block), vessel, {.moving_average_rows = 1});
}

IdentifiedSeries identify_series(const Series& series, const RigOptions& options,
                                 const std::function<void()>& row_done) {
  IdentifiedSeries identified{series, {}};
  const Vessel vessel = papers_vessel(series.flow);
  for (const Row& row : measured_rows(series)) {
    const Experiment experiment = measure(series, row.command_V, options);
    IdentifiedRow result{row, fit_orifice(experiment.record, vessel, {.pressure_fit = false}),
                         fit_pressures(experiment.record, vessel)};
    result.rate_fit_mae_kPa = mae_kPa(result.rate_fit, experiment.record);
    result.pressure_fit_mae_kPa = mae_kPa(result.pressure_fit, steady_far_side(experiment.record));
    identified.rows.push_back(result);
    row_done();
  }
  return identified;
}

std::vector<double> simulate_sine(const IdentifiedSeries& charge, const IdentifiedSeries& discharge,
                                  const SineExperiment& experiment) {
  const std::size_t rows = experiment.time_s.size();
  // The command is held over a sampling time, as the card does.
  const auto rate_Pa_s = [&](std::size_t i, double p) {
    const EllipsePort in = looked_up(charge, experiment.command_V[i]);
    const EllipsePort out = looked_up(discharge, experiment.command_V[i]);
    return vessel_rate(in, Flow::kCharge, p, experiment.supply_Pa[i]).rate_Pa_s +
           vessel_rate(out, Flow::kDischarge, p, kAmbient_Pa).rate_Pa_s;
  };
  std::vector<double> run;
  double p = experiment.vessel_Pa.front();
  for (std::size_t i = 0; i < rows; ++i) {
    run.push_back(p);
    p = plant::runge_kutta_step(0.0, p, kSample_s, [&](double, double at) { return rate_Pa_s(i, at); });
  }
  return run;
}

}  // namespace plenum::host::reproduce::proportional_valve
