// Analog inputs and outputs of a simulated board: the plant's converters behind the ports of the firmware.
// Twins of the IIO drivers of the board.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "firmware/ports/analog.hpp"
#include "host-sim/plant/converter.hpp"
#include "host-sim/plant/random.hpp"

namespace plenum::host::ports {

/// One converter channel an input, each with noise of its own.
class SimulatedAnalogInput final : public plenum::ports::AnalogInput {
 public:
  SimulatedAnalogInput(const plant::AdcConfig& config, std::size_t channels, const plant::Random& random) {
    for (std::size_t i = 0; i < channels; ++i)
      channel_.push_back({plant::AveragingAdc(config, random.split(i))});
  }

  /// The mean voltage at an input over the tick just past.
  void set_mean_V(std::size_t channel, double mean_V) { channel_.at(channel).mean_V = mean_V; }

  /// Fault injection: no more samples arrive from a channel, or they do again.
  void set_dead(std::size_t channel, bool dead) { channel_.at(channel).dead = dead; }

  /// Fault injection: the converter answers with the voltage of its next reading, whatever is at the input, or it converts again.
  void set_stuck(std::size_t channel, bool stuck) {
    channel_.at(channel).stuck = stuck;
    channel_.at(channel).stuck_V.reset();
  }

  void read(std::span<plenum::ports::AnalogReading> readings) noexcept override {
    const std::size_t count = std::min(readings.size(), channel_.size());
    for (std::size_t i = 0; i < count; ++i) {
      Channel& channel = channel_[i];
      // The converter runs on behind a dead line, so that its noise does not depend on the fault.
      const float converted_V = static_cast<float>(channel.adc.read_V(channel.mean_V));
      if (channel.stuck && !channel.stuck_V) channel.stuck_V = converted_V;
      const float mean_V = channel.stuck_V.value_or(converted_V);
      readings[i] =
          channel.dead ? plenum::ports::AnalogReading{} : plenum::ports::AnalogReading{mean_V, true};
    }
  }

 private:
  struct Channel {
    plant::AveragingAdc adc;
    double mean_V = 0.0;
    bool dead = false;
    bool stuck = false;
    std::optional<float> stuck_V{};
  };
  std::vector<Channel> channel_;
};

class SimulatedAnalogOutput final : public plenum::ports::AnalogOutput {
 public:
  explicit SimulatedAnalogOutput(std::size_t channels, int bits = 16)
      : dac_(channels, plant::Dac(bits)), at_valve_(channels) {
    for (std::size_t i = 0; i < channels; ++i) at_valve_[i] = i;
  }

  double output_V(std::size_t channel) const { return dac_.at(channel).output_V(); }

  /// What is at the valve's terminals; empty: its wire is cut.
  std::optional<double> valve_V(std::size_t valve) const {
    const std::optional<std::size_t> channel = at_valve_.at(valve);
    return channel ? std::optional(output_V(*channel)) : std::nullopt;
  }

  /// Fault injection: the valve is wired to this channel, from 0, in the place of its own; empty: to none.
  void wire(std::size_t valve, std::optional<std::size_t> channel) { at_valve_.at(valve) = channel; }

  /// Fault injection: writes are refused and the outputs stay, or they are taken again.
  void set_refusing(bool refusing) { refusing_ = refusing; }

  bool write(std::span<const float> command_V) noexcept override {
    if (refusing_ || command_V.size() < dac_.size()) return false;
    for (std::size_t i = 0; i < dac_.size(); ++i) dac_[i].write_V(static_cast<double>(command_V[i]));
    return true;
  }

 private:
  std::vector<plant::Dac> dac_;
  std::vector<std::optional<std::size_t>> at_valve_;  ///< the channel that a valve is wired to
  bool refusing_ = false;
};

}  // namespace plenum::host::ports
