#include "firmware/canopen/heartbeat_consumer.hpp"

#include <algorithm>

namespace plenum::canopen {

std::uint32_t HeartbeatConsumer::entry(std::size_t number) const noexcept {
  return std::uint32_t{watch_[number].node_id} << 16 | watch_[number].pause_ms;
}

Abort HeartbeatConsumer::set_entry(std::size_t number, std::uint32_t packed) noexcept {
  if (packed >> 24 != 0) return Abort::value_range;  // reserved
  const Watch watch{.node_id = static_cast<std::uint8_t>(packed >> 16),
                    .pause_ms = static_cast<std::uint16_t>(packed)};
  for (std::size_t i = 0; i < kWatches; ++i) {
    const bool same_node = watch_[i].is_used() && watch_[i].node_id == watch.node_id;
    if (i != number && watch.is_used() && same_node) return Abort::parameter_incompatible;
  }
  watch_[number] = watch;
  return Abort::none;
}

HeartbeatConsumer::Heard HeartbeatConsumer::hear(std::uint8_t node_id,
                                                 std::span<const std::uint8_t> data) noexcept {
  for (Watch& watch : watch_) {
    if (!watch.is_used() || watch.node_id != node_id) continue;
    if (data.size() != 1) return Heard::malformed;
    switch (static_cast<NmtState>(data[0])) {
      case NmtState::initialising:
        return Heard::taken;
      case NmtState::stopped:
      case NmtState::operational:
      case NmtState::pre_operational:
        watch.running = true;
        watch.silence.end();
        return Heard::taken;
    }
    return Heard::malformed;
  }
  return Heard::not_watched;
}

bool HeartbeatConsumer::is_watching() const noexcept {
  return std::any_of(watch_.begin(), watch_.end(), [](const Watch& watch) { return watch.running; });
}

bool HeartbeatConsumer::elapse(std::uint32_t elapsed_us) noexcept {
  silent_ = 0;
  for (std::size_t i = 0; i < kWatches; ++i) {
    Watch& watch = watch_[i];
    if (watch.running && watch.silence.elapse(elapsed_us) > 1000U * watch.pause_ms)
      silent_ = static_cast<std::uint8_t>(silent_ | 1U << i);
  }
  return silent_ != 0;
}

}  // namespace plenum::canopen
