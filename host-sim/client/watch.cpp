#include "host-sim/client/watch.hpp"

#include <bit>
#include <span>

#include "firmware/canopen/cia301.hpp"

namespace plenum::host::client {
namespace {

namespace cob = canopen::cob;

constexpr double kPa_per_mbar = 100.0;
constexpr std::int16_t kNoPressure_mbar = -32768;  ///< what a NaN reads as

std::optional<double> millibar_at(const CanFrame& frame, std::size_t place) {
  const auto mbar = static_cast<std::int16_t>(canopen::load_le(std::span(frame.data).subspan(2 * place, 2)));
  if (mbar == kNoPressure_mbar || mbar == 0)
    return std::nullopt;  // absolute: 0 is of a chamber that is not in use
  return kPa_per_mbar * mbar;
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
  if ((frame.id & 0x7FU) != node_id_) return false;
  switch (frame.id & ~0x7FU) {
    case cob::kTpdo1:
    case cob::kTpdo1 + 0x100:
      if (frame.length != 8) return false;
      for (std::size_t i = 0; i < 4; ++i) {
        chamber_[(frame.id >= cob::kTpdo1 + 0x100 ? 4 : 0) + i].actual_Pa = {millibar_at(frame, i), time_s};
      }
      break;
    case cob::kTpdo1 + 0x200:
      if (frame.length != 2) return false;
      status_word_ = {static_cast<std::uint16_t>(canopen::load_le(std::span(frame.data).first<2>())), time_s};
      break;
    case cob::kRpdo1:
    case cob::kRpdo1 + 0x100:
    case cob::kRpdo1 + 0x200:
    case cob::kRpdo1 + 0x300:
      if (frame.length != 8) return false;
      take_setpoints(time_s, (frame.id - cob::kRpdo1) / 0x100, frame);
      return true;
    case cob::kHeartbeat:
      if (frame.length != 1) return false;
      nmt_ = {static_cast<canopen::NmtState>(frame.data[0] & 0x7FU), time_s};
      if (nmt_.value == canopen::NmtState::initialising)
        nmt_.value.reset();  // the boot-up: that is over with it
      break;
    default: {
      const auto emergency = decode_emergency(frame);
      if (!emergency) return false;
      emergency_ = emergency;
    }
  }
  board_s_ = time_s;
  return true;
}

/// Four values in mbar a PDO, in RPDO1 and 2; or two REAL32 a PDO in RPDO1 to 4, which RPDO3 and 4 give away: in mbar they
/// carry the control word.
void Watch::take_setpoints(double time_s, std::size_t pdo, const CanFrame& frame) {
  pascal_ = pascal_ || pdo >= 2;
  const std::size_t count = pascal_ ? 2 : 4;
  for (std::size_t i = 0; i < count; ++i) {
    Heard<double>& setpoint_Pa = chamber_[count * pdo + i].setpoint_Pa;
    if (pascal_) {
      const auto bits = canopen::load_le(std::span(frame.data).subspan(4 * i, 4));
      setpoint_Pa = {static_cast<double>(std::bit_cast<float>(bits)), time_s};
    } else {
      setpoint_Pa = {millibar_at(frame, i), time_s};
    }
  }
}

}  // namespace plenum::host::client
