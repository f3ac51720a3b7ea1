// Real vessels: tests/data/leak_zillen/README.md.
#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <vector>

#include "host-sim/identify/orifice/fit_orifice.hpp"
#include "host-sim/identify/orifice/vessel_run.hpp"
#include "tests/identify/orifice/leak_records.hpp"

namespace plenum::host::identify::orifice {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const Vessel kUnknownVolume{.flow_exponent = 1.0};

TEST(MeasuredLeak, WholeCurvesAreFollowedWithinOneAndAHalfPercentOfTheirSpan) {
  for (const auto& [name, rate_1_s, bounded_kPa, wide_kPa] :
       {std::tuple{"Ultimaker_015", 0.0462, 12.0, 6.0}, std::tuple{"Ultimaker_020", 0.1257, 5.0, 2.5}}) {
    const VesselRecord record = leak(name);
    const OrificeFit bounded = fit_orifice(record, kUnknownVolume);
    const OrificeFit wide = fit_orifice(record, kUnknownVolume, {.most_subsonic_index = 10.0});
    EXPECT_LT(bounded.mean_absolute_error_Pa, 1e3 * bounded_kPa) << name;
    EXPECT_LT(wide.mean_absolute_error_Pa, 1e3 * wide_kPa) << name;
    EXPECT_NEAR(wide.choked_rate_1_s.value, rate_1_s, 0.01 * rate_1_s) << name;
  }
}

// Pores are no sharp edge: b falls to 0 and beta asks for more than the 1 that the paper allows a valve.
TEST(MeasuredLeak, PorousWallAsksForASubsonicIndexBeyondThePapersBound) {
  for (const char* name : {"Ultimaker_015", "Ultimaker_020"}) {
    const VesselRecord record = leak(name);
    EXPECT_EQ(fit_orifice(record, kUnknownVolume).subsonic_index.at_bound, Bound::high) << name;
    const OrificeFit wide = fit_orifice(record, kUnknownVolume, {.most_subsonic_index = 10.0});
    EXPECT_GT(wide.subsonic_index.value, 2.0) << name;
    EXPECT_EQ(wide.critical_ratio.at_bound, Bound::low) << name;
  }
}

TEST(MeasuredLeak, AreaIsNotSaidBecauseNoVolumeIsGiven) {
  EXPECT_FALSE(fit_orifice(leak("Ultimaker_020"), kUnknownVolume).area_m2.has_value());
}

TEST(MeasuredLeak, TightVesselsShowTheirRateAndNoFlowShape) {
  double slowest = 1.0;
  double fastest = 0.0;
  for (const char* name : {"Aluminium", "Prusa", "Formlabs", "Ultimaker_006", "Ultimaker_010"}) {
    const VesselRecord record = leak(name);
    EXPECT_THROW(fit_orifice(record, kUnknownVolume), CannotIdentify) << name;
    const OrificeFit fit = fit_orifice(record, kUnknownVolume, held_at_thin_plate());
    EXPECT_TRUE(fit.choked_rate_1_s.identified) << name;
    EXPECT_LT(fit.mean_absolute_error_Pa, 500.0) << name;
    slowest = std::min(slowest, fit.choked_rate_1_s.value);
    fastest = std::max(fastest, fit.choked_rate_1_s.value);
  }
  EXPECT_GT(slowest, 2e-5);
  EXPECT_LT(fastest, 1e-4);
}

// Changes in mbar since the first row; where the others began was not recorded.
TEST(RepeatedLeak, FirstOfTheReconnectedTestsIsTheRecordOfUltimaker006) {
  const trace::Recording whole = leak_file("Ultimaker_006", {"t_s", "p_bar"});
  const trace::Recording tests = leak_file("repeated/reconnected", {"t_s", "test_1_mbar"});
  for (std::size_t i = 0; i < tests.rows; ++i)
    ASSERT_NEAR(1e3 * (whole["p_bar"][i] - whole["p_bar"].front()), tests["test_1_mbar"][i], 1e-9)
        << "row " << i;
}

// Changes in mbar since the first row, from where Ultimaker_006 began.
VesselRecord repeated(const std::string& name, int test) {
  const std::string column = "test_" + std::to_string(test) + "_mbar";
  const trace::Recording file = leak_file("repeated/" + name, {"t_s", column});
  VesselRecord record{Flow::kDischarge, file["t_s"], file[column],
                      std::vector<double>(file.rows, kLeakAtmosphere_Pa)};
  const double start_Pa = leak("Ultimaker_006").vessel_Pa.front();
  for (double& p : record.vessel_Pa) p = start_Pa + 100.0 * p;
  return record;
}

TEST(RepeatedLeak, IsForetoldByItsFirstTestBetterThanNoLeakWouldBe) {
  const VesselRecord first = repeated("reconnected", 1);
  const OrificeFit fit = fit_orifice(first, kUnknownVolume, held_at_thin_plate());
  const std::vector<double> run = free_run(fit.port_1_s(), first, first.vessel_Pa.front());
  const std::vector<double> no_leak(run.size(), run.front());
  for (const int test : {2, 3}) {
    const VesselRecord again = repeated("reconnected", test);
    EXPECT_LT(mean_absolute_error(run, again.vessel_Pa), 0.5 * mean_absolute_error(no_leak, again.vessel_Pa))
        << "test " << test;
  }
}

// So that what a fit says of k is of one connection, and its standard error is not what the next will differ by.
TEST(RepeatedLeak, DiffersBetweenConnectionsByFarMoreThanItsStandardError) {
  const OrificeParameter k =
      fit_orifice(repeated("reconnected", 1), kUnknownVolume, held_at_thin_plate()).choked_rate_1_s;
  for (const int test : {2, 3}) {
    const OrificeParameter again =
        fit_orifice(repeated("reconnected", test), kUnknownVolume, held_at_thin_plate()).choked_rate_1_s;
    EXPECT_GT(again.value - k.value, 5.0 * (again.standard_error + k.standard_error)) << "test " << test;
  }
}

// Of three tests of a vessel that nobody touched.
TEST(RepeatedLeak, ThatLosesLessThanTenTimesTheNoiseIsNotFitted) {
  for (const int test : {1, 2})
    EXPECT_THAT([&] { fit_orifice(repeated("rerun", test), kUnknownVolume, held_at_thin_plate()); },
                ThrowsMessage<CannotIdentify>(HasSubstr("no excitation")))
        << "test " << test;
}

}  // namespace
}  // namespace plenum::host::identify::orifice
