#include "tests/safety/machine.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "host-sim/client/model_bytes.hpp"
#include "host-sim/identify/fit.hpp"

namespace plenum::safety_case {
namespace {

namespace plant = host::plant;

constexpr double kTick_s = 0.01;
constexpr double kPa = 1e3;
constexpr double kMl = 1e-6;
constexpr double kSupply_Pa = 700e3;
constexpr double kPressurePerV_Pa = 100e3;
constexpr double kSmallest_m3 = 150e-6;  ///< mean volume of the first chamber
constexpr double kSwing = 0.1;           ///< amplitude over mean of each volume
constexpr double kFastest_Hz = 0.8;
constexpr double kUnpowered_V = 5.0;  ///< where springs hold the spool
constexpr float kVent_V = 2.5F;       ///< below the regulator's range, to be told from its commands
constexpr plant::AdcConfig kConverter{
    .low_V = -10.0, .high_V = 10.0, .bits = 16, .sample_noise_V = 0.005, .samples_per_tick = 200};
/// What the noise of a mean and a step of the converter hide: six deviations of the one and one of the other.
const double kHidden_Pa =
    kPressurePerV_Pa * (6.0 * kConverter.sample_noise_V / std::sqrt(kConverter.samples_per_tick) +
                        20.0 / std::exp2(kConverter.bits));

double mean_m3(std::size_t chamber) {
  return kSmallest_m3 * (1.0 + 0.1 * static_cast<double>(chamber));
}

plant::ChamberConfig chamber_config() {
  plant::ChamberConfig config;
  config.supply_Pa = kSupply_Pa;
  config.initial_pressure_Pa = 200e3;
  return config;
}

plant::ChamberPlant chamber_plant(std::size_t chamber, plant::Random& random) {
  const double amplitude_m3 = kSwing * mean_m3(chamber);
  const plant::VolumeMotion motion(mean_m3(chamber),
                                   {{{.amplitude_m3 = amplitude_m3,
                                      .frequency_Hz = random.uniform(0.2, kFastest_Hz),
                                      .phase_rad = random.uniform(0.0, 2.0 * std::numbers::pi)},
                                     {},
                                     {}}});
  return {plant::ThinPlateValve({}, chamber_config().gas), chamber_config(), motion};
}

std::vector<plant::ChamberPlant> chamber_plants(std::uint64_t seed) {
  plant::Random random(seed);
  std::vector<plant::ChamberPlant> plants;
  for (std::size_t c = 0; c < kChambers; ++c) plants.push_back(chamber_plant(c, random));
  return plants;
}

Settings machine_settings(config::SafeOutput safe_output) {
  Settings settings;
  settings.node.node_id = Machine::kNode;
  settings.regulator.valve_delay_ticks = 0.0F;  // these valves answer at once
  settings.board.supply_low_kPa = 500.0F;
  for (std::size_t c = 0; c < kChambers; ++c) {
    config::ChamberSettings& chamber = settings.chamber[c];
    chamber.vent_V = kVent_V;
    chamber.safe_output = safe_output;
    chamber.pressure_high_kPa = 500.0F;
    chamber.over_pressure_kPa = 560.0F;
    chamber.volume_offset_mL = 0.0F;
    chamber.volume_gain_mL_per_V = static_cast<float>(2.0 * mean_m3(c) / kMl / 10.0);
    chamber.position_valid_low_V = 0.2F;
    chamber.position_valid_high_V = 9.8F;
  }
  return settings;
}

plant::PortFlows flows(const plant::ChamberPlant& chamber, double command_V, double pressure_Pa,
                       double supply_Pa) {
  const auto& valve = std::get<plant::ThinPlateValve>(chamber.valve());
  return valve.flows(valve.opening(command_V), pressure_Pa, supply_Pa, chamber.ambient_Pa());
}

/// kappa R T: what a flow [kg/s] adds to p v [Pa m3/s].
double pv_per_kg_J(const plant::Gas& gas) {
  return gas.kappa * gas.specific_gas_constant_J_kg_K() * gas.temperature_K;
}

/// b / kappa: highest |v'| over the smallest v.
constexpr double kFastestMotion_per_s = 2.0 * std::numbers::pi * kFastest_Hz * kSwing / (1.0 - kSwing);

/// (G1) of firmware/control/greybox.hpp with the figures of the plant's valve: they are the same equation.
std::vector<double> greybox_figures(const plant::ChamberPlant& chamber) {
  const plant::ThinPlateValveConfig sheet = std::get<plant::ThinPlateValve>(chamber.valve()).config();
  const plant::Gas& gas = chamber.gas();
  // of choked flow, a square metre
  const double mL_s_m2 = gas.kappa * gas.specific_gas_constant_J_kg_K() * gas.temperature_K *
                         plant::thin_plate_constants(gas, sheet.discharge_coefficient).beta_s_m / kMl;
  std::vector<double> figures(config::kGreyboxParameters, 0.0);
  figures[config::kOpenAbove] = sheet.open_above_V;
  figures[config::kExhaustBelow] = sheet.exhaust_below_V;
  figures[config::kInletConductance] = mL_s_m2 * sheet.inlet_area_per_V_m2;
  figures[config::kExhaustConductance] = mL_s_m2 * sheet.exhaust_area_per_V_m2;
  figures[config::kInletLeak] = mL_s_m2 * sheet.inlet_leak_m2;
  figures[config::kExhaustLeak] = mL_s_m2 * sheet.exhaust_leak_m2;
  figures[config::kTransition] = mL_s_m2 * sheet.transition_m2;
  figures[config::kCriticalRatio] = 0.528;
  figures[config::kSubsonicIndex] = 0.5;
  figures[config::kCrackingRatio] = 1.0;
  figures[config::kVolumeExponent] = gas.kappa;
  figures[config::kSpoolDamping] = 0.7;  // of no spool, but with a range
  figures[config::kSupply] = chamber.supply_Pa() / kPa;
  figures[config::kAmbient] = chamber.ambient_Pa() / kPa;
  return figures;
}

/// A chamber under commands that jump about, for 30 s.
host::trace::Log recorded(plant::ChamberPlant chamber, plant::Random& random) {
  host::trace::Log log;
  double command_V = 5.0;
  double mean_Pa = chamber.pressure_Pa();
  for (int k = 0; k < 3000; ++k) {
    if (k % 8 == 0) command_V = random.uniform(4.4, 5.6);
    log.time_s.push_back(kTick_s * k);
    log.command_V.push_back(command_V);
    log.pressure_Pa.push_back(mean_Pa);
    log.volume_m3.push_back(chamber.volume_m3());
    mean_Pa = chamber.advance(command_V, kTick_s).mean_Pa;
  }
  return log;
}

std::vector<std::uint8_t> model_of(config::ModelKind kind) {
  plant::Random random(1);
  const plant::ChamberPlant chamber = chamber_plant(kChambers / 2, random);
  if (kind == config::ModelKind::greybox)
    return host::client::encode_model("greybox", greybox_figures(chamber), {});
  const bool repaired = kind == config::ModelKind::tassa9r;
  host::identify::FitOptions options;
  options.form = repaired ? host::identify::Form::repaired : host::identify::Form::published;
  const auto fit = host::identify::fit_tassa9({recorded(chamber, random)}, {}, options);
  return host::client::encode_model(repaired ? "tassa9r" : "tassa9", fit.model.image(), {});
}

/// For every chamber alike: their valves are, and the volume is an input.
Images images_of(config::ModelKind kind) {
  Images images;
  images.fill(model_of(kind));
  return images;
}

Settings with(const Machine::Mistake& mistake, Settings settings) {
  if (mistake) mistake(settings);
  return settings;
}

}  // namespace

const Images& models(config::ModelKind kind) {
  if (kind == config::ModelKind::greybox) {
    static const Images greybox = images_of(kind);
    return greybox;
  }
  if (kind == config::ModelKind::tassa9) {
    static const Images tassa9 = images_of(kind);
    return tassa9;
  }
  static const Images tassa9r = images_of(config::ModelKind::tassa9r);
  return tassa9r;
}

Readings::Readings(std::uint64_t seed) : converter(kConverter, kAnalogInputs, plant::Random(seed)) {}

void Readings::read(std::span<ports::AnalogReading> readings) noexcept {
  converter.read(readings);
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (forced.at(i)) readings[i] = *forced.at(i);
    last.at(i) = readings[i];
  }
}

