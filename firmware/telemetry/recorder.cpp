#include "firmware/telemetry/recorder.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>

#include "firmware/config/crc32.hpp"
#include "firmware/numeric/nearest.hpp"

namespace plenum::telemetry {
namespace {

constexpr std::array<Column, 4> kColumns = {{
    {"pressure_Pa", "Pa", 0, 4, true, 1.0F},
    {"volume_m3", "m3", 4, 4, true, 1.0F},
    {"command_V", "V", 8, 2, false, kCommandLsb_V},
    {"flags", "", 10, 2, false, 1.0F},
}};

class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> bytes) noexcept : bytes_(bytes) {}
  Writer& integer(std::uint32_t x, std::size_t size) noexcept {
    for (std::size_t i = 0; i < size; ++i) bytes_[at_++] = static_cast<std::uint8_t>(x >> (8 * i));
    return *this;
  }
  Writer& real(float x) noexcept { return integer(std::bit_cast<std::uint32_t>(x), 4); }

 private:
  std::span<std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

}  // namespace

std::uint16_t command_code(numeric::Scalar command_V) noexcept {
  constexpr auto kCodes_per_V = numeric::Scalar(1.0F / kCommandLsb_V);
  return static_cast<std::uint16_t>(numeric::nearest_within(command_V * kCodes_per_V, 0, 65535, 0));
}

std::span<const Column> columns() noexcept {
  return kColumns;
}

void Recorder::write(std::uint32_t tick, bool excited, const Samples& samples) noexcept {
  if (state_ == State::frozen) return;
  const bool follows = held_ > 0 && tick == last_tick_ + 1;
  const auto common =
      static_cast<std::uint16_t>((follows ? row_flag::kFollows : 0U) | (excited ? row_flag::kExcited : 0U));
  std::array<Row, config::kChambers>& rows = ring_[end_ % kLogTicks];
  for (std::size_t c = 0; c < config::kChambers; ++c) {
    const Sample& sample = samples[c];
    rows[c] = {.pressure_kPa = static_cast<float>(sample.pressure_Pa.in_core()),
               .volume_mL = static_cast<float>(sample.volume_m3.in_core()),
               .command = command_code(sample.command_V.in_core()),
               .flags = static_cast<std::uint16_t>(common | (sample.measured ? row_flag::kMeasured : 0U))};
  }
  last_tick_ = tick;
  ++end_;
  held_ = std::min(held_ + 1, static_cast<std::uint32_t>(kLogTicks));
  if (state_ == State::recording && held_ == length_) state_ = State::frozen;
}

void Recorder::forget_orders() noexcept {
  if (state_ == State::recording) order(static_cast<std::uint8_t>(Order::roll));
  select(0);
  length_ = kLogTicks;
}

bool Recorder::order(std::uint8_t what) noexcept {
  if (what > static_cast<std::uint8_t>(Order::record)) return false;
  order_ = static_cast<Order>(what);
  switch (order_) {
    case Order::roll:
      state_ = State::rolling;
      break;
    case Order::freeze:
      state_ = State::frozen;
      break;
    case Order::record:
      held_ = 0;
      state_ = State::recording;
      break;
  }
  restart_crc();
  return true;
}

bool Recorder::select(std::uint8_t chamber) noexcept {
  if (chamber >= config::kChambers) return false;
  chamber_ = chamber;
  restart_crc();
  return true;
}

bool Recorder::set_length(std::uint16_t rows) noexcept {
  if (rows == 0 || rows > kLogTicks || state_ == State::recording) return false;
  length_ = rows;
  return true;
}

std::uint32_t Recorder::size() const noexcept {
  return static_cast<std::uint32_t>(kHeaderBytes + kRowBytes * held_ + kCrcBytes);
}

Recorder::Piece Recorder::piece_at(std::uint32_t offset) const noexcept {
  const auto rows_end = static_cast<std::uint32_t>(kHeaderBytes + kRowBytes * held_);
  Piece piece;
  Writer out(piece.bytes);
  if (offset < kHeaderBytes) {
    piece.size = kHeaderBytes;
    out.integer(kLogMagic, 4)
        .integer(last_tick_, 4)
        .integer(held_, 2)
        .integer(chamber_, 1)
        .integer(kRowBytes, 1);
    out.real(config::kTick_s).real(kCommandLsb_V);
  } else if (offset < rows_end) {
    const auto number = static_cast<std::uint32_t>((offset - kHeaderBytes) / kRowBytes);
    const Row& row = this->row(begin() + number, chamber_);
    piece.first = static_cast<std::uint32_t>(kHeaderBytes + kRowBytes * number);
    piece.size = kRowBytes;
    out.real(row.pressure_kPa * config::kPascal_per_kPa)
        .real(row.volume_mL * config::kM3_per_mL)
        .integer(row.command, 2)
        .integer(row.flags, 2);
  } else {
    piece.first = rows_end;
    piece.size = kCrcBytes;
    out.integer(crc_, 4);
  }
  return piece;
}

void Recorder::restart_crc() noexcept {
  crc_ = 0;
  crc_bytes_ = 0;
}

/// Takes whole pieces only: `to` is the end of one.
void Recorder::advance_crc(std::uint32_t to) noexcept {
  while (crc_bytes_ < to) {
    const Piece piece = piece_at(crc_bytes_);
    crc_ = config::crc32(std::span(piece.bytes).first(piece.size), crc_);
    crc_bytes_ += piece.size;
  }
}

std::size_t Recorder::read(std::uint32_t offset, std::span<std::uint8_t> bytes) noexcept {
  if (state_ != State::frozen) return 0;
  const auto rows_end = static_cast<std::uint32_t>(kHeaderBytes + kRowBytes * held_);
  std::size_t done = 0;
  while (done < bytes.size() && offset + done < size()) {
    const auto at = static_cast<std::uint32_t>(offset + done);
    if (at >= rows_end) advance_crc(rows_end);
    const Piece piece = piece_at(at);
    const std::uint32_t skipped = at - piece.first;
    const std::size_t count = std::min<std::size_t>(piece.size - skipped, bytes.size() - done);
    std::copy_n(piece.bytes.begin() + skipped, count, bytes.begin() + static_cast<std::ptrdiff_t>(done));
    done += count;
    if (at < rows_end) advance_crc(piece.first + piece.size);
  }
  return done;
}

}  // namespace plenum::telemetry
