#include "host-sim/identify/orifice/vessel_run.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <stdexcept>

#include "host-sim/plant/chamber.hpp"
#include "tests/identify/orifice/vessel_scene.hpp"

namespace plenum::host::identify::orifice {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

void expect_run(const plant::EllipsePort& port, Flow flow, std::size_t rows, double step_s,
                double tolerance_Pa, const std::function<double(double)>& closed_form_Pa) {
  const VesselRecord record = record_of(port, flow, rows, step_s);
  const std::vector<double> run = free_run(port, record, record.vessel_Pa.front());
  for (std::size_t i = 0; i < rows; ++i)
    EXPECT_NEAR(run[i], closed_form_Pa(record.time_s[i]), tolerance_Pa) << "at " << record.time_s[i] << " s";
}

// b = 0, a, beta = 1: rdot = k (1 - (r/a)^2), hence r = a tanh(k t / a + artanh(r_0 / a)).
TEST(FreeRun, ChargeOfAParabolicPortFollowsTheHyperbolicTangent) {
  const double k = 0.3;
  const double a = 0.8;
  expect_run({k, 0.0, a, 1.0}, Flow::kCharge, 400, 0.02, 5.0, [&](double t) {
    return kSupply_Pa * a * std::tanh(k * t / a + std::atanh(kAmbient_Pa / kSupply_Pa / a));
  });
}

// b = 0, a, beta = 1: p pdot = -k (p^2 - c^2) with c = P_a / a.
TEST(FreeRun, DischargeOfAParabolicPortFollowsTheExponentialOfTheSquare) {
  const double k = 5.0;
  const double a = 0.6;
  const double c2 = std::pow(kAmbient_Pa / a, 2.0);
  expect_run({k, 0.0, a, 1.0}, Flow::kDischarge, 400, 0.002, 5.0, [&](double t) {
    return std::sqrt(c2 + (kSupply_Pa * kSupply_Pa - c2) * std::exp(-2.0 * k * t));
  });
}

// ISO form: choked, p rises at k P_s; then r = b + (1 - b) sin(k t' / (1 - b)), at rest after a quarter
// period.
TEST(FreeRun, ChargeOfAnIsoPortFollowsTheSineAndRestsAtTheSupply) {
  const double k = 16.0;
  const double b = 0.4;
  expect_run({k, b, 1.0, 0.5}, Flow::kCharge, 150, 0.001, 200.0, [&](double t) {
    const double t_b = (b - kAmbient_Pa / kSupply_Pa) / k;
    if (t < t_b) return kAmbient_Pa + k * kSupply_Pa * t;
    const double angle = k * (t - t_b) / (1.0 - b);
    return kSupply_Pa * (angle < std::acos(0.0) ? b + (1.0 - b) * std::sin(angle) : 1.0);
  });
}

TEST(FreeRun, ChokedDischargeIsExactWhateverTheStep) {
  const plant::EllipsePort port{3.0, 0.528, 1.0, 0.5};
  VesselRecord record{.flow = Flow::kDischarge, .time_s = {0.0, 0.1, 0.4}, .vessel_Pa = {}, .far_Pa = {}};
  record.vessel_Pa = {7e5, 5e5, 3e5};
  record.far_Pa = {1e5, 1e5, 1e5};
  const std::vector<double> run = free_run(port, record, 7e5);
  EXPECT_NEAR(run[1], 7e5 * std::exp(-0.3), 1e-6);
  EXPECT_NEAR(run[2], 7e5 * std::exp(-1.2), 1e-6);
}

TEST(FreeRun, RestsAtTheCrackingRatioFromBothSidesOfAnyIndex) {
  for (const double index : {0.42, 0.5, 0.73, 1.0}) {
    const plant::EllipsePort port{16.0, 0.3, 0.9, index};
    EXPECT_NEAR(record_of(port, Flow::kCharge, 3000, 1e-3).vessel_Pa.back(), 0.9 * kSupply_Pa, 10.0) << index;
    EXPECT_NEAR(record_of(port, Flow::kDischarge, 3000, 1e-3).vessel_Pa.back(), kAmbient_Pa / 0.9, 10.0)
        << index;
  }
}

// Rows of one vessel pressure: nothing to divide by, one step a row.
VesselRecord undivided(Flow flow, std::size_t rows, double step_s) {
  VesselRecord record;
  record.flow = flow;
  for (std::size_t i = 0; i < rows; ++i) {
    record.time_s.push_back(static_cast<double>(i) * step_s);
    record.vessel_Pa.push_back(3e5);
    record.far_Pa.push_back(flow == Flow::kCharge ? kSupply_Pa : kAmbient_Pa);
  }
  return record;
}

TEST(FreeRun, IsOfSecondOrderInTheStep) {
  const plant::EllipsePort port{0.3, 0.0, 0.8, 1.0};
  const double end_Pa = kSupply_Pa * 0.8 * std::tanh(0.3 / 0.8 + std::atanh(kAmbient_Pa / kSupply_Pa / 0.8));
  const auto error_Pa = [&](std::size_t steps) {
    return free_run(port, undivided(Flow::kCharge, steps + 1, 1.0 / static_cast<double>(steps)), kAmbient_Pa)
               .back() -
           end_Pa;
  };
  EXPECT_NEAR(error_Pa(10) / error_Pa(20), 4.0, 0.3);
}

// Where the flow ends with an unbounded slope a step could stall hundreds of pascals before rest.
TEST(FreeRun, RestsAtTheCrackingRatioAtLongStepsToo) {
  for (const double index : {0.42, 0.5, 0.73}) {
    const plant::EllipsePort port{16.0, 0.528, 0.95, index};
    EXPECT_NEAR(free_run(port, undivided(Flow::kCharge, 200, 2e-3), kAmbient_Pa).back(), 0.95 * kSupply_Pa,
                10.0)
        << index;
    EXPECT_NEAR(free_run(port, undivided(Flow::kDischarge, 500, 2e-3), kSupply_Pa).back(), kAmbient_Pa / 0.95,
                10.0)
        << index;
  }
}

// The plant integrates the same equations by another method, with error control.
TEST(FreeRun, AgreesWithThePlantOfTheMeasuredValve) {
  for (const double command_V : {5.4, 6.0, 7.0, 10.0}) {
    plant::ChamberConfig config;
    config.gas = plant::reference_atmosphere();
    config.supply_Pa = kSupply_Pa;
    config.ambient_Pa = kAmbient_Pa;
    config.initial_pressure_Pa = kAmbient_Pa;
    config.tolerance_Pa = 0.05;
    const plant::MpyeValve valve(plant::MpyeChannel::a, config.gas);
    plant::ChamberPlant plant(valve, config, plant::VolumeMotion(0.4e-3));
    plant::EllipsePort port = valve.opening(command_V).inlet;
    const double RT = config.gas.specific_gas_constant_J_kg_K() * config.gas.temperature_K;
    port.choked_kg_s_Pa *= 1.4 * RT / 0.4e-3;

    VesselRecord record;
    const double step_s = 0.02 / port.choked_kg_s_Pa;  // moves the ratio by 0.02
    for (int i = 0; i < 150; ++i) {
      record.time_s.push_back(i * step_s);
      record.vessel_Pa.push_back(plant.pressure_Pa());
      record.far_Pa.push_back(kSupply_Pa);
      plant.advance(command_V, step_s);
    }
    const std::vector<double> run = free_run(port, record, kAmbient_Pa);
    for (std::size_t i = 0; i < run.size(); ++i)
      EXPECT_NEAR(run[i], record.vessel_Pa[i], 300.0) << command_V << " V, row " << i;
  }
}

TEST(ChokedRate, IsThatOfEquationsFourAndSevenAndNotOfEquationEight) {
  const Vessel vessel{.volume_m3 = 0.4e-3, .flow_exponent = 1.4, .discharge_coefficient = 0.575};
  const double mdot_of_area = 0.575 * plant::choked_flow_function(1.4) * std::sqrt(2.0 / (1e5 / 1.185));
  const double pdot_of_area = 1e5 / 1.185 / 0.4e-3 * 1.4 * mdot_of_area;
  EXPECT_NEAR(choked_rate_of_area_1_s_m2(vessel).value() / pdot_of_area, 1.0, 1e-12);
}

TEST(ChokedRate, IsUnknownWithoutAVolumeAndRefusesWhatIsNoVessel) {
  EXPECT_FALSE(choked_rate_of_area_1_s_m2({}).has_value());
  EXPECT_THAT([] { choked_rate_of_area_1_s_m2({.volume_m3 = -1.0}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("vessel volume_m3: -1")));
  EXPECT_THAT([] { choked_rate_of_area_1_s_m2({.flow_exponent = 1.5}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("vessel flow_exponent: 1.5")));
}

TEST(MeanAbsoluteError, IsTheMeanOfTheDistances) {
  EXPECT_DOUBLE_EQ(mean_absolute_error({1.0, 2.0, 3.0}, {2.0, 2.0, 1.0}), 1.0);
  EXPECT_THAT([] { mean_absolute_error({1.0}, {}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("1 predicted and 0 recorded")));
}

TEST(VesselRecord, NamesColumnAndRowOfWhatIsWrong) {
  const VesselRecord good = record_of({1.0, 0.3, 1.0, 0.5}, Flow::kCharge, 30, 0.01);
  VesselRecord bad = good;
  bad.vessel_Pa[4] = -1.0;
  EXPECT_THAT([&] { validate(bad); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("column vessel_Pa, row 5: -1 Pa, expected")));
  bad = good;
  bad.time_s[7] = bad.time_s[6];
  EXPECT_THAT([&] { validate(bad); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("column time_s, row 8")));
  bad = good;
  bad.far_Pa.pop_back();
  EXPECT_THAT([&] { validate(bad); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("column far_Pa: 29 rows, expected 30")));
}

}  // namespace
}  // namespace plenum::host::identify::orifice
