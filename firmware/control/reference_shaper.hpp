// The reference of a chamber: set points delayed to their time, limited in value and in rate.
//
// A set point that arrives with a preview of N ticks is to be met N ticks later; until then it is known in
// advance, and the regulator can move the valve before the error appears. The shaper answers with the references
// at this tick's start and at the ends of the ticks that follow, as many as are asked for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/config/limits.hpp"
#include "firmware/config/seal.hpp"
#include "firmware/control/valve_path.hpp"

namespace plenum::control {

class ReferenceShaper {
 public:
  static constexpr std::size_t kMaxPreview = config::kMostPreview_ticks;

  struct Config {
    Scalar low_kPa = Scalar(100);        ///< set points below are raised to it
    Scalar high_kPa = Scalar(700);       ///< set points above are lowered to it
    Scalar rise_kPa_s = Scalar(100000);  ///< largest rate of the reference upwards
    Scalar fall_kPa_s = Scalar(100000);  ///< and downwards
  };

  /// How far ahead a regulator may look: the longest delay of a valve, and the tick in which a command acts.
  static constexpr std::size_t kMostAhead = static_cast<std::size_t>(ValvePath::kMostDelay_ticks) + 2;

  struct Reference {
    /// At the start of this tick, at its end, and so on; beyond the preview the last one known.
    std::array<Scalar, kMostAhead + 1> kPa{};

    /// `whole` ticks ahead and `part` of one, on the straight line between two of them; whole < kMostAhead.
    Scalar at(std::size_t whole, Scalar part) const noexcept {
      return kPa[whole] + part * (kPa[whole + 1] - kPa[whole]);
    }
  };

  void configure(const Config& config) noexcept;

  /// The reference stands at `pressure_kPa`; set points move it from there at the ramp's rate.
  void reset(Scalar pressure_kPa) noexcept;

  /// Takes the set point latched for this tick. preview_ticks above kMaxPreview counts as kMaxPreview. Answers up to the
  /// end of `ahead` ticks, 1 to kMostAhead.
  const Reference& step(Scalar setpoint_kPa, std::uint8_t preview_ticks, std::size_t ahead) noexcept;

  /// The reference at the last tick's end was not yet where its set point wants it.
  bool ramp_runs() const noexcept { return ramp_runs_; }
  /// The newest set point lies beyond the limits. None, as 0 stands for, does not.
  bool limit_touched() const noexcept { return limit_touched_; }

  /// Of what configure() alone writes: config/seal.hpp.
  std::uint64_t sum_of_constants() const noexcept {
    return config::sum_of_object(config_) + config::sum_of_object(rise_kPa_) +
           config::sum_of_object(fall_kPa_);
  }
  /// Of what the next step() goes on from.
  std::uint64_t sum_of_latched() const noexcept {
    return config::sum_of_object(latched_kPa_) + std::uint64_t{newest_} +
           config::sum_of_object(reference_.kPa[1]);
  }

 private:
  static constexpr std::uint32_t kKept = kMaxPreview + 1;

  Scalar latched_kPa(std::size_t ticks_ago) const noexcept {
    const std::size_t at = newest_ + ticks_ago;
    return latched_kPa_[at < kKept ? at : at - kKept];
  }

  Config config_;
  Scalar rise_kPa_ = Scalar(1000);  ///< what the ramp allows in a tick
  Scalar fall_kPa_ = Scalar(1000);
  std::array<Scalar, kKept> latched_kPa_{};  ///< a ring, from newest_ on backwards in time
  std::uint32_t newest_ = 0;
  Reference reference_;
  bool ramp_runs_ = false;
  bool limit_touched_ = false;
};

}  // namespace plenum::control
