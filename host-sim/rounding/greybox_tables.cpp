// Compiled with the core's sources for a scalar and in a namespace of its own; TABLES_IN names the function (CMakeLists.txt).
#include "host-sim/rounding/greybox_tables.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>

#include "firmware/control/greybox.hpp"

namespace plenum::control {

/// The friend of the model: sees its tables.
struct GreyboxTables {
  using Tables = ::rounding::GreyboxTables;

  static double number(Scalar of) { return static_cast<double>(of); }
  static std::vector<double> numbers(std::span<const Scalar> of) {
    std::vector<double> as_double;
    std::transform(of.begin(), of.end(), std::back_inserter(as_double), number);
    return as_double;
  }
  static Tables::Curve curve(const Greybox::Curve& of) {
    return {numbers(of.corner_kPa), numbers(of.flow_kPa), numbers(of.slope)};
  }
  static Tables::Ports ports(const Greybox::Ports& of) { return {number(of.inlet), number(of.exhaust)}; }

  static Tables of(const Greybox& model) {
    Tables tables;
    tables.inlet = curve(model.inlet_);
    tables.exhaust = curve(model.exhaust_);
    tables.leak_L_s_kPa = number(model.leak_L_s_kPa_);
    tables.gap_kPa = number(Greybox::kGap_kPa);
    tables.node_V = numbers(model.node_V_);
    std::transform(model.node_.begin(), model.node_.end(), std::back_inserter(tables.node), ports);
    std::transform(model.slope_.begin(), model.slope_.end(), std::back_inserter(tables.slope), ports);
    tables.tick_s_mL_L = number(kTick_s * Scalar(1000));
    tables.least_volume_mL = number(model.least_volume_mL_);
    tables.dead_volume_mL = number(model.dead_volume_mL_);
    tables.volume_exponent = number(model.volume_exponent_);
    tables.supply_kPa = number(model.supply_kPa_);
    tables.ambient_kPa = number(model.ambient_kPa_);
    return tables;
  }
};

}  // namespace plenum::control

namespace rounding {

GreyboxTables TABLES_IN(std::span<const float> parameters) {
  using plenum::control::Greybox;
  std::array<plenum::numeric::Scalar, Greybox::kParameters> of{};
  std::copy_n(parameters.begin(), std::min(parameters.size(), of.size()), of.begin());
  const auto model = std::make_unique<Greybox>();
  model->configure(of, plenum::numeric::Scalar(0), plenum::numeric::Scalar(10));
  return plenum::control::GreyboxTables::of(*model);
}

}  // namespace rounding