Machine::Machine(const Images& stored, config::SafeOutput safe_output, std::uint64_t seed,
                 const Mistake& mistake)
    : settings(machine_settings(safe_output)),
      plant(chamber_plants(seed)),
      readings(seed),
      board(with(mistake, settings), {readings, analog_out, digital, can, store}),
      session(*this, kNode),
      phase_(static_cast<double>(seed % 1000)) {
  keep_set(store, stored);
  for (std::size_t c = 0; c < kChambers; ++c) {
    explained_Pa_[c] = plant[c].pressure_Pa();
    volume_before_m3_[c] = plant[c].volume_m3();
  }
}

void Machine::start(canopen::ControlMode mode) {
  session.subscribe([this](const host::client::Arrival& arrival) {
    if (const auto emergency = host::client::decode_emergency(arrival.frame))
      emergencies_.push_back(*emergency);
  });
  board.start();
  session.write(0x1016, 1, std::uint32_t{kMaster} << 16U | kHeartbeat_ms);
  session.write(canopen::object::kControlMode, 0, static_cast<std::int8_t>(mode));
  for (std::size_t c = 0; c < kChambers; ++c) {
    session.write(canopen::object::nth(canopen::object::kExcitation, c), 5, 350e3F);
    session.write(canopen::object::of_module(canopen::object::kHoldSetpoint, c), 1, std::int16_t{2500});
  }
  put(0, {1, kNode});
  tick();
}

