// (30)-(32): from the continuous models to the sampled ones.
#include <cmath>
#include <vector>

#include "host-sim/identify/regulator_valve/discrete_model.hpp"
#include "host-sim/plant/regulator_valve/linear_model.hpp"
#include "host-sim/reproduce/regulator_valve/parts.hpp"
#include "host-sim/reproduce/regulator_valve/printed.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::regulator_valve {
namespace {

using identify::regulator_valve::DiscreteModel;

constexpr double kSample_s = 0.005;

// (28) with the correct reading of (38): slow enough for its 5 ms.
plant::regulator_valve::ThirdOrder slow_model() {
  return identify::regulator_valve::read_back(kPrintedSwarm.rising);
}

// Forward Euler on p, p', p'' of (28), a unit step of the screw from sample 0 on.
std::vector<double> euler(const plant::regulator_valve::ThirdOrder& c, int samples) {
  std::vector<double> p{0.0};
  double d1 = 0.0;
  double d2 = 0.0;
  for (int k = 0; k < samples; ++k) {
    const double d3 = c.gain_Pa_m_s3 - c.square_1_s * d2 - c.linear_1_s2 * d1 - c.constant_1_s3 * p.back();
    p.push_back(p.back() + kSample_s * d1);
    d1 += kSample_s * d2;
    d2 += kSample_s * d3;
  }
  return p;
}

}  // namespace

Part discretisation() {
  const auto c = slow_model();
  const DiscreteModel model = identify::regulator_valve::discretise(c, kSample_s);
  const int samples = 400;
  const std::vector<double> stepped = euler(c, samples);
  int first = 0;
  while (stepped[static_cast<std::size_t>(first)] == 0.0) ++first;
  // (30) from rest, its b moved to where Euler has it
  double largest = 0.0;
  std::vector<double> p(3, 0.0);
  for (std::size_t k = 3; k < stepped.size(); ++k) {
    p.push_back(model.b_Pa_m - model.a[0] * p[k - 1] - model.a[1] * p[k - 2] - model.a[2] * p[k - 3]);
    largest = greater_of(largest, std::abs(p[k] - stepped[k]) / c.static_gain_Pa_m());
  }
  return {
      .title = "(30)-(32): discretisation",
      .text =
          "\"Euler Method\" at 5 ms. (32) is the forward difference s = (z - 1)/t_s; it is put beside "
          "Euler's method on the three states "
          "of (28).",
      .findings = {
          {.item = "(32)",
           .quantity = "largest distance of (30) from Euler's method on the states, of the settled value",
           .paper = 0.0,
           .ours = largest,
           .tolerance = 1e-9,
           .source = Source::kPapersOwnEquation,
           .why = "a_1, a_2, a_3 and b_0 of (32) are not those of Euler's method"},
          {.item = "(30), (32)",
           .quantity = "samples from a turn of the screw to the first answer",
           .paper = 1.0,
           .ours = static_cast<double>(first),
           .source = Source::kPapersOwnEquation,
           .why =
               "the forward difference that gives (32) has b_0 z^-3 over the same denominator; (30) writes "
               "b_0 z^-1, two samples (10 ms) earlier, \"considering the sampling input delay\", which would "
               "be later"}}};
}

}  // namespace plenum::host::reproduce::regulator_valve
