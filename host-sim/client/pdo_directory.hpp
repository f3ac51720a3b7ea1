// Which objects the PDOs of each node carry: those of a board as delivered, until the bus or the board itself says otherwise.
//
// A master that remaps a PDO writes 1400h to 1A0Bh by SDO, and a bystander hears it. What was mapped before somebody listened
// only the board can tell: learn().
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "firmware/canopen/cia301.hpp"
#include "firmware/canopen/objects.hpp"
#include "host-sim/client/link.hpp"

namespace plenum::canopen {
struct Entry;
}  // namespace plenum::canopen

namespace plenum::host::client {

class Session;

/// An object in a PDO.
struct PdoValue {
  const canopen::Entry* entry =
      nullptr;  ///< that of the object in the first chamber, where it has one a chamber
  std::uint8_t sub = 0;
  unsigned instance = 0;  ///< chamber from 0
  double value = 0.0;     ///< a pressure in Pa, NaN where it is not known; else as the object's name says
  bool is_pressure = false;
};

struct Pdo {
  std::uint8_t node = 0;
  bool receive = false;  ///< by the board
  unsigned number = 0;   ///< from 1
  /// Empty where the frame is not as long as what is mapped, or something is mapped that no board has.
  std::optional<std::vector<PdoValue>> values{};
};

/// What the bytes of an object that is no DOMAIN and no string say.
double number_of(canopen::DataType type, std::span<const std::uint8_t> bytes);

class PdoDirectory {
 public:
  /// Any frame, the next one of the bus or log: SDO transfers are followed, and a boot-up brings back what the node has stored.
  void hear(const CanFrame& frame);
  /// Asks the board. Throws what a read throws (errors.hpp); what was known before stays then.
  void learn(Session& session);

  /// The PDO that the frame is; empty for any other frame.
  std::optional<Pdo> read(const CanFrame& frame) const;

 private:
  struct Parameters {
    std::uint32_t cob_id = 0;
    std::uint8_t count = 0;
    std::array<std::uint32_t, canopen::kMappable> packed{};
  };
  struct Node {
    std::array<Parameters, canopen::kRpdos> rpdo{};
    std::array<Parameters, canopen::kTpdos> tpdo{};
  };
  /// The value of an object, of up to four bytes.
  struct Value {
    std::uint16_t index = 0;
    std::uint8_t sub = 0;
    std::uint32_t bits = 0;
  };
  /// What a master asked of a node, who has not answered yet.
  struct Request {
    bool write = false;
    Value value;  ///< of a read without bits
  };
  struct Known {
    Node now;
    Node stored;  ///< what a boot-up brings back, as far as it is known
    std::optional<Request> request{};
  };

  static Node delivered(std::uint8_t node_id);
  static void set(Node& node, const Value& value);
  static std::optional<std::vector<PdoValue>> values(const Parameters& pdo, bool receive,
                                                     const CanFrame& frame);
  void hear_request(Known& known, const CanFrame& frame);
  void hear_answer(std::uint8_t node_id, Known& known, const CanFrame& frame);

  std::map<std::uint8_t, Known> known_;  ///< by node id: those that were spoken to
};

}  // namespace plenum::host::client
