// Instructions of one tick of the controller with 8 chambers regulating, counted by callgrind (tick.py runs
// it).
//
// One tick is Controller::step: monitors, volume and pressure observers, two model inversions a chamber, the
// supervisor and the node's tick with the TPDOs of the process data and of the capture stream due. To find
// the worst input the eight chambers are in the same state, so that what is dear for one is dear eight times;
// models, set points and readings are drawn from everything that regulates without a fault: admissible models
// of every shape, pressures that creep, rest or jump across the span, volumes that rest, move or jump,
// targets beside the pressure, far from it and beyond reach.
//
// usage: plenum_tick_bench [KIND]    KIND: tassa9 (default), tassa9r or greybox: the kind of all eight models
//
// A second count takes in the frames of that tick: SYNC, two PDOs of set points received, and what is sent.
#include <valgrind/callgrind.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <memory>
#include <random>
#include <span>
#include <string_view>

#include "firmware/canopen/cia301.hpp"
#include "firmware/canopen/objects.hpp"
#include "firmware/config/model_image.hpp"
#include "firmware/controller.hpp"
#include "tests/firmware/control/admissible.hpp"
#include "tests/firmware/control/random_greybox.hpp"

namespace {

using namespace plenum;

constexpr int kEpisodes = 150;  ///< one model each
constexpr int kTicks = 20;      ///< of an episode
constexpr std::uint8_t kNode = 1;
constexpr float kPressureGain_kPa_V = 110.0F;
constexpr float kVolumeGain_mL_V = 110.0F;

Settings settings() {
  Settings settings;
  settings.node.node_id = kNode;
  settings.board.supply_low_kPa = 0.0F;
  for (config::ChamberSettings& chamber : settings.chamber) {
    chamber.pressure_gain_kPa_per_V = kPressureGain_kPa_V;
    chamber.volume_gain_mL_per_V = kVolumeGain_mL_V;
    chamber.volume_offset_mL = 0.0F;
    chamber.pressure_low_kPa = 30.0F;
    chamber.pressure_high_kPa = 1000.0F;
    chamber.over_pressure_kPa = 1200.0F;
    chamber.residual_ticks = 0;  // the readings are not those of the model
  }
  return settings;
}

void receive(Controller& controller, std::uint32_t id, std::initializer_list<std::uint8_t> data) {
  ports::CanFrame frame;
  frame.id = id;
  frame.length = static_cast<std::uint8_t>(data.size());
  std::copy(data.begin(), data.end(), frame.data.begin());
  controller.receive(frame);
}

void control_word(Controller& controller, std::uint16_t word) {
  receive(controller, 0x400U + kNode,
          {static_cast<std::uint8_t>(word), static_cast<std::uint8_t>(word >> 8U)});
}

void setpoints(Controller& controller, float pressure_kPa) {
  const auto mbar = static_cast<std::uint16_t>(std::lround(pressure_kPa * 10.0F));
  const auto low = static_cast<std::uint8_t>(mbar);
  const auto high = static_cast<std::uint8_t>(mbar >> 8U);
  for (const std::uint32_t id : {0x200U, 0x300U}) {
    receive(controller, id + kNode, {low, high, low, high, low, high, low, high});
  }
}

/// TPDO5..12 on the bus with each SYNC: the capture stream.
void start_stream(Controller& controller) {
  for (std::uint8_t c = 0; c < config::kChambers; ++c) {
    receive(controller, 0x600U + kNode,
            {0x23, static_cast<std::uint8_t>(0x04 + c), 0x18, 1, static_cast<std::uint8_t>(0x80 + c), 0x06, 0,
             0x40});
  }
}

void drain(Controller& controller) {
  ports::CanFrame frame;
  while (controller.next_frame(frame)) {
  }
}

/// What the eight chambers are shown in one tick.
struct Scene {
  float pressure_kPa = 300.0F;
  float volume_mL = 300.0F;
  float target_kPa = 300.0F;
};

/// A model, and a chamber that may have it.
struct Subject {
  config::ModelParameters model;
  float ambient_kPa, supply_kPa;
  float pressure_kPa, volume_mL, volume_rate_mL_s;
};

Subject draw_formula(std::mt19937& random, config::ModelKind kind) {
  constexpr std::size_t kC4 = 3;
  const control::testing::RandomChamber chamber = control::testing::random_chamber(random);
  Subject subject{{},
                  chamber.parameters[11],
                  chamber.parameters[10],
                  chamber.pressure_kPa,
                  chamber.volume_mL,
                  chamber.volume_rate_mL_s};
  for (std::size_t i = 0; i < chamber.parameters.size(); ++i) {
    if (kind == config::ModelKind::tassa9r && i == kC4) continue;
    subject.model.value[subject.model.count++] = chamber.parameters[i];
  }
  return subject;
}

Subject draw_greybox(std::mt19937& random) {
  const control::testing::GreyboxCase chamber = control::testing::random_case(random);
  Subject subject{{},
                  chamber.set[control::Greybox::kAmbient],
                  chamber.set[control::Greybox::kSupply],
                  chamber.pressure_kPa,
                  chamber.motion.volume_mL,
                  chamber.motion.volume_rate_mL_s};
  subject.model.count = control::Greybox::kParameters;
  std::copy(chamber.set.begin(), chamber.set.end(), subject.model.value.begin());
  return subject;
}

class Search {
 public:
  Search(unsigned seed, config::ModelKind kind) : random_(seed), kind_(kind) {}

