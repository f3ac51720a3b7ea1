// Numbers of CiA 301: function codes, NMT, SDO abort codes, data types. Shared by the node and its clients.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace plenum::canopen {

/// COB-IDs of the predefined connection set; those of one node add its node id (1..127).
namespace cob {
inline constexpr std::uint32_t kNmt = 0x000;
inline constexpr std::uint32_t kSync = 0x080;
inline constexpr std::uint32_t kEmergency = 0x080;
inline constexpr std::uint32_t kTpdo1 = 0x180;  ///< TPDOn at 180h + 100h (n - 1), n = 1..4
inline constexpr std::uint32_t kRpdo1 = 0x200;  ///< RPDOn at 200h + 100h (n - 1), n = 1..4
inline constexpr std::uint32_t kSdoResponse = 0x580;
inline constexpr std::uint32_t kSdoRequest = 0x600;
inline constexpr std::uint32_t kHeartbeat = 0x700;
inline constexpr std::uint32_t kLssResponse = 0x7E4;  ///< without a node id, as the next
inline constexpr std::uint32_t kLssRequest = 0x7E5;

inline constexpr std::uint32_t kInvalid =
    0x8000'0000U;  ///< bit 31 of a PDO's or the EMCY's COB-ID: does not exist
inline constexpr std::uint32_t kNoRtr =
    0x4000'0000U;  ///< bit 30 of a TPDO's COB-ID: no remote request (always so here)
inline constexpr std::uint32_t kExtended = 0x2000'0000U;  ///< bit 29: 29-bit identifier (not supported here)
inline constexpr std::uint32_t kIdMask = 0x7FF;
}  // namespace cob

inline constexpr std::uint8_t kMaxNodeId = 127;
inline constexpr std::uint8_t kUnconfiguredNodeId = 255;  ///< CiA 305: such a node is silent but for LSS

enum class NmtCommand : std::uint8_t {
  start = 1,
  stop = 2,
  enter_pre_operational = 128,
  reset_node = 129,
  reset_communication = 130,
};

/// Emergency error code of a consumed heartbeat that is lost; byte 4 of its message is the node (own).
inline constexpr std::uint16_t kHeartbeatLost = 0x8130;

/// As the heartbeat carries it; `initialising` is the boot-up message.
enum class NmtState : std::uint8_t { initialising = 0, stopped = 4, operational = 5, pre_operational = 127 };

enum class Abort : std::uint32_t {
  none = 0,
  pending = 1,  ///< never on the wire: the answer waits for the write's outcome
  toggle_not_alternated = 0x0503'0000U,
  timed_out = 0x0504'0000U,
  unknown_command = 0x0504'0001U,
  invalid_block_size = 0x0504'0002U,
  invalid_sequence = 0x0504'0003U,
  crc_error = 0x0504'0004U,
  out_of_memory = 0x0504'0005U,
  write_only = 0x0601'0001U,
  read_only = 0x0601'0002U,
  no_object = 0x0602'0000U,
  not_mappable = 0x0604'0041U,
  pdo_length_exceeded = 0x0604'0042U,
  parameter_incompatible = 0x0604'0043U,
  hardware_error = 0x0606'0000U,
  length_mismatch = 0x0607'0010U,
  length_too_high = 0x0607'0012U,
  length_too_low = 0x0607'0013U,
  no_subindex = 0x0609'0011U,
  value_range = 0x0609'0030U,
  value_too_high = 0x0609'0031U,
  value_too_low = 0x0609'0032U,
  max_below_min = 0x0609'0036U,
  general = 0x0800'0000U,
  cannot_store = 0x0800'0020U,
  device_state = 0x0800'0022U,
  no_data = 0x0800'0024U,
};

/// What has to be written to 1010h and 1011h, so that nothing is stored or lost by chance: "save" and "load".
inline constexpr std::uint32_t kSaveSignature = 0x6576'6173U;
inline constexpr std::uint32_t kLoadSignature = 0x6461'6F6CU;

/// Numbers of the static data types 0001h..000Fh, as an EDS names them.
enum class DataType : std::uint8_t {
  integer8 = 0x02,
  integer16 = 0x03,
  integer32 = 0x04,
  unsigned8 = 0x05,
  unsigned16 = 0x06,
  unsigned32 = 0x07,
  real32 = 0x08,
  visible_string = 0x09,
  domain = 0x0F,
};

/// Bytes of a value; 0 for the types without a fixed size.
constexpr std::size_t size_of(DataType type) noexcept {
  switch (type) {
    case DataType::integer8:
    case DataType::unsigned8:
      return 1;
    case DataType::integer16:
    case DataType::unsigned16:
      return 2;
    case DataType::integer32:
    case DataType::unsigned32:
    case DataType::real32:
      return 4;
    case DataType::visible_string:
    case DataType::domain:
      return 0;
  }
  return 0;
}

/// Little-endian bytes to bits; at most four bytes count.
constexpr std::uint32_t load_le(std::span<const std::uint8_t> bytes) noexcept {
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < bytes.size() && i < 4; ++i) bits |= std::uint32_t{bytes[i]} << (8 * i);
  return bits;
}

/// Bits to little-endian bytes; of more than four the rest is zero.
constexpr void store_le(std::uint32_t bits, std::span<std::uint8_t> bytes) noexcept {
  for (std::uint8_t& byte : bytes) {
    byte = static_cast<std::uint8_t>(bits);
    bits >>= 8;
  }
}

/// One entry of a PDO mapping parameter.
constexpr std::uint32_t mapping_entry(std::uint32_t index, std::uint32_t sub, std::uint32_t bits) noexcept {
  return index << 16 | sub << 8 | bits;
}

}  // namespace plenum::canopen
