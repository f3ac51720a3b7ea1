// The gas, and the constants of the thin-plate port.
//
//   alpha = C sqrt( 2 M / (Z R T) * kappa / (kappa - 1) )                                    (11)  [s/m]
//   beta  = C sqrt( kappa M / (Z R T) * (2 / (kappa + 1))^((kappa + 1) / (kappa - 1)) )      (12)  [s/m]
//   theta = ((kappa + 1) / 2)^(kappa / (kappa - 1))                                          (13)  [-]
//
// M molar mass [kg/mol], Z compressibility [-], R universal gas constant [Pa m3/(mol K)], T temperature [K],
// kappa ratio of specific heats [-], C discharge coefficient of the port [-].
// Assumptions: one temperature everywhere, Z and kappa constant. Range: dry air, 1 to 10 bar, 0 to 60 degC.
// The printed constants are consistent: both branches of (1c) and their slopes meet at p_u / p_d = theta for
// every kappa > 1 (a test holds them to it). The R of (4a) is per kilogram; with p v = m Z (R / M) T it is Z
// R / M, so that (4a) and (11) speak of the same gas. Source: "Modeling and Identification of Pneumatic
// Actuators", appendix and Table II.
#pragma once

namespace plenum::host::plant {

/// A perfect gas with a compressibility factor. The defaults are air of Table II; T, not stated there, is 20
/// degC.
struct Gas {
  double molar_mass_kg_mol = 0.029;
  double compressibility = 0.99;
  double universal_gas_constant_J_mol_K = 8.31;
  double temperature_K = 293.15;
  double kappa = 1.4;

  /// Z R / M [J/(kg K)]: p v = m * specific_gas_constant * T.
  double specific_gas_constant_J_kg_K() const {
    return compressibility * universal_gas_constant_J_mol_K / molar_mass_kg_mol;
  }

  friend bool operator==(const Gas&, const Gas&) = default;
};

/// The reference atmosphere of the proportional valve paper (its Table 1): R = P_a / (rho_0 T_0) = 287.87
/// J/(kg K) from P_a = 1e5 Pa, rho_0 = 1.185 kg/m3, T_0 = 293.15 K; gamma = 1.4.
Gas reference_atmosphere();

/// Throws std::invalid_argument naming the field, its value and its range.
void validate(const Gas& gas);

struct ThinPlateConstants {
  double alpha_s_m = 0.0;  ///< (11)
  double beta_s_m = 0.0;   ///< (12)
  double theta = 0.0;      ///< (13): choked above this ratio of upstream to downstream pressure
  double kappa = 0.0;
};

/// (11)-(13). The default discharge coefficient is that of Table II. Throws as validate().
ThinPlateConstants thin_plate_constants(const Gas& gas, double discharge_coefficient = 0.72);

}  // namespace plenum::host::plant
