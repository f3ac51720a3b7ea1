#include "host-sim/blind/departures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace plenum::host::blind {
namespace {

constexpr double kTau = 2.0 * std::numbers::pi;

Drawn draw_spool_lag(Random& random, const Scale&, Departures& into) {
  const double frequency_Hz = random.log_uniform(4.0, 120.0);
  const SpoolLag drawn{frequency_Hz, random.uniform(0.5, 1.2),
                       kTau * frequency_Hz * random.uniform(0.8, 3.0)};
  into.spool_lag = drawn;
  return {"spool_lag",
          "third order, speed limited",
          {{"natural_frequency_Hz", drawn.natural_frequency_Hz},
           {"damping", drawn.damping},
           {"slew_V_s", drawn.slew_V_s}}};
}

Drawn draw_dead_time(Random& random, const Scale&, Departures& into) {
  into.dead_time = DeadTime{random.log_uniform(0.3e-3, 30e-3)};
  return {"dead_time", "pure", {{"delay_s", into.dead_time->delay_s}}};
}

Drawn draw_hysteresis(Random& random, const Scale&, Departures& into) {
  const double half_width_V = random.log_uniform(0.001, 0.2);
  if (random.chance(0.5)) {
    into.bouc_wen = BoucWen{half_width_V};
    return {"valve_hysteresis", "Bouc-Wen", {{"half_width_V", half_width_V}}};
  }
  into.lugre = LuGre{half_width_V, random.uniform(0.0, 0.3)};
  return {"valve_hysteresis", "LuGre", {{"half_width_V", half_width_V}, {"stribeck", into.lugre->stribeck}}};
}

Drawn draw_null_drift(Random& random, const Scale&, Departures& into) {
  NullDrift drawn{};
  drawn.size_V = random.signed_log_uniform(0.002, 0.4);
  for (double& phase : drawn.phase) phase = random.angle();
  const unsigned course = random.below(3);
  const char* name = "";
  if (course == 0) {
    drawn.course = NullDrift::Course::kWarmUp;
    drawn.time_s = random.uniform(5.0, 20.0);
    name = "warm-up";
  } else if (course == 1) {
    drawn.course = NullDrift::Course::kRamp;
    drawn.time_s = random.uniform(25.0, 60.0);
    name = "ramp";
  } else {
    drawn.course = NullDrift::Course::kWander;
    drawn.time_s = random.uniform(20.0, 40.0);
    name = "wander";
  }
  into.null_drift = drawn;
  return {"null_drift", name, {{"size_V", drawn.size_V}, {"time_s", drawn.time_s}}};
}

Drawn draw_area_shape(Random& random, const Scale&, Departures& into) {
  const double size = random.log_uniform(0.005, 0.6);
  const double reach_V = random.uniform(2.0, 5.0);
  const unsigned form = random.below(3);
  std::array<double, 7> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double s = static_cast<double>(i) / 6.0;
    const double bow = s * (1.0 - s);
    values[i] = form == 0 ? s - size * std::sin(kTau * s) / kTau : s + (form == 1 ? -size : size) * bow;
  }
  into.area_shape = area_shape(reach_V, values);
  return {"area_shape",
          form == 0   ? "S-shaped table"
          : form == 1 ? "progressive table"
                      : "saturating table",
          {{"size", size}, {"reach_V", reach_V}}};
}

Drawn draw_flow_function(Random& random, const Scale&, Departures& into) {
  FlowFunction drawn{};
  if (random.chance(0.4)) {
    drawn.law = FlowFunction::Law::kDischarge;
    drawn.rise = random.signed_log_uniform(0.005, 0.6);
    into.flow_function = drawn;
    return {"flow_function", "discharge coefficient of the ratio", {{"rise", drawn.rise}}};
  }
  drawn.law = FlowFunction::Law::kEllipse;
  drawn.share = random.log_uniform(0.01, 1.0);
  drawn.critical_ratio = random.uniform(0.2, 0.45);
  drawn.cracking_ratio = random.chance(0.5) ? 1.0 : random.uniform(0.85, 1.0);
  drawn.subsonic_index = random.uniform(0.4, 0.65);
  into.flow_function = drawn;
  return {"flow_function",
          "ellipse",
          {{"share", drawn.share},
           {"critical_ratio", drawn.critical_ratio},
           {"cracking_ratio", drawn.cracking_ratio},
           {"subsonic_index", drawn.subsonic_index}}};
}

