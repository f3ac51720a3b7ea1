// Room for a model of any kind that an image can hold: one of them at a time.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "firmware/config/model_image.hpp"
#include "firmware/control/greybox.hpp"
#include "firmware/control/pressure_model.hpp"
#include "firmware/control/tassa9.hpp"
#include "firmware/control/tassa9r.hpp"

namespace plenum::control {

class AnyModel {
 public:
  /// Takes over parameters that config::validate() has passed. Returns the model, in_force().
  const PressureModel* take_over(const config::ModelParameters& parameters, Scalar command_low_V,
                                 Scalar command_high_V) noexcept {
    const std::array computed = config::scalars(parameters);
    const std::span values(computed);
    kind_ = parameters.kind;
    switch (kind_) {
      case config::ModelKind::none:
        break;
      case config::ModelKind::tassa9:
        tassa9_.configure(values.first<Tassa9::kParameters>(), command_low_V, command_high_V);
        break;
      case config::ModelKind::greybox:
        greybox_.configure(values.first<Greybox::kParameters>(), command_low_V, command_high_V);
        break;
      case config::ModelKind::tassa9r:
        tassa9r_.configure(values.first<Tassa9r::kParameters>(), command_low_V, command_high_V);
        break;
    }
    return in_force();
  }

  /// The model that was taken over last, which lives as long as this; nullptr for kind none. Found anew by its kind: of an
  /// address that is kept a flipped bit makes one of anything.
  const PressureModel* in_force() const noexcept {
    switch (kind_) {
      case config::ModelKind::none:
        break;
      case config::ModelKind::tassa9:
        return &tassa9_;
      case config::ModelKind::greybox:
        return &greybox_;
      case config::ModelKind::tassa9r:
        return &tassa9r_;
    }
    return nullptr;
  }

  /// Its memory, which nothing writes between two take_over().
  std::span<const std::byte> memory() const noexcept {
    const auto of = [](const auto& model) noexcept { return std::as_bytes(std::span(&model, 1)); };
    switch (kind_) {
      case config::ModelKind::none:
        break;
      case config::ModelKind::tassa9:
        return of(tassa9_);
      case config::ModelKind::greybox:
        return of(greybox_);
      case config::ModelKind::tassa9r:
        return of(tassa9r_);
    }
    return {};
  }

 private:
  config::ModelKind kind_ = config::ModelKind::none;
  Tassa9 tassa9_;
  Greybox greybox_;
  Tassa9r tassa9r_;
};

}  // namespace plenum::control