void Machine::send(const ports::CanFrame& frame) {
  can.to_board.push_back(frame);
  board.handle_frames();
}

std::optional<ports::CanFrame> Machine::receive(double timeout_s) {
  for (const double end_s = now_s() + timeout_s; can.from_board.empty(); tick()) {
    if (now_s() >= end_s) return std::nullopt;
  }
  const ports::CanFrame frame = can.from_board.front();
  can.from_board.pop_front();
  return frame;
}

void Machine::put(std::uint32_t id, const std::vector<std::uint8_t>& data) {
  if (can.state_now == ports::CanState::bus_off) return;
  ports::CanFrame frame;
  frame.id = id;
  frame.length = static_cast<std::uint8_t>(data.size());
  std::copy(data.begin(), data.end(), frame.data.begin());
  can.to_board.push_back(frame);
}

/// The master's part of a tick: set points that move, SYNC, and its heartbeat.
void Machine::speak() {
  for (std::uint32_t half = 0; setpoints && half < 2; ++half) {
    std::vector<std::uint8_t> data;
    for (std::uint32_t c = 4 * half; c < 4 * half + 4; ++c) {
      const double reference_kPa = 280.0 + 90.0 * std::sin(phase_ + (2.0 + 0.3 * c) * now_s());
      const auto mbar = static_cast<std::uint16_t>(std::lround(10.0 * reference_kPa));
      data.push_back(static_cast<std::uint8_t>(mbar));
      data.push_back(static_cast<std::uint8_t>(mbar >> 8U));
    }
    put(0x200U + 0x100U * half + kNode, data);
  }
  if (syncs) put(0x80, {});
  if (heartbeats) put(0x700U + kMaster, {5});
}

