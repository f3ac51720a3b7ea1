#include "tests/board/gpiod/fake_chip.hpp"

#include <algorithm>
#include <cerrno>

namespace plenum::board::drivers::fake {
namespace {

int fail(int cause) {
  errno = cause;
  return -1;
}

}  // namespace

std::optional<unsigned> Chip::offset(const std::string& name) const {
  for (unsigned i = 0; i < line.size(); ++i)
    if (line[i].name == name) return i;
  return std::nullopt;
}

int Chip::request(unsigned offset, const Request& request, const char* consumer) {
  Line& one = line.at(offset);
  if (!one.holder.empty()) return fail(EBUSY);
  if (request.edges && request.direction != Direction::input) return fail(EINVAL);
  one.holder = consumer;
  one.active_low = request.active_low;
  one.edges = request.edges;
  one.waiting = 0;
  if (request.direction == Direction::as_is) return 0;
  one.output = request.direction == Direction::output;
  if (one.output) {
    one.high = request.active != request.active_low;
    asked.push_back(one.name + " output " + (one.high ? "high" : "low"));
  } else {
    asked.push_back(one.name + " input");
  }
  return 0;
}

void Chip::release(unsigned offset) {
  line.at(offset).holder.clear();
  line.at(offset).edges = false;
}

int Chip::value(unsigned offset) const {
  const Line& one = line.at(offset);
  if (one.broken) return fail(ENODEV);
  return one.high != one.active_low ? 1 : 0;
}

int Chip::set(unsigned offset, bool active) {
  Line& one = line.at(offset);
  if (one.broken) return fail(ENODEV);
  if (!one.output) return fail(EPERM);
  one.high = active != one.active_low;
  asked.push_back(one.name + (one.high ? " high" : " low"));
  return 0;
}

int Chip::events(unsigned offset) const {
  const Line& one = line.at(offset);
  if (one.broken) return fail(ENODEV);
  return one.waiting > 0 ? 1 : 0;
}

int Chip::take_events(unsigned offset, unsigned at_most) {
  Line& one = line.at(offset);
  if (one.broken) return fail(ENODEV);
  const unsigned taken = std::min(one.waiting, at_most);
  one.waiting -= taken;
  return static_cast<int>(taken);
}

void Chip::drive(unsigned offset, bool high) {
  Line& one = line.at(offset);
  if (one.edges && one.high != high) ++one.waiting;
  one.high = high;
}

Chip& chip() {
  static Chip one;
  return one;
}

}  // namespace plenum::board::drivers::fake
