// The capture stream: one TPDO a chamber, sent by the board each tick whatever comes from the bus, packed so that pressure, command and volume of one tick
// share a frame.
//
//   bytes 0..3 actual pressure REAL32 [Pa] | 4..5 command U16, LSB 10 V / 65535 | 6..7 volume U16, LSB of
//   object 2228h:2
//
// or, of a board at rest, whose commands tell nothing: bytes 4..7 position sensor REAL32 [V].
//
// A board that has a sensor at its supply can send that, too: REAL32 [Pa] in its TPDO4, before the chambers of the tick.
//
// Boards that stream at once do so on identifiers of their own: CiA 301 leaves 680h to 6DFh free for PDOs (it restricts 6E0h to 6FFh), which
// is twelve blocks of one identifier a chamber. Node ids 1 to 12 have a block each, and so on; Session::configure_stream() passes over a block
// that another streams on.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "firmware/canopen/objects.hpp"
#include "host-sim/client/link.hpp"

namespace plenum::host::client {

inline constexpr std::size_t kChambers = plenum::config::kChambers;

inline constexpr double kCommandLsb_V = 10.0 / 65535.0;  ///< of 2220h + c:1 (2228h:1)

inline constexpr std::uint32_t kSupplyTpdo = 3;  ///< of those of a board, from 0: the supply's ...
inline constexpr std::uint32_t kStreamTpdo = 4;  ///< ... and chamber 0's

inline constexpr std::uint32_t kStreamIds = 0x680;        ///< the first of the first block
inline constexpr std::uint32_t kStreamBlock = kChambers;  ///< identifiers of a block
inline constexpr std::uint32_t kStreamBlocks = 12;

/// Which block a frame's identifier is of; empty for one that is no stream's.
std::optional<std::uint32_t> stream_block(const CanFrame& frame);

struct StreamConfig {
  std::uint8_t chambers = 0xFF;  ///< bit c: chamber c
  std::uint8_t every_ticks = 1;  ///< 1..240
  bool position = false;         ///< the position sensor's voltage in the place of command and volume
  bool supply = false;           ///< and the supply's pressure
  double largest_volume_m3 =
      6.5535e-3;  ///< what code FFFFh stands for: the smaller, the finer (1/65535 of it)
};

struct StreamSample {
  std::size_t chamber = 0;
  double actual_Pa = 0.0;  ///< mean over the tick just past
  double command_V = 0.0;  ///< held from this tick to the next
  double volume_m3 = 0.0;
  double position_V = 0.0;  ///< StreamConfig::position; command and volume are 0 then
};

/// All chambers of one tick.
struct StreamRow {
  double time_s = 0.0;                           ///< arrival of its first frame
  std::uint8_t chambers = 0;                     ///< which of them arrived
  std::array<StreamSample, kChambers> sample{};  ///< valid where `chambers` says so
  std::optional<double> supply_Pa{};             ///< mean over the tick just past
};

/// Decodes the frames of one board's stream, and gathers them to rows.
class Stream {
 public:
  /// `first_cob_id` is that of chamber 0, `supply_cob_id` that of the supply where it is sent; `volume_lsb_m3` as the board has it.
  Stream(const StreamConfig& config, std::uint32_t first_cob_id, std::uint32_t supply_cob_id,
         double volume_lsb_m3);

  std::uint32_t first_cob_id() const { return first_cob_id_; }

  /// The sample that a frame carries; empty when the frame is none of this stream.
  std::optional<StreamSample> decode(const CanFrame& frame) const;

  /// Adds a frame. Calls `on_row` when it completes a row, or when it shows that the row before it will stay
  /// incomplete (that one is handed over with `chambers` short of the configured ones), each with the supply's pressure that came last.
  /// Returns whether the frame was of this stream.
  bool accept(double time_s, const CanFrame& frame, const std::function<void(const StreamRow&)>& on_row);

 private:
  StreamConfig config_;
  std::uint32_t first_cob_id_;
  std::uint32_t supply_cob_id_;
  double volume_lsb_m3_;
  StreamRow row_;
  std::optional<double> supply_Pa_;  ///< the newest
};

}  // namespace plenum::host::client
