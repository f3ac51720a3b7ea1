#include "host-sim/client/bus_recorder.hpp"

#include <cmath>
#include <utility>

#include "host-sim/wire/candump.hpp"

namespace plenum::host::client {

BusRecorder::BusRecorder(Link& link, std::ostream& log, std::string channel, std::uint64_t begin_us)
    : link_(link), log_(log), channel_(std::move(channel)), begin_us_(begin_us), begin_s_(link.now_s()) {}

bool BusRecorder::take(double timeout_s) {
  const auto frame = link_.receive(timeout_s);
  if (!frame) return false;
  const double time_s = link_.now_s() - begin_s_;
  const std::uint64_t time_us =
      link_.stamp_us().value_or(begin_us_ + static_cast<std::uint64_t>(std::llround(time_s * 1e6)));
  if (const std::uint64_t lost = link_.lost(); lost > lost_) {
    gaps_.push_back({.before_frame = frames_, .time_s = time_s, .lost = lost - lost_});
    lost_ = lost;
    log_ << wire::candump_line(time_us, channel_, wire::kReceiveOverflow) << '\n';
  }
  log_ << wire::candump_line(time_us, channel_, *frame) << '\n';
  ++frames_;
  return true;
}

}  // namespace plenum::host::client
