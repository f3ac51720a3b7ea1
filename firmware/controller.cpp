#include "firmware/controller.hpp"

#include <algorithm>

#include "firmware/config/units.hpp"
#include "firmware/numeric/fixed.hpp"

namespace plenum {
namespace {

/// An output that refuses its safe value holds the last one: without power the valve is safe all the same. Power that an emergency
/// stop has taken comes back by a reset, not when the circuit closes. And settings that stand in for others may be wrong about
/// the valves.
constexpr safety::FaultSet kWithoutPower = safety::only(safety::Fault::hardware) |
                                           safety::only(safety::Fault::emergency_stop) |
                                           safety::only(safety::Fault::configuration_refused);

/// Each chamber is excited by a sequence of its own.
std::uint32_t chamber_seed(std::uint32_t seed, std::size_t chamber) noexcept {
  constexpr std::uint32_t kGoldenRatio = 0x9E3779B9U;
  return seed + kGoldenRatio * static_cast<std::uint32_t>(chamber + 1);
}

/// With those that were left out. No watch waits for longer than this many.
std::uint32_t ticks_passed(const TickTiming& timing) noexcept {
  constexpr std::uint32_t kMost = UINT16_MAX;
  return 1 + std::min(timing.missed, kMost);
}

/// An order of the bus in which a bit has flipped was given by nobody. Returns false when there was one.
bool withdraw_spoilt_orders(canopen::ProcessImage& image) noexcept {
  bool intact = image.control_word.intact() && image.control_mode.intact() && image.preview_ticks.intact();
  if (!intact) {
    image.control_word = 0;
    image.control_mode = canopen::ControlMode::pressure_closed_loop;
    image.preview_ticks = 0;
  }
  for (canopen::ChamberImage& chamber : image.chamber) {
    if (chamber.setpoint_Pa.intact() && chamber.hold_setpoint_Pa.intact()) continue;
    intact = false;
    chamber.setpoint_Pa = numeric::Scalar(0);  // the lowest that its limits allow
    chamber.hold_setpoint_Pa = numeric::Scalar(0);
  }
  return intact;
}

/// Of a sensor that is fitted, and says what is enough; 0: none. Where it says less, it is broken, or the supply is: fault 3412h.
numeric::Scalar believed_supply_kPa(const config::BoardSettings& settings,
                                    const ports::AnalogReading& reading) noexcept {
  const bool fitted = settings.supply_low_kPa > 0.0F;
  return fitted && safety::supply_suffices(settings, reading.mean_V, reading.fresh)
             ? numeric::Scalar(config::supply_kPa(settings, reading.mean_V))
             : numeric::Scalar(0);
}

/// While it lives, what saturates is of this board, and counted where the bus shows it. (The count of numeric::Fixed is the
/// thread's, in which other boards may compute, too.) Of frames that come nothing can but the code of a volume far beyond its scale,
/// which is cut off anyway: with what is a Scalar they compute no more than codes and the bends of a port (config::ValveCurve::bent_V),
/// of an opening of a volt and of parameters that have passed their ranges.
class CountedSaturations {
 public:
  explicit CountedSaturations(canopen::ProcessImage& image) noexcept : image_(image) {}
  CountedSaturations(const CountedSaturations&) = delete;
  CountedSaturations& operator=(const CountedSaturations&) = delete;
  ~CountedSaturations() { image_.saturation_count += numeric::Fixed::saturations() - before_; }

