// (17)-(29): the nonlinear valve against its linear models.
#include <array>
#include <cmath>
#include <utility>

#include "host-sim/plant/regulator_valve/linear_model.hpp"
#include "host-sim/plant/regulator_valve/valve.hpp"
#include "host-sim/plant/runge_kutta.hpp"
#include "host-sim/reproduce/regulator_valve/parts.hpp"
#include "host-sim/reproduce/regulator_valve/printed.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::regulator_valve {
namespace {

namespace valve = plant::regulator_valve;

constexpr double kRest_Pa = 3e5;  // absolute
constexpr double kSample_s = 0.005;
constexpr int kSamples = 400;

/// Pressure [Pa] after a step of the screw, from rest.
struct Answers {
  report::Curve plant;
  report::Curve linear;
  double largest_difference_Pa = 0.0;
};

// (28) or (29) after a step, by Runge-Kutta on its three states.
std::vector<double> linear_answer_Pa(const valve::ThirdOrder& c, double step_m) {
  using State = std::array<double, 3>;
  constexpr int kParts = 50;
  constexpr double h = kSample_s / kParts;
  const auto slope = [&](double, const State& y) -> State {
    return {y[1], y[2],
            c.gain_Pa_m_s3 * step_m - c.square_1_s * y[2] - c.linear_1_s2 * y[1] - c.constant_1_s3 * y[0]};
  };
  State y{};
  std::vector<double> answer;
  for (int i = 0; i < kSamples * kParts; ++i) {
    y = plant::runge_kutta_step(i * h, y, h, slope);
    if ((i + 1) % kParts == 0) answer.push_back(y[0]);
  }
  return answer;
}

// A step up from where the inlet, a step down from where the exhaust is about to open.
Answers answers(double step_m) {
  const valve::ValveConfig bench = valve::bench_valve();
  const bool up = step_m > 0.0;
  const valve::ThirdOrder c =
      up ? valve::linear_pressurisation(bench) : valve::linear_exhaustion(bench, kRest_Pa);
  valve::Valve plant(
      bench, (kRest_Pa - bench.ambient_Pa) / kPrintedSlope_Pa_m + (up ? bench.dead_band_m : 0.0), kRest_Pa);
  plant.advance(plant.screw_m() + step_m, 1e-9);
  Answers found{.plant = {.name = "nonlinear valve", .x = {}, .y = {}, .ink = report::Ink::kNeutral},
                .linear = {.name = up ? "(28)" : "(29)",
                           .x = {},
                           .y = linear_answer_Pa(c, step_m),
                           .stroke = report::Stroke::kDashed}};
  for (int k = 1; k <= kSamples; ++k) {
    plant.advance(plant.screw_m(), kSample_s);
    found.plant.x.push_back(k * kSample_s);
    found.plant.y.push_back(plant.state().pressure_Pa - kRest_Pa);
  }
  found.linear.x = found.plant.x;
  for (std::size_t i = 0; i < found.plant.y.size(); ++i)
    found.largest_difference_Pa =
        greater_of(found.largest_difference_Pa, std::abs(found.plant.y[i] - found.linear.y[i]));
  return found;
}

report::LineChart chart(const char* title, const Answers& shown) {
  return {.title = title,
          .caption = "From rest at 3 bar absolute, at the edge of the dead band.",
          .y = {"Change of pressure", "Pa"},
          .curves = {shown.plant, shown.linear}};
}

}  // namespace

Part linear_models() {
  constexpr double kSmall_m = 10e-6;
  const Answers up = answers(kTurn_m);
  const Answers down = answers(-kTurn_m);
  const Answers little_down = answers(-kSmall_m);
  const Answers twice_down = answers(-2.0 * kSmall_m);
  return {
      .title = "(17)-(29): force balance and linear models",
      .text =
          "The nonlinear valve (both conditions, blocked and subsonic ports, contact of plunger and spool) "
          "answers a step of the screw, beside the transfer functions with the coefficients of the same "
          "constants. Pressurisation is linear in the paper's own range, exhaustion is linearised, so its "
          "difference must go with the square of the step. That the pressure settles at (26) shows the "
          "force balance at rest alone: A_d is set to the slope of section 4.",
      .findings = {{.item = "(26)",
                    .quantity = "settled pressure for each mm of the screw, pressurisation",
                    .unit = "Pa/mm",
                    .paper = 1e-3 * kPrintedSlope_Pa_m,
                    .ours = 1e-3 * up.plant.y.back() / kTurn_m,
                    .tolerance = 0.005e5,
                    .source = Source::kSetToPaper,
                    .why = "the force balance does not settle at k_me x_p/A_d"},
                   {.item = "(28)",
                    .quantity = "0.25 mm up: largest distance of the nonlinear valve from (28), of the step",
                    .unit = "%",
                    .paper = 0.0,
                    .ours = 100.0 * up.largest_difference_Pa / (kPrintedSlope_Pa_m * kTurn_m),
                    .tolerance = 0.01,
                    .why = "the inlet shuts before the pressure has settled, which (28) does not know"},
                   {.item = "(29)",
                    .quantity =
                        "0.01 mm down: largest distance of the nonlinear valve from (29), of the step",
                    .unit = "%",
                    .paper = 0.0,
                    .ours = 100.0 * little_down.largest_difference_Pa / (kPrintedSlope_Pa_m * kSmall_m),
                    .tolerance = 1.0,
                    .why = "(27) is not the slope of (16)"},
                   {.item = "(27), (29)",
                    .quantity = "that distance in pascals, of 0.02 mm over 0.01 mm: a Taylor series cut "
                                "after its first order",
                    .paper = 4.0,
                    .ours = twice_down.largest_difference_Pa / little_down.largest_difference_Pa,
                    .tolerance = 0.1,
                    .why = "what (29) leaves out is not of the second order"}},
      .charts = {chart("Pressurisation: 0.25 mm up", up), chart("Exhaustion: 0.25 mm down", down)}};
}

}  // namespace plenum::host::reproduce::regulator_valve
