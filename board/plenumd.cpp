#include "board/plenumd.hpp"

#include <algorithm>

namespace plenum::board {
namespace {

constexpr std::uint64_t kMillisecond_ns = 1'000'000;
constexpr std::uint64_t kPeriod_ns = plenum::config::kTick_us * std::uint64_t{1000};

std::uint32_t microseconds(std::uint64_t time_ns) noexcept {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(time_ns / 1000, UINT32_MAX));
}

}  // namespace

Plenumd::Plenumd(const config::RealTime& real_time, Board& board, rt::Events& events,
                 Hardware& hardware) noexcept
    : overrun_(real_time.overrun),
      board_(board),
      events_(events),
      hardware_(hardware),
      pace_({.period_ns = kPeriod_ns, .by_scans = real_time.pacing == config::Pacing::adc}, events.now_ns()),
      scans_ns_(events.now_ns()) {}

void Plenumd::run() noexcept {
  hardware_.make_safe();
  hardware_.begin();
  while (step()) {
  }
  hardware_.make_safe();
  hardware_.stopping();
  finish_storing();
}

bool Plenumd::step() noexcept {
  const rt::Happened happened =
      events_.wait(pace_.deadline_ns(hardware_.scans_ready()),
                   waits_ < kWaits ? rt::WaitFor::anything : rt::WaitFor::moment_or_stop);
  if (happened.stop || (happened.child && !hardware_.guarded())) return false;
  ++waits_;
  if (happened.emergency_stop) hardware_.look_at_stop();
  const std::uint64_t now_ns = events_.now_ns();
  if (happened.scans && hardware_.gather()) scans_ns_ = now_ns;
  if (const auto due = pace_.due(now_ns, hardware_.scans_ready())) {
    tick(*due, now_ns);
  } else if (happened.frames) {
    board_.handle_frames();
  }
  return true;
}

void Plenumd::tick(const rt::Pace::Tick& tick, std::uint64_t now_ns) noexcept {
  waits_ = 0;
  board_.handle_frames();
  board_.tick({.overrun = tick.missed == 0 ? Overrun::none : overrun_,
               .missed = tick.missed,
               .latency_us = microseconds(tick.latency_ns),
               .scan_age_us = microseconds(now_ns - scans_ns_)});
  board_.store_changed();
  for (std::size_t chamber = 0; chamber < plenum::config::kChambers; ++chamber)
    hardware_.rest_at(chamber, board_.controller().resting_V(chamber));
  hardware_.ticked(events_.now_ns(), board_.controller().image().tick_count);
}

void Plenumd::finish_storing() noexcept {
  for (int i = 0; i < kFinish_ms; ++i) {
    if (board_.controller().image().store.phase == canopen::StorePhase::idle) return;
    board_.store_changed();
    events_.wait(events_.now_ns() + kMillisecond_ns, rt::WaitFor::moment_or_stop);
  }
}

}  // namespace plenum::board
