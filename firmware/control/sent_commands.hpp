// The commands that are still on their way to the flow, or act on it, as a model takes them.
//
// A command of delay n + f (n whole ticks, 0 <= f < 1) acts from n + f ticks after its tick's start, for a tick. So over the
// tick just past the command of n + 2 ticks ago acted for the share f, then that of n + 1 ticks ago.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/config/seal.hpp"
#include "firmware/control/pressure_model.hpp"
#include "firmware/control/supply_line.hpp"
#include "firmware/control/valve_path.hpp"

namespace plenum::control {

class SentCommands {
 public:
  struct Sent {
    Scalar command_V = 0;  ///< as it was sent
    Scalar model_V = 0;    ///< as a model takes it
    bool planned = false;  ///< as the regulator had planned it, by an inverse that found this slope:
    Scalar by_command_kPa_V = 0;
    bool opened = false;  ///< a model has said what it does:
    Opening opening{};
  };

  /// `delay_ticks`: 0 to ValvePath::kMostDelay_ticks.
  void configure(Scalar delay_ticks) noexcept {
    whole_ticks_ = static_cast<std::size_t>(delay_ticks);
    part_ticks_ = delay_ticks - static_cast<Scalar>(whole_ticks_);
  }
  /// n; not above what the tables hold, whatever has flipped.
  std::size_t whole_ticks() const noexcept { return whole_ticks_ <= kMost ? whole_ticks_ : kMost; }
  Scalar part_ticks() const noexcept { return part_ticks_; }  ///< f

  /// Of what configure() alone writes: config/seal.hpp.
  std::uint64_t sum_of_constants() const noexcept {
    return config::sum_of_object(whole_ticks_) + config::sum_of_object(part_ticks_);
  }

  /// Of those that act on the tick to come, or after it; what is older is read no more.
  std::uint64_t sum_of_acting() const noexcept {
    std::uint64_t sum = newest_;
    for (std::size_t ticks = whole_ticks() + 2; ticks > 0; --ticks) sum += config::sum_of_object(ago(ticks));
    return sum;
  }

  /// The same command has been sent for long.
  void reset(Scalar command_V) noexcept { sent_.fill({.command_V = command_V, .model_V = command_V}); }

  /// Another model, and another path of the valve: the same commands go through it once more, the oldest of them sent for long.
  void pass_again(ValvePath& valve) noexcept {
    valve.reset(ago(kRing).command_V);
    for (std::size_t ticks = kRing; ticks > 0; --ticks) {
      Sent& of = sent_[place(ticks)];
      of = {.command_V = of.command_V, .model_V = valve.sent(of.command_V)};
    }
  }

  void push(const Sent& sent) noexcept {
    newest_ = (newest_ + 1) % kRing;
    sent_[newest_] = sent;
  }

  /// Of `ticks` ago, 1 to n + 2; 1: the last.
  const Sent& ago(std::size_t ticks) const noexcept { return sent_[place(ticks)]; }

  /// What the command of `ticks` ago does, of the model in force since reset() or pass_again(): computed once.
  const Opening& opening(const PressureModel& model, std::size_t ticks) noexcept {
    Sent& of = sent_[place(ticks)];
    if (!of.opened) of.opening = model.opening(of.model_V);
    of.opened = true;
    return of.opening;
  }

  /// The one that acted last over the tick just past.
  const Sent& acted() const noexcept { return ago(whole_ticks() + 1); }

  /// The tick just past, from the pressure at its start, and what it takes from the supply.
  Prediction past_tick(const PressureModel& model, Scalar pressure_kPa, const ChamberMotion& past,
                       SupplyLine& line) noexcept {
    ChamberMotion motion = past;
    motion.supply = line.supply();
    const Moving moves = model.moving(motion);
    const Scalar rest = Scalar(1) - part_ticks_;
    const Prediction first = line.step(line.part(), part_ticks_, model, pressure_kPa,
                                       opening(model, whole_ticks() + 2), motion, moves);
    const Prediction second =
        line.step(line.rest(), rest, model, first.end_kPa, opening(model, whole_ticks() + 1), motion, moves);
    return {.end_kPa = second.end_kPa, .mean_kPa = part_ticks_ * first.mean_kPa + rest * second.mean_kPa};
  }

 private:
  static constexpr std::size_t kRing = 16;
  static constexpr std::size_t kMost = static_cast<std::size_t>(ValvePath::kMostDelay_ticks);
  static_assert(kRing >= kMost + 2);

  std::size_t place(std::size_t ticks_ago) const noexcept {
    return (newest_ + kRing + 1 - ticks_ago) % kRing;
  }

  std::array<Sent, kRing> sent_{};
  std::size_t newest_ = 0;
  std::size_t whole_ticks_ = 0;
  Scalar part_ticks_ = 0;
};

}  // namespace plenum::control
