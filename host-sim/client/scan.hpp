// Who is on a bus: heartbeats tell, and ids that are silent are asked.
#pragma once

#include <cstdint>
#include <functional>
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

/// Listens for `duration_s` in all, but no shorter than the 0.4 s in which it asks the ids that it has heard nothing of until then for
/// 1000h, one every 2.7 ms, or, where that is longer, every three frames' time at the bit rate of the bus (5 s in all at 10 kbit/s),
/// which is the link's unless `bit_rate` says it; then it reads what those it found say of themselves, one by one. In the order of node ids. Throws
/// std::runtime_error when the link fails.
///
/// A request would end an SDO transfer that another master has under way with the node: one that is heard by then is not asked in this
/// way, and with `config` each session can listen before it reads.
///
/// `progress` is told which node is being asked; 0: none, it is being listened.
std::vector<ScannedNode> scan(Link& link, double duration_s, const SessionConfig& config = {},
                              const std::function<void(unsigned node)>& progress = {},
                              std::optional<std::uint32_t> bit_rate = {});

/// Whether a node of this id, 1..127, answers a request for its 1000h or is heard by its heartbeat within the time. Throws as scan().
bool is_on_bus(Link& link, std::uint8_t node_id, double duration_s);

}  // namespace plenum::host::client
