// The digital lines of a simulated board. Twin of the libgpiod driver of the board.
#pragma once

#include "firmware/ports/digital_io.hpp"

namespace plenum::host::ports {

class SimulatedDigitalIo final : public plenum::ports::DigitalIo {
 public:
  /// The world's side of the lines.
  void set_emergency_stop(bool open) { inputs_.emergency_stop = open; }
  const plenum::ports::DigitalOutputs& outputs() const { return outputs_; }

  plenum::ports::DigitalInputs read() noexcept override { return inputs_; }
  void write(const plenum::ports::DigitalOutputs& outputs) noexcept override { outputs_ = outputs; }

 private:
  plenum::ports::DigitalInputs inputs_;
  plenum::ports::DigitalOutputs outputs_;
};

}  // namespace plenum::host::ports
