// Stack that calls of the controller really use, over the runs of a master who asks for everything.
//
// Before each call the stack below is painted; what is not the paint's colour any more was used. The bound of call_graph.py must hold it.
//
// Prints one JSON object a line: {"row": "Controller::step", "bytes": 1234}
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <random>
#include <utility>

#include "tests/cost/chambers_alike.hpp"
#include "tests/cost/master.hpp"

namespace {

using namespace plenum;
using config::ModelKind;

/// Where the stack ends in the function that this is inlined into: its calls go below.
[[gnu::always_inline]] inline std::uintptr_t stack_pointer() {
  std::uintptr_t pointer;
#if defined(__x86_64__)
  asm volatile("mov %%rsp, %0" : "=r"(pointer));
#else
  asm volatile("mov %0, sp" : "=r"(pointer));
#endif
  return pointer;
}

/// The stack below those who paint it and look at it: from a red zone under them to kDeepest.
constexpr std::uintptr_t kRedZone = 128;
constexpr std::uintptr_t kDeepest = 16384;
constexpr auto kPaint = static_cast<std::uintptr_t>(0xA5C3A5C396F096F0ULL);

volatile std::uintptr_t& word_at(std::uintptr_t address) {
  return *std::bit_cast<volatile std::uintptr_t*>(address);
}

[[gnu::noinline]] void paint() {
  const std::uintptr_t here = stack_pointer();
  for (std::uintptr_t depth = kRedZone; depth <= kDeepest; depth += sizeof here)
    word_at(here - depth) = kPaint;
}

/// The lowest address that has lost its paint since.
[[gnu::noinline]] std::uintptr_t lowest_used() {
  const std::uintptr_t here = stack_pointer();
  std::uintptr_t depth = kDeepest - kRedZone;  // those who paint may have stood a little higher
  while (depth > kRedZone && word_at(here - depth) == kPaint) depth -= sizeof here;
  return here - depth;
}

/// The deepest call of each sort.
class Depths {
 public:
  template <class Calls>
  void operator()(cost::Call call, Calls&& calls) {
    paint();
    const std::uintptr_t from = stack_pointer_of(calls);
    std::size_t& most = most_[static_cast<std::size_t>(call)];
    most = std::max(most, from - lowest_used());
  }
  std::size_t most(cost::Call call) const { return most_[static_cast<std::size_t>(call)]; }

 private:
  /// Performs the call; where the stack ended when it began.
  template <class Calls>
  [[gnu::noinline]] static std::uintptr_t stack_pointer_of(Calls& calls) {
    const std::uintptr_t pointer = stack_pointer();
    calls();
    return pointer;
  }

  std::array<std::size_t, 4> most_{};
};

void session(std::mt19937_64& random, ModelKind kind, Depths& depths) {
  constexpr int kActs = 12;
  using Chambers = cost::ChambersAlike<std::mt19937_64>;
  const auto chambers = std::make_unique<Chambers>(random, cost::draw_subject(random, kind));
  depths(cost::Call::prepare, [&] { chambers->controller().prepare(); });
  chambers->go_active();
  cost::Master<std::mt19937_64, Depths> master(random, *chambers, depths);
  for (int i = 0; i < kActs; ++i) master.act();
  master.set_by_block();
}

}  // namespace

int main() {
  constexpr int kSessions = 3;  // of each kind
  std::mt19937_64 random(2024);
  Depths depths;
  for (int i = 0; i < kSessions; ++i) {
    for (const ModelKind kind : {ModelKind::tassa9, ModelKind::tassa9r, ModelKind::greybox})
      session(random, kind, depths);
  }
  constexpr std::array<std::pair<const char*, cost::Call>, 4> kRows = {
      {{"Controller::prepare", cost::Call::prepare},
       {"Controller::receive", cost::Call::receive},
       {"Controller::step", cost::Call::step},
       {"Controller::next_frame", cost::Call::send}}};
  for (const auto& [name, call] : kRows)
    std::printf(R"({"row": "%s", "bytes": %zu})"
                "\n",
                name, depths.most(call));
}
