#include "firmware/config/settings_desk.hpp"

#include <gtest/gtest.h>

namespace plenum::config {
namespace {

ChamberSettings with_limits(float high_kPa, float over_kPa) {
  ChamberSettings settings;
  settings.pressure_high_kPa = high_kPa;
  settings.over_pressure_kPa = over_kPa;
  return settings;
}

/// Takes every owner's restored settings; false when any were not admissible.
bool take_all(SettingsDesk& desk) {
  bool admissible = desk.take_restored(kChambers);
  for (std::size_t chamber = 0; chamber < kChambers; ++chamber)
    admissible = desk.take_restored(chamber) && admissible;
  desk.end_restore();
  return admissible;
}

TEST(SettingsDesk, TakesWhatIsAdmissibleAndTellsOnceWhichChambersChanged) {
  SettingsDesk desk;
  EXPECT_EQ(desk.take_changed(), 0);
  EXPECT_TRUE(desk.set(2, with_limits(500.0F, 600.0F)));
  EXPECT_TRUE(desk.set(7, with_limits(700.0F, 750.0F)));
  EXPECT_EQ(desk.chamber(2).over_pressure_kPa, 600.0F);
  EXPECT_EQ(desk.take_changed(), 0b1000'0100);
  EXPECT_EQ(desk.take_changed(), 0);
  EXPECT_EQ(desk.refusal().verdict.error, SettingError::none);
}

TEST(SettingsDesk, RefusesWhatContradictsItselfAndRemembersWhy) {
  SettingsDesk desk;
  EXPECT_FALSE(desk.set(4, with_limits(850.0F, 800.0F)));
  EXPECT_EQ(desk.chamber(4).pressure_high_kPa, ChamberSettings{}.pressure_high_kPa);
  EXPECT_EQ(desk.take_changed(), 0);
  EXPECT_EQ(desk.refusal().chamber, 5);
  EXPECT_STREQ(desk.refusal().verdict.field, "over_pressure_kPa");
  BoardSettings board;
  board.supply_gain_kPa_per_V = 0.0F;
  EXPECT_FALSE(desk.set(board));
  EXPECT_EQ(desk.refusal().chamber, 0);
  EXPECT_STREQ(desk.refusal().verdict.field, "supply_gain_kPa_per_V");
}

TEST(SettingsDesk, RestoresASetWhoseFieldsContradictTheOldOnesOnTheWay) {
  SettingsDesk desk;
  desk.begin_restore();
  // field by field: 950 kPa lies beyond the trip of 900 kPa that still stands
  ChamberSettings settings = desk.edited(0);
  settings.pressure_high_kPa = 950.0F;
  EXPECT_TRUE(desk.set(0, settings));
  settings = desk.edited(0);
  settings.over_pressure_kPa = 980.0F;
  EXPECT_TRUE(desk.set(0, settings));
  EXPECT_EQ(desk.chamber(0).pressure_high_kPa, ChamberSettings{}.pressure_high_kPa)
      << "half of a set is not in force";
  EXPECT_EQ(desk.take_changed(), 0);
  EXPECT_TRUE(take_all(desk));
  EXPECT_EQ(desk.chamber(0).pressure_high_kPa, 950.0F);
  EXPECT_EQ(desk.chamber(0).over_pressure_kPa, 980.0F);
}

TEST(SettingsDesk, RestoresOverTheInstallersSettingsAndNotOverWhatWasWrittenSince) {
  SettingsDesk desk;
  ASSERT_TRUE(desk.set(3, with_limits(400.0F, 500.0F)));
  BoardSettings board;
  board.supply_ticks = 7;
  ASSERT_TRUE(desk.set(board));
  desk.begin_restore();
  EXPECT_TRUE(take_all(desk));
  EXPECT_EQ(desk.chamber(3).pressure_high_kPa, ChamberSettings{}.pressure_high_kPa);
  EXPECT_EQ(desk.board().supply_ticks, BoardSettings{}.supply_ticks);
}

TEST(SettingsDesk, PutsBackTheInstallersSettingsWhereRestoredOnesAreNotAdmissible) {
  SettingsDesk::Chambers installed{};
  installed[1] = with_limits(400.0F, 500.0F);
  SettingsDesk desk({}, installed);
  ASSERT_TRUE(desk.set(1, with_limits(410.0F, 510.0F)));
  desk.begin_restore();
  desk.set(0, with_limits(300.0F, 350.0F));
  desk.set(1, with_limits(600.0F, 550.0F));
  BoardSettings board;
  board.supply_ticks = 0;
  desk.set(board);
  EXPECT_FALSE(take_all(desk));
  EXPECT_EQ(desk.chamber(0).pressure_high_kPa, 300.0F);
  EXPECT_EQ(desk.chamber(1).pressure_high_kPa, 400.0F);
  EXPECT_EQ(desk.board().supply_ticks, BoardSettings{}.supply_ticks);
  EXPECT_EQ(desk.refusal().chamber, 2);
  EXPECT_FALSE(desk.set(1, with_limits(600.0F, 550.0F))) << "from now on each change is judged";
}

TEST(SettingsDesk, TakesNothingOfAChamberOrTheBoardOneOfWhoseStoredValuesCouldNotBeRead) {
  SettingsDesk desk;
  BoardSettings board;
  board.supply_ticks = 7;
  for (const bool refuses : {true, false}) {
    desk.begin_restore();
    if (refuses) desk.refuse_restored(3);
    if (refuses) desk.refuse_restored(kChambers);
    desk.set(board);
    desk.set(3, with_limits(300.0F, 350.0F));
    desk.set(4, with_limits(400.0F, 450.0F));
    EXPECT_TRUE(take_all(desk)) << "none was found inadmissible here";
    EXPECT_EQ(desk.chamber(3).pressure_high_kPa, refuses ? ChamberSettings{}.pressure_high_kPa : 300.0F);
    EXPECT_EQ(desk.chamber(4).pressure_high_kPa, 400.0F);
    EXPECT_EQ(desk.board().supply_ticks, refuses ? BoardSettings{}.supply_ticks : 7);
  }
}

}  // namespace
}  // namespace plenum::config
