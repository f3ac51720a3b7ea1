#include "firmware/board.hpp"

#include <algorithm>

namespace plenum {

void Board::start() noexcept {
  for (std::uint8_t c = 0; c < config::kChambers; ++c) {
    std::array<std::uint8_t, config::kMaxImageBytes> bytes{};
    const std::size_t size = drivers_.store.load(c, bytes);
    if (size > 0) controller_.restore(c, std::span(bytes).first(size));
  }
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

void Board::tick(bool late) noexcept {
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
  inputs.tick_late = late;

  const Outputs outputs = controller_.step(inputs);
  outputs_ok_ = drivers_.analog_out.write(outputs.command_V);
  drivers_.digital.write(outputs.digital);
  to_store_ = static_cast<std::uint8_t>(to_store_ | controller_.take_changed());
  send_frames();
}

void Board::store_changed() noexcept {
  for (std::uint8_t c = 0; c < config::kChambers; ++c) {
    const std::uint8_t bit = static_cast<std::uint8_t>(1U << c);
    if ((to_store_ & bit) == 0 || !drivers_.store.store(c, controller_.active_image(c))) continue;
    to_store_ = static_cast<std::uint8_t>(to_store_ & ~bit);
  }
}

}  // namespace plenum
