// What a board remembers of its chambers: the last ticks in which their valves were driven, a row a tick.
//
// One ring for all chambers. It rolls from the start; a client freezes it to read it, or has it record a given
// number of ticks and freeze by itself. Only a frozen log can be read: nothing that is read changes meanwhile.
//
// The log of one chamber as bytes, little endian, no padding:
//    0  u32  magic "PLL1"                       12  f32  time from one row to the next [s]
//    4  u32  tick count (2200h:1) of the last   16  f32  LSB of the command code [V]
//            row                                20       rows, the oldest first
//    8  u16  rows n                             20 + 12 n  u32  CRC-32 (IEEE 802.3) of all bytes before it
//   10  u8   chamber, from 0
//   11  u8   bytes of a row: 12
// and a row:
//    0  f32  pressure [Pa], absolute: the mean over the tick before the row's time
//    4  f32  volume [m3] at the row's time
//    8  u16  code of the command held from the row's time on
//   10  u16  flags: row_flag
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/config/limits.hpp"
#include "firmware/config/units.hpp"

namespace plenum::telemetry {

inline constexpr std::size_t kLogTicks = 1024;  ///< 10.24 s; a power of two

inline constexpr std::uint32_t kLogMagic = 0x314C4C50U;  // "PLL1"
inline constexpr std::size_t kHeaderBytes = 20;
inline constexpr std::size_t kRowBytes = 12;
inline constexpr std::size_t kCrcBytes = 4;

/// FFFFh stands for 10 V.
inline constexpr float kCommandLsb_V = 10.0F / 65535.0F;

/// The nearest code; 0 for not-a-number.
std::uint16_t command_code(numeric::Scalar command_V) noexcept;

namespace row_flag {
inline constexpr std::uint16_t kMeasured =
    1;                                        ///< the pressure was measured in the tick before the row's time
inline constexpr std::uint16_t kFollows = 2;  ///< the row before it is of the tick before
inline constexpr std::uint16_t kExcited = 4;  ///< the command is the excitation's, not the regulator's
}  // namespace row_flag

struct Row {
  float pressure_kPa = 0.0F;
  float volume_mL = 0.0F;
  std::uint16_t command = 0;
  std::uint16_t flags = 0;

  float command_V() const noexcept { return static_cast<float>(command) * kCommandLsb_V; }
  bool has(std::uint16_t flag) const noexcept { return (flags & flag) != 0; }
};

/// One recorded quantity: where it stands in a row, and what one step of it is worth.
struct Column {
  const char* name;
  const char* unit;  ///< empty: a pure number
  std::uint8_t offset;
  std::uint8_t bytes;
  bool real;  ///< REAL32; otherwise an unsigned integer
  float lsb;  ///< unit of an integer's step
};

/// The columns of a row, in order.
std::span<const Column> columns() noexcept;

class Recorder {
 public:
  /// What a client asks for (2300h:1).
  enum class Order : std::uint8_t {
    roll = 0,    ///< keep the last kLogTicks rows, always
    freeze = 1,  ///< keep what is there
    record = 2   ///< forget what is there, keep the next length() rows, then freeze
  };
  enum class State : std::uint8_t { rolling = 0, recording = 1, frozen = 2 };

  struct Sample {
    config::Pascals pressure_Pa;
    config::CubicMetres volume_m3;
    config::Volts command_V;
    bool measured = false;
  };
  using Samples = std::array<Sample, config::kChambers>;

  /// One row of all chambers, while their valves are driven. `tick` counts all ticks of the board.
  void write(std::uint32_t tick, bool excited, const Samples& samples) noexcept;

  /// Returns false, and changes nothing, for an order that is none.
  bool order(std::uint8_t what) noexcept;
  std::uint8_t last_order() const noexcept { return static_cast<std::uint8_t>(order_); }
  /// A client is gone: chamber and length go back to those of the start, and a recording under way rolls on. A frozen log stays as
  /// it is, for who comes to read what has happened.
  void forget_orders() noexcept;
  /// Whose log is read. Returns false for a chamber that the board does not have.
  bool select(std::uint8_t chamber) noexcept;
  std::uint8_t selected() const noexcept { return chamber_; }
  /// Rows of the next Order::record, 1..kLogTicks. Returns false for any other number.
  bool set_length(std::uint16_t rows) noexcept;
  std::uint16_t length() const noexcept { return length_; }
  State state() const noexcept { return state_; }

  // Rows by number, counted since the start and wrapping: begin() is the oldest that is held, end() the next one.
  std::uint32_t begin() const noexcept { return end_ - held_; }
  std::uint32_t end() const noexcept { return end_; }
  std::uint16_t rows() const noexcept { return static_cast<std::uint16_t>(held_); }
  /// `number` from begin() to before end(), `chamber` < kChambers.
  const Row& row(std::uint32_t number, std::size_t chamber) const noexcept {
    return ring_[number % kLogTicks][chamber];
  }

  /// Bytes of the selected chamber's log.
  std::uint32_t size() const noexcept;
  /// Its bytes from `offset` on, as many as fit; returns their count. Only of a frozen log. The CRC is computed as the
  /// reader goes on: the work is in proportion to the bytes read forward.
  std::size_t read(std::uint32_t offset, std::span<std::uint8_t> bytes) noexcept;

 private:
  /// The header, a row or the CRC, whichever holds a byte.
  struct Piece {
    std::uint32_t first = 0;  ///< offset of its first byte
    std::uint32_t size = 0;
    std::array<std::uint8_t, kHeaderBytes> bytes{};
  };
  Piece piece_at(std::uint32_t offset) const noexcept;
  void advance_crc(std::uint32_t to) noexcept;
  void restart_crc() noexcept;

  std::array<std::array<Row, config::kChambers>, kLogTicks> ring_{};
  std::uint32_t end_ = 0;
  std::uint32_t held_ = 0;
  std::uint32_t last_tick_ = 0;
  Order order_ = Order::roll;
  State state_ = State::rolling;
  std::uint8_t chamber_ = 0;
  std::uint16_t length_ = kLogTicks;
  std::uint32_t crc_ = 0;  ///< of the log's first crc_bytes_ bytes
  std::uint32_t crc_bytes_ = 0;
};

}  // namespace plenum::telemetry
