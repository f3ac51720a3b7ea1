#include "host-sim/client/board_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "firmware/telemetry/recorder.hpp"

namespace plenum::host::client {
namespace {

namespace object = canopen::object;
using telemetry::Recorder;

using telemetry::kCrcBytes;
using telemetry::kHeaderBytes;
using telemetry::kRowBytes;

[[noreturn]] void refuse(unsigned chamber, const std::string& what) {
  throw ProtocolError(fmt::format("log of chamber {}: {}", chamber + 1, what));
}

Recorder::State state_of(Session& session) {
  return static_cast<Recorder::State>(session.read<std::uint8_t>(object::kCapture, 4));
}
void order(Session& session, Recorder::Order what) {
  session.write<std::uint8_t>(object::kCapture, 1, static_cast<std::uint8_t>(what));
}

/// While it lives the log stands still; a log that rolled then rolls again.
class Frozen {
 public:
  explicit Frozen(Session& session) : session_(session) {
    const Recorder::State state = state_of(session);
    if (state == Recorder::State::recording) {
      throw Refused(
          fmt::format("node {}: the board is recording a log that somebody ordered ({} of {} rows), expected "
                      "one that rolls or stands",
                      session.node_id(), session.read<std::uint16_t>(object::kCapture, 5),
                      session.read<std::uint16_t>(object::kCapture, 3)));
    }
    rolled_ = state == Recorder::State::rolling;
    if (rolled_) order(session, Recorder::Order::freeze);
  }
  Frozen(const Frozen&) = delete;
  Frozen& operator=(const Frozen&) = delete;
  ~Frozen() {
    try {
      if (rolled_) let_log_roll(session_);
    } catch (const std::exception&) {  // what ended the reading is already on its way to the caller
    }
  }

 private:
  Session& session_;
  bool rolled_ = false;
};

}  // namespace

bool log_is_frozen(Session& session) {
  return state_of(session) == Recorder::State::frozen;
}

void let_log_roll(Session& session) {
  order(session, Recorder::Order::roll);
}

BoardLog parse_board_log(std::span<const std::uint8_t> bytes, unsigned chamber) {
  const auto word = [&](std::size_t at) { return canopen::load_le(bytes.subspan(at, 4)); };
  const auto half = [&](std::size_t at) { return canopen::load_le(bytes.subspan(at, 2)); };
  const auto real = [&](std::size_t at) { return static_cast<double>(std::bit_cast<float>(word(at))); };
  if (bytes.size() < kHeaderBytes + kCrcBytes) {
    refuse(chamber, fmt::format("{} bytes, expected at least {}", bytes.size(), kHeaderBytes + kCrcBytes));
  }
  if (word(0) != telemetry::kLogMagic)
    refuse(chamber, fmt::format("begins with {:08X}h, expected {:08X}h", word(0), telemetry::kLogMagic));
  const std::size_t rows = half(8);
  const std::size_t size = kHeaderBytes + kRowBytes * rows + kCrcBytes;
  if (bytes.size() != size || bytes[11] != kRowBytes) {
    refuse(chamber, fmt::format("{} bytes, {} a row, expected {} with {} a row, for {} rows", bytes.size(),
                                bytes[11], size, kRowBytes, rows));
  }
  const std::uint32_t crc = config::crc32(bytes.first(size - kCrcBytes));
  if (word(size - kCrcBytes) != crc) {
    refuse(chamber, fmt::format("CRC {:08X}h, expected {:08X}h", word(size - kCrcBytes), crc));
  }
  if (!(real(12) > 0.0 && real(12) < 1.0))
    refuse(chamber, fmt::format("a row every {} s, expected 0 to 1 s", real(12)));
  const double command_lsb_V = real(16);
  if (!std::isfinite(command_lsb_V))
    refuse(chamber, fmt::format("a command's LSB of {} V, expected a number", command_lsb_V));
  if (bytes[10] != chamber) refuse(chamber, fmt::format("is that of chamber {}", bytes[10] + 1));

  BoardLog log{.last_tick = word(4), .period_s = real(12), .rows = {}};
  for (std::size_t at = kHeaderBytes; at < size - kCrcBytes; at += kRowBytes) {
    const std::uint32_t flags = half(at + 10);
    const bool is_measured = (flags & telemetry::row_flag::kMeasured) != 0;
    if (is_measured && !(std::isfinite(real(at)) && std::isfinite(real(at + 4)))) {
      refuse(chamber, fmt::format("row {}: {} Pa, {} m3, expected what is measured to be numbers",
                                  log.rows.size() + 1, real(at), real(at + 4)));
    }
    log.rows.push_back({.pressure_Pa = real(at),
                        .volume_m3 = real(at + 4),
                        .command_V = half(at + 8) * command_lsb_V,
                        .measured = is_measured,
                        .follows = (flags & telemetry::row_flag::kFollows) != 0});
  }
  return log;
}

Remembered remembered(Session& session, unsigned chambers, const Progress& progress) {
  std::vector<BoardLog> logs;
  {
    const Frozen frozen(session);
    for (unsigned c = 0; c < chambers; ++c) {
      session.write<std::uint8_t>(object::kCapture, 2, static_cast<std::uint8_t>(c));
      const auto tell = [&](std::size_t done, std::optional<std::size_t> total) {
        if (progress && total) {
          progress((c + static_cast<double>(done) / static_cast<double>(std::max<std::size_t>(*total, 1))) /
                   chambers);
        }
      };
      logs.push_back(parse_board_log(session.sdo_read_domain(object::kCaptureBuffer, 0, tell), c));
    }
  }
  const std::size_t rows = logs.front().rows.size();
  for (const BoardLog& log : logs) {
    if (log.rows.size() != rows || log.last_tick != logs.front().last_tick) {
      throw ProtocolError(
          fmt::format("node {}: the logs of its chambers are of different ticks, expected one log that "
                      "stands still",
                      session.node_id()));
    }
  }
  // back from the last row to the last gap: a row that does not follow begins a stretch, one not measured is in none
  std::size_t first = rows;
  while (first > 0) {
    const bool whole =
        std::all_of(logs.begin(), logs.end(), [&](const BoardLog& l) { return l.rows[first - 1].measured; });
    if (!whole) break;
    --first;
    if (!logs.front().rows[first].follows) break;
  }
  if (first == rows) {
    throw Refused(
        fmt::format("node {}: the board remembers no tick in which its valves were driven, expected some",
                    session.node_id()));
  }
  Remembered result{.rows = {}, .before = first};
  const double rate_Hz = std::round(1.0 / logs.front().period_s);
  for (std::size_t k = first; k < rows; ++k) {
    CapturedRow row;
    row.time_s = static_cast<double>(k - first) / rate_Hz;
    for (unsigned c = 0; c < chambers; ++c) {
      const BoardLogRow& of = logs[c].rows[k];
      row.sample[c] = {
          .chamber = c, .actual_Pa = of.pressure_Pa, .command_V = of.command_V, .volume_m3 = of.volume_m3};
    }
    result.rows.push_back(row);
  }
  return result;
}

}  // namespace plenum::host::client
