#include "host-sim/plant/orifice.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "tests/plant/plant_oracles.hpp"

namespace plenum::host::plant {
namespace {

TEST(Gas, ConstantsEqualThoseWorkedByHandFromTableII) {
  // M/(ZRT) = 0.029 / (0.99 * 8.31 * 293.15) = 1.20246344e-5; alpha = 0.72 sqrt(7 M/(ZRT)); theta = 1.2^3.5;
  // beta = 0.72 sqrt(1.4 M/(ZRT) / 1.2^6)
  const ThinPlateConstants c = thin_plate_constants(Gas{});
  EXPECT_NEAR(c.alpha_s_m, 0.72 * std::sqrt(7.0 * 1.20246344e-5), 1e-9);
  EXPECT_NEAR(c.beta_s_m, 0.72 * std::sqrt(1.4 * 1.20246344e-5 / 2.985984), 1e-9);
  EXPECT_NEAR(c.theta, 1.892929, 1e-6);
}

TEST(Gas, RefusesWhatIsNoGasAndNamesTheField) {
  Gas gas;
  gas.kappa = 1.0;
  try {
    thin_plate_constants(gas);
    FAIL() << "kappa = 1 accepted";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("kappa"), std::string::npos) << e.what();
  }
}

TEST(Gas, ReferenceAtmosphereHasTheDensityOfTable1) {
  const Gas gas = reference_atmosphere();
  EXPECT_NEAR(1e5 / (gas.specific_gas_constant_J_kg_K() * gas.temperature_K), 1.185, 1e-12);
}

TEST(SeventhRoot, HoldsItsErrorOverTheSubsonicRange) {
  for (double x = 0.5283; x <= 1.0; x += 1e-4) {
    EXPECT_NEAR(seventh_root(x) / std::pow(x, 1.0 / 7.0), 1.0, 2e-14) << "x = " << x;
  }
}

TEST(ThinPlate, AgreesWithThePrintedFormulaForAirAndForOtherGases) {
  for (const double kappa : {1.4, 1.4 + 1e-9, 1.3, 1.667}) {
    Gas gas;
    gas.kappa = kappa;
    const ThinPlateConstants c = thin_plate_constants(gas);
    const ThinPlate plate(c);
    for (double pd = 20e3; pd < 619e3; pd += 1.7e3) {
      const double expected = oracle::thin_plate_z(620e3, pd, c.alpha_s_m, c.beta_s_m, c.theta, kappa);
      EXPECT_NEAR(plate.phi(620e3, pd) / expected, 1.0, 1e-12)
          << "kappa " << kappa << ", p_d " << pd << " Pa";
    }
  }
}

TEST(ThinPlate, MassFlowAndItsSlopeAreContinuousAtTheChokedLimit) {
  for (const double kappa : {1.2, 1.4, 1.667}) {
    Gas gas;
    gas.kappa = kappa;
    const ThinPlate plate(thin_plate_constants(gas));
    const double limit = 620e3 / plate.constants().theta;
    const Flux choked = plate.flux(620e3, limit * (1.0 - 1e-9));
    const Flux subsonic = plate.flux(620e3, limit * (1.0 + 1e-9));
    EXPECT_NEAR(subsonic.flow / choked.flow, 1.0, 1e-12) << "kappa " << kappa;
    EXPECT_NEAR(subsonic.by_first / choked.by_first, 1.0, 1e-6) << "kappa " << kappa;
    EXPECT_NEAR(subsonic.by_second / choked.by_first, 0.0, 1e-6) << "kappa " << kappa;
  }
}

TEST(ThinPlate, FlowIsOddAndVanishesAtEqualPressures) {
  const ThinPlate plate(thin_plate_constants(Gas{}));
  EXPECT_EQ(plate.phi(3e5, 3e5), 0.0);
  for (double p = 5e4; p < 7e5; p += 1.3e4) EXPECT_EQ(plate.phi(p, 3e5), -plate.phi(3e5, p)) << p << " Pa";
}

TEST(ThinPlate, ChordMeetsTheRootWhereItBegins) {
  for (const double kappa : {1.4, 1.3}) {
    Gas gas;
    gas.kappa = kappa;
    const ThinPlate plate(thin_plate_constants(gas));
    const double inside = plate.phi(1e5, 1e5 * (1.0 - kLaminarBelow * (1.0 - 1e-9)));
    const double outside = plate.phi(1e5, 1e5 * (1.0 - kLaminarBelow * (1.0 + 1e-9)));
    EXPECT_NEAR(inside / outside, 1.0, 1e-5) << "kappa " << kappa;
  }
}

template <class Port>
void expect_slopes_are_differences(const Port& port, double p1, double p2) {
  const double h = 1.0;
  const Flux f = port.flux(p1, p2);
  const double by_first = (port.flux(p1 + h, p2).flow - port.flux(p1 - h, p2).flow) / (2.0 * h);
  const double by_second = (port.flux(p1, p2 + h).flow - port.flux(p1, p2 - h).flow) / (2.0 * h);
  const double scale = std::abs(f.flow / p1) + std::abs(by_second);
  EXPECT_NEAR(f.by_first, by_first, 1e-5 * scale) << p1 << " Pa to " << p2 << " Pa";
  EXPECT_NEAR(f.by_second, by_second, 1e-5 * scale) << p1 << " Pa to " << p2 << " Pa";
}

TEST(ThinPlate, SlopesAreThoseOfTheFlow) {
  Gas helium;
  helium.kappa = 1.667;
  for (const Gas& gas : {Gas{}, helium}) {
    const ThinPlate plate(thin_plate_constants(gas));
    for (double p = 60e3; p < 900e3; p += 37e3) expect_slopes_are_differences(plate, 620e3, p);
    for (double p = 60e3; p < 900e3; p += 37e3) expect_slopes_are_differences(plate, p, 101e3);
  }
}

TEST(EllipsePort, IsTheIsoFormAtIndexOneHalfAndCrackingOne) {
  const EllipsePort port{2e-8, 0.31, 1.0, 0.5};
  for (double r = 0.32; r < 0.999; r += 0.01) {
    const double iso = std::sqrt(1.0 - std::pow((r - 0.31) / (1.0 - 0.31), 2.0));
    EXPECT_NEAR(port.flux(5e5, r * 5e5).flow, 2e-8 * 5e5 * iso, 1e-14) << "r = " << r;
  }
}

TEST(EllipsePort, IsChokedBelowTheCriticalAndShutBeyondTheCrackingRatio) {
  const EllipsePort port{2e-8, 0.2, 0.6, 0.8};
  EXPECT_DOUBLE_EQ(port.flux(5e5, 0.1 * 5e5).flow, 2e-8 * 5e5);
  EXPECT_NEAR(port.flux(5e5, 0.4 * 5e5).flow, 2e-8 * 5e5 * std::pow(0.75, 0.8), 1e-14);
  EXPECT_EQ(port.flux(5e5, 0.6 * 5e5).flow, 0.0);
  EXPECT_EQ(port.flux(5e5, 5e5).flow, 0.0);
  EXPECT_EQ(port.flux(0.4 * 5e5, 5e5).flow, -port.flux(5e5, 0.4 * 5e5).flow);
}

TEST(EllipsePort, SlopesAreThoseOfTheFlow) {
  for (const EllipsePort& port : {EllipsePort{2e-8, 0.31, 1.0, 0.5}, EllipsePort{2e-8, 0.0, 0.9, 1.0},
                                  EllipsePort{2e-8, 0.2, 0.98, 0.43}}) {
    for (double p = 60e3; p < 900e3; p += 37e3) expect_slopes_are_differences(port, 620e3, p);
    for (double p = 60e3; p < 900e3; p += 37e3) expect_slopes_are_differences(port, p, 101e3);
  }
}

TEST(FlowFunction, IsTheTabulatedMaximumForAir) {
  EXPECT_NEAR(choked_flow_function(1.4), 0.484, 5e-4);
}

}  // namespace
}  // namespace plenum::host::plant
