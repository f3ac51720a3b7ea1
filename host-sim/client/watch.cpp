#include "host-sim/client/watch.hpp"

#include "firmware/canopen/object_dictionary.hpp"

namespace plenum::host::client {
namespace {

namespace cob = canopen::cob;
namespace object = canopen::object;

/// Absolute: 0 is of a chamber that is not in use.
std::optional<double> pressure(double value_Pa) {
  return value_Pa > 0.0 ? std::optional(value_Pa) : std::nullopt;
}

}  // namespace

void Watch::take(double time_s, const CanFrame& frame) {
  if (frame.extended || frame.remote || !understand(time_s, frame)) return;
  ++frames_;
}

BoardView Watch::view(double now_s) const {
  BoardView view;
  view.frames = frames_;
  view.nmt = nmt_.at(now_s);
  view.status_word = status_word_.at(now_s);
  if (board_s_ && now_s - *board_s_ >= kStale_s) view.silent_s = now_s - *board_s_;
  if (emergency_) {
    view.error_code = emergency_->code;
    view.fault_chamber = emergency_->chamber;
  }
  for (std::size_t c = 0; c < kChambers; ++c) {
    view.chamber[c] = {.setpoint_Pa = chamber_[c].setpoint_Pa.at(now_s),
                       .actual_Pa = chamber_[c].actual_Pa.at(now_s),
                       .command_V = chamber_[c].command_V.at(now_s),
                       .volume_m3 = chamber_[c].volume_m3.at(now_s)};
  }
  return view;
}

bool Watch::understand(double time_s, const CanFrame& frame) {
  if (stream_) {
    if (const auto sample = stream_->decode(frame)) {
      Chamber& chamber = chamber_[sample->chamber];
      chamber.actual_Pa = {sample->actual_Pa, time_s};
      chamber.command_V = {sample->command_V, time_s};
      chamber.volume_m3 = {sample->volume_m3, time_s};
      board_s_ = time_s;
      return true;
    }
  }
  pdos_.hear(frame);
  if (const auto pdo = pdos_.read(frame)) return pdo->node == node_id_ && take_pdo(time_s, *pdo);
  if ((frame.id & 0x7FU) != node_id_) return false;
  if ((frame.id & ~0x7FU) == cob::kHeartbeat) {
    if (frame.length != 1) return false;
    nmt_ = {static_cast<canopen::NmtState>(frame.data[0] & 0x7FU), time_s};
    if (nmt_.value == canopen::NmtState::initialising)
      nmt_.value.reset();  // the boot-up: that is over with it
  } else {
    const auto emergency = decode_emergency(frame);
    if (!emergency) return false;
    emergency_ = emergency;
  }
  board_s_ = time_s;
  return true;
}

bool Watch::take_pdo(double time_s, const Pdo& pdo) {
  if (!pdo.values) return false;
  for (const PdoValue& value : *pdo.values) take_value(time_s, value);
  if (!pdo.receive) board_s_ = time_s;
  return true;
}

void Watch::take_value(double time_s, const PdoValue& value) {
  const auto is = [&value](std::uint16_t index, std::uint8_t sub) {
    return value.entry->index == index && value.sub == sub;
  };
  if (is(object::kStatusWord, 0)) status_word_ = {static_cast<std::uint16_t>(value.value), time_s};
  if (value.instance >= kChambers) return;
  Chamber& chamber = chamber_[value.instance];
  if (is(object::kSetpoint, 1) || is(object::kPascals, 1))
    chamber.setpoint_Pa = {pressure(value.value), time_s};
  if (is(object::kActual, 1) || is(object::kPascals, 2)) chamber.actual_Pa = {pressure(value.value), time_s};
  if (is(object::kPascals, 3)) chamber.volume_m3 = {value.value, time_s};
  if (is(object::kCodes, 1)) chamber.command_V = {kCommandLsb_V * value.value, time_s};
  if (is(object::kRegulator, 3)) chamber.command_V = {value.value, time_s};
}

}  // namespace plenum::host::client
