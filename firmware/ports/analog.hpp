// Analog inputs and outputs of a board, as the core sees them.
#pragma once

#include <cstdint>
#include <span>

namespace plenum::ports {

/// One ADC channel over one tick: the mean of the raw samples taken in the tick just past.
struct AnalogReading {
  float mean_V = 0.0F;  ///< mean voltage at the input pin over the tick [V]
  bool fresh = false;   ///< false: no sample arrived in the tick just past
  bool at_end = false;  ///< all samples at the most that the converter can tell: the voltage may be any above
};

/// Block-averaged inputs. Implementations: board/drivers (IIO buffer), host-sim/ports (simulated converter).
class AnalogInput {
 public:
  /// Fills one reading a channel, in channel order; channels beyond those the device has are left not fresh.
  virtual void read(std::span<AnalogReading> readings) noexcept = 0;

 protected:
  ~AnalogInput() = default;
};

/// Voltage outputs, held until the next write.
class AnalogOutput {
 public:
  /// Sets the outputs [V], in channel order. Returns false when the device refused any of them.
  virtual bool write(std::span<const float> command_V) noexcept = 0;

 protected:
  ~AnalogOutput() = default;
};

}  // namespace plenum::ports
