// The reference of a chamber: set points delayed to their time, limited in value and in rate.
//
// A set point that arrives with a preview of N ticks is to be met N ticks later; until then it is known in
// advance, and the regulator can move the valve before the error appears. The shaper answers with the
// references of this tick's start, of its end, and of the next tick's end.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/control/pressure_model.hpp"

namespace plenum::control {

class ReferenceShaper {
 public:
  static constexpr std::size_t kMaxPreview = 8;

  struct Config {
    Scalar low_kPa = Scalar(100);        ///< set points below are raised to it
    Scalar high_kPa = Scalar(700);       ///< set points above are lowered to it
    Scalar ramp_kPa_s = Scalar(100000);  ///< largest rate of the reference
  };

  struct Reference {
    Scalar now_kPa = 0;    ///< at the start of the tick
    Scalar next_kPa = 0;   ///< at its end
    Scalar after_kPa = 0;  ///< one tick later; next_kPa where the preview does not reach so far
  };

  void configure(const Config& config) noexcept { config_ = config; }

  /// The reference stands at `pressure_kPa`; set points move it from there at the ramp's rate.
  void reset(Scalar pressure_kPa) noexcept;

  /// Takes the set point latched for this tick. preview_ticks above kMaxPreview counts as kMaxPreview.
  Reference step(Scalar setpoint_kPa, std::uint8_t preview_ticks) noexcept;

 private:
  Config config_;
  std::array<Scalar, kMaxPreview + 1> latched_kPa_{};  ///< the newest first
  Scalar now_kPa_ = 0;
};

}  // namespace plenum::control
