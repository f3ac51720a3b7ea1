#include "firmware/board.hpp"

#include <algorithm>

namespace plenum {

void Board::start() noexcept {
  controller_.prepare();
  keeper_.start(controller_);
  controller_.show_store(keeper_.image());
}

void Board::handle_frames() noexcept {
  ports::CanFrame frame;
  for (int i = 0; i < kFramesAtOnce && drivers_.can.receive(frame); ++i) controller_.receive(frame);
  send_frames();
}

void Board::send_frames() noexcept {
  while (has_unsent_ || controller_.next_frame(unsent_)) {
    has_unsent_ = !drivers_.can.send(unsent_);
    if (has_unsent_) return;
  }
}

void Board::tick(const TickTiming& timing) noexcept {
  std::array<ports::AnalogReading, kAnalogInputs> readings{};
  drivers_.analog_in.read(readings);
  Inputs inputs;
  std::copy_n(readings.begin(), config::kChambers, inputs.pressure.begin());
  std::copy_n(readings.begin() + config::kChambers, config::kChambers, inputs.position.begin());
  inputs.supply = readings[2 * config::kChambers];
  inputs.digital = drivers_.digital.read();
  inputs.can = drivers_.can.state();
  const std::uint32_t lost = drivers_.can.lost();
  inputs.frames_lost = lost != lost_before_;
  lost_before_ = lost;
  inputs.outputs_ok = outputs_ok_;
  inputs.timing = timing;
  inputs.stored_set_lost = keeper_.take_loss();
  inputs.store_failing = keeper_.failing();
  inputs.configuration_refused = (configuration_refused_ | configuration_refused_.second()) != 0;

  const Outputs outputs = controller_.step(inputs);
  outputs_ok_ = drivers_.analog_out.write(outputs.command_V);
  // A valve whose output has not taken what it was told gets no power, not even for the tick in which 5000h is not told yet.
  drivers_.digital.write(
      {.valve_power = outputs.digital.valve_power && outputs_ok_, .fault_lamp = outputs.digital.fault_lamp});
  if (controller_.take_changed() != 0) keeper_.models_changed();
  controller_.show_store(keeper_.image());
  // As the node forgets those that wait behind it.
  if (inputs.can == ports::CanState::bus_off && has_unsent_)
    has_unsent_ = !controller_.node().is_tpdo(unsent_);
  send_frames();
}

void Board::store_changed() noexcept {
  keeper_.step(controller_);
  controller_.show_store(keeper_.image());
}

}  // namespace plenum
