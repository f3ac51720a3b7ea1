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
  if (frame.extended || frame.remote || !understand(frame)) return;
  view_.time_s = time_s;
  ++view_.frames;
}

bool Watch::understand(const CanFrame& frame) {
  if (stream_) {
    if (const auto sample = stream_->decode(frame)) {
      ChamberView& chamber = view_.chamber[sample->chamber];
      chamber.actual_Pa = sample->actual_Pa;
      chamber.command_V = sample->command_V;
      chamber.volume_m3 = sample->volume_m3;
      return true;
    }
  }
  if ((frame.id & 0x7FU) != node_id_) return false;
  switch (frame.id & ~0x7FU) {
    case cob::kTpdo1:
    case cob::kTpdo1 + 0x100:
      if (frame.length != 8) return false;
      for (std::size_t i = 0; i < 4; ++i) {
        view_.chamber[(frame.id >= cob::kTpdo1 + 0x100 ? 4 : 0) + i].actual_Pa = millibar_at(frame, i);
      }
      return true;
    case cob::kTpdo1 + 0x200:
      if (frame.length != 2) return false;
      view_.status_word = static_cast<std::uint16_t>(canopen::load_le(std::span(frame.data).first<2>()));
      return true;
    case cob::kRpdo1:
    case cob::kRpdo1 + 0x100:
    case cob::kRpdo1 + 0x200:
    case cob::kRpdo1 + 0x300:
      if (frame.length != 8) return false;
      take_setpoints((frame.id - cob::kRpdo1) / 0x100, frame);
      return true;
    case cob::kHeartbeat:
      if (frame.length != 1) return false;
      view_.nmt = static_cast<canopen::NmtState>(frame.data[0] & 0x7FU);
      return true;
    default:
      break;
  }
  const auto emergency = decode_emergency(frame);
  if (!emergency) return false;
  view_.error_code = emergency->code;
  view_.fault_chamber = emergency->chamber;
  return true;
}

/// Four values in mbar a PDO, in RPDO1 and 2; or two REAL32 a PDO in RPDO1 to 4, which RPDO3 and 4 give away: in mbar they
/// carry the control word.
void Watch::take_setpoints(std::size_t pdo, const CanFrame& frame) {
  pascal_ = pascal_ || pdo >= 2;
  const std::size_t count = pascal_ ? 2 : 4;
  for (std::size_t i = 0; i < count; ++i) {
    std::optional<double>& setpoint_Pa = view_.chamber[count * pdo + i].setpoint_Pa;
    if (pascal_) {
      setpoint_Pa = static_cast<double>(
          std::bit_cast<float>(canopen::load_le(std::span(frame.data).subspan(4 * i, 4))));
    } else {
      setpoint_Pa = millibar_at(frame, i);
    }
  }
}

}  // namespace plenum::host::client
