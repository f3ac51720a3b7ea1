// Whose heartbeat this node listens for (1016h): a node that falls silent after its first heartbeat is lost.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/canopen/cia301.hpp"
#include "firmware/canopen/elapsed.hpp"

namespace plenum::canopen {

class HeartbeatConsumer {
 public:
  static constexpr std::size_t kWatches = 8;

  enum class Heard : std::uint8_t { not_watched, taken, malformed };

  /// Entry `number` (from 0) as 1016h packs it: node id << 16 | longest pause [ms]; node or pause 0: not used.
  std::uint32_t entry(std::size_t number) const noexcept;
  /// value_range: bits that are no entry. parameter_incompatible: another entry watches that node.
  Abort set_entry(std::size_t number, std::uint32_t packed) noexcept;

  /// A frame with the identifier of `node_id`'s heartbeat. A boot-up message says that the node has begun anew,
  /// not that it is well: it neither starts a watch nor feeds it.
  Heard hear(std::uint8_t node_id, std::span<const std::uint8_t> data) noexcept;

  /// A node has been heard, and must be heard again.
  bool is_watching() const noexcept;

  /// Time passes. Returns true while a node is silent for longer than its pause.
  bool elapse(std::uint32_t elapsed_us) noexcept;
  /// Which ones are, as of the last elapse(): bit i is entry i.
  std::uint8_t silent() const noexcept { return silent_; }
  std::uint8_t node_id(std::size_t number) const noexcept { return watch_[number].node_id; }

 private:
  struct Watch {
    std::uint8_t node_id = 0;
    std::uint16_t pause_ms = 0;
    bool running = false;  ///< from the first heartbeat on
    Silence silence{};

    /// CiA 301: not with a node id of 0 or above 127.
    bool is_used() const noexcept { return node_id != 0 && node_id <= kMaxNodeId && pause_ms != 0; }
  };
  std::array<Watch, kWatches> watch_{};
  std::uint8_t silent_ = 0;
};

}  // namespace plenum::canopen