Drawn draw_supply_droop(Random& random, const Scale& scale, Departures& into) {
  if (random.chance(0.5)) {
    into.reservoir = Reservoir{scale.size * random.log_uniform(0.3e-3, 5e-3),
                               scale.size * random.log_uniform(2e-6, 80e-6)};
    return {"supply_droop",
            "vessel behind an orifice",
            {{"volume_m3", into.reservoir->volume_m3}, {"feed_m2", into.reservoir->feed_m2}}};
  }
  // Share of the supply that is lost when the port is open by two volts and choked.
  const double share = random.log_uniform(0.003, 0.3);
  into.regulator = Regulator{share * scale.supply_Pa / (scale.flow_kg_s_m2 * 2.0 * scale.area_per_V_m2),
                             random.log_uniform(0.01, 0.2)};
  return {"supply_droop",
          "regulator",
          {{"share_at_2_V", share},
           {"droop_Pa_s_kg", into.regulator->droop_Pa_s_kg},
           {"time_s", into.regulator->time_s}}};
}

Drawn draw_exhaust_backpressure(Random& random, const Scale& scale, Departures& into) {
  const double silencer_m2 = scale.size * random.log_uniform(2e-6, 60e-6);
  const double manifold_m3 = random.chance(0.5) ? scale.size * random.log_uniform(30e-6, 200e-6) : 0.0;
  into.silencer = Silencer{scale.flow_kg_s_m2 / scale.supply_Pa * silencer_m2, manifold_m3};
  return {"exhaust_backpressure",
          manifold_m3 > 0.0 ? "silencer behind a manifold" : "silencer",
          {{"silencer_m2", silencer_m2}, {"manifold_m3", manifold_m3}}};
}

Drawn draw_chamber_leak(Random& random, const Scale& scale, Departures& into) {
  // Both pass the same at about 5 bar for the same area.
  constexpr double kCapillary_kg_s_Pa_m2 = 7e-4;
  const double area_m2 = scale.size * random.log_uniform(0.0003e-6, 0.5e-6);
  const unsigned form = random.below(3);
  const double laminar = form == 0 ? 1.0 : form == 1 ? 0.0 : 0.5;
  into.chamber_leak = ChamberLeak{laminar * kCapillary_kg_s_Pa_m2 * area_m2, (1.0 - laminar) * area_m2};
  return {
      "chamber_leak",
      form == 0   ? "capillary"
      : form == 1 ? "hole"
                  : "capillary and hole",
      {{"capillary_kg_s_Pa", into.chamber_leak->capillary_kg_s_Pa}, {"hole_m2", into.chamber_leak->hole_m2}}};
}

Drawn draw_tube(Random& random, const Scale& scale, Departures& into) {
  const double length_m = random.log_uniform(0.05, 4.0);
  const auto cells = static_cast<std::size_t>(std::clamp(std::lround(length_m / 0.12), 1L, 12L));
  into.tube =
      Tube{length_m, std::sqrt(scale.size) * random.uniform(3e-3, 6e-3), random.uniform(0.02, 0.04), cells};
  return {"tube_dynamics",
          "distributed line",
          {{"length_m", length_m},
           {"bore_m", into.tube->bore_m},
           {"friction", into.tube->friction},
           {"cells", static_cast<double>(cells)}}};
}

Drawn draw_heat_transfer(Random& random, const Scale& scale, Departures& into) {
  const double wall = std::pow(scale.volume_m3 / 1e-4, 2.0 / 3.0);  // walls grow as the volume's two thirds
  into.wall_heat = WallHeat{wall * random.log_uniform(0.0005, 1.0), random.uniform(0.3, 0.8)};
  return {"heat_transfer",
          "wall, growing with pressure",
          {{"conductance_W_K", into.wall_heat->conductance_W_K}, {"exponent", into.wall_heat->exponent}}};
}

