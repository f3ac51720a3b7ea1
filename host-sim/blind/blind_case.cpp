#include "host-sim/blind/blind_case.hpp"

#include <algorithm>
#include <cmath>

#include "host-sim/blind/excitation.hpp"
#include "host-sim/blind/recalibrate.hpp"

namespace plenum::host::blind {
namespace {

using Json = nlohmann::ordered_json;

trace::RigDescription draw_truth(Random& random) {
  trace::RigDescription rig;
  rig.gas.temperature_K = random.uniform(288.0, 303.0);
  rig.supply.pressure_Pa = random.uniform(400e3, 800e3);
  rig.ambient.pressure_Pa = random.uniform(97e3, 103e3);
  auto& valve = rig.valve;
  const double null_V = random.uniform(4.85, 5.15), apart_V = random.uniform(0.05, 0.25);
  valve.open_above_V = null_V + 0.5 * apart_V;
  valve.exhaust_below_V = null_V - 0.5 * apart_V;
  valve.inlet_area_per_V_m2 = random.uniform(0.8e-6, 2.2e-6);
  valve.exhaust_area_per_V_m2 =
      std::clamp(valve.inlet_area_per_V_m2 * random.uniform(0.8, 1.2), 0.8e-6, 2.2e-6);
  valve.inlet_leak_m2 = random.log_uniform(0.01e-6, 0.15e-6);
  valve.exhaust_leak_m2 = random.log_uniform(0.01e-6, 0.15e-6);
  valve.transition_m2 = random.uniform(0.1e-6, 0.4e-6);
  rig.sensor.pressure_noise_Pa = random.log_uniform(60.0, 300.0);
  return rig;
}

/// What a data sheet would say of this valve.
trace::RigDescription nominal_of(const trace::RigDescription& truth, Random& random) {
  trace::RigDescription rig = truth;
  auto& valve = rig.valve;
  valve.inlet_area_per_V_m2 *= random.uniform(0.85, 1.15);
  valve.exhaust_area_per_V_m2 *= random.uniform(0.85, 1.15);
  valve.open_above_V += random.uniform(-0.05, 0.05);
  valve.exhaust_below_V += random.uniform(-0.05, 0.05);
  if (valve.open_above_V < valve.exhaust_below_V) std::swap(valve.open_above_V, valve.exhaust_below_V);
  valve.inlet_leak_m2 *= random.log_uniform(1.0 / 3.0, 3.0);
  valve.exhaust_leak_m2 *= random.log_uniform(1.0 / 3.0, 3.0);
  valve.transition_m2 *= random.log_uniform(0.5, 2.0);
  return rig;
}

void enlarge(trace::RigDescription::Valve& valve, double size) {
  for (double* area : {&valve.inlet_area_per_V_m2, &valve.exhaust_area_per_V_m2, &valve.inlet_leak_m2,
                       &valve.exhaust_leak_m2, &valve.transition_m2}) {
    *area *= size;
  }
}

Motion draw_motion(Random& random, bool moves) {
  Motion motion;
  motion.mean_m3 = random.log_uniform(40e-6, 300e-6);
  const double share = random.uniform(0.2, 0.4), split = random.uniform(0.5, 1.0);
  const double slow_Hz = random.log_uniform(0.1, 0.5), fast_Hz = random.log_uniform(0.5, 1.5);
  const double slow_phase = random.angle(), fast_phase = random.angle();
  if (moves) {
    motion.tones[0] = {share * split, slow_Hz, slow_phase};
    motion.tones[1] = {share * (1.0 - split), fast_Hz, fast_phase};
  }
  return motion;
}

Clutter draw_clutter(Random& random, const trace::RigDescription& rig) {
  Clutter clutter;
  clutter.command_lsb_V = 10.0 / 65536.0;
  clutter.pressure_lsb_Pa = 1e6 / 65536.0;
  clutter.volume_lsb_m3 = 500e-6 / 65536.0;
  clutter.jitter_s = random.uniform(5e-6, 20e-6);
  clutter.ripple_Pa = rig.sensor.pressure_noise_Pa * random.uniform(0.3, 0.8);
  clutter.ripple_Hz = random.uniform(0.5, 3.0);
  clutter.ripple_phase = random.angle();
  clutter.seed = random.bits();
  return clutter;
}

Scale scale_of(const trace::RigDescription& rig, const Motion& motion, double size) {
  const double flow = rig.valve.discharge_coefficient *
                      thin_plate_flux(rig.supply.pressure_Pa, rig.ambient.pressure_Pa, rig.gas.temperature_K);
  return {size,
          rig.supply.pressure_Pa,
          rig.ambient.pressure_Pa,
          rig.gas.temperature_K,
          motion.mean_m3,
          motion.moves(),
          0.5 * (rig.valve.inlet_area_per_V_m2 + rig.valve.exhaust_area_per_V_m2),
          rig.valve.discharge_coefficient,
          flow};
}

ExcitationSetting excitation_for(const Recipe& recipe, double seconds, const trace::RigDescription& nominal,
                                 const Scale& scale) {
  const double speed_Pa_s = kKappa * kGasConstant_J_kg_K * scale.temperature_K / scale.volume_m3 *
                            scale.flow_kg_s_m2 * scale.area_per_V_m2;
  ExcitationSetting setting;
  setting.kind = recipe.tier == 3 ? Excitation::kChirp : Excitation::kMixed;
  setting.period_s = 1.0 / nominal.sampling.rate_Hz;
  setting.rows = static_cast<std::size_t>(std::lround(seconds / setting.period_s)) + 1;
  setting.supply_Pa = scale.supply_Pa;
  setting.ambient_Pa = scale.ambient_Pa;
  setting.null_V = 0.5 * (nominal.valve.open_above_V + nominal.valve.exhaust_below_V);
  setting.half_gap_V = 0.5 * (nominal.valve.open_above_V - nominal.valve.exhaust_below_V);
  setting.fill_s = (scale.supply_Pa - scale.ambient_Pa) / speed_Pa_s;
  return setting;
}

trace::Log record(const Machine& machine, const Rows& rows, Random& random) {
  trace::Log log;
  const double rate_Hz = machine.rig.sampling.rate_Hz;
  log.period_s = 1.0 / rate_Hz;
  log.pressure_average_s = machine.rig.sampling.pressure_average_s;
  const auto rounded = [](double value, double lsb) {
    return lsb > 0.0 ? lsb * std::round(value / lsb) : value;
  };
  for (std::size_t k = 0; k < rows.command_V.size(); ++k) {
    log.time_s.push_back(static_cast<double>(k) / rate_Hz);
    log.command_V.push_back(rows.command_V[k]);
    const double noisy = rows.pressure_Pa[k] + machine.rig.sensor.pressure_noise_Pa * random.normal();
    log.pressure_Pa.push_back(rounded(noisy, machine.clutter.pressure_lsb_Pa));
    log.volume_m3.push_back(rounded(rows.volume_m3[k], machine.clutter.volume_lsb_m3));
  }
  return log;
}

double rms_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

/// What this departure alone leaves after recalibration.
double alone_Pa(const std::string& id, const std::vector<Drawn>& drawn, Machine machine,
                const Recalibration& recalibration, const Rows& rows) {
  for (const Drawn& other : drawn) {
    if (other.id != id) departure_kind(other.id).remove(machine.departures);
  }
  return recalibration.rest_Pa(simulate(machine, rows.command_V.size(), replay(rows.command_V)).pressure_Pa);
}

Json valve_json(const trace::RigDescription::Valve& valve) {
  return {{"open_above_V", valve.open_above_V},
          {"exhaust_below_V", valve.exhaust_below_V},
          {"inlet_area_per_V_m2", valve.inlet_area_per_V_m2},
          {"exhaust_area_per_V_m2", valve.exhaust_area_per_V_m2},
          {"inlet_leak_m2", valve.inlet_leak_m2},
          {"exhaust_leak_m2", valve.exhaust_leak_m2},
          {"transition_m2", valve.transition_m2},
          {"discharge_coefficient", valve.discharge_coefficient}};
}

}  // namespace

Case make_case(const Recipe& recipe) {
  Random random(recipe.seed, 1);
  Case out;
  Machine& machine = out.machine;
  machine.rig = draw_truth(random);
  out.rig = nominal_of(machine.rig, random);
  machine.motion = draw_motion(random, recipe.tier == 1);
  machine.clutter = draw_clutter(random, machine.rig);
  enlarge(machine.rig.valve, recipe.size);
  enlarge(out.rig.valve, recipe.size);
  machine.motion.mean_m3 *= recipe.size;
  machine.clutter.volume_lsb_m3 *= recipe.size;
  const double span_Pa = machine.rig.supply.pressure_Pa - machine.rig.ambient.pressure_Pa;
  machine.initial_Pa = machine.rig.ambient.pressure_Pa + random.uniform(0.0, 0.3) * span_Pa;

  const Scale scale = scale_of(machine.rig, machine.motion, recipe.size);
  std::vector<Drawn> drawn;
  for (const std::string& id : recipe.effects) {
    drawn.push_back(departure_kind(id).draw(random, scale, machine.departures));
  }

  const auto setting = excitation_for(recipe, recipe.seconds, out.rig, scale);
  const auto held_setting = excitation_for(recipe, kHeldoutShare * recipe.seconds, out.rig, scale);
  const Rows rows = simulate(machine, setting.rows, excite(setting, random.bits()));
  out.log = record(machine, rows, random);

  Machine again = machine;  // another day: it starts elsewhere, the volume in another phase
  again.initial_Pa = machine.rig.ambient.pressure_Pa + random.uniform(0.0, 0.3) * span_Pa;
  for (auto& tone : again.motion.tones) tone.phase = random.angle();
  again.clutter.seed = random.bits();
  const Rows held = simulate(again, held_setting.rows, excite(held_setting, random.bits()));
  out.heldout = record(again, held, random);

  const Driver same = replay(held.command_V);
  Machine clean = again;
  clean.clutter = Clutter{};
  const Rows truth = simulate(clean, held.command_V.size(), same);

  Json& label = out.label;
  label["kind"] = recipe.kind;
  label["tier"] = recipe.tier;
  label["seed"] = recipe.seed;
  label["seconds"] = recipe.seconds;
  label["size"] = recipe.size;
  label["effects"] = Json::array();
  Machine nominal = clean;
  nominal.departures = Departures{};
  label["recalibrated_gap_Pa"] = 0.0;
  if (!drawn.empty()) {
    const Recalibration recalibration(nominal, held.command_V);
    const double together_Pa = recalibration.rest_Pa(truth.pressure_Pa);
    label["recalibrated_gap_Pa"] = together_Pa;
    for (const Drawn& one : drawn) {
      Machine without = clean;
      departure_kind(one.id).remove(without.departures);
      const Rows rest = simulate(without, held.command_V.size(), same);
      Json parameters = Json::object();
      for (const Parameter& parameter : one.parameters) parameters[parameter.name] = parameter.value;
      label["effects"].push_back(
          {{"id", one.id},
           {"variant", one.variant},
           {"catalogued", departure_kind(one.id).catalogued},
           {"equation", departure_kind(one.id).equation},
           {"parameters", parameters},
           {"gap_Pa", rms_difference(truth.pressure_Pa, rest.pressure_Pa)},
           {"alone_recalibrated_gap_Pa",
            drawn.size() == 1 ? together_Pa : alone_Pa(one.id, drawn, clean, recalibration, held)}});
    }
  }
  label["noise_floor_Pa"] = rms_difference(out.heldout.pressure_Pa, truth.pressure_Pa);
  label["pressure_noise_Pa"] = machine.rig.sensor.pressure_noise_Pa;
  label["valve"] = valve_json(machine.rig.valve);
  label["volume_m3"] = machine.motion.mean_m3;
  label["clutter"] = {{"jitter_s", machine.clutter.jitter_s},
                      {"ripple_Pa", machine.clutter.ripple_Pa},
                      {"ripple_Hz", machine.clutter.ripple_Hz},
                      {"command_lsb_V", machine.clutter.command_lsb_V},
                      {"pressure_lsb_Pa", machine.clutter.pressure_lsb_Pa},
                      {"volume_lsb_m3", machine.clutter.volume_lsb_m3}};
  return out;
}

}  // namespace plenum::host::blind
