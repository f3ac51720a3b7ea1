// The log of a chamber as a board sends it (2301h), from any bytes: it is accepted and holds together, or refused by an error of one line
// that names the chamber.
//
// The first byte says of which chamber the log is to be, and whether magic, size and CRC are mended, so that the search reaches what
// lies behind them.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "firmware/config/crc32.hpp"
#include "firmware/telemetry/recorder.hpp"
#include "host-sim/client/board_log.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using namespace plenum;
using fuzz::require;
using Bytes = std::vector<std::uint8_t>;

void put(Bytes& bytes, std::size_t at, std::uint32_t value, std::size_t size) {
  canopen::store_le(value, std::span(bytes).subspan(at, size));
}

void mend(Bytes& bytes) {
  constexpr std::size_t kRowsAt = 8, kRowBytesAt = 11;
  constexpr std::size_t kLeast = telemetry::kHeaderBytes + telemetry::kCrcBytes;
  const std::size_t rows = bytes.size() < kLeast ? 0 : (bytes.size() - kLeast) / telemetry::kRowBytes;
  bytes.resize(kLeast + rows * telemetry::kRowBytes);
  put(bytes, 0, telemetry::kLogMagic, 4);
  put(bytes, kRowsAt, static_cast<std::uint32_t>(rows), 2);
  put(bytes, kRowBytesAt, telemetry::kRowBytes, 1);
  const std::size_t crc_at = bytes.size() - telemetry::kCrcBytes;
  put(bytes, crc_at, config::crc32(std::span(bytes).first(crc_at)), telemetry::kCrcBytes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const unsigned chamber = data[0] & 7U;
  Bytes bytes(data + 1, data + size);
  if ((data[0] & 8U) != 0) mend(bytes);
  try {
    const host::client::BoardLog log = host::client::parse_board_log(bytes, chamber);
    require(telemetry::kHeaderBytes + log.rows.size() * telemetry::kRowBytes + telemetry::kCrcBytes ==
                bytes.size(),
            "every byte is of a row");
    require(log.period_s > 0.0 && log.period_s < 1.0, "the rows are apart in time");
    for (const host::client::BoardLogRow& row : log.rows) {
      require(std::isfinite(row.command_V), "a command is a number");
      require(!row.measured || (std::isfinite(row.pressure_Pa) && std::isfinite(row.volume_m3)),
              "what is measured is a number");
    }
  } catch (const host::client::ProtocolError& error) {
    const std::string_view said = error.what();
    require(said.find('\n') == std::string_view::npos && said.find("chamber ") != std::string_view::npos,
            "an error of one line names the chamber");
  }
  return 0;
}