Drawn draw_volume_error(Random& random, const Scale& scale, Departures& into) {
  const bool late = random.chance(0.25);
  if (late && scale.moves) {  // at rest it would be no departure
    into.volume_lag = VolumeLag{random.log_uniform(5e-3, 0.15)};
    return {"volume_error", "position sensor late", {{"time_s", into.volume_lag->time_s}}};
  }
  double share = random.log_uniform(0.001, 0.3);
  if (random.chance(0.4)) share = -0.5 * share;
  into.volume_error = VolumeError{share * scale.volume_m3};
  return {"volume_error", "offset, bent", {{"offset_m3", into.volume_error->offset_m3}}};
}

Drawn draw_sensor_lag(Random& random, const Scale&, Departures& into) {
  into.sensor_lag =
      SensorLag{random.log_uniform(0.2e-3, 40e-3), random.chance(0.5) ? 0.0 : random.uniform(0.6, 1.2)};
  return {"sensor_lag",
          into.sensor_lag->damping == 0.0 ? "first order" : "second order",
          {{"time_s", into.sensor_lag->time_s}, {"damping", into.sensor_lag->damping}}};
}

Drawn draw_sensor_bias(Random& random, const Scale&, Departures& into) {
  const unsigned form = random.below(3);
  SensorBias drawn{0.0, 1.0};
  if (form != 1) drawn.offset_Pa = random.signed_log_uniform(150.0, 20e3);
  if (form != 0) drawn.gain = 1.0 + random.signed_log_uniform(7e-4, 0.05);
  into.sensor_bias = drawn;
  return {"sensor_bias",
          form == 0   ? "offset"
          : form == 1 ? "gain"
                      : "offset and gain",
          {{"offset_Pa", drawn.offset_Pa}, {"gain", drawn.gain}}};
}

Drawn draw_supply_pulsation(Random& random, const Scale&, Departures& into) {
  into.supply_pulsation =
      SupplyPulsation{random.log_uniform(0.03, 0.25), random.uniform(1.5, 8.0), random.angle()};
  return {"supply_pulsation",
          "compressor strokes",
          {{"share", into.supply_pulsation->share}, {"frequency_Hz", into.supply_pulsation->frequency_Hz}}};
}

Drawn draw_sticking_flapper(Random& random, const Scale&, Departures& into) {
  const double break_Pa = random.log_uniform(20e3, 150e3);
  into.sticking_flapper = StickingFlapper{break_Pa, break_Pa * random.uniform(0.1, 0.5)};
  return {
      "sticking_flapper", "latched", {{"break_Pa", break_Pa}, {"close_Pa", into.sticking_flapper->close_Pa}}};
}

Drawn draw_neighbour(Random& random, const Scale& scale, Departures& into) {
  into.neighbour = Neighbour{scale.supply_Pa * random.log_uniform(0.03, 0.25), random.uniform(0.3, 1.5),
                             random.uniform(0.2, 0.5), random.uniform()};
  return {"neighbour",
          "draws from the shared manifold",
          {{"drop_Pa", into.neighbour->drop_Pa},
           {"period_s", into.neighbour->period_s},
           {"duty", into.neighbour->duty}}};
}

Drawn draw_missed_steps(Random& random, const Scale&, Departures& into) {
  into.missed_steps =
      MissedSteps{random.log_uniform(0.01, 0.08), random.log_uniform(0.02, 0.2), random.bits()};
  return {"missed_steps",
          "stepper",
          {{"step_V", into.missed_steps->step_V}, {"missed", into.missed_steps->missed}}};
}

Drawn draw_volume_tremor(Random& random, const Scale& scale, Departures& into) {
  const double amplitude_m3 = scale.volume_m3 * random.log_uniform(0.001, 0.03);
  const double frequency_Hz = random.uniform(3.0, 15.0);
  into.volume_tremor = VolumeTremor{amplitude_m3, frequency_Hz, random.angle()};
  return {"volume_tremor",
          "vibration that the position sensor misses",
          {{"amplitude_m3", amplitude_m3}, {"frequency_Hz", frequency_Hz}}};
}

Drawn draw_lifting_seal(Random& random, const Scale& scale, Departures& into) {
  into.lifting_seal = LiftingSeal{scale.size * random.log_uniform(0.05e-6, 1e-6), random.uniform(0.2, 1.0),
                                  random.uniform(0.2, 0.5), random.bits()};
  return {"lifting_seal",
          "leak now and then",
          {{"area_m2", into.lifting_seal->area_m2},
           {"period_s", into.lifting_seal->period_s},
           {"duty", into.lifting_seal->duty}}};
}

}  // namespace

