#include "firmware/config/units.hpp"

#include <gtest/gtest.h>

namespace plenum::config {
namespace {

TEST(InSi, ReadsInTheUnitsOfTheBusWhatTheCoreHasInItsOwn) {
  EXPECT_EQ(float{Pascals::of_core(numeric::Scalar(350.5F))}, 350'500.0F);
  EXPECT_FLOAT_EQ(CubicMetres::of_core(numeric::Scalar(150)), 150e-6F);
  EXPECT_EQ(float{Volts::of_core(numeric::Scalar(7.25F))}, 7.25F);
}

TEST(InSi, TakesWhatIsWrittenInThem) {
  EXPECT_EQ(Pascals(350'500.0F).in_core(), numeric::Scalar(350.5F));
  EXPECT_NEAR(static_cast<float>(CubicMetres(150e-6F).in_core()), 150.0F, 2e-5F);
  EXPECT_EQ(Volts(7.25F).in_core(), numeric::Scalar(7.25F));
  EXPECT_EQ(float{Pascals()}, 0.0F);
}

}  // namespace
}  // namespace plenum::config
