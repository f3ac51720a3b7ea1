#include "host-sim/plant/servo/orifice_constants.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "host-sim/plant/orifice.hpp"

namespace plenum::host::plant::servo {
namespace {

TEST(OrificeConstants, OfAirAreThePrintedOnesForTheGasConstantOfAKilogram) {
  const OrificeConstants c = orifice_constants(1.4, 287.0);
  EXPECT_NEAR(c.choked, kPrintedForAir.choked, 5e-7);
  EXPECT_NEAR(c.subsonic, kPrintedForAir.subsonic, 5e-7);
  EXPECT_NEAR(c.critical_ratio, kPrintedForAir.critical_ratio, 5e-4);
}

TEST(OrificeConstants, EqualThoseWorkedByHand) {
  // k = 1.4: (2/2.4)^6 = 1/2.985984, C2 = sqrt(7/R), P_cr = (1/1.2)^3.5
  const OrificeConstants c = orifice_constants(1.4, 280.0);
  EXPECT_NEAR(c.choked, std::sqrt(0.005 / 2.985984), 1e-15);
  EXPECT_NEAR(c.subsonic, std::sqrt(0.025), 1e-15);
  EXPECT_NEAR(c.critical_ratio, 0.52828178771, 1e-10);
}

TEST(OrificeFlow, BothBranchesMeetAtTheCriticalRatioForEveryGas) {
  for (const double k : {1.1, 1.3, 1.4, 1.667}) {
    const OrificeConstants c = orifice_constants(k, 287.0);
    const double below = orifice_flow_kg_s(c, k, 1e-6, 7e5, 7e5 * c.critical_ratio * (1.0 - 1e-9), 293.0);
    const double above = orifice_flow_kg_s(c, k, 1e-6, 7e5, 7e5 * c.critical_ratio * (1.0 + 1e-9), 293.0);
    EXPECT_NEAR(above / below, 1.0, 1e-8) << "k = " << k;
  }
}

TEST(OrificeFlow, IsTheThinPlateOfTheCylindersValve) {
  Gas gas;
  const double C_f = 0.72;
  const ThinPlate plate(thin_plate_constants(gas, C_f));
  const OrificeConstants c = orifice_constants(gas.kappa, gas.specific_gas_constant_J_kg_K());
  for (double pd = 1e5; pd < 6.99e5; pd += 1.3e4) {
    const double flow = orifice_flow_kg_s(c, gas.kappa, C_f, 7e5, pd, gas.temperature_K);
    EXPECT_NEAR(plate.phi(7e5, pd) / flow, 1.0, 1e-12) << "P_d = " << pd << " Pa";
  }
}

TEST(OrificeFlow, RefusesWhatIsOutOfRangeAndNamesIt) {
  const OrificeConstants c = orifice_constants(1.4, 287.0);
  try {
    orifice_flow_kg_s(c, 1.4, 1e-6, 1e5, 2e5, 293.0);
    FAIL() << "a downstream pressure above the upstream one was accepted";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("downstream_Pa"), std::string::npos) << e.what();
  }
  EXPECT_THROW(orifice_constants(1.0, 287.0), std::invalid_argument);
  EXPECT_THROW(orifice_constants(1.4, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::plant::servo
