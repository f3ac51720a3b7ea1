#include "tests/safety/upset.hpp"

#include <gtest/gtest.h>

#include <map>
#include <string>

namespace plenum::safety_case {
namespace {

// What a sanitizer stops a program for is what an upset does: a bool that is neither true nor false.
#if defined(__has_feature)
constexpr bool kSanitized = __has_feature(address_sanitizer);
#else
constexpr bool kSanitized = false;
#endif

/// Sixteen of each part; tests/bench/safety.cpp takes 12,000.
TEST(SingleEventUpset, IsDetectedHarmlessOrEndsTheProcess) {
  if (kSanitized)
    GTEST_SKIP() << "sanitizers end a program at values that upsets make; run it in the preset host";
  std::map<std::string, std::map<End, int>> ends;
  for (const Upset& upset : upsets(0, 16 * parts().size())) {
    EXPECT_TRUE(upset.end == End::harmless || upset.end == End::detected || upset.end == End::ended)
        << "seed " << upset.seed << ": " << upset.what;
    ++ends[parts()[upset.part].name][upset.end];
  }
  // the protection answers, not luck: of what is sealed or kept twice most flips are told
  for (const char* part : {"settings of a chamber", "settings at rest", "fault register", "volume observer",
                           "regulator's configuration"}) {
    EXPECT_GE(ends[part][End::detected], 8) << part;
  }
}

}  // namespace
}  // namespace plenum::safety_case
