// Real vessels: tests/data/leak_zillen/README.md.
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "host-sim/identify/orifice/fit_orifice.hpp"
#include "host-sim/trace/csv.hpp"

namespace plenum::host::identify::orifice {
namespace {

constexpr double kAtmosphere_Pa = 101325.0;  // not recorded with the data

// From the row where the vessel has lost 3 % of its greatest pressure (before, it is still fed) where it
// loses that.
VesselRecord leak(const std::string& name) {
  const std::string file = PLENUM_SOURCE_DIR "/tests/data/leak_zillen/" + name + ".csv";
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  const trace::NumberTable table =
      trace::parse_numbers(text.str(), file, [](std::string_view) { return true; });
  const std::vector<double>& time_s = table.columns[trace::column_of(table, "t_s", file)];
  const std::vector<double>& gauge_bar = table.columns[trace::column_of(table, "p_bar", file)];
  const double fed_bar = 0.97 * *std::max_element(gauge_bar.begin(), gauge_bar.end());
  std::size_t first = 0;
  if (gauge_bar.back() < fed_bar) {
    for (std::size_t i = 0; i < gauge_bar.size(); ++i) {
      if (gauge_bar[i] > fed_bar) first = i + 1;
    }
  }
  VesselRecord record{.flow = Flow::kDischarge, .time_s = {}, .vessel_Pa = {}, .far_Pa = {}};
  for (std::size_t i = first; i < time_s.size(); ++i) {
    record.time_s.push_back(time_s[i]);
    record.vessel_Pa.push_back(kAtmosphere_Pa + 1e5 * gauge_bar[i]);
    record.far_Pa.push_back(kAtmosphere_Pa);
  }
  return record;
}

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
    const OrificeFit fit = fit_orifice(
        record, kUnknownVolume, {.cracking_ratio = 1.0, .critical_ratio = 0.528, .subsonic_index = 0.5});
    EXPECT_TRUE(fit.choked_rate_1_s.identified) << name;
    EXPECT_LT(fit.mean_absolute_error_Pa, 500.0) << name;
    slowest = std::min(slowest, fit.choked_rate_1_s.value);
    fastest = std::max(fastest, fit.choked_rate_1_s.value);
  }
  EXPECT_GT(slowest, 2e-5);
  EXPECT_LT(fastest, 1e-4);
}

}  // namespace
}  // namespace plenum::host::identify::orifice
