// Who is on a bus: every node id is asked at once, and heartbeats tell of those that do not answer.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host-sim/client/board_facts.hpp"

namespace plenum::host::client {

/// What a Plenum board says of itself beside its identity.
struct BoardSummary {
  std::uint16_t status_word = 0;
  std::optional<FaultEntry> fault;
  unsigned models = 0;      ///< chambers with a model in force
  bool compatible = false;  ///< its models are of the schema that this program writes
};

struct ScannedNode {
  std::uint8_t node_id = 0;
  std::optional<canopen::NmtState> nmt;      ///< of its heartbeat; empty when none was heard
  std::optional<std::uint32_t> device_type;  ///< 1000h; empty when it does not answer, as a stopped node
  Identity identity;
  std::string name;      ///< 1008h; empty when it has none
  std::string software;  ///< 100Ah; empty when it has none
  std::optional<BoardSummary> board;
  std::string trouble;  ///< why the rest is missing; empty when nothing is
};

/// Listens for `timeout_s` in all, then asks those it found one by one. In the order of node ids. Throws
/// std::runtime_error when the link fails. Reading 1000h ends an SDO transfer that another client has under way with the
/// same node.
std::vector<ScannedNode> scan(Link& link, double timeout_s);

}  // namespace plenum::host::client
