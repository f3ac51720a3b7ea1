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
    const auto made = model_.step(
        taken_over(box.pressure_kPa), taken_over(box.command_V),
        {.volume_mL = taken_over(box.volume_mL), .volume_rate_mL_s = taken_over(box.speed_mL_s)}, Rounded(1));
    return {.end_kPa = bounds(made.end_kPa),
            .mean_kPa = bounds(made.mean_kPa),
            .error_kPa = std::max(made.end_kPa.error(), made.mean_kPa.error()),
            .largest = Rounded::largest};
  }

  std::size_t parameters() const override { return Model::kParameters; }

 private:
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
