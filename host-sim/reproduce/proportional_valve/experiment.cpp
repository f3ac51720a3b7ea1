#include "host-sim/reproduce/proportional_valve/experiment.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <variant>

#include "host-sim/identify/orifice/filter.hpp"
#include "host-sim/plant/chamber.hpp"
#include "host-sim/plant/converter.hpp"
#include "host-sim/reproduce/proportional_valve/walled_vessel.hpp"

namespace plenum::host::reproduce::proportional_valve {
namespace {

using identify::orifice::Flow;
using plant::MpyeChannel;

constexpr double kPeriodic_Hz = 100.0;
constexpr double kReset_s = 3.0;  // 60 time constants of the open valve
constexpr double kLeast_s = 0.5;  // of a set point: a square wave of 1 Hz
constexpr double kRestWindow_s = 0.1;
constexpr double kAtRest_Pa = 20.0;  // moved in that window
constexpr double kSineMean_V = 5.0;
constexpr double kSineAmplitude_V = 2.5;
constexpr double kSine_Hz = 2.0;

// One transducer and its channel of the card, over kCycles recordings of the same pressures, averaged.
std::vector<double> recorded(const std::vector<double>& pressures_Pa, const RigOptions& options,
                             std::uint64_t stream) {
  plant::Random random = plant::Random(options.seed).split(stream);
  plant::AdcConfig card;
  card.low_V = -10.0;
  card.high_V = 10.0;
  card.sample_noise_V = options.white_V;
  card.samples_per_tick = 1;
  plant::AveragingAdc adc(card, random.split(0));
  std::vector<double> samples;
  samples.reserve(kCycles * pressures_Pa.size());
  for (std::size_t cycle = 0; cycle < kCycles; ++cycle) {
    const double phase = random.uniform(0.0, 2.0 * std::numbers::pi);
    for (std::size_t i = 0; i < pressures_Pa.size(); ++i) {
      const double t = static_cast<double>(i) * kSample_s;
      const double hum_V = options.periodic_V * std::sin(2.0 * std::numbers::pi * kPeriodic_Hz * t + phase);
      const double signal_V = pressures_Pa[i] * 1e-3 * kMillivoltPerKilopascal * 1e-3;
      samples.push_back(adc.read_V(signal_V + hum_V) / (kMillivoltPerKilopascal * 1e-6));
    }
  }
  return identify::orifice::cyclic_average(samples, kCycles);
}

// The plant reads channel B at 10 V - u; here commands are those of the tables.
double plant_command(MpyeChannel channel, double command_V) {
  return channel == MpyeChannel::a ? command_V : 10.0 - command_V;
}

// The rig's vessel, of either kind.
class RigVessel {
 public:
  RigVessel(MpyeChannel channel, double start_Pa, double command_V, const RigOptions& options)
      : channel_(channel), vessel_(made(channel, start_Pa, command_V, options)) {}

  // `command_V` as the tables print it.
  void advance(double command_V, double duration_s) {
    std::visit([&](auto& vessel) { vessel.advance(plant_command(channel_, command_V), duration_s); },
               vessel_);
  }
  double pressure_Pa() const {
    return std::visit([](const auto& vessel) { return vessel.pressure_Pa(); }, vessel_);
  }

 private:
  using AnyVessel = std::variant<plant::ChamberPlant, WalledVessel>;

  static AnyVessel made(MpyeChannel channel, double start_Pa, double command_V, const RigOptions& options) {
    const plant::Gas gas = plant::reference_atmosphere();
    const plant::MpyeValve valve(channel, gas);
    if (options.wall && options.spool)
      throw std::invalid_argument("rig options: a wall and a spool, expected one of them");
    if (options.wall) return WalledVessel(valve, gas, start_Pa, *options.wall);
    plant::ChamberConfig config;
    config.gas = gas;
    config.supply_Pa = kSupply_Pa;
    config.ambient_Pa = kAmbient_Pa;
    config.initial_pressure_Pa = start_Pa;
    config.initial_command_V = plant_command(channel, command_V);
    config.spool = options.spool;
    config.tolerance_Pa = 0.5;
    return plant::ChamberPlant(valve, config, plant::VolumeMotion(kVessel_m3));
  }

