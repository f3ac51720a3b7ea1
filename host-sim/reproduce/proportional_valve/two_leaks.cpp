#include "host-sim/reproduce/proportional_valve/two_leaks.hpp"

#include "host-sim/identify/orifice/vessel_run.hpp"
#include "host-sim/plant/runge_kutta.hpp"
#include "host-sim/reproduce/proportional_valve/experiment.hpp"

namespace plenum::host::reproduce::proportional_valve {
namespace {

using identify::orifice::Flow;
using identify::orifice::vessel_rate;

plant::EllipsePort ideal(double rate_1_s) {
  return {rate_1_s, 0.528, 1.0, 0.5};
}

}  // namespace

TwoLeaks leaks_resting_at(double rest_Pa, double in_1_s) {
  const double in = vessel_rate(ideal(in_1_s), Flow::kCharge, rest_Pa, kSupply_Pa).rate_Pa_s;
  const double out_of_one = -vessel_rate(ideal(1.0), Flow::kDischarge, rest_Pa, kAmbient_Pa).rate_Pa_s;
  return {in_1_s, in / out_of_one};
}

double net_rate_Pa_s(const TwoLeaks& leaks, double vessel_Pa) {
  return vessel_rate(ideal(leaks.in_1_s), Flow::kCharge, vessel_Pa, kSupply_Pa).rate_Pa_s +
         vessel_rate(ideal(leaks.out_1_s), Flow::kDischarge, vessel_Pa, kAmbient_Pa).rate_Pa_s;
}

identify::orifice::VesselRecord run_of(const TwoLeaks& leaks, Flow flow, double duration_s) {
  identify::orifice::VesselRecord record;
  record.flow = flow;
  double p = flow == Flow::kCharge ? kAmbient_Pa : kSupply_Pa;
  const double h = kSample_s;
  for (double t = 0.0; t < duration_s; t += h) {
    record.time_s.push_back(t);
    record.vessel_Pa.push_back(p);
    record.far_Pa.push_back(flow == Flow::kCharge ? kSupply_Pa : kAmbient_Pa);
    p = plant::runge_kutta_step(0.0, p, h, [&](double, double at) { return net_rate_Pa_s(leaks, at); });
  }
  return record;
}

}  // namespace plenum::host::reproduce::proportional_valve
