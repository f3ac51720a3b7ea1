// III.C and (10c), (10e): where the rate of change of the volume enters.
#include <algorithm>
#include <thread>

#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/plant/reach.hpp"
#include "host-sim/reproduce/actuators/illustrated.hpp"
#include "host-sim/reproduce/actuators/parts.hpp"
#include "host-sim/reproduce/actuators/physical_volume_rate.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

/// ds/dv' of (4a) at v' = 0 [Pa s/m3]: from R T mdot(s) = v' s.
double steady_by_volume_rate(const plant::ThinPlateValve& valve, double u) {
  const plant::Gas gas;
  const double s = plant::steady_state_Pa(valve, u, kSupply_Pa, kAmbient_Pa);
  const plant::PortFlows m = valve.flows(valve.opening(u), s, kSupply_Pa, kAmbient_Pa);
  return s / (gas.specific_gas_constant_J_kg_K() * gas.temperature_K *
              (m.inlet_slope_kg_s_Pa - m.exhaust_slope_kg_s_Pa));
}

/// Fig. 13 for the moving records with v' where (4a) has it.
struct ByPhysics {
  std::vector<identify::Drift> identified_at_rest;  ///< each by its chamber's model at rest
  std::vector<identify::Drift> fitted;              ///< each by a fit to that record, as the published form's
};
ByPhysics drifts_by_physics(const Study& study) {
  const std::size_t count = study.moving.size();
  ByPhysics drifts{std::vector<identify::Drift>(count), std::vector<identify::Drift>(count)};
  identify::in_parallel(count, std::thread::hardware_concurrency(), [&](std::size_t i) {
    const trace::Log& log = study.moving[i].log;
    const PhysicalModel at_rest{study.at_rest[i].one_step.model, study.at_rest[i].mean_volume_mL()};
    drifts.identified_at_rest[i] = drift(log, at_rest, kStarts, kHorizon_s);
    drifts.fitted[i] = drift(log, fit_next_pressure(log, at_rest), kStarts, kHorizon_s);
  });
  return drifts;
}

std::vector<double> worst_percent(const std::vector<identify::Drift>& drifts) {
  return over(drifts, [](const identify::Drift& one) { return one.worst_std_percent; });
}

report::XyChart steady_chart(const std::vector<double>& command_V, const std::vector<double>& by_rate) {
  return {.title = "Change of the steady state with the volume's rate, by (2) and (4a)",
          .caption = "(10c) has one number c_4 for all commands.",
          .x = {"Command", "V"},
          .y = {"ds/dv'", "kPa s/mL"},
          .curves = {{.name = "(4a)", .x = command_V, .y = by_rate}}};
}

report::LineChart drift_chart(const Study& study, const ByPhysics& by_physics) {
  report::LineChart chart{.title = "Drift on moving volumes, v' where (10c) and where (4a) has it",
                          .caption =
                              "Each line one chamber, every fourth of the 76: standard deviation over 48 "
                              "starts.",
                          .x = {"Time since the last measurement", "s"},
                          .y = {"Standard deviation of the prediction", "% of span"}};
  for (std::size_t i = 0; i < study.moving.size(); i += 4) {
    const identify::Drift& published = study.moving[i].one_step_drift;
    const identify::Drift& physical = by_physics.fitted[i];
    chart.curves.push_back({.name = "(10)", .x = published.time_s, .y = published.std_percent});
    chart.curves.push_back({.name = "v' as in (4a)", .x = physical.time_s, .y = physical.std_percent});
  }
  return chart;
}

}  // namespace

Part volume_rate(const Study& study) {
  Part part{
      .title = "III.C, (10c), (10e): where the volume's rate enters",
      .text =
          "(4a) says how a moving volume changes steady state and rate; (10) takes it up in c_4 and c_5. "
          "The last lines predict the moving records of Fig. 13 with the rate of the volume where (4a) has "
          "it: r = (K + kappa v')/v, s = K s_0/(K + kappa v'), K = c_7 k V, once with each chamber's "
          "parameters identified at rest, once with the six that remain fitted to the record as V.C does.",
      .findings = {}};
  const plant::ThinPlateValve valve(illustrated_valves()[0].valve);
  const std::vector<double> command_V = evenly(kLow_V, kHigh_V, 401);
  const std::vector<double> by_rate =
      over(command_V, [&](double u) { return 1e-9 * steady_by_volume_rate(valve, u); });
  const auto [most, least] = std::minmax_element(by_rate.begin(), by_rate.end());  // all are negative
  part.findings.push_back(
      {.item = "(4a), (10c)",
       .quantity = "ds/dv' at the command where it is largest over that where it is least, 3 to 7 V",
       .paper = 1.0,
       .ours = *most / *least,
       .tolerance = 0.1,
       .instead = "one c_4 for all commands",
       .why = "(4a) with (2) gives ds/dv' = s/(R T dmdot/dp): a sealed chamber follows its piston, an "
              "open one does not. (10c) shifts s by c_4 v' at every command alike (by our valve; any "
              "that opens far beyond its leak shows it)"});

  const std::vector<double> kappas = over(study.moving, [](const Identified& chamber) {
    return chamber.one_step.model.c[4] / chamber.one_step.model.c[5];
  });
  const std::vector<double> not_positive_percent = over(study.moving, [](const Identified& chamber) {
    return 100.0 * chamber.one_step.rate_not_positive_fraction;
  });
  part.findings.push_back({.item = "(4a), (10e)",
                           .quantity = "c_5/c_6, median of the fits on moving volumes; kappa by (4a)",
                           .paper = plant::Gas{}.kappa,
                           .ours = median(kappas),
                           .tolerance = 0.05,
                           .why = "with v' misplaced in (10c) the best c_5 is not that of the physics"});
  part.findings.push_back({.item = "(6)",
                           .quantity = "\"r > 0\": ticks with r <= 0, the most of any fit on a moving volume",
                           .unit = "%",
                           .paper = 0.0,
                           .ours = largest(not_positive_percent),
                           .why = "where a chamber shrinks behind a sealed valve, c_5 v' outweighs c_7 k "
                                  "in (10e): no bound of Table I prevents it, and (4a) itself has K + "
                                  "kappa v' <= 0 there"});

  const ByPhysics by_physics = drifts_by_physics(study);
  const char* const kOfPublished = "what Fig. 13 has of (10)";
  const auto at_most = [&](const char* item, const char* quantity, double limit, double ours,
                           const char* instead) {
    part.findings.push_back(
        {.item = item,
         .quantity = quantity,
         .unit = "% of span",
         .paper = limit,
         .ours = ours,
         .expect = Expect::kAtMost,
         .instead = instead,
         .why = "no number of the paper's: what is left is s_0 symmetric in pressure and a rate that "
                "does not depend on it, as at rest, and parameters that have seen one volume and another "
                "record"});
  };
  at_most("V.D, Fig. 13", "v' as in (4a), nothing fitted to the record: largest drift of any valve, moving",
          10.0, largest(worst_percent(by_physics.identified_at_rest)), kOfPublished);
  at_most("V.D, Fig. 13", "v' as in (4a), fitted to the record: largest drift of any valve, moving", 10.0,
          largest(worst_percent(by_physics.fitted)), kOfPublished);
  at_most("Fig. 12", "v' as in (4a): growth of the error from 1 s to 2 s, typical chamber moving", 1.0,
          late_growth_percent(by_physics.fitted[place_of_typical(study.moving)]),
          "our reading of \"almost no drift\"");
  part.charts = {steady_chart(command_V, by_rate), drift_chart(study, by_physics)};
  return part;
}

}  // namespace plenum::host::reproduce::actuators
