#include "board/rt/pace.hpp"

namespace plenum::board::rt {

std::optional<Pace::Tick> Pace::due(std::uint64_t now_ns, bool scans_ready) noexcept {
  const bool by_scans = config_.by_scans && scans_ready;
  // The phase of the scans is taken as it comes: when one is earlier than any before it, and when they begin.
  const bool begins = by_scans && !by_scans_now_ && now_ns < due_ns_ + config_.period_ns;
  if (!begins && now_ns < deadline_ns(by_scans)) return std::nullopt;
  if (begins || (by_scans && now_ns < due_ns_)) due_ns_ = now_ns;
  const std::uint64_t called_ns = by_scans ? due_ns_ : deadline_ns(false);  // what the next tick follows
  const std::uint64_t missed = (now_ns - called_ns) / config_.period_ns;
  const Tick tick{.latency_ns = now_ns - due_ns_, .missed = static_cast<std::uint32_t>(missed)};
  due_ns_ = called_ns + (missed + 1) * config_.period_ns;
  if (by_scans) due_ns_ += config_.period_ns / kDrift;
  by_scans_now_ = by_scans;
  return tick;
}

}  // namespace plenum::board::rt
