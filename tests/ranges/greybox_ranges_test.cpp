// That the range of Q31.32 suffices: for a tick of every admissible grey box, and for its inverse.
//
// Its steps ask which corner comes first and by which formula a piece is solved, so that no interval follows them. But all numbers on the
// way are made of a few: openings, the flow function, and how often a tick fills the chamber, which the model limits. Each of these is
// bounded from the ranges of the parameters, then each number that is made of them, in the order of greybox.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <utility>
#include <vector>

#include "firmware/config/greybox_parameters.hpp"
#include "firmware/config/model_image.hpp"
#include "firmware/control/greybox.hpp"
#include "host-sim/rounding/greybox_tables.hpp"
#include "tests/firmware/control/random_admissible.hpp"

namespace ranges {
namespace {

using namespace plenum::config;
using rounding::GreyboxTables;

/// What a number of Q31.32 can be.
constexpr double kRange = 2147483648.0;

using Model = plenum::control::Greybox;

// Limits of the core's own, and the states looked at: a pressure of up to 5 MPa, a supply of 0.2 to 2 times the parameter, a speed of up
// to 1.5 L/s. A growth is followed up to e^4, the mean of which is 13.4.
constexpr double kMostFilled = static_cast<double>(Model::kMostFilled),
                 kGap_kPa = static_cast<double>(Model::kGap_kPa);
constexpr double kLeastVolume_mL = static_cast<double>(Model::kLeastVolume_mL);
constexpr double kFarther_kPa = static_cast<double>(Model::kFarther_kPa),
                 kMostFlow_kPa = static_cast<double>(Model::kMostFlow_kPa);
constexpr double kMostPressure_kPa = static_cast<double>(plenum::control::kMostPressure_kPa);
constexpr double kPressure_kPa = 5000, kMostSupply = 2, kSpeed_L_s = 1.5, kMostGrowth = 13.5;
constexpr double kAtABound = 0.4;
constexpr std::array kChordEnd = {0.0,        0.17364818, 0.34202014, 0.50000000, 0.64278761, 0.76604444,
                                  0.86602540, 0.93969262, 0.98480775, 0.99619470, 1.0};
constexpr std::size_t kChords = kChordEnd.size() - 1;

double low(GreyboxParameter of) {
  return static_cast<double>(parameter_schema(ModelKind::greybox)[of].low);
}
double high(GreyboxParameter of) {
  return static_cast<double>(parameter_schema(ModelKind::greybox)[of].high);
}

/// The most of 1 + k (r* - r).
double most_discharge() {
  constexpr double kCritical = 0.5282818;
  return 1 + std::max(high(kDischargeSlope) * kCritical, -low(kDischargeSlope) * (1 - kCritical));
}

/// Of the flow function at the ends of its chords, moved up as they are: psi, and what it loses from one to the next over their
/// distance. Both for all indices between two, within which it falls with the index. A chord's end moves up by a third of what half the
/// middles of its two sides exceed these sides' ends by, of which those that lie higher than the middle are left out here.
struct FlowFunction {
  double most = 0;
  double steepest = 0;
};
FlowFunction flow_function() {
  const auto plate = [](double along) {
    const double ratio = 0.5282818 + (1 - 0.5282818) * along;
    return std::sqrt(std::max(std::pow(ratio, 2 / 1.4) - std::pow(ratio, 2.4 / 1.4), 0.0) / 0.06698485);
  };
  constexpr int kParts = 500;
  constexpr double kRounded = 1 + 1e-5, kLeastWidth = 0.05;
  const double width = (high(kSubsonicIndex) - low(kSubsonicIndex)) / kParts;
  FlowFunction of;
  for (int part = 0; part < kParts; ++part) {
    const double index = low(kSubsonicIndex) + part * width;
    const auto at_most = [&](double along) {
      return std::pow(std::min(plate(along) * kRounded, 1.0), 2 * index);
    };
    const auto at_least = [&](double along) {
      return std::pow(std::min(plate(along) / kRounded, 1.0), 2 * (index + width));
    };
    const auto middle = [](std::size_t i) { return 0.5 * (kChordEnd[i] + kChordEnd[i + 1]); };
    std::array<double, kChords + 1> psi{};
    for (std::size_t i = 0; i <= kChords; ++i) {
      double above = 0;
      if (i > 0) above += at_most(middle(i - 1)) - at_least(kChordEnd[i]);
      if (i < kChords) above += at_most(middle(i)) - at_least(kChordEnd[i + 1]);
      psi[i] = most_discharge() * (at_most(kChordEnd[i]) + above / 6) * kRounded;
      of.most = std::max(of.most, psi[i]);
    }
    for (std::size_t i = 0; i < kChords; ++i)
      of.steepest = std::max(
          of.steepest, std::max(psi[i], psi[i + 1]) / (kLeastWidth * (kChordEnd[i + 1] - kChordEnd[i])));
  }
  return of;
}

// Openings and conductances (valve_curve.hpp): o m(o) beyond a command of 0 or 10 V.
double widest_opening_V() {
  return 10 - low(kOpenAbove);
}
double widest_beyond_mL_s() {
  const double o = widest_opening_V(), g = o / (o + 2);
  const double bent_V = o * (1 + g * (high(kInletSlope) + g * (high(kInletCurve) + g * high(kInletBend))));
  return high(kInletConductance) * bent_V + high(kInletLeak);
}
double widest_port_L_s() {
  return (widest_beyond_mL_s() + 0.5 * high(kTransition)) / 1000;
}

struct Number {
  const char* name;
  double most;
};

TEST(GreyboxRanges, OfATickAndItsInverseAreHeldByFixedPointForEveryAdmissibleParameterSet) {
  const double opening_V = widest_opening_V(), beyond_mL_s = widest_beyond_mL_s(),
               port_L_s = widest_port_L_s();
  // pressures, flows over conductances, their slopes
  const FlowFunction psi = flow_function();
  const double corner_kPa = std::max(high(kSupply) / low(kCriticalRatio), kMostPressure_kPa);
  const double flow_kPa = psi.most * kPressure_kPa;
  const double gap_L_s_kPa = 0.5 * high(kChamberLeak) / 1000 / low(kAmbient);
  const double leak_kPa_L_s =
      gap_L_s_kPa * kPressure_kPa * (kPressure_kPa + high(kAmbient) + kPressure_kPa + kGap_kPa);
  // f: what all conductances share is kMostFilled, a gap's as at kGap_kPa. The corner ahead is passed above the supply by the moving
  // volume alone, which then makes f.
  const double per_volume_s_L = 10 / kLeastVolume_mL;
  const double moved = per_volume_s_L * high(kVolumeExponent) * kSpeed_L_s;
  const double share = std::max(psi.most, 2.0);  // of a gap's chord: (low + high)/kGap_kPa
  const double here_kPa = (kMostFilled * share + moved) * kPressure_kPa;
  const double ahead_kPa = (kMostFilled * share + moved) * kMostPressure_kPa;
  const double passed_kPa = here_kPa + moved * kMostPressure_kPa;
  const double slope = kMostFilled * std::max(psi.steepest, share) + moved;
  const double gained = flow_kPa * kMostGrowth + kMostFlow_kPa;

  for (const Number& number : {
           Number{"opening where smax() bends [V]",
                  (12 * high(kTransition) + high(kInletLeak)) / low(kInletConductance) + opening_V},
           {"B o m(o) - L [mL/s]", beyond_mL_s},
           {"of the transition far from it [mL/s]", std::max(1024 * high(kTransition), 4 * beyond_mL_s)},
           {"x^2 + 1 near it", 1024.0 * 1024.0 + 1},
           {"corner of a supply [kPa]", kMostSupply * corner_kPa},
           {"phi there [kPa]", kMostSupply * psi.most * corner_kPa},
           {"slope of phi", psi.steepest},
           {"through the gap [kPa L/s]", leak_kPa_L_s},
           {"f [kPa a tick]", here_kPa},
           {"J", slope},
           {"J times a way [kPa a tick]", here_kPa + ahead_kPa},
           {"f at the corner ahead [kPa a tick]", ahead_kPa},
           {"f here and there, both passed [kPa a tick]", 2 * passed_kPa},
           {"way times a logarithm [kPa]", kMostPressure_kPa * 17},
           {"way over its time, rounded up [kPa a tick]", 2 * passed_kPa},
           {"way of an exponential [kPa]", passed_kPa * kMostGrowth},
           {"pressures gone, of the mean [kPa]", 2 * kMostPressure_kPa},
           {"flow of wide open ports [kPa L/s]", 2 * port_L_s * flow_kPa},
           {"flow drawn [kPa L/s]", port_L_s * flow_kPa},
           {"secant of the gap [L/s]", leak_kPa_L_s},
           {"f phi_1, f (phi_1 - phi_2) [kPa]", here_kPa * kMostGrowth},
           {"secant of phi times a way [kPa]", std::max(2 * flow_kPa, psi.steepest) * kFarther_kPa},
           {"gain by a conductance [kPa s/L]", per_volume_s_L * gained},
           {"gain by a conductance's change [kPa]", kMostFilled * gained},
           {"slopes by the command [kPa/V]", 2 * std::ldexp(1.0, plenum::control::kSteepest)},
           {"what is to be gained [kPa]", std::ldexp(1.0, Model::kMostGain) + kMostPressure_kPa},
       }) {
    EXPECT_LT(number.most, kRange) << number.name;
  }
}

// What the bounds above are made of, in the core's own tables.
TEST(GreyboxRanges, StandOnTablesThatKeepTheirBounds) {
  const FlowFunction psi = flow_function();
  std::mt19937 random(23);
  double most_filled = 0, most_psi = 0, steepest_psi = 0, most_port = 0;
  for (int i = 0; i < 3000; ++i) {
    const ModelParameters set =
        plenum::control::testing::draw_admissible(random, ModelKind::greybox, kAtABound);
    for (const GreyboxTables& tables : {rounding::greybox_in_fixed({set.value.data(), set.count}),
                                        rounding::greybox_in_double({set.value.data(), set.count})}) {
      const double filled = tables.tick_s_mL_L / tables.least_volume_mL *
                            (tables.node.back().inlet + tables.node.front().exhaust +
                             tables.leak_L_s_kPa * (kGap_kPa + tables.ambient_kPa));
      ASSERT_LE(filled, kMostFilled * (1 + 1e-6));
      ASSERT_GE(tables.least_volume_mL, kLeastVolume_mL * (1 - 1e-6));
      most_filled = std::max(most_filled, filled);
      for (const GreyboxTables::Ports& port : tables.node)
        most_port = std::max({most_port, port.inlet, port.exhaust});
      for (const auto& [curve, source_kPa] :
           {std::pair{&tables.inlet, tables.supply_kPa}, {&tables.exhaust, tables.ambient_kPa}}) {
        for (std::size_t k = 0; k < curve->corner_kPa.size(); ++k) {
          const double share = std::fabs(curve->flow_kPa[k]) / std::max(curve->corner_kPa[k], source_kPa);
          ASSERT_LE(share, psi.most);
          most_psi = std::max(most_psi, share);
        }
        for (const double slope : curve->slope) {
          ASSERT_LE(std::fabs(slope), psi.steepest);
          steepest_psi = std::max(steepest_psi, std::fabs(slope));
        }
      }
    }
  }
  EXPECT_GT(most_filled, 0.999 * kMostFilled) << "no set was at the limit";
  EXPECT_GT(most_psi, 0.9 * psi.most);
  EXPECT_GT(steepest_psi, 0.5 * psi.steepest);
  EXPECT_LT(most_port, widest_port_L_s());
  EXPECT_GT(most_port, 0.5 * widest_port_L_s());
}

}  // namespace
}  // namespace ranges
