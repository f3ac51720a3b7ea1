// Frames as CANopen: what they say, in words and in SI units, for a log or a live view.
//
// Identifiers are those of the predefined connection set, PDOs carry what a board maps when it is delivered, until an SDO transfer
// tells otherwise (pdo_directory.hpp). A capture stream whose mapping was not heard is known by its identifiers, 680h to 6DFh, which
// tell the chamber and not the node. An SDO transfer is followed, so that its segments and blocks name their object.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host-sim/client/link.hpp"
#include "host-sim/client/pdo_directory.hpp"

namespace plenum::host::client {

struct DecodedValue {
  std::string name;
  double value = 0.0;
  std::string unit;  ///< SI; empty where it has none
};

struct Decoded {
  std::string
      kind;  ///< "NMT", "SYNC", "EMCY", "TPDO1".., "RPDO1".., "stream", "SDO", "LSS", "heartbeat", "other"
  unsigned node = 0;  ///< 0: all, or none
  std::string text;
  std::vector<DecodedValue> values;
};

class Decoder {
 public:
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

  std::string decode_sdo(const CanFrame& frame, bool request, Transfer& transfer);

  PdoDirectory pdos_;
  std::array<Transfer, 128> transfer_{};
};

}  // namespace plenum::host::client
