#include "host-sim/identify/servo/cylinder_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/plant/random.hpp"

namespace plenum::host::identify::servo {
namespace {

ServoRig truth() {
  ServoRig rig;
  rig.cylinder.initial_pressure_1_Pa = 3.4e5;
  rig.cylinder.initial_pressure_2_Pa = 3.8e5;
  return rig;
}

ServoRig guess() {
  ServoRig rig = truth();
  rig.valve.inlet_area_per_V_m2 *= 1.2;
  rig.valve.exhaust_area_per_V_m2 *= 0.9;
  rig.valve.open_above_V += 0.02;
  rig.valve.exhaust_below_V += 0.02;
  rig.cylinder.friction = {20.0, 20.0, 0.02, 120.0};
  rig.cylinder.moving_mass_kg = 4.0;
  return rig;
}

// Commands that wander about the null, and the positions they lead to.
ServoRecord recorded(double noise_m) {
  ServoRecord record;
  plant::Random random(3);
  double level = 5.0;
  for (int k = 0; k < 800; ++k) {
    if (k % 15 == 0) level = (k / 15) % 2 == 0 ? random.uniform(5.1, 5.7) : random.uniform(4.3, 4.9);
    record.commands_V.push_back(level);
  }
  record.positions_m.resize(record.commands_V.size());
  record.positions_m = free_run(truth(), record).positions_m;
  for (double& x : record.positions_m) x += noise_m * random.gaussian();
  return record;
}

TEST(ServoFit, FindsTheFiguresThatMadeTheRecording) {
  const ServoFit fit = fit_servo(guess(), recorded(0.0));
  const ServoRig exact = truth();
  EXPECT_NEAR(fit.rig.valve.inlet_area_per_V_m2 / exact.valve.inlet_area_per_V_m2, 1.0, 1e-3);
  EXPECT_NEAR(fit.rig.valve.exhaust_area_per_V_m2 / exact.valve.exhaust_area_per_V_m2, 1.0, 1e-3);
  EXPECT_NEAR(fit.rig.valve.open_above_V, exact.valve.open_above_V, 1e-3);
  EXPECT_NEAR(fit.rig.cylinder.friction.coulomb_N / exact.cylinder.friction.coulomb_N, 1.0, 5e-3);
  EXPECT_NEAR(fit.rig.cylinder.friction.stribeck_N / exact.cylinder.friction.stribeck_N, 1.0, 2e-2);
  EXPECT_NEAR(fit.rig.cylinder.friction.viscous_N_s_m / exact.cylinder.friction.viscous_N_s_m, 1.0, 2e-2);
  EXPECT_NEAR(fit.rig.cylinder.moving_mass_kg / exact.cylinder.moving_mass_kg, 1.0, 5e-3);
  EXPECT_LT(fit.rms_m, 1e-5);
  EXPECT_EQ(fit.at_bound, PerFigure{});
}

TEST(ServoFit, LeavesTheNoiseAndNothingElse) {
  const double noise_m = 5e-5;
  const ServoFit fit = fit_servo(guess(), recorded(noise_m));
  EXPECT_NEAR(fit.rms_m / noise_m, 1.0, 0.1);
  EXPECT_NEAR(std::log(fit.rig.cylinder.moving_mass_kg / 5.0), 0.0, 5.0 * fit.error[6]);
  EXPECT_NEAR(std::log(fit.rig.cylinder.friction.coulomb_N / 30.0), 0.0, 5.0 * fit.error[3]);
}

TEST(ServoFit, LeavesWhatIsHeldAtTheGuess) {
  ServoRig known = guess();
  known.cylinder.moving_mass_kg = truth().cylinder.moving_mass_kg;
  known.cylinder.friction.stribeck_N = truth().cylinder.friction.stribeck_N;
  const PerFigure held{false, false, false, false, true, false, true};
  const ServoFit fit = fit_servo(known, recorded(5e-5), held);
  EXPECT_EQ(fit.rig.cylinder.moving_mass_kg, known.cylinder.moving_mass_kg);
  EXPECT_EQ(fit.rig.cylinder.friction.stribeck_N, known.cylinder.friction.stribeck_N);
  EXPECT_NEAR(std::log(fit.rig.cylinder.friction.coulomb_N / 30.0), 0.0, 5.0 * fit.error[3]);
  EXPECT_EQ(fit.error[6], 0.0);
  const ServoFit all = fit_servo(known, recorded(5e-5));
  EXPECT_LT(fit.error[3], all.error[3]) << "what is known of one figure helps the others";
}

TEST(ServoFit, NamesTheFigureThatEndsAtItsBound) {
  ServoRig far = guess();
  far.cylinder.friction.viscous_N_s_m = truth().cylinder.friction.viscous_N_s_m / (1.5 * kWidest);
  const ServoFit fit = fit_servo(far, recorded(0.0));
  EXPECT_EQ(fit.at_bound, (PerFigure{false, false, false, false, false, true, false}));
}

TEST(ServoFit, SaysWhenThePistonDoesNotMove) {
  ServoRecord record;
  record.commands_V.assign(100, 5.0);
  record.positions_m.assign(100, 0.01);
  try {
    fit_servo(guess(), record);
    FAIL() << "a piston at rest was accepted";
  } catch (const CannotIdentify& e) {
    EXPECT_NE(std::string(e.what()).find("1 mm"), std::string::npos) << e.what();
  }
  record.positions_m.pop_back();
  EXPECT_THROW(fit_servo(guess(), record), std::invalid_argument);
}

TEST(ServoFit, SaysWhenTheGuessDoesNotMove) {
  ServoRig jammed = guess();
  jammed.cylinder.friction.coulomb_N = 500.0;  // 700 kPa on 8 cm2 push with 480 N
  try {
    fit_servo(jammed, recorded(0.0));
    FAIL() << "a guess from which nothing can be learnt was taken";
  } catch (const CannotIdentify& e) {
    EXPECT_NE(std::string(e.what()).find("of the guess does not move"), std::string::npos) << e.what();
  }
}

TEST(ServoFit, NamesAFigureThatTheRecordingDoesNotShow) {
  ServoRig without = guess();
  without.cylinder.friction.stribeck_N = 0.0;  // a factor of nothing changes nothing
  try {
    fit_servo(without, recorded(0.0));
    FAIL() << "a friction that is not there was fitted";
  } catch (const CannotIdentify& e) {
    EXPECT_NE(std::string(e.what()).find("Stribeck"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace plenum::host::identify::servo
