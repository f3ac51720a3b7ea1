// Tracking in a closed loop, with the three kinds of model on the same chambers: `model.tracking_rmse_KIND_kPa`.
//
// Twelve chambers of the violent population (volume doubling at 0.4 to 1.6 Hz) are recorded for 100 s and a model of each kind is
// fitted to the record. The board's regulator and volume observer then drive the same chamber, 20 s from 200 kPa, along
//   350 kPa + 60 kPa sin(2 pi 0.5 Hz t) + 15 kPa sin(2 pi 1.3 Hz t),
// with the reference known ahead, learning as they do on the board. The error is the pressure at the end of each tick less the
// reference then, RMS from 2 s on, but for the ticks in the tenth of a second after a command at its limit: there the valve
// decides and no model. The rows are the medians over the chambers.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "firmware/control/any_model.hpp"
#include "firmware/control/regulator.hpp"
#include "firmware/control/volume_observer.hpp"
#include "host-sim/identify/chamber/fit_greybox.hpp"
#include "host-sim/identify/fit.hpp"
#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/reproduce/actuators/population.hpp"
#include "tests/bench/row.hpp"
#include "tests/identify/board_parameters.hpp"

namespace {

using namespace plenum::host;
using namespace plenum::control;
namespace config = plenum::config;

constexpr std::size_t kChambers = 12;
constexpr int kTicks = 2000;
constexpr int kSettled = 200;
constexpr int kRecovery = 10;
constexpr double kTick_s = 0.01;
constexpr std::array<const char*, 3> kKinds = {"tassa9", "tassa9r", "greybox"};

double reference_kPa(double t_s) {
  const double turn = 2.0 * std::numbers::pi * t_s;
  return 350.0 + 60.0 * std::sin(0.5 * turn) + 15.0 * std::sin(1.3 * turn);
}

config::ModelParameters fitted(std::string_view kind, const trace::Log& log,
                               const trace::RigDescription& rig) {
  if (kind == "greybox") {
    const auto fit = identify::chamber::fit_greybox({log}, rig);
    return testing::board_parameters(kind, identify::chamber::to_model_file(fit, {}).parameters);
  }
  identify::FitOptions options;
  options.form = kind == "tassa9r" ? identify::Form::repaired : identify::Form::published;
  return testing::board_parameters(kind, identify::fit_tassa9({log}, rig, options).model.image());
}

double tracking_rmse_kPa(const config::ModelParameters& parameters, unsigned seed) {
  const reproduce::actuators::PopulationChamber drawn =
      reproduce::actuators::chamber_of_seed(seed, reproduce::actuators::Motion::violent);
  plant::ChamberConfig chamber;
  chamber.supply_Pa = reproduce::actuators::kPopulationSupply_Pa;
  chamber.initial_pressure_Pa = 200e3;
  plant::ChamberPlant plant(plant::ThinPlateValve(drawn.valve), chamber, drawn.volume);

  AnyModel room;
  const PressureModel& model = *room.take_over(parameters, 3.0F, 7.0F);
  Regulator::Config settings;
  settings.valve_delay_ticks = 0.0F;  // the plant's valve is prompt
  Regulator regulator;
  regulator.configure(settings);
  regulator.reset(200.0F, 5.0F);
  VolumeObserver observer;
  observer.configure({});
  observer.reset(static_cast<float>(1e6 * plant.volume_m3()));

  double measured_kPa = 200.0, square = 0.0;
  int since_limit = 0, counted = 0;
  double volume_mL = 1e6 * plant.volume_m3();
  for (int k = 0; k < kTicks; ++k) {
    const ChamberMotion next = observer.step(static_cast<float>(volume_mL));
    regulator.observe(model, static_cast<float>(measured_kPa), observer.past());
    ReferenceShaper::Reference wanted;
    for (std::size_t i = 0; i < wanted.kPa.size(); ++i) {
      wanted.kPa[i] = static_cast<float>(reference_kPa(kTick_s * (k + static_cast<double>(i))));
    }
    const Regulator::Command command = regulator.regulate(model, wanted, next);
    regulator.sent(command.command_V);
    since_limit = command.saturated ? 0 : since_limit + 1;
    const double before_mL = 1e6 * plant.volume_m3();
    measured_kPa = 1e-3 * plant.advance(static_cast<double>(command.command_V), kTick_s).mean_Pa;
    volume_mL = 0.5 * (before_mL + 1e6 * plant.volume_m3());
    const double error_kPa = 1e-3 * plant.pressure_Pa() - reference_kPa(kTick_s * (k + 1));
    if (k < kSettled || since_limit < kRecovery) continue;
    square += error_kPa * error_kPa;
    ++counted;
  }
  return std::sqrt(square / counted);
}

}  // namespace

int main() {
  std::array<std::vector<double>, kKinds.size()> rmse_kPa;
  for (auto& of_kind : rmse_kPa) of_kind.resize(kChambers);
  identify::in_parallel(kChambers, std::thread::hardware_concurrency(), [&](std::size_t i) {
    const auto seed = static_cast<unsigned>(i + 1);
    const trace::Log log = reproduce::actuators::record_chamber(seed, reproduce::actuators::Motion::violent);
    const trace::RigDescription rig = reproduce::actuators::population_rig();
    for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
      rmse_kPa[kind][i] = tracking_rmse_kPa(fitted(kKinds[kind], log, rig), seed);
    }
  });
  for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
    auto& values = rmse_kPa[kind];
    std::sort(values.begin(), values.end());
    const double median = 0.5 * (values[kChambers / 2 - 1] + values[kChambers / 2]);
    plenum::bench::print({fmt::format("model.tracking_rmse_{}_kPa", kKinds[kind]), median, "kPa"});
  }
}
