// chamber_leak against closed forms.
#include <gtest/gtest.h>

#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

TEST(ChamberLeak, SealedChamberDecaysAsTheLaminarLawInClosedForm) {
  // p' = -K (p^2 - P_a^2):  (p - P_a)/(p + P_a) falls as e^(-2 K P_a t)
  const double volume_m3 = 200e-6;
  const double conductance = 0.3;  // g/(s MPa)
  const double K = 1.4 * RT() / volume_m3 * conductance * 1e-9 / (2.0 * kAmbient_Pa);
  const Figures figures = with(sealed(), kIdChamberLeak, {conductance});
  for (const int steps : {4, 16}) {
    Drive drive = drive_of(std::vector<double>(1000, 5.0), plant::VolumeMotion(volume_m3), steps);
    drive.timing.average_s = 0.0;
    const std::vector<double> p = run(only(kIdChamberLeak), figures, drive, 6e5);
    for (std::size_t k = 0; k < p.size(); k += 50) {
      const double c = (6e5 - kAmbient_Pa) / (6e5 + kAmbient_Pa) *
                       std::exp(-2.0 * K * kAmbient_Pa * static_cast<double>(k) * kTick_s);
      EXPECT_NEAR(p[k], kAmbient_Pa * (1.0 + c) / (1.0 - c), steps == 4 ? 0.5 : 0.03)
          << "Pa at row " << k << ", " << steps << " steps";
    }
  }
}

TEST(ChamberLeak, SlopeIsThatOfItsFlow) {
  for (const double density_share : {0.0, 0.4, 1.0}) {
    const double x[] = {2.0, density_share, 0.0, 150.0};
    ChamberLeak<double> leak;
    leak.prepare(x, kAmbient_Pa, 100e-6, 100e-6);
    for (const double p : {5e4, 2e5, 7e5}) {
      EXPECT_NEAR((leak.flow(p + 100.0) - leak.flow(p - 100.0)) / 200.0 / leak.slope(p), 1.0, 1e-9)
          << "at " << p << " Pa, density share " << density_share;
    }
  }
}

TEST(ChamberLeak, StraightInTheGaugePressureASealedChamberDecaysExponentially) {
  const double volume_m3 = 200e-6;
  const double conductance = 0.3;  // g/(s MPa)
  const double per_s = 1.4 * RT() / volume_m3 * conductance * 1e-9;
  const Figures figures = with(sealed(), kIdChamberLeak, {conductance, 0.0});
  Drive drive = drive_of(std::vector<double>(1000, 5.0), plant::VolumeMotion(volume_m3), 4);
  drive.timing.average_s = 0.0;
  const std::vector<double> p = run(only(kIdChamberLeak), figures, drive, 6e5);
  for (std::size_t k = 0; k < p.size(); k += 50) {
    EXPECT_NEAR(p[k] - kAmbient_Pa, (6e5 - kAmbient_Pa) * std::exp(-per_s * static_cast<double>(k) * kTick_s),
                0.01)
        << "Pa at row " << k;
  }
}

TEST(ChamberLeak, GrowsWithThePowerOfTheVolumeAlongAWornBore) {
  const double x[] = {2.0, 1.0, 1.5, 0.0};
  ChamberLeak<double> leak;
  // the conductance is that at the mean volume, wherever a log begins
  const double gauge_Pa = 4e5 - kAmbient_Pa;
  const double mean_kg_s = 2e-9 * gauge_Pa * (1.0 + gauge_Pa / (2.0 * kAmbient_Pa));
  leak.prepare(x, kAmbient_Pa, 100e-6, 250e-6);
  EXPECT_NEAR(leak.flow(4e5) / mean_kg_s, std::pow(2.5, 1.5), 1e-6);
  for (const double share : {0.5, 1.0, 3.0}) {
    leak.at(share * 100e-6);
    EXPECT_NEAR(leak.flow(4e5) / mean_kg_s, std::pow(share, 1.5), 1e-6) << share;
  }
}

TEST(ChamberLeak, PastAPistonASealedChamberComesToThePressureOfTheOtherSide) {
  // p' = -K (p^2 - P^2):  (p - P)/(p + P) falls as e^(-2 K P t), from above and from below
  const double volume_m3 = 200e-6, beyond_Pa = kAmbient_Pa + 250e3;
  const double conductance = 0.3;  // g/(s MPa)
  const double K = 1.4 * RT() / volume_m3 * conductance * 1e-9 / (2.0 * beyond_Pa);
  const Figures figures = with(sealed(), kIdChamberLeak, {conductance, 1.0, 0.0, 250.0});
  Drive drive = drive_of(std::vector<double>(1000, 5.0), plant::VolumeMotion(volume_m3), 4);
  drive.timing.average_s = 0.0;
  for (const double start_Pa : {6e5, 1.5e5}) {
    const std::vector<double> p = run(only(kIdChamberLeak), figures, drive, start_Pa);
    for (std::size_t k = 0; k < p.size(); k += 50) {
      const double c = (start_Pa - beyond_Pa) / (start_Pa + beyond_Pa) *
                       std::exp(-2.0 * K * beyond_Pa * static_cast<double>(k) * kTick_s);
      EXPECT_NEAR(p[k], beyond_Pa * (1.0 + c) / (1.0 - c), 0.5) << "Pa at row " << k << " from " << start_Pa;
    }
  }
}

TEST(ChamberLeak, FillsAChamberBelowAmbient) {
  const Figures figures = with(sealed(), kIdChamberLeak, {1.0});
  EXPECT_GT(flow_kg_s(only(kIdChamberLeak), figures, 5.0, 8e4), 0.0);
  EXPECT_NEAR(flow_kg_s(only(kIdChamberLeak), figures, 5.0, kAmbient_Pa), 0.0, 1e-15);
  const double expected_kg_s = -1e-9 * (3e5 * 3e5 - kAmbient_Pa * kAmbient_Pa) / (2.0 * kAmbient_Pa);
  EXPECT_NEAR(flow_kg_s(only(kIdChamberLeak), figures, 5.0, 3e5) / expected_kg_s, 1.0, 1e-5);
}

}  // namespace
}  // namespace plenum::host::effects