/// The command that the spool answers.
double Machine::spool_V(std::size_t chamber) const {
  const bool powered = digital.outputs.valve_power && !analog_out.held_V.empty();
  const double told_V = powered ? static_cast<double>(analog_out.held_V[chamber]) : kUnpowered_V;
  const std::optional<Jam>& jam = jam_[chamber];
  const bool freed = jam && jam->stuck == Stuck::until_vented && told_V <= static_cast<double>(kVent_V);
  return jam && !freed ? jam->command_V : told_V;
}

void Machine::move_chambers() {
  for (std::size_t c = 0; c < kChambers; ++c) {
    const double before_m3 = plant[c].volume_m3();
    const double mean_Pa = plant[c].advance(spool_V(c), kTick_s).mean_Pa;
    readings.converter.set_mean_V(c, mean_Pa / kPressurePerV_Pa);
    const double per_V_m3 = static_cast<double>(settings.chamber[c].volume_gain_mL_per_V) * kMl;
    readings.converter.set_mean_V(kChambers + c, 0.5 * (before_m3 + plant[c].volume_m3()) / per_V_m3);
  }
  readings.converter.set_mean_V(kSupplyChannel, plant[0].supply_Pa() / kPressurePerV_Pa);
}

void Machine::tick() {
  speak();
  std::array<Valve, kChambers> valve{};
  for (std::size_t c = 0; c < kChambers; ++c) valve[c] = valve_over_tick(c);
  move_chambers();
  for (std::size_t c = 0; c < kChambers; ++c) explain(c, valve[c]);
  board.handle_frames();
  board.tick({.overrun = overrun});
  if (storing) board.store_changed();
  ++ticks;
  for (std::size_t c = 0; c < kChambers; ++c) watch(c);
}

/// By what the outputs held when the tick began.
Machine::Valve Machine::valve_over_tick(std::size_t chamber) const {
  const std::optional<Jam>& jam = jam_[chamber];
  if (jam && jam->stuck == Stuck::for_good) return Valve::stood_open;
  if (!digital.outputs.valve_power || analog_out.held_V.empty())
    return jam ? Valve::stood_open : Valve::stood_shut;
  const float held_V = analog_out.held_V[chamber];
  if (held_V == analog_out.asked_V[chamber] && !unseen[chamber]) return Valve::obeyed;
  return !jam && held_V <= settings.chamber[chamber].null_V ? Valve::stood_shut : Valve::stood_open;
}

/// The most that this tick may have made of what was explained before it.
void Machine::explain(std::size_t chamber, Valve valve) {
  highest_supply_Pa_ = std::max(highest_supply_Pa_, plant[chamber].supply_Pa());
  const double kappa = plant[chamber].gas().kappa;
  const double now_m3 = plant[chamber].volume_m3();
  const double leaked_Pa =
      kTick_s * inflow_Pa_s(chamber, static_cast<double>(settings.chamber[chamber].null_V), 0.0);
  const double risen_Pa = kTick_s * fastest_rise_Pa_s(chamber, 0.0);
  double& explained_Pa = explained_Pa_[chamber];

  if (valve == Valve::stood_shut) {
    explained_Pa = explained_Pa * std::pow(volume_before_m3_[chamber] / now_m3, kappa) + leaked_Pa;
  } else if (valve == Valve::obeyed &&
             ticks_in_reach_[chamber] >= settings.chamber[chamber].over_pressure_ticks) {
    explained_Pa = explained_Pa * std::exp(-emptying_per_s(chamber) * kTick_s) + leaked_Pa;
  } else {
    explained_Pa += risen_Pa;
  }
  ticks_in_reach_[chamber] = valve == Valve::obeyed ? ticks_in_reach_[chamber] + 1 : 0;
  if (ticks_in_reach_[chamber] > 0) explained_Pa = std::max(explained_Pa, most_in_reach_Pa(chamber));
  const double largest_m3 = (1.0 + kSwing) * mean_m3(chamber);
  explained_Pa = std::min(explained_Pa, highest_supply_Pa_ * std::pow(largest_m3 / now_m3, kappa));
  volume_before_m3_[chamber] = now_m3;
}