  void episode() {
    Subject subject =
        kind_ == config::ModelKind::greybox ? draw_greybox(random_) : draw_formula(random_, kind_);
    subject.model.kind = kind_;
    const auto controller = std::make_unique<Controller>(settings());
    std::array<std::uint8_t, config::kMaxImageBytes> bytes{};
    const std::size_t size = config::encode(subject.model, bytes);
    for (std::uint8_t c = 0; c < config::kChambers; ++c) {
      if (!controller->restore(c, std::span(bytes).first(size))) ++refused_;
    }
    low_kPa_ = subject.ambient_kPa;
    high_kPa_ = std::min(subject.supply_kPa, 990.0F);
    scene_ = {subject.pressure_kPa, subject.volume_mL, subject.pressure_kPa};
    rate_mL_s_ = subject.volume_rate_mL_s;

    receive(*controller, 0, {1, kNode});  // NMT start
    start_stream(*controller);
    control_word(*controller, canopen::word::kDisabled);
    tick(*controller, false);
    control_word(*controller, canopen::word::kHold);
    tick(*controller, false);
    control_word(*controller, canopen::word::kActive);
    tick(*controller, false);
    for (int k = 0; k < kTicks; ++k) {
      next_scene();
      tick(*controller, true);
    }
  }

  int not_regulating() const { return not_regulating_; }
  int refused() const { return refused_; }

 private:
  float between(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random_); }

  void next_scene() {
    const float span_kPa = high_kPa_ - low_kPa_;
    const float way = between(0.0F, 1.0F);
    if (way < 0.3F) scene_.pressure_kPa = between(low_kPa_, high_kPa_);
    if (way > 0.6F) scene_.pressure_kPa += 0.02F * span_kPa * between(-1.0F, 1.0F);
    scene_.pressure_kPa = std::clamp(scene_.pressure_kPa, 30.0F, 1000.0F);

    const float volume_way = between(0.0F, 1.0F);
    if (volume_way < 0.1F) scene_.volume_mL = between(5.0F, 1000.0F);
    if (volume_way > 0.4F) scene_.volume_mL += 0.01F * rate_mL_s_;
    scene_.volume_mL = std::clamp(scene_.volume_mL, 1.0F, 1000.0F);

    const std::array<float, 5> reaches{0.0F, 0.002F, 0.03F, 0.3F, 2.0F};
    const float reach = reaches[std::uniform_int_distribution<std::size_t>(0, reaches.size() - 1)(random_)];
    scene_.target_kPa =
        std::clamp(scene_.pressure_kPa + reach * span_kPa * between(-1.0F, 1.0F), 30.0F, 1000.0F);
  }

  void tick(Controller& controller, bool counted) {
    Inputs inputs;
    for (std::size_t c = 0; c < config::kChambers; ++c) {
      inputs.pressure[c] = {.mean_V = scene_.pressure_kPa / kPressureGain_kPa_V, .fresh = true};
      inputs.position[c] = {.mean_V = scene_.volume_mL / kVolumeGain_mL_V, .fresh = true};
    }
    inputs.supply = {.mean_V = 7.0F, .fresh = true};
    if (counted) CALLGRIND_TOGGLE_COLLECT;
    setpoints(controller, scene_.target_kPa);
    receive(controller, 0x80, {});
    if (counted) CALLGRIND_DUMP_STATS_AT("receive");
    controller.step(inputs);
    if (counted) CALLGRIND_DUMP_STATS_AT("step");
    drain(controller);
    if (counted) {
      CALLGRIND_TOGGLE_COLLECT;
      CALLGRIND_DUMP_STATS_AT("send");
      if (controller.state() != safety::State::active || controller.image().error_code != 0)
        ++not_regulating_;
    }
  }

  std::mt19937 random_;
  config::ModelKind kind_;
  Scene scene_;
  float low_kPa_ = 100.0F;
  float high_kPa_ = 700.0F;
  float rate_mL_s_ = 0.0F;
  int not_regulating_ = 0;
  int refused_ = 0;
};

}  // namespace

int main(int count, char** words) {
  const std::string_view name = count > 1 ? words[1] : "tassa9";
  const auto kind = name == "tassa9"    ? config::ModelKind::tassa9
                    : name == "tassa9r" ? config::ModelKind::tassa9r
                    : name == "greybox" ? config::ModelKind::greybox
                                        : config::ModelKind::none;
  if (kind == config::ModelKind::none) {
    std::fprintf(stderr, "%s: expected tassa9, tassa9r or greybox\n", words[1]);
    return 2;
  }
  Search search(2024, kind);
  for (int episode = 0; episode < kEpisodes; ++episode) search.episode();
  if (search.not_regulating() == 0 && search.refused() == 0) return 0;
  std::fprintf(stderr, "%d of %d ticks did not regulate, %d models were refused; the count is void\n",
               search.not_regulating(), kEpisodes * kTicks, search.refused());
  return 1;
}
