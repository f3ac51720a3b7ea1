// A controller whose eight chambers are in the same state, so that what is dear for one is dear eight times.
//
// Models, set points and readings are drawn from everything that regulates without a fault: admissible models of every shape,
// pressures that creep, rest or jump across the span, volumes that rest, move or jump, targets beside the pressure, far from it and
// beyond reach.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <random>
#include <span>

#include "firmware/canopen/cia301.hpp"
#include "firmware/canopen/objects.hpp"
#include "firmware/config/model_image.hpp"
#include "firmware/controller.hpp"
#include "tests/firmware/control/random_subject.hpp"

namespace plenum::cost {

inline constexpr std::uint8_t kNode = 1;
inline constexpr float kPressureGain_kPa_V = 110.0F;
inline constexpr float kVolumeGain_mL_V = 110.0F;

inline Settings settings_alike() {
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

inline ports::CanFrame frame_of(std::uint32_t id, std::span<const std::uint8_t> data) {
  ports::CanFrame frame;
  frame.id = id;
  frame.length = static_cast<std::uint8_t>(data.size());
  std::copy(data.begin(), data.end(), frame.data.begin());
  return frame;
}

using control::testing::draw_subject;
using control::testing::Subject;

template <class Random>
class ChambersAlike {
 public:
  /// Draws from `random` with each next_scene(); it must outlive this.
  ChambersAlike(Random& random, const Subject& subject, const Settings& settings = settings_alike())
      : random_(random),
        controller_(settings),
        low_kPa_(subject.ambient_kPa),
        high_kPa_(std::min(subject.supply_kPa, 990.0F)),
        rate_mL_s_(subject.volume_rate_mL_s),
        pressure_kPa_(subject.pressure_kPa),
        volume_mL_(subject.volume_mL),
        target_kPa_(subject.pressure_kPa) {
    std::array<std::uint8_t, config::kMaxImageBytes> bytes{};
    const std::size_t size = config::encode(subject.model, bytes);
    for (std::uint8_t c = 0; c < config::kChambers; ++c) {
      if (!controller_.restore(c, std::span(bytes).first(size))) ++refused_;
    }
  }

  Controller& controller() { return controller_; }
  /// Models that the controller has not taken.
  int refused() const { return refused_; }
  bool regulates() const {
    return controller_.state() == safety::State::active && controller_.image().error_code == 0;
  }

  /// From power-on to ACTIVE, the capture stream running.
  void go_active() {
    controller_.prepare();
    receive(0, {1, kNode});  // NMT start
    for (std::uint8_t c = 0; c < config::kChambers; ++c) {
      // TPDO5..12 on the bus with each SYNC
      receive(0x600U + kNode, {0x23, static_cast<std::uint8_t>(0x04 + c), 0x18, 1,
                               static_cast<std::uint8_t>(0x80 + c), 0x06, 0, 0x40});
    }
    for (const std::uint16_t word :
         {canopen::word::kDisabled, canopen::word::kHold, canopen::word::kActive}) {
      receive(0x400U + kNode, {static_cast<std::uint8_t>(word), static_cast<std::uint8_t>(word >> 8U)});
      for (const ports::CanFrame& frame : setpoints()) controller_.receive(frame);
      controller_.step(inputs());
      ports::CanFrame frame;
      while (controller_.next_frame(frame)) {
      }
    }
  }

  /// What the chambers are shown in the tick to come.
  void next_scene() {
    const float span_kPa = high_kPa_ - low_kPa_;
    const float way = between(0.0F, 1.0F);
    if (way < 0.3F) pressure_kPa_ = between(low_kPa_, high_kPa_);
    if (way > 0.6F) pressure_kPa_ += 0.02F * span_kPa * between(-1.0F, 1.0F);
    pressure_kPa_ = std::clamp(pressure_kPa_, 30.0F, 1000.0F);

    const float volume_way = between(0.0F, 1.0F);
    if (volume_way < 0.1F) volume_mL_ = between(5.0F, 1000.0F);
    if (volume_way > 0.4F) volume_mL_ += 0.01F * rate_mL_s_;
    volume_mL_ = std::clamp(volume_mL_, 1.0F, 1000.0F);

    const std::array<float, 5> reaches{0.0F, 0.002F, 0.03F, 0.3F, 2.0F};
    const float reach = reaches[std::uniform_int_distribution<std::size_t>(0, reaches.size() - 1)(random_)];
    target_kPa_ = std::clamp(pressure_kPa_ + reach * span_kPa * between(-1.0F, 1.0F), 30.0F, 1000.0F);
  }

  /// The frames that precede a tick: the set points of all chambers, and the SYNC.
  std::array<ports::CanFrame, 3> setpoints() const {
    const auto mbar = static_cast<std::uint16_t>(std::lround(target_kPa_ * 10.0F));
    const auto low = static_cast<std::uint8_t>(mbar);
    const auto high = static_cast<std::uint8_t>(mbar >> 8U);
    const std::array<std::uint8_t, 8> data{low, high, low, high, low, high, low, high};
    return {frame_of(0x200U + kNode, data), frame_of(0x300U + kNode, data), frame_of(0x80U, {})};
  }

  Inputs inputs() const {
    Inputs inputs;
    for (std::size_t c = 0; c < config::kChambers; ++c) {
      inputs.pressure[c] = {.mean_V = pressure_kPa_ / kPressureGain_kPa_V, .fresh = true};
      inputs.position[c] = {.mean_V = volume_mL_ / kVolumeGain_mL_V, .fresh = true};
    }
    inputs.supply = {.mean_V = 7.0F, .fresh = true};
    return inputs;
  }

 private:
  float between(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random_); }

  void receive(std::uint32_t id, std::initializer_list<std::uint8_t> data) {
    controller_.receive(frame_of(id, {data.begin(), data.size()}));
  }

  Random& random_;
  Controller controller_;
  float low_kPa_, high_kPa_, rate_mL_s_;
  float pressure_kPa_, volume_mL_, target_kPa_;
  int refused_ = 0;
};

}  // namespace plenum::cost