  MpyeChannel channel_;
  AnyVessel vessel_;
};

std::uint64_t stream_of(MpyeChannel channel, Flow flow, double command_V) {
  return static_cast<std::uint64_t>(std::lround(command_V * 10.0)) * 8 + (channel == MpyeChannel::a ? 0 : 4) +
         (flow == Flow::kCharge ? 0 : 2);
}

}  // namespace

const std::vector<Series>& all_series() {
  static const std::vector<Series> series = {
      {MpyeChannel::a, Flow::kCharge, &plant::kMpyeChannelAInlet, 2},
      {MpyeChannel::a, Flow::kDischarge, &plant::kMpyeChannelAExhaust, 3},
      {MpyeChannel::b_mirrored, Flow::kCharge, &plant::kMpyeChannelBInlet, 4},
      {MpyeChannel::b_mirrored, Flow::kDischarge, &plant::kMpyeChannelBExhaust, 5},
  };
  return series;
}

std::vector<Row> measured_rows(const Series& series) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < plant::kMpyeRows; ++i) {
    if ((*series.table)[i].area_m2 > 0.0)
      rows.push_back({static_cast<double>(i) * plant::kMpyeStep_V, (*series.table)[i]});
  }
  return rows;
}

Experiment measure(const Series& series, double command_V, const RigOptions& options) {
  const bool charge = series.flow == Flow::kCharge;
  const bool opposite_is_high = charge == (series.channel == MpyeChannel::b_mirrored);
  const double reset_V = opposite_is_high ? 10.0 : 0.0;
  RigVessel vessel(series.channel, charge ? kAmbient_Pa : kSupply_Pa, reset_V, options);
  // full and as warm as its wall is how a walled vessel is made: its heat need not be waited for
  if (charge || !options.wall) {
    vessel.advance(command_V, kReset_s);
    vessel.advance(reset_V, kReset_s);
  }

  Experiment experiment;
  const auto window = static_cast<std::size_t>(std::lround(kRestWindow_s / kSample_s));
  std::vector<double>& truth = experiment.vessel_truth_Pa;
  for (double t = 0.0; t < options.most_s; t += kSample_s) {
    experiment.record.time_s.push_back(t);
    truth.push_back(vessel.pressure_Pa());
    if (t > kLeast_s && std::abs(truth.back() - truth[truth.size() - 1 - window]) < kAtRest_Pa) break;
    vessel.advance(command_V, kSample_s);
  }
  const std::uint64_t stream = stream_of(series.channel, series.flow, command_V);
  experiment.record.flow = series.flow;
  experiment.record.vessel_Pa = recorded(truth, options, stream);
  const std::vector<double> far_Pa(truth.size(), kSupply_Pa);
  experiment.record.far_Pa =
      charge ? recorded(far_Pa, options, stream + 1) : std::vector<double>(truth.size(), kAmbient_Pa);
  return experiment;
}

SineExperiment measure_sine(MpyeChannel channel, const RigOptions& options) {
  SineExperiment experiment;
  RigVessel vessel(channel, 4e5, kSineMean_V, options);
  constexpr int kSettlingPeriods = 10;
  const int period = static_cast<int>(std::lround(1.0 / (kSine_Hz * kSample_s)));
  std::vector<double> truth;
  for (int i = 0; i < (kSettlingPeriods + 1) * period; ++i) {
    const double t = i * kSample_s;
    const double command_V = kSineMean_V + kSineAmplitude_V * std::sin(2.0 * std::numbers::pi * kSine_Hz * t);
    if (i >= kSettlingPeriods * period) {
      experiment.time_s.push_back(t - kSettlingPeriods * period * kSample_s);
      experiment.command_V.push_back(command_V);
      truth.push_back(vessel.pressure_Pa());
    }
    vessel.advance(command_V, kSample_s);
  }
  experiment.vessel_Pa = recorded(truth, options, 1000);
  experiment.supply_Pa = recorded(std::vector<double>(truth.size(), kSupply_Pa), options, 1001);
  return experiment;
}

identify::orifice::Vessel papers_vessel(Flow flow) {
  return {.volume_m3 = kVessel_m3,
          .flow_exponent = flow == Flow::kCharge ? plant::kMpyeChargeExponent : plant::kMpyeDischargeExponent,
          .discharge_coefficient = plant::kMpyeDischargeCoefficient,
          .gas = plant::reference_atmosphere()};
}

}  // namespace plenum::host::reproduce::proportional_valve
