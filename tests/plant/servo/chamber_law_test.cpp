#include "host-sim/plant/servo/chamber_law.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>

namespace plenum::host::plant::servo {
namespace {

const Gas kAir;
const double kR = kAir.specific_gas_constant_J_kg_K();
const double kT0 = kAir.temperature_K;

// A chamber under `law` for `duration_s`, by fixed-step Runge-Kutta.
struct Course {
  std::function<Throughflow(double time_s, const ChamberState&)> flow;
  std::function<ChamberVolume(double time_s)> volume;
};
ChamberState run(const ChamberLaw& law, ChamberState y, double duration_s, int steps, const Course& course) {
  const auto rate = [&](double t, const ChamberState& s) {
    const Throughflow f = course.flow(t, s);
    return ChamberState{pressure_rate_Pa_s(law, kAir, s, f, course.volume(t)), f.in_kg_s - f.out_kg_s};
  };
  const auto plus = [](const ChamberState& a, double h, const ChamberState& b) {
    return ChamberState{a.pressure_Pa + h * b.pressure_Pa, a.mass_kg + h * b.mass_kg};
  };
  const double h = duration_s / steps;
  for (int i = 0; i < steps; ++i) {
    const double t = i * h;
    const ChamberState k1 = rate(t, y);
    const ChamberState k2 = rate(t + h / 2, plus(y, h / 2, k1));
    const ChamberState k3 = rate(t + h / 2, plus(y, h / 2, k2));
    const ChamberState k4 = rate(t + h, plus(y, h, k3));
    y = plus(plus(plus(plus(y, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
  }
  return y;
}

ChamberState at_rest(double pressure_Pa, double volume_m3, double temperature_K) {
  return {pressure_Pa, mass_of_kg(kAir, pressure_Pa, volume_m3, temperature_K)};
}

const Course kCompression{[](double, const ChamberState&) { return Throughflow{}; },
                          [](double t) {
                            return ChamberVolume{100e-6 - 60e-6 * t, -60e-6};
                          }};

TEST(ChamberLaw, ClosedCompressionFollowsItsPolytrope) {
  for (const double n : {1.0, 1.2, 1.4}) {
    const ChamberState end = run(Polytropic{n}, at_rest(2e5, 100e-6, kT0), 1.0, 400, kCompression);
    EXPECT_NEAR(end.pressure_Pa / (2e5 * std::pow(100.0 / 40.0, n)), 1.0, 1e-9) << "n = " << n;
    EXPECT_NEAR(temperature_of_K(kAir, end, 40e-6) / (kT0 * std::pow(2.5, n - 1.0)), 1.0, 1e-9);
  }
}

TEST(ChamberLaw, PolytropeAtKappaIsTheAdiabaticLawAndAtOneTheIsothermal) {
  const ChamberState s = at_rest(4.3e5, 80e-6, 301.0);
  const Throughflow f{1.7e-3, 0.4e-3};
  const ChamberVolume v{80e-6, 3e-5};
  const double k = kAir.kappa;
  const double adiabatic = k * kR * 301.0 / 80e-6 * 1.3e-3 - k * 4.3e5 / 80e-6 * 3e-5;  // (15)
  const double isothermal = kR * 301.0 / 80e-6 * 1.3e-3 - 4.3e5 / 80e-6 * 3e-5;         // (18)
  EXPECT_NEAR(pressure_rate_Pa_s(Polytropic{k}, kAir, s, f, v) / adiabatic, 1.0, 1e-12);
  EXPECT_NEAR(pressure_rate_Pa_s(Polytropic{1.0}, kAir, s, f, v) / isothermal, 1.0, 1e-12);
}

TEST(ChamberLaw, PolytropeNeedsNoMemoryOfItsStart) {
  // any state reached along P (V/m)^n = const from (2 bar, 100 mL, 290 K) has the rate of (10)
  const double n = 1.27;
  const ChamberState start = at_rest(2e5, 100e-6, 290.0);
  for (const double mass_ratio : {0.5, 1.0, 2.3}) {
    for (const double volume_m3 : {40e-6, 100e-6, 170e-6}) {
      const ChamberState s{2e5 * std::pow(mass_ratio * 100e-6 / volume_m3, n), mass_ratio * start.mass_kg};
      const Throughflow f{2e-3, 0.0};
      const ChamberVolume v{volume_m3, -2e-5};
      EXPECT_NEAR(pressure_rate_Pa_s(Polytropic{n}, kAir, s, f, v) /
                      polytropic_rate_Pa_s(kAir, n, s, 2e5, 290.0, f, v),
                  1.0, 1e-12);
    }
  }
}

TEST(ChamberLaw, EnergyBalanceWithoutHeatIsAdiabaticForGasThatEntersAtTheChambersTemperature) {
  const ChamberState s = at_rest(3e5, 90e-6, kT0);
  const Throughflow f{1.1e-3, 2.0e-3};
  const ChamberVolume v{90e-6, -4e-5};
  EXPECT_NEAR(pressure_rate_Pa_s(EnergyBalance{}, kAir, s, f, v) /
                  pressure_rate_Pa_s(Polytropic{kAir.kappa}, kAir, s, f, v),
              1.0, 1e-12);
}

TEST(ChamberLaw, ChargingAnEmptyChamberEndsKappaTimesHotter) {
  // steady flow of gas at T0 into an evacuated rigid chamber: T -> k T0, by (13)-(14) with q = 0
  const Course filling{[](double, const ChamberState&) {
                         return Throughflow{1e-3, 0.0};
                       },
                       [](double) {
                         return ChamberVolume{100e-6, 0.0};
                       }};
  const ChamberState end = run(EnergyBalance{}, at_rest(10.0, 100e-6, kT0), 0.5, 200, filling);
  EXPECT_NEAR(temperature_of_K(kAir, end, 100e-6) / kT0, kAir.kappa, 1e-4);
  EXPECT_NEAR(end.pressure_Pa, 10.0 + kAir.kappa * kR * kT0 * 1e-3 * 0.5 / 100e-6, 1.0);
}

TEST(ChamberLaw, WallOfLargeConductanceMakesTheBalanceIsothermal) {
  // choked discharge at T: P = P0 exp(-c R T t / V); and the heat it takes is (17)
  const double c = 2e-9;
  const Course venting{[c](double, const ChamberState& s) {
                         return Throughflow{0.0, c * s.pressure_Pa};
                       },
                       [](double) {
                         return ChamberVolume{100e-6, 0.0};
                       }};
  const double exact = 6e5 * std::exp(-c * kR * kT0 * 0.5 / 100e-6);
  const auto error = [&](const ChamberLaw& law) {
    return std::abs(run(law, at_rest(6e5, 100e-6, kT0), 0.5, 8000, venting).pressure_Pa / exact - 1.0);
  };
  EXPECT_LT(error(Polytropic{1.0}), 1e-9);
  const double at_500 = error(EnergyBalance{500.0, kT0});
  const double at_1000 = error(EnergyBalance{1000.0, kT0});
  EXPECT_LT(at_1000, 2e-3);
  EXPECT_NEAR(at_500 / at_1000, 2.0, 0.03);  // vanishes as 1 / G_w
  EXPECT_GT(error(EnergyBalance{0.0, kT0}), 0.1);
}

TEST(ChamberLaw, IsothermalHeatClosesTheFirstLaw) {
  // q + k C_v T (mdot_in - mdot_out) - P Vdot = C_v mdot T: (13) with (16) gives (17)
  const ChamberState s = at_rest(5e5, 60e-6, 310.0);
  const Throughflow f{0.3e-3, 1.9e-3};
  const ChamberVolume v{60e-6, 7e-5};
  const double C_v = kR / (kAir.kappa - 1.0);
  const double mdot = f.in_kg_s - f.out_kg_s;
  const double U_dot = C_v * mdot * 310.0;
  EXPECT_NEAR(isothermal_heat_W(kAir, s, f, v) + kAir.kappa * C_v * 310.0 * mdot - 5e5 * 7e-5, U_dot, 1e-9);
}

TEST(ChamberLaw, MixedExponentsOfOneAreIsothermalAndOfKappaAdiabatic) {
  const ChamberState s = at_rest(5e5, 60e-6, kT0);
  const Throughflow f{0.3e-3, 1.9e-3};
  const ChamberVolume v{60e-6, 7e-5};
  for (const double n : {1.0, kAir.kappa}) {
    EXPECT_NEAR(pressure_rate_Pa_s(MixedExponents{n, n, n}, kAir, s, f, v) /
                    pressure_rate_Pa_s(Polytropic{n}, kAir, s, f, v),
                1.0, 1e-12);
  }
}

TEST(ChamberLaw, MixedExponentsKeepTheGasLawOnlyAtOne) {
  const auto gas_law_defect = [](double alpha) {
    const ChamberState end =
        run(MixedExponents{alpha, alpha, alpha}, at_rest(2e5, 100e-6, kT0), 1.0, 400, kCompression);
    return end.pressure_Pa * 40e-6 / (end.mass_kg * kR * kT0) - 1.0;
  };
  EXPECT_NEAR(gas_law_defect(1.0), 0.0, 1e-9);
  EXPECT_NEAR(gas_law_defect(1.2), std::pow(2.5, 0.2) - 1.0, 1e-9);
}

TEST(ChamberLaw, FirstLawHoldsForAnyCourseOfTheEnergyBalance) {
  // U = P V / (k - 1) against the integral of enthalpy, heat and work, carried along as an extra quadrature
  const double G_w = 3.0;
  const ChamberLaw law = EnergyBalance{G_w, kT0};
  const auto volume = [](double t) {
    return ChamberVolume{80e-6 + 30e-6 * std::sin(9.0 * t), 270e-6 * std::cos(9.0 * t)};
  };
  const auto flow = [](double t) {
    return Throughflow{1e-3 * std::max(std::sin(5.0 * t), 0.0), 1e-3 * std::max(-std::sin(5.0 * t), 0.0)};
  };
  const Course course{[&](double t, const ChamberState&) { return flow(t); }, volume};
  const double k = kAir.kappa;
  ChamberState s = at_rest(4e5, 80e-6, kT0);
  const double U_start = s.pressure_Pa * volume(0.0).volume_m3 / (k - 1.0);
  double supplied_J = 0.0;
  const int parts = 2000;
  const double h = 1.0 / parts;
  const auto power_W = [&](double t, const ChamberState& y) {
    const double T = temperature_of_K(kAir, y, volume(t).volume_m3);
    return G_w * (kT0 - T) + k * kR / (k - 1.0) * (flow(t).in_kg_s * kT0 - flow(t).out_kg_s * T) -
           y.pressure_Pa * volume(t).rate_m3_s;
  };
  for (int i = 0; i < parts; ++i) {
    const double t = i * h;
    const Course shifted{[&](double u, const ChamberState& y) { return course.flow(t + u, y); },
                         [&](double u) { return course.volume(t + u); }};
    const ChamberState middle = run(law, s, h / 2, 1, shifted);
    const ChamberState end = run(law, s, h, 2, shifted);
    supplied_J += h / 6.0 * (power_W(t, s) + 4.0 * power_W(t + h / 2, middle) + power_W(t + h, end));
    s = end;
  }
  const double U_end = s.pressure_Pa * volume(1.0).volume_m3 / (k - 1.0);
  EXPECT_NEAR(U_end - U_start, supplied_J, 1e-6 * U_start);
}

TEST(ChamberLaw, RefusesWhatNoGasDoesAndNamesIt) {
  try {
    validate(ChamberLaw{Polytropic{0.7}});
    FAIL() << "an index below 1 was accepted";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("polytropic index"), std::string::npos) << e.what();
  }
  EXPECT_THROW(validate(ChamberLaw{EnergyBalance{-1.0, 293.0}}), std::invalid_argument);
  EXPECT_THROW(validate(ChamberLaw{MixedExponents{1.4, 1.0, 3.0}}), std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::plant::servo
