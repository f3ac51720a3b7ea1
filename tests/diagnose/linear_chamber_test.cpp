// The linear tick against itself, moved by a little, and against the model that it stands for.
#include "host-sim/diagnose/linear_chamber.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "host-sim/effects/free_run.hpp"

namespace plenum::host::diagnose {
namespace {

constexpr double kPressure_Pa = 3e5;
constexpr double kCommand_V = 5.4;

/// At 1000 and 200 Hz two steps a tick, at 100 Hz four, just below it six, at 50 Hz eight.
class LinearTick : public testing::TestWithParam<int> {
 protected:
  Linear tick(const Inputs& in, double early_s = 0.0) const {
    return chamber_.tick(kPressure_Pa, in, volume_m3_.data(), timing_, early_s);
  }
  Inputs inputs() const {
    const Ports at = ports_of(scene_.nominal, kCommand_V);
    Inputs in{};
    for (std::size_t part = 0; part < kParts; ++part) {
      in[kInlet + part] = (1.0 + 0.1 * static_cast<double>(part)) * at.inlet.area;
      in[kExhaust + part] = at.exhaust.area;
    }
    in[kSupply] = scene_.around.supply_Pa;
    in[kBehind] = scene_.around.ambient_Pa;
    return in;
  }

  Scene scene_ = identify::chamber::make_scene({});
  LinearChamber chamber_{scene_};
  effects::Timing timing_{
      .tick_s = 0.0025 * GetParam(), .average_s = 0.0025 * GetParam(), .steps = GetParam()};
  std::vector<double> volume_m3_ = [this] {
    std::vector<double> volume_m3;
    for (int i = 0; i <= timing_.steps; ++i) volume_m3.push_back(150e-6 * (1.0 - 0.002 * i));
    return volume_m3;
  }();
};

TEST_P(LinearTick, IsAsTheModelIsWhereAllPartsAreOpenAlike) {
  const Ports at = ports_of(scene_.nominal, kCommand_V);
  Inputs in = inputs();
  for (std::size_t part = 0; part < kParts; ++part) in[kInlet + part] = at.inlet.area;
  identify::chamber::Record record;
  record.drive.command_V = {kCommand_V, kCommand_V};
  record.drive.volume_m3 = volume_m3_;
  record.drive.timing = timing_;
  record.measured_Pa = {kPressure_Pa, kPressure_Pa};
  const std::vector<double> read = identify::chamber::run(scene_, record, 0, scene_.nominal, {kPressure_Pa});
  EXPECT_NEAR(tick(in).at.reading, read[1], 0.002 * std::abs(read[1] - kPressure_Pa));
}

/// By finite differences of 1 %, the pressure's way being two tenths of it at most.
TEST_P(LinearTick, KnowsWhatEachPartOfItDoes) {
  const Inputs in = inputs();
  const Linear at = tick(in);
  for (std::size_t input = kInlet; input < kSupply; ++input) {
    const double by = 0.01 * in[input];
    Inputs more = in;
    Inputs less = in;
    more[input] += by;
    less[input] -= by;
    const double end = (tick(more).at.end - tick(less).at.end) / (2.0 * by);
    const double reading = (tick(more).at.reading - tick(less).at.reading) / (2.0 * by);
    EXPECT_NE(end, 0.0);
    EXPECT_NEAR(at.by_input[input].end, end, 0.05 * std::abs(end)) << "input " << input;
    EXPECT_NEAR(at.by_input[input].reading, reading, 0.05 * std::abs(reading)) << "input " << input;
  }
}

TEST_P(LinearTick, KnowsWhatAnEarlyStampDoes) {
  const double early_s = 1e-4;
  const Linear at = tick(inputs());
  EXPECT_NEAR(tick(inputs(), early_s).at.reading, at.at.reading + early_s * at.reading_by_early,
              1e-9 * kPressure_Pa);
  EXPECT_GT(at.reading_by_early, 0.0);
}

INSTANTIATE_TEST_SUITE_P(Steps, LinearTick, testing::Values(2, 4, 6, 8),
                         [](const auto& test) { return std::to_string(test.param); });

}  // namespace
}  // namespace plenum::host::diagnose
