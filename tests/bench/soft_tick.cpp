// Ticks of the controller with 8 chambers regulating, for a board without floating point: soft_tick.py compiles it once a scalar and
// counts what is executed.
//
// usage: soft_tick KIND run|idle    idle: all but the controller's part, for the difference
#include <cstdio>
#include <memory>
#include <random>
#include <string_view>

#include "tests/cost/chambers_alike.hpp"

int main(int count, char** words) {
  using namespace plenum;
  constexpr int kModels = 3, kTicks = 8;
  const config::ModelKind kind = control::testing::kind_named(count == 3 ? words[1] : "");
  if (kind == config::ModelKind::none) return 2;
  const bool runs = std::string_view(words[2]) == "run";
  std::mt19937 random(2024);
  int not_regulating = 0;
  for (int i = 0; i < kModels; ++i) {
    const auto chambers =
        std::make_unique<cost::ChambersAlike<std::mt19937>>(random, cost::draw_subject(random, kind));
    chambers->go_active();
    for (int k = 0; k < kTicks; ++k) {
      chambers->next_scene();
      const auto setpoints = chambers->setpoints();
      const Inputs inputs = chambers->inputs();
      if (!runs) continue;
      for (const ports::CanFrame& frame : setpoints) chambers->controller().receive(frame);
      chambers->controller().step(inputs);
      ports::CanFrame frame;
      while (chambers->controller().next_frame(frame)) {
      }
      if (!chambers->regulates()) ++not_regulating;
    }
  }
  std::printf("%d\n", kModels * kTicks);
  return not_regulating == 0 ? 0 : 1;
}
