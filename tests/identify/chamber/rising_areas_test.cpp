#include "host-sim/identify/chamber/rising_areas.hpp"

#include <gtest/gtest.h>

namespace plenum::host::identify::chamber {
namespace {

constexpr std::size_t kShape = effects::kFirstFigure[effects::kIdAreaShape];

effects::Figures shaped(std::size_t parameter, double value) {
  effects::Figures figures = effects::neutral_figures();
  figures[kShape + parameter] = value;
  return figures;
}

TEST(RisingAreas, CostNothingWhereTheyRise) {
  EXPECT_EQ(falling_areas_Pa(effects::neutral_figures()).norm(), 0.0);
  EXPECT_EQ(falling_areas_Pa(shaped(0, 3.0)).norm(), 0.0);
  EXPECT_EQ(falling_areas_Pa(shaped(0, -0.9)).norm(), 0.0);
}

TEST(RisingAreas, CostOfThePortThatFallsAndOfNoOther) {
  // b = o (1 - 1.5 g) has its top where 1 - 1.5 g = 1.5 o g', g' = 2/(o + 2)^2: at o = 1.46 V, until m is held at 0.05
  const Eigen::VectorXd inlet = falling_areas_Pa(shaped(0, -1.5));
  EXPECT_EQ(inlet.tail(100).norm(), 0.0);
  EXPECT_EQ(inlet[13], 0.0) << "1.3 to 1.4 V";
  EXPECT_GT(inlet[15], 0.0) << "1.5 to 1.6 V";
  EXPECT_EQ(falling_areas_Pa(shaped(2, -1.5)).head(100).norm(), 0.0);
  EXPECT_EQ(falling_areas_Pa(shaped(2, -1.5)).tail(100), inlet.head(100));
}

}  // namespace
}  // namespace plenum::host::identify::chamber
