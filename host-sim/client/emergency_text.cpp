#include "host-sim/client/emergency_text.hpp"

#include <algorithm>
#include <array>

namespace plenum::host::client {
namespace {

struct Row {
  std::uint16_t code;
  const char* text;
};

// What firmware/safety raises; a test holds the two together.
constexpr std::array kOfBoard = std::to_array<Row>({
    {0x0000, "no error"},
    {0x3412, "supply low"},
    {0x5000, "hardware"},
    {0x6300, "no valid model, stored set damaged, or stored set cannot be written"},
    {0x6320, "configuration refused"},
    {0x8110, "CAN overrun"},
    {0x8120, "CAN error passive"},
    {0x8130, "heartbeat lost"},
    {0x8140, "bus-off"},
    {0x8210, "PDO too short"},
    {0x8220, "PDO longer than mapped"},
    {0x8240, "SYNC that 1019h does not allow"},
    {0x8250, "set-point timeout"},
    {0x8302, "over-pressure"},
    {0x9000, "emergency stop"},
    {0xFF01, "tick overrun"},
    {0xFF02, "model residual"},
    {0xFF03, "pressure stale"},
    {0xFF04, "pressure not finite"},
    {0xFF05, "pressure sensor out of range"},
    {0xFF06, "position stale"},
    {0xFF07, "position not finite"},
    {0xFF08, "position sensor out of range"},
    {0xFF09, "memory upset"},
    {0xFF0A, "pressure sensor stuck"},
    {0xFF0B, "model drift"},
    {0xFF0C, "control deviation"},
});

// The high byte, or its first digit where the second is 0.
constexpr std::array kClasses = std::to_array<Row>({
    {0x10, "generic error"},
    {0x20, "current"},
    {0x30, "voltage"},
    {0x40, "temperature"},
    {0x50, "device hardware"},
    {0x60, "device software"},
    {0x61, "internal software"},
    {0x62, "user software"},
    {0x63, "data set"},
    {0x70, "additional modules"},
    {0x80, "monitoring"},
    {0x81, "communication"},
    {0x82, "protocol error"},
    {0x90, "external error"},
    {0xF0, "additional functions"},
    {0xFF, "device specific"},
});

template <class Table>
const char* look_up(const Table& table, unsigned code) {
  const auto found =
      std::find_if(table.begin(), table.end(), [&](const Row& row) { return row.code == code; });
  return found == table.end() ? nullptr : found->text;
}

}  // namespace

const char* emergency_text(std::uint16_t code) {
  if (const char* text = look_up(kOfBoard, code)) return text;
  if (const char* text = look_up(kClasses, code >> 8U)) return text;
  if (const char* text = look_up(kClasses, (code >> 8U) & 0xF0U)) return text;
  return "unknown error";
}

}  // namespace plenum::host::client