AreaShape area_shape(double reach_V, const std::array<double, 7>& values) {
  constexpr double kSpacing = 1.0 / 6.0;
  AreaShape shape{reach_V, values, {}};
  const auto secant = [&](std::size_t i) { return (values[i + 1] - values[i]) / kSpacing; };
  shape.slopes.front() = secant(0);
  shape.slopes.back() = secant(5);
  for (std::size_t i = 1; i < 6; ++i) {
    const double a = secant(i - 1), b = secant(i);
    shape.slopes[i] = a * b <= 0.0 ? 0.0 : 2.0 * a * b / (a + b);  // harmonic mean: no overshoot
  }
  return shape;
}

const std::vector<DepartureKind>& departure_kinds() {
  static const std::vector<DepartureKind> kinds{
      {"spool_lag", "command", true, draw_spool_lag, [](Departures& d) { d.spool_lag.reset(); }},
      {"dead_time", "command", true, draw_dead_time, [](Departures& d) { d.dead_time.reset(); }},
      {"valve_hysteresis", "command", true, draw_hysteresis,
       [](Departures& d) {
         d.bouc_wen.reset();
         d.lugre.reset();
       }},
      {"area_shape", "valve_area", true, draw_area_shape, [](Departures& d) { d.area_shape.reset(); }},
      {"null_drift", "command", true, draw_null_drift, [](Departures& d) { d.null_drift.reset(); }},
      {"flow_function", "mass_flow", true, draw_flow_function,
       [](Departures& d) { d.flow_function.reset(); }},
      {"supply_droop", "supply", true, draw_supply_droop,
       [](Departures& d) {
         d.reservoir.reset();
         d.regulator.reset();
       }},
      {"exhaust_backpressure", "mass_flow", true, draw_exhaust_backpressure,
       [](Departures& d) { d.silencer.reset(); }},
      {"chamber_leak", "mass_flow", true, draw_chamber_leak, [](Departures& d) { d.chamber_leak.reset(); }},
      {"tube_dynamics", "mass_flow", true, draw_tube, [](Departures& d) { d.tube.reset(); }},
      {"heat_transfer", "energy", true, draw_heat_transfer, [](Departures& d) { d.wall_heat.reset(); }},
      {"volume_error", "energy", true, draw_volume_error,
       [](Departures& d) {
         d.volume_error.reset();
         d.volume_lag.reset();
       }},
      {"sensor_lag", "sensor", true, draw_sensor_lag, [](Departures& d) { d.sensor_lag.reset(); }},
      {"sensor_bias", "sensor", true, draw_sensor_bias, [](Departures& d) { d.sensor_bias.reset(); }},
      {"supply_pulsation", "supply", false, draw_supply_pulsation,
       [](Departures& d) { d.supply_pulsation.reset(); }},
      {"sticking_flapper", "mass_flow", false, draw_sticking_flapper,
       [](Departures& d) { d.sticking_flapper.reset(); }},
      {"neighbour", "supply", false, draw_neighbour, [](Departures& d) { d.neighbour.reset(); }},
      {"missed_steps", "command", false, draw_missed_steps, [](Departures& d) { d.missed_steps.reset(); }},
      {"volume_tremor", "energy", false, draw_volume_tremor, [](Departures& d) { d.volume_tremor.reset(); }},
      {"lifting_seal", "mass_flow", false, draw_lifting_seal, [](Departures& d) { d.lifting_seal.reset(); }},
  };
  return kinds;
}

const DepartureKind& departure_kind(std::string_view id) {
  const auto& kinds = departure_kinds();
  const auto found =
      std::find_if(kinds.begin(), kinds.end(), [id](const DepartureKind& kind) { return kind.id == id; });
  if (found != kinds.end()) return *found;
  std::vector<std::string_view> known;
  known.reserve(kinds.size());
  for (const DepartureKind& kind : kinds) known.push_back(kind.id);
  throw std::invalid_argument(
      fmt::format("effect '{}' is not known, expected one of {}", id, fmt::join(known, ", ")));
}

}  // namespace plenum::host::blind
