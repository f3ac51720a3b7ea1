#include "host-sim/diagnose/set_fits.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/identify/chamber/chamber_scene.hpp"

namespace plenum::host::diagnose {
namespace {

// Beside a null that may wander another effect, whose error it follows, is not seen.
TEST(SetFits, OfANullThatWandersThePlainDriftIsOfTheSameSetAndHasNoWayOfItsOwn) {
  constexpr std::size_t kNull = effects::kIdNullDrift, kFirstWander = effects::kFirstFigure[kNull] + 2;
  Scene scene = identify::chamber::chamber_scene(identify::chamber::jumping_V(1500), 30e-6);
  const HeldOut held{.record = scene.records[0], .first = 900, .continues = 0};
  scene.records[0].fitted_rows = 900;
  const SetFits fits(scene, {held}, 100.0, 1);
  effects::Figures wandering = scene.nominal;
  wandering[kFirstWander] = 0.05;
  const Split rows = followed(split_of(scene, {held}));
  const Trial wanders_off =
      tried(rows, fit(rows.fitted, bit(kNull), wandering, {}, {.most_iterations = 1, .refined = bit(kNull)}));
  ASSERT_TRUE(wanders(wanders_off.fit));

  const Trial plain = fits.drifting(wanders_off);
  EXPECT_EQ(plain.on, wanders_off.on);
  EXPECT_FALSE(wanders(plain.fit));
  for (std::size_t k = kFirstWander; k < effects::kFirstFigure[kNull + 1]; ++k) {
    EXPECT_EQ(plain.fit.figures[k], scene.nominal[k]) << k;
  }
  for (const effects::Start& start : plain.fit.start) {
    EXPECT_TRUE(std::all_of(start.null_V.begin(), start.null_V.end(), [](double V) { return V == 0.0; }));
  }
}

// What an effect closes beside others is told from the smaller set as it fits best, not from where the figures beside the effect lead.
TEST(SetFits, WithoutAnEffectASetFitsNoWorseThanItWasFoundTo) {
  constexpr std::size_t kSilencer = effects::kIdExhaustBackpressure, kArea = effects::kIdAreaShape;
  constexpr std::size_t kResistance = effects::kFirstFigure[kSilencer];
  Scene scene = identify::chamber::chamber_scene(identify::chamber::jumping_V(1500), 30e-6);
  effects::Figures machine = scene.nominal;
  machine[kResistance] = 250.0;
  Record& record = scene.records[0];
  record.measured_Pa = run(scene, record, bit(kSilencer), machine, {3e5});
  const HeldOut held{.record = record, .first = 900, .continues = 0};
  record.fitted_rows = 900;
  SetFits fits(scene, {held}, 100.0, 1);
  const Trial alone = fits.all_with(recalibrated(scene, {held}), {kSilencer}).front();
  ASSERT_NEAR(alone.fit.figures[kResistance], 250.0, 1.0);

  // a silencer so wide that a little wider or narrower changes nothing
  const Split rows = split_of(scene, {held});
  const Trial both =
      tried(rows, fit(rows.fitted, bit(kSilencer) | bit(kArea), scene.nominal, {}, {.most_iterations = 0}));
  const Trial rest = fits.without(both, kArea);
  EXPECT_EQ(rest.on, bit(kSilencer));
  EXPECT_LE(rest.joint_squares, alone.joint_squares);
}

}  // namespace
}  // namespace plenum::host::diagnose
