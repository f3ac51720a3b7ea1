// Frames as CANopen: what they say, in words and in SI units, for a log or a live view.
//
// Identifiers are those of the predefined connection set, PDOs those that a board maps by default, and capture streams at
// 680h to 6DFh, of which the identifier tells the chamber and not the node. An SDO transfer is followed, so that its segments and blocks name their object.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host-sim/client/link.hpp"

namespace plenum::canopen {
struct Communication;
struct PdoParameters;
}  // namespace plenum::canopen

namespace plenum::host::client {

struct DecodedValue {
  std::string name;
  double value = 0.0;
  std::string unit;  ///< SI; empty where it has none
};

struct Decoded {
  std::string kind;   ///< "NMT", "SYNC", "EMCY", "TPDO1".., "RPDO1".., "stream", "SDO", "heartbeat", "other"
  unsigned node = 0;  ///< 0: all, or none
  std::string text;
  std::vector<DecodedValue> values;
};

class Decoder {
 public:
  Decoder();
  ~Decoder();
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  /// Any frame; the next one of the log or bus.
  Decoded decode(const CanFrame& frame);

 private:
  enum class Blocks { none, from_board, to_board };

  /// The transfer under way with a node.
  struct Transfer {
    std::uint16_t index = 0;
    std::uint8_t sub = 0;
    Blocks blocks = Blocks::none;
    std::uint8_t last = 0;  ///< number of the segment that said it is the last; 0: none has
  };

  Decoded decode_pdo(const CanFrame& frame, const canopen::PdoParameters& pdo, std::string kind,
                     unsigned node) const;
  std::string decode_sdo(const CanFrame& frame, bool request, Transfer& transfer);

  std::unique_ptr<canopen::Communication> defaults_;
  std::array<Transfer, 128> transfer_{};
};

}  // namespace plenum::host::client
