// What of the supply's sensor the models of a board believe.
#include <gtest/gtest.h>

#include <limits>

#include "tests/firmware/board/bench.hpp"
#include "tests/firmware/board/greybox_image.hpp"

namespace plenum {
namespace {

constexpr std::size_t kSupplySensor = 2 * config::kChambers;

/// What the first chamber's output holds [V] in the mean of ten ticks, from when the supply's sensor says something else.
float command_V(float followed_share, float sensor_V, bool fresh = true, float supply_low_kPa = 500.0F) {
  Settings settings = bench_settings();
  settings.board.supply_low_kPa = supply_low_kPa;
  Bench bench(settings);
  Images images;
  images.fill(greybox_with({{config::kSupply, 620.0F}, {config::kSupplyFollowed, followed_share}}));
  bench.store_models(images);
  bench.setpoint_kPa = 400.0;
  bench.board.start();
  bench.put(0, {1, 0});
  bench.tick();
  bench.climb();
  bench.run(100);
  bench.setpoint_kPa = 404.0;
  force(bench, kSupplySensor, sensor_V, fresh);
  float sum_V = 0.0F;
  for (int i = 0; i < 10; ++i) {
    bench.tick();
    sum_V += bench.analog_out.held_V.front();
  }
  EXPECT_EQ(bench.state(), safety::State::active);
  return sum_V / 10.0F;
}

constexpr float kAsStated_V = 6.2F, kLower_V = 5.6F;

TEST(SupplyFollowing, AModelThatFollowsTheSensorOpensFurtherWhereTheSupplyIsLower) {
  EXPECT_GT(command_V(1.0F, kLower_V), command_V(1.0F, kAsStated_V) + 0.01F);
}

TEST(SupplyFollowing, AModelThatDoesNotMovesNothing) {
  EXPECT_EQ(command_V(0.0F, kLower_V), command_V(0.0F, kAsStated_V));
}

TEST(SupplyFollowing, ASensorThatIsBrokenStaleOrNotFittedIsNotBelieved) {
  const float undisturbed_V = command_V(1.0F, kAsStated_V);
  EXPECT_EQ(command_V(1.0F, 0.0F), undisturbed_V) << "a broken wire: below supply_low_kPa";
  EXPECT_EQ(command_V(1.0F, std::numeric_limits<float>::quiet_NaN()), undisturbed_V);
  EXPECT_EQ(command_V(1.0F, kLower_V, false), undisturbed_V) << "of a sample that is old";
  EXPECT_EQ(command_V(1.0F, kLower_V, true, 0.0F), command_V(1.0F, kAsStated_V, true, 0.0F)) << "not watched";
}

}  // namespace
}  // namespace plenum