 private:
  canopen::ProcessImage& image_;
  const std::uint32_t before_ = numeric::Fixed::saturations();
};

}  // namespace

Controller::Controller(const Settings& settings) noexcept
    : regulator_(settings.regulator),
      regulator_seal_(config::sum_of_object(regulator_)),
      settings_(settings.board, settings.chamber),
      inverse_run_(settings_),
      shadow_run_(recorder_, settings.regulator.valve_delay_ticks),
      slots_(&shadow_run_, &inverse_run_),
      node_(settings.node, image_, slots_, settings_, recorder_) {
  const CountedSaturations counted(image_);
  configure(0xFF);
}

config::ImageVerdict Controller::restore(std::uint8_t chamber, std::span<const std::uint8_t> image) noexcept {
  const CountedSaturations counted(image_);
  const config::ImageVerdict verdict = slots_.stage(chamber, image);
  if (!verdict) return verdict;
  slots_.prove(chamber, {}, {});  // it was in force before
  const std::uint32_t crc = config::trailing_crc(image);
  slots_.commit(static_cast<std::uint8_t>(1U << chamber), config::commit_crc({&crc, 1}), config::kForceKey);
  take_over(slots_.apply_at_tick_edge());
  return verdict;
}

std::uint8_t Controller::take_changed() noexcept {
  const std::uint8_t changed = changed_;
  changed_ = 0;
  return changed;
}

void Controller::configure(std::uint8_t changed) noexcept {
  for (std::size_t c = 0; c < config::kChambers; ++c) {
    if ((std::uint32_t{changed} >> c & 1U) == 0) continue;
    const config::ChamberSettings& chamber = settings_.chamber(c);
    chamber_[c].configure(chamber, regulator_);
    slots_.expect(c, {.valve = chamber.valve_serial, .sensor = chamber.sensor_serial});
  }
}

void Controller::take_over(std::uint8_t changed) noexcept {
  for (std::size_t c = 0; c < config::kChambers; ++c) {
    if ((std::uint32_t{changed} >> c & 1U) != 0) chamber_[c].take_over(slots_.active(c));
  }
}

/// Looks at what is long of one chamber a tick, and at what is short every time, before anything of it is used or written anew.
bool Controller::memory_upset() noexcept {
  const std::size_t c = image_.tick_count % config::kChambers;
  const bool chamber_intact = chamber_[c].intact();
  const bool kept_intact = settings_.intact(c) && slots_.intact(c);
  const unsigned others = damaged_ & ~(1U << c);
  damaged_ = static_cast<std::uint8_t>(chamber_intact && kept_intact ? others : others | 1U << c);
  bool states_intact = true;
  for (ChamberLoop& chamber : chamber_) states_intact = chamber.state_intact() && states_intact;
  const bool orders_intact = withdraw_spoilt_orders(image_);
  const bool regulator_intact = regulator_seal_ == config::sum_of_object(regulator_);
  return damaged_ != 0 || !regulator_intact || !settings_.intact(config::kChambers) ||
         !supervisor_.intact() || !faults_.intact() || !orders_intact || !states_intact || !node_.intact();
}

Outputs Controller::step(const Inputs& inputs) noexcept {
  const CountedSaturations counted(image_);
  const bool upset = memory_upset();
  const std::uint8_t reset = settings_.take_changed();
  const std::uint8_t changed = slots_.apply_at_tick_edge();
  configure(reset);
  take_over(static_cast<std::uint8_t>(changed | reset));  // a model is bound to the range of commands
  changed_ = static_cast<std::uint8_t>(changed_ | changed);

  const safety::FaultReport report = judge(inputs, upset);
  bool models_ready = true;
  for (const ChamberLoop& chamber : chamber_) {
    models_ready = models_ready && (!chamber.in_use() || chamber.has_model() || !model_needed());
  }
  const safety::Supervisor::Output order = supervisor_.step({.control_word = image_.control_word,
                                                             .ready = true,
                                                             .model_ready = models_ready,
                                                             .reaction = report.reaction});
  const bool valve_power =
      order.state != safety::State::not_ready && (faults_.standing_on_board() & kWithoutPower) == 0;
  Outputs outputs = drive(order.drive, valve_power);
  outputs.digital = {.valve_power = valve_power, .fault_lamp = report.any};
  last_drive_ = order.drive;

  image_.status_word = static_cast<std::uint16_t>(order.status_word | regulation_bits());
  image_.error_code = report.code;
  image_.error_register = report.error_register;
  image_.fault_chamber = report.chamber;
  for (std::size_t c = 0; c < config::kChambers; ++c) image_.standing_faults[c + 1] = faults_.standing(c);
  image_.standing_faults[0] = faults_.standing_on_board();
  image_.bus_off = inputs.can == ports::CanState::bus_off;
  image_.supply_Pa = config::supply_kPa(settings_.board(), inputs.supply.mean_V) * config::kPascal_per_kPa;
  ++image_.tick_count;
  // What led to a fault stays, though in HOLD the valves are driven on.
  if (report.reaction == safety::Reaction::none) record(order.drive);
  if (!inverse_run_.step(slots_)) shadow_run_.step(slots_);
  image_.overrun_count += inputs.timing.overrun != Overrun::none ? 1U : 0U;
  image_.latency.add(inputs.timing.latency_us);
  image_.scan_age_us = inputs.timing.scan_age_us;
  node_.tick(ticks_passed(inputs.timing) * config::kTick_us);
  return outputs;
}

safety::FaultReport Controller::judge(const Inputs& inputs, bool upset) noexcept {
  constexpr std::uint16_t kRegulates = safety::control_bit::kD | safety::control_bit::kH;
  const bool asked = (image_.control_word & kRegulates) == kRegulates;
  // by now: setpoint_lost is a tick old
  const bool active_asked = (image_.control_word & canopen::word::kStateMask) == canopen::word::kActive;
  // In excitation there are no set points: there the master shows by its SYNC that it is still there.
  const std::uint32_t master_count = model_needed() ? image_.setpoint_count : image_.sync_count;
  const std::uint32_t ticks = ticks_passed(inputs.timing);
  const safety::FaultSet board_causes =
      monitor_.step(settings_.board(), {.ticks = ticks,
                                        .emergency_stop = inputs.digital.emergency_stop,
                                        .outputs_ok = inputs.outputs_ok,
                                        .memory_upset = upset,
                                        .configuration_refused = inputs.configuration_refused,
                                        .tick_late = inputs.timing.overrun == Overrun::fault,
                                        .supply_V = inputs.supply.mean_V,
                                        .supply_fresh = inputs.supply.fresh,
                                        .bus_off = inputs.can == ports::CanState::bus_off,
                                        .error_passive = inputs.can == ports::CanState::error_passive,
                                        .frames_lost = inputs.frames_lost,
                                        .heartbeat_lost = image_.heartbeat_lost,
                                        .setpoint_lost = image_.setpoint_lost && active_asked,
                                        .pdo_short = image_.pdo_short,
                                        .pdo_long = image_.pdo_long,
                                        .sync_misfits = image_.sync_misfits,
                                        .stored_set_lost = inputs.stored_set_lost,
                                        .store_failing = inputs.store_failing,
                                        .setpoint_count = master_count,
                                        .setpoints_needed = last_drive_ == safety::Drive::active});
  const bool was_active = last_drive_ == safety::Drive::active;
  const numeric::Scalar supply_kPa = believed_supply_kPa(settings_.board(), inputs.supply);
  safety::ChamberFaults causes{};
  for (std::size_t c = 0; c < config::kChambers; ++c) {
    setpoint_news_[c].step((std::uint32_t{image_.setpoints_came} >> c & 1U) != 0, was_active,
                           settings_.board().setpoint_watchdog_ticks, ticks);
    causes[c] = chamber_[c].measure({.ticks = ticks,
                                     .pressure = inputs.pressure[c],
                                     .position = inputs.position[c],
                                     .supply_kPa = supply_kPa},
                                    asked, model_needed());
    if (inputs.position[c].fresh) image_.chamber[c].position_V = inputs.position[c].mean_V;
  }
  image_.setpoints_came = 0;
  // neither the word in which R has risen nor what came after it asks for motion
  const bool risen = image_.reset_word.intact() && image_.reset_word != 0;
  const bool reset =
      risen && supervisor_.accepts_reset(image_.reset_word) && supervisor_.accepts_reset(image_.control_word);
  image_.reset_word = 0;
  return faults_.step(causes, board_causes, reset);
}

/// Bits 8 to 11 of 6041h.
std::uint16_t Controller::regulation_bits() const noexcept {
  std::uint8_t any = 0;
  bool watched = false;
  bool on_target = true;
  for (std::size_t c = 0; c < config::kChambers; ++c) {
    any = static_cast<std::uint8_t>(any | image_.chamber[c].regulation);
    if (!chamber_[c].in_use() || !settings_.chamber(c).target_watched) continue;
    watched = true;
    on_target = on_target && (image_.chamber[c].regulation & canopen::regulation::kOnTarget) != 0;
  }
  const std::uint8_t of_all = watched && on_target ? canopen::regulation::kOnTarget : std::uint8_t{0};
  return static_cast<std::uint16_t>(((any & ~canopen::regulation::kOnTarget) | of_all) << 8U);
}

/// What stands in 6380h may be of yesterday: until a set point of now has come a chamber goes on in ACTIVE as in HOLD.
safety::Drive Controller::drive_of(std::size_t chamber, safety::Drive drive) const noexcept {
  const bool follows = drive == safety::Drive::active && model_needed();
  return follows && !setpoint_news_[chamber].is_of_now() ? safety::Drive::hold : drive;
}

Outputs Controller::drive(safety::Drive drive, bool powered) noexcept {
  Outputs outputs;
  image_.must_vent = 0;
  for (std::size_t c = 0; c < config::kChambers; ++c) {
    const ChamberLoop::Order order{
        .drive = drive_of(c, drive),
        .must_vent = faults_.must_vent(c),
        .powered = powered,
        .commanded = (safety::status_word(supervisor_.state()) & safety::control_bit::kD) != 0,
        .mode = image_.control_mode,
        .preview_ticks = image_.preview_ticks,
        .excitation_seed = chamber_seed(image_.chamber[c].excitation.seed, c)};
    if (order.must_vent) image_.must_vent = static_cast<std::uint8_t>(image_.must_vent | 1U << c);
    outputs.command_V[c] = chamber_[c].command(order, image_.chamber[c]);
  }
  return outputs;
}

void Controller::record(safety::Drive drive) noexcept {
  if (drive != safety::Drive::active && drive != safety::Drive::hold) return;
  telemetry::Recorder::Samples samples;
  for (std::size_t c = 0; c < config::kChambers; ++c) {
    const canopen::ChamberImage& chamber = image_.chamber[c];
    samples[c] = {.pressure_Pa = chamber.actual_Pa,
                  .volume_m3 = chamber.volume_m3,
                  .command_V = chamber.command_V,
                  .measured = chamber_[c].pressure_fresh()};
  }
  recorder_.write(image_.tick_count, !model_needed(), samples);
}

}  // namespace plenum
