#include "host-sim/reproduce/proportional_valve/measured_leaks.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>

#include "tests/identify/orifice/leak_records.hpp"

namespace plenum::host::reproduce::proportional_valve {
namespace {

using identify::orifice::kLeakAtmosphere_Pa;

constexpr std::size_t kEvery = 10;  // rows

TEST(MeasuredLeakTable, FollowsFromTheRecords) {
  for (const MeasuredLeak& leak : kMeasuredLeaks) {
    const identify::orifice::VesselRecord record = identify::orifice::leak(leak.vessel);
    ASSERT_EQ(leak.samples.size(), (record.time_s.size() + kEvery - 1) / kEvery) << leak.vessel;
    for (std::size_t i = 0; i < leak.samples.size(); ++i) {
      EXPECT_NEAR(leak.samples[i].time_s, record.time_s[kEvery * i], 0.05 + 1e-9) << leak.vessel;
      EXPECT_NEAR(1e5 * leak.samples[i].gauge_bar, record.vessel_Pa[kEvery * i] - kLeakAtmosphere_Pa, 1e-3)
          << leak.vessel << ", " << leak.samples[i].time_s << " s";
    }
  }
}

TEST(MeasuredLeakTable, OfRepeatedTestsFollowsFromTheRecords) {
  const std::array<std::string, 3> tests{"test_1_mbar", "test_2_mbar", "test_3_mbar"};
  const trace::Recording record =
      identify::orifice::leak_file("repeated/reconnected", {"t_s", tests[0], tests[1], tests[2]});
  ASSERT_EQ(kReconnected.size(), (record.rows + kEvery - 1) / kEvery);
  for (std::size_t i = 0; i < kReconnected.size(); ++i) {
    EXPECT_DOUBLE_EQ(kReconnected[i].time_s, record["t_s"][kEvery * i]);
    for (std::size_t test = 0; test < tests.size(); ++test)
      EXPECT_EQ(kReconnected[i].change_mbar[test], record[tests[test]][kEvery * i])
          << tests[test] << ", " << kReconnected[i].time_s << " s";
  }
}

// The first test is Ultimaker_006: tests/identify/orifice.
TEST(MeasuredLeakTable, RepeatedTestsBeginWhereTheRecordOfTheirVesselDoes) {
  const identify::orifice::VesselRecord record = identify::orifice::leak("Ultimaker_006");
  EXPECT_NEAR(1e5 * kReconnectedFrom_gauge_bar, record.vessel_Pa.front() - kLeakAtmosphere_Pa, 1e-3);
}

}  // namespace
}  // namespace plenum::host::reproduce::proportional_valve
