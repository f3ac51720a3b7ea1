// Compiled once a scalar, as the core's own sources are (CMakeLists.txt): PLENUM_CORE_IN names the function that it defines.
#include "tests/equivalence/core.hpp"

#include <algorithm>

#include "firmware/control/any_model.hpp"
#include "firmware/control/model_paths.hpp"
#include "firmware/control/reference_shaper.hpp"
#include "firmware/control/regulator.hpp"
#include "firmware/control/volume_observer.hpp"

namespace equivalence {
namespace {

using namespace plenum;
using numeric::Scalar;

Scalar scalar(double x) {
  return static_cast<Scalar>(x);
}
double real(Scalar x) {
  return static_cast<double>(x);
}
control::ChamberMotion motion(const State& of) {
  return {.volume_mL = scalar(of.volume_mL),
          .volume_rate_mL_s = scalar(of.volume_rate_mL_s),
          .supply = scalar(of.supply)};
}

class OneChamber final : public Core {
 public:
  OneChamber(std::uint16_t kind, std::span<const float> parameters) {
    config::ModelParameters model;
    model.kind = static_cast<config::ModelKind>(kind);
    model.count = static_cast<std::uint16_t>(parameters.size());
    std::copy(parameters.begin(), parameters.end(), model.value.begin());
    model_ = known_.take_over(model, Scalar(0), Scalar(10));
    control::Regulator::Config regulator;
    regulator.command_low_V = Scalar(0);
    regulator.command_high_V = Scalar(10);
    regulator_.configure(regulator);
    const control::ModelPaths paths = control::paths_of(model, regulator.valve_delay_ticks);
    regulator_.take_over(paths.valve, paths.sensor_lag_ticks);
    volume_.configure({});
    shaper_.configure({});
  }

  Prediction step(const State& from, double command_V) const override {
    const control::Prediction made =
        model_->step(scalar(from.pressure_kPa), scalar(command_V), motion(from), Scalar(1));
    return {.end_kPa = real(made.end_kPa), .mean_kPa = real(made.mean_kPa)};
  }

  Inverse inverse(const State& from, double target_kPa, double near_V) const override {
    const control::Inverse made =
        model_->inverse(scalar(from.pressure_kPa), scalar(target_kPa), motion(from), scalar(near_V));
    return {.command_V = real(made.command_V),
            .reached_kPa = real(made.reached_kPa),
            .saturated = made.saturated};
  }

  std::uint32_t saturations() const override { return numeric::Fixed::saturations(); }

  void reset(double pressure_kPa, double volume_mL, double command_V) override {
    volume_.reset(scalar(volume_mL));
    shaper_.reset(scalar(pressure_kPa));
    regulator_.reset(scalar(pressure_kPa), scalar(command_V));
  }

  double regulate(double measured_kPa, double measured_mL, double setpoint_kPa) override {
    const control::ChamberMotion next = volume_.step(scalar(measured_mL));
    regulator_.observe(*model_, scalar(measured_kPa), volume_.past());
    const control::ReferenceShaper::Reference& reference =
        shaper_.step(scalar(setpoint_kPa), 0, regulator_.ahead());
    const control::Regulator::Command command = regulator_.regulate(*model_, reference, next);
    regulator_.sent(command.command_V);
    return real(command.command_V);
  }

 private:
  control::AnyModel known_;
  const control::PressureModel* model_ = nullptr;
  control::Regulator regulator_;
  control::VolumeObserver volume_;
  control::ReferenceShaper shaper_;
};

}  // namespace

std::unique_ptr<Core> PLENUM_CORE_IN(std::uint16_t kind, std::span<const float> parameters) {
  return std::make_unique<OneChamber>(kind, parameters);
}

}  // namespace equivalence
