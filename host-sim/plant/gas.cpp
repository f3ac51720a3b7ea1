#include "host-sim/plant/gas.hpp"

#include <cmath>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant {

Gas reference_atmosphere() {
  const double specific_gas_constant = 1e5 / (1.185 * 293.15);
  Gas gas;
  gas.compressibility = 1.0;
  gas.universal_gas_constant_J_mol_K = 8.314462618;
  gas.molar_mass_kg_mol = gas.universal_gas_constant_J_mol_K / specific_gas_constant;
  gas.temperature_K = 293.15;
  gas.kappa = 1.4;
  return gas;
}

void validate(const Gas& gas) {
  require_above("gas molar_mass_kg_mol", gas.molar_mass_kg_mol, 0.0);
  require_above("gas compressibility", gas.compressibility, 0.0);
  require_above("gas universal_gas_constant_J_mol_K", gas.universal_gas_constant_J_mol_K, 0.0);
  require_above("gas temperature_K", gas.temperature_K, 0.0);
  require_above("gas kappa", gas.kappa, 1.0);
}

ThinPlateConstants thin_plate_constants(const Gas& gas, double discharge_coefficient) {
  validate(gas);
  require_above("discharge_coefficient", discharge_coefficient, 0.0);
  const double M_ZRT = 1.0 / (gas.specific_gas_constant_J_kg_K() * gas.temperature_K);
  const double C = discharge_coefficient;
  const double kappa = gas.kappa;
  ThinPlateConstants constants;
  constants.alpha_s_m = C * std::sqrt(2.0 * M_ZRT * kappa / (kappa - 1.0));
  constants.beta_s_m =
      C * std::sqrt(kappa * M_ZRT * std::pow(2.0 / (kappa + 1.0), (kappa + 1.0) / (kappa - 1.0)));
  constants.theta = std::pow((kappa + 1.0) / 2.0, kappa / (kappa - 1.0));
  constants.kappa = kappa;
  return constants;
}

}  // namespace plenum::host::plant
