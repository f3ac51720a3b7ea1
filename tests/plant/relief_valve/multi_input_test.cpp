#include "host-sim/plant/relief_valve/multi_input.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace {

using namespace plenum::host::plant::relief_valve;

const MultiInputConfig kConfig{.alpha1_m2 = 2e-4,
                               .alpha2_m2_s_sqrtPa = 6e-4,
                               .alpha3_m3_s_sqrtPa = 2e-9,
                               .upstream_volume_m3 = 1e-3,
                               .bulk_modulus_Pa = 1.4e9};

// (3.18)-(3.20) with a displacement that is given as a function of time, and what the ports then see.
struct Given {
  double x_m, x_rate_m_s;
  MultiInputPorts ports;
  double upstream_rate_Pa_s;
};

Given given(double t) {
  Given g{.x_m = 2e-4 + 1e-4 * std::sin(40.0 * t),
          .x_rate_m_s = 4e-3 * std::cos(40.0 * t),
          .ports = {},
          .upstream_rate_Pa_s = 0.0};
  g.ports = {.inflow_m3_s = 5e-4,
             .upstream_Pa = 8e6 + 1e5 * std::sin(11.0 * t),
             .primary_Pa = 1e6 + 2e5 * std::sin(23.0 * t),
             .secondary_Pa = 3e5,
             .primary_flow_m3_s = 0.0,
             .primary_flow_rate_m3_s2 = 0.0,
             .primary_rate_Pa_s = 23.0 * 2e5 * std::cos(23.0 * t)};
  const double drop = g.ports.upstream_Pa - g.ports.primary_Pa;
  g.ports.primary_flow_m3_s = kConfig.alpha2_m2_s_sqrtPa * g.x_m * std::sqrt(drop);
  const double stored = g.ports.inflow_m3_s - g.ports.primary_flow_m3_s -
                        kConfig.alpha3_m3_s_sqrtPa * std::sqrt(g.ports.upstream_Pa - g.ports.secondary_Pa) -
                        kConfig.alpha1_m2 * g.x_rate_m_s;
  g.upstream_rate_Pa_s = stored * kConfig.bulk_modulus_Pa / kConfig.upstream_volume_m3;
  g.ports.primary_flow_rate_m3_s2 =
      kConfig.alpha2_m2_s_sqrtPa *
      (g.x_rate_m_s * std::sqrt(drop) +
       0.5 * g.x_m * (g.upstream_rate_Pa_s - g.ports.primary_rate_Pa_s) / std::sqrt(drop));
  return g;
}

TEST(MultiInput, RateFromThePortsAloneIsThatOfTheMovingElement) {
  for (int i = 0; i < 200; ++i) {
    const Given g = given(1e-3 * i);
    EXPECT_NEAR(upstream_rate_Pa_s(kConfig, g.ports), g.upstream_rate_Pa_s, 1e-9 * 1e9)
        << "Pa/s at " << i << " ms";
  }
}

TEST(MultiInput, DisplacementIsWhatPassesTheFlow) {
  const Given g = given(0.02);
  EXPECT_NEAR(displacement_m(kConfig, g.ports), g.x_m, 1e-15);
}

TEST(MultiInput, WithoutSweptVolumeItIsTheFluidsCapacitance) {
  MultiInputConfig config = kConfig;
  config.alpha1_m2 = 0.0;
  const MultiInputPorts ports = given(0.01).ports;
  const double stored = ports.inflow_m3_s - ports.primary_flow_m3_s - secondary_flow_m3_s(config, ports);
  EXPECT_NEAR(upstream_rate_Pa_s(config, ports), stored * 1.4e9 / 1e-3, 1e-3);
}

TEST(MultiInput, RefusesPortsOutOfItsRange) {
  MultiInputPorts ports = given(0.0).ports;
  ports.primary_Pa = ports.upstream_Pa;
  EXPECT_THROW(upstream_rate_Pa_s(kConfig, ports), std::invalid_argument);
  ports = given(0.0).ports;
  ports.primary_flow_m3_s = 1.0;  // more than the volume's compression can feed back
  EXPECT_THROW(upstream_rate_Pa_s(kConfig, ports), std::invalid_argument);
  MultiInputConfig config = kConfig;
  config.alpha2_m2_s_sqrtPa = 0.0;
  EXPECT_THROW(validate(config), std::invalid_argument);
}

}  // namespace
