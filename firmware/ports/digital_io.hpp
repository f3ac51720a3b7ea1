// The digital lines of a board, as the core sees them.
#pragma once

namespace plenum::ports {

struct DigitalInputs {
  bool emergency_stop = false;  ///< true: the emergency stop circuit is open
};

struct DigitalOutputs {
  bool valve_power = false;  ///< supply relay of the valves
  bool fault_lamp = false;
};

/// Implementations: board/drivers (libgpiod), host-sim/ports.
class DigitalIo {
 public:
  virtual DigitalInputs read() noexcept = 0;
  virtual void write(const DigitalOutputs& outputs) noexcept = 0;

 protected:
  ~DigitalIo() = default;
};

}  // namespace plenum::ports
