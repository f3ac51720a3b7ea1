// Compiled with the core's sources that it runs, on Rounded numbers and in a namespace of their own (CMakeLists.txt).
#include "host-sim/rounding/core_box.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "firmware/control/tassa9.hpp"
#include "firmware/control/tassa9r.hpp"

namespace rounding {
namespace {

using plenum::numeric::Rounded;

/// As the board has it, which takes it over from a float or a reading.
Rounded taken_over(const Bounds& of) {
  if (of.low == of.high) return Rounded(of.low);
  return {of.low, of.high, Rounded::kHalfUlp};
}
Bounds bounds(const Rounded& of) {
  return {of.low(), of.high()};
}

template <class Model>
class Boxed final : public CoreModel {
 public:
  explicit Boxed(std::span<const Bounds> parameters) {
    std::array<Rounded, Model::kParameters> of;
    if (parameters.size() < of.size()) throw std::invalid_argument("too few parameters");
    const auto chamber = parameters.first(of.size());  // what follows is the valve's
    std::transform(chamber.begin(), chamber.end(), of.begin(), taken_over);
    Rounded::largest = 0;
    model_.configure(of, Rounded(0), Rounded(10));
    largest_ = Rounded::largest;
  }

  Tick tick(const Box& box) const override {
    Rounded::largest = largest_;
    return tick_of(model_.step(taken_over(box.pressure_kPa), taken_over(box.command_V),
                               motion(box.volume_mL, box.speed_mL_s), Rounded(1)));
  }

  Shares opening(const Bounds& command_V) const override {
    Rounded::largest = largest_;
    const auto open = model_.opening(taken_over(command_V));
    return {
        .first = bounds(open.first), .second = bounds(open.second), .third = {}, .largest = Rounded::largest};
  }

  Shares moving(const Bounds& volume_mL, const Bounds& speed_mL_s) const override {
    Rounded::largest = 0;
    const auto moves = model_.moving(motion(volume_mL, speed_mL_s));
    return {.first = bounds(moves.first),
            .second = bounds(moves.second),
            .third = bounds(moves.third),
            .largest = Rounded::largest};
  }

  Tick step(const Bounds& pressure_kPa, const Shares& open, const Shares& moves) const override {
    Rounded::largest = 0;
    return tick_of(model_.step(taken_over(pressure_kPa),
                               {.first = taken_over(open.first), .second = taken_over(open.second)},
                               {.first = taken_over(moves.first),
                                .second = taken_over(moves.second),
                                .third = taken_over(moves.third)},
                               Rounded(1)));
  }

  std::size_t parameters() const override { return Model::kParameters; }

 private:
  static plenum::control::ChamberMotion motion(const Bounds& volume_mL, const Bounds& speed_mL_s) {
    return {.volume_mL = taken_over(volume_mL), .volume_rate_mL_s = taken_over(speed_mL_s)};
  }
  static Tick tick_of(const plenum::control::Prediction& made) {
    return {.end_kPa = bounds(made.end_kPa),
            .mean_kPa = bounds(made.mean_kPa),
            .error_kPa = std::max(made.end_kPa.error(), made.mean_kPa.error()),
            .largest = Rounded::largest};
  }

  Model model_;
  double largest_ = 0;
};

}  // namespace

std::unique_ptr<CoreModel> core_model(std::string_view kind, std::span<const Bounds> parameters) {
  if (kind == "tassa9") return std::make_unique<Boxed<plenum::control::Tassa9>>(parameters);
  if (kind == "tassa9r") return std::make_unique<Boxed<plenum::control::Tassa9r>>(parameters);
  return nullptr;
}

}  // namespace rounding