/// kappa R T/v mdot_c at the smallest volume.
double Machine::inflow_Pa_s(std::size_t chamber, double command_V, double pressure_Pa) const {
  const plant::ChamberPlant& of = plant[chamber];
  const double smallest_m3 = (1.0 - kSwing) * mean_m3(chamber);
  const double flow_kg_s = flows(of, command_V, pressure_Pa, highest_supply_Pa_).inlet_kg_s;
  return pv_per_kg_J(of.gas()) * flow_kg_s / smallest_m3;
}

/// r, of a pressure above `pressure_Pa`.
double Machine::fastest_rise_Pa_s(std::size_t chamber, double pressure_Pa) const {
  return inflow_Pa_s(chamber, static_cast<double>(settings.chamber[chamber].command_high_V), pressure_Pa) +
         plant[chamber].gas().kappa * kFastestMotion_per_s * highest_supply_Pa_;
}

/// a - b.
double Machine::emptying_per_s(std::size_t chamber) const {
  const plant::ChamberPlant& of = plant[chamber];
  const config::ChamberSettings& its = settings.chamber[chamber];
  const double largest_m3 = (1.0 + kSwing) * mean_m3(chamber);
  const double from_Pa = static_cast<double>(its.over_pressure_kPa) * kPa;  // choked, as all above it
  const double flow_kg_s =
      flows(of, static_cast<double>(its.vent_V), from_Pa, highest_supply_Pa_).exhaust_kg_s;
  return pv_per_kg_J(of.gas()) * flow_kg_s / (from_Pa * largest_m3) - of.gas().kappa * kFastestMotion_per_s;
}

double Machine::most_in_reach_Pa(std::size_t chamber) const {
  const config::ChamberSettings& its = settings.chamber[chamber];
  const double limit_Pa = static_cast<double>(its.over_pressure_kPa) * kPa;
  const double from_Pa = limit_Pa - kTick_s * fastest_rise_Pa_s(chamber, 0.0);
  return limit_Pa + kTick_s * fastest_rise_Pa_s(chamber, from_Pa) * (its.over_pressure_ticks + 0.5) +
         kHidden_Pa;
}

void Machine::watch(std::size_t chamber) {
  const config::ChamberSettings& its = settings.chamber[chamber];
  const float command_V = analog_out.asked_V[chamber];
  const bool regulated = command_V >= its.command_low_V && command_V <= its.command_high_V;
  if (!regulated && command_V != its.vent_V && violation_.empty())
    violation_ = accusation(chamber, "is commanded " + std::to_string(command_V) + " V");

  const double pressure_Pa = plant[chamber].pressure_Pa();
  if (pressure_Pa > explained_Pa_[chamber] && over_pressure_.empty()) {
    over_pressure_ = accusation(chamber, "holds " + std::to_string(pressure_Pa / kPa) + " kPa, of which " +
                                             std::to_string(explained_Pa_[chamber] / kPa) + " are explained");
    if (violation_.empty()) violation_ = over_pressure_;
  }
  if (ticks_in_reach_[chamber] > 0) explained_Pa_[chamber] = std::min(explained_Pa_[chamber], pressure_Pa);
}

std::string Machine::accusation(std::size_t chamber, const std::string& what) const {
  std::ostringstream words;
  words << "tick " << ticks << ": chamber " << chamber + 1 << ' ' << what;
  return words.str();
}

void Machine::climb(std::initializer_list<std::uint16_t> words) {
  for (const std::uint16_t word : words) {
    control(word);
    run(2);
  }
}

float Machine::safe_V(std::size_t chamber) const {
  const config::ChamberSettings& its = settings.chamber[chamber];
  return its.safe_output == config::SafeOutput::vent ? its.vent_V : its.null_V;
}

std::vector<host::client::Emergency> Machine::take_emergencies() {
  for (; !can.from_board.empty(); can.from_board.pop_front()) session.hear(can.from_board.front());
  return std::exchange(emergencies_, {});
}

}  // namespace plenum::safety_case
