// The emergency stop, answered when it comes and not only at the next tick: the valves lose their supply at once, and the tick
// makes the fault of it.
#pragma once

#include "firmware/ports/digital_io.hpp"

namespace plenum::board {

class PromptStop final : public ports::DigitalIo {
 public:
  /// `lines` must outlive it.
  explicit PromptStop(ports::DigitalIo& lines) noexcept : lines_(lines) {}

  /// The line of the emergency stop has changed.
  void look() noexcept {
    if (!lines_.read().emergency_stop) return;
    seen_ = true;
    outputs_.valve_power = false;
    lines_.write(outputs_);
  }

  /// What look() has seen since the last call counts, too.
  ports::DigitalInputs read() noexcept override {
    ports::DigitalInputs inputs = lines_.read();
    inputs.emergency_stop = inputs.emergency_stop || seen_;
    seen_ = false;
    return inputs;
  }

  void write(const ports::DigitalOutputs& outputs) noexcept override {
    outputs_ = outputs;
    lines_.write(outputs);
  }

 private:
  ports::DigitalIo& lines_;
  ports::DigitalOutputs outputs_;  ///< as written last
  bool seen_ = false;
};

}  // namespace plenum::board
