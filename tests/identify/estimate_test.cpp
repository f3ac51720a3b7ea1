#include "host-sim/identify/estimate.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace plenum::host::identify {
namespace {

TEST(Estimate, IsAtABoundWithinAMillionthOfTheRange) {
  EXPECT_EQ(bound_of(3.0 + 0.9e-6, 3.0, 4.0), Bound::low);
  EXPECT_EQ(bound_of(3.0 + 1.1e-6, 3.0, 4.0), Bound::none);
  EXPECT_EQ(bound_of(4.0 - 1.1e-6, 3.0, 4.0), Bound::none);
  EXPECT_EQ(bound_of(4.0 - 0.9e-6, 3.0, 4.0), Bound::high);
  EXPECT_EQ(bound_of(3.0, 3.0, 3.0), Bound::none) << "held";
}

TEST(Estimate, IsWrittenWithNothingWhereThereIsNothingToSay) {
  EXPECT_EQ(to_json({.value = 1.0, .standard_error = 0.25}).dump(),
            R"({"standard_error":0.25,"at_bound":null})");
  const Estimate low{1.0, std::numeric_limits<double>::quiet_NaN(), Bound::low};
  EXPECT_EQ(to_json(low).dump(), R"({"standard_error":null,"at_bound":"low"})");
  const Estimate high{1.0, std::numeric_limits<double>::infinity(), Bound::high};
  EXPECT_EQ(to_json(high).dump(), R"({"standard_error":null,"at_bound":"high"})");
}

TEST(Estimate, NamesItsBound) {
  EXPECT_STREQ(bound_in_words(Bound::low), "at its lower bound");
  EXPECT_STREQ(bound_in_words(Bound::high), "at its upper bound");
  EXPECT_STREQ(bound_in_words(Bound::none), "");
}

}  // namespace
}  // namespace plenum::host::identify
