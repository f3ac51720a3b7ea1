// The client's side of SDO: expedited, segmented and block transfers with one server (CiA 301, 7.2.4.3).
//
// Whatever a link does to frames (loses, doubles, delays them), a transfer ends with the right bytes or with an error,
// within the time-outs of its answers. Lost segments of a block are sent again; where a CRC watches over it, a block
// that falls silent in the middle is asked for again, once. After an error the server is told by an abort.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/canopen/cia301.hpp"
#include "host-sim/client/errors.hpp"
#include "host-sim/client/link.hpp"

namespace plenum::host::client {

/// How far a transfer is [bytes]; no total when the server does not know it.
using TransferProgress = std::function<void(std::size_t done, std::optional<std::size_t> total)>;

/// CRC of block transfers: polynomial 1021h, initial value 0 (CiA 301, 7.2.4.3.16). 31C3h for "123456789".
std::uint16_t crc16(std::span<const std::uint8_t> bytes);

struct SdoConfig {
  double timeout_s = 0.5;  ///< for each answer, and for each segment of a block
  /// For the answer to a block sent: a server that has missed its last segment speaks only after a while of its own.
  double block_timeout_s = 1.5;
  std::size_t block_from_bytes = 28;  ///< from here on blocks take fewer frames than segments
  std::uint8_t block_size = 127;      ///< segments a block that this client asks for; 1..127
  std::size_t largest_bytes = std::size_t{64} << 20U;  ///< a value that goes on beyond this is given up
};

class SdoClient {
 public:
  using Bytes = std::array<std::uint8_t, 8>;

  /// `heard` gets every frame that is none of the server's answers. The link must outlive the client.
  SdoClient(Link& link, std::uint8_t node_id, const SdoConfig& config,
            std::function<void(const CanFrame&)> heard);

  /// Expedited or segmented, as the server has it. Throws SdoAbort, Timeout, ProtocolError, as all of them.
  std::vector<std::uint8_t> read(std::uint16_t index, std::uint8_t sub);
  /// By blocks; in segments from a server that knows no blocks, and for values too short for them.
  std::vector<std::uint8_t> read_domain(std::uint16_t index, std::uint8_t sub,
                                        const TransferProgress& progress = {});
  /// Expedited up to four bytes, by blocks from `block_from_bytes` on where the server knows them, else in segments.
  void write(std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> bytes,
             const TransferProgress& progress = {});

 private:
  /// The transfer under way, for messages and aborts.
  struct Object {
    std::uint16_t index;
    std::uint8_t sub;
    const char* doing;
  };

  void send(const Bytes& data);
  /// The server's next frame that belongs to `object`; empty after `timeout_s`. Throws SdoAbort for its abort.
  std::optional<Bytes> next(const Object& object, bool initiate, double timeout_s);
  Bytes exchange(const Object& object, const Bytes& request, bool initiate);
  [[noreturn]] void fail(const Object& object, canopen::Abort abort, const std::string& found);
  [[noreturn]] void time_out(const Object& object, double timeout_s);
  void abort(const Object& object, canopen::Abort abort);

  std::vector<std::uint8_t> read_answered(const Object& object, const Bytes& first);
  void write_segments(const Object& object, std::span<const std::uint8_t> bytes,
                      const TransferProgress& progress);

  // blocks: sdo_blocks.cpp
  class BlockReader;
  std::vector<std::uint8_t> read_blocks(const Object& object, const Bytes& first,
                                        const TransferProgress& progress);
  /// False when the server knows no block transfer.
  bool write_blocks(const Object& object, std::span<const std::uint8_t> bytes,
                    const TransferProgress& progress);
  void send_block(const Object& object, std::span<const std::uint8_t> bytes, std::size_t segments);
  Bytes await_block_answer(const Object& object, std::uint8_t subcommand);

  Link& link_;
  std::uint8_t node_id_;
  SdoConfig config_;
  std::function<void(const CanFrame&)> heard_;
  bool server_knows_blocks_ = true;  ///< until it says otherwise
};

}  // namespace plenum::host::client
