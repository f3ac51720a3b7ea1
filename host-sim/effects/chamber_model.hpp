// The chamber with its valve, and whichever effects are on: the one place where the effects meet.
//
//   p' = n (R T (a_c(x) phi(P, p) - a_r(x) phi(p, Q) - leak)/v - p v'/v)                       (1)-(4)
//
// `N` is a number or lanes of numbers. A tick is cut into equal steps. In each, the areas are taken in the mean
// and the volume at its middle, and the pressure moves by the exponential rule with the chord of its rate,
//   p1 = p + h phi_1(h J) f(p),   S = (f(p1) - f(p))/(p1 - p),   p+ = p + h phi_1(h S) f(p),
//   mean = p + h phi_2(h S) f(p):
// stable at any step, exact where the rate is linear in p, second order elsewhere; the chord settles on the right
// end where the rate is a square root, at equal pressures. Behind a dead time the pressure moves in two, before the
// valve does and after; areas that a spool changes within the step enter by their first moment, too, but for those of a
// hose: what flows sooner counts longer in the mean. Source: "Modeling and Identification of Pneumatic
// Actuators" (1)-(4); Hochbruck and Ostermann, Acta Numerica 19 (2010).
#pragma once

#include <span>

#include "host-sim/effects/catalogue.hpp"
#include "host-sim/plant/gas.hpp"

namespace plenum::host::effects {

/// What is known of the rig and not fitted.
struct Surroundings {
  plant::Gas gas;  ///< of kappa 1.4: the flow function is calculated in sevenths
  double supply_Pa = 700000.0;
  double ambient_Pa = 101325.0;
  double discharge_coefficient = 0.72;
  /// In the mean over the first log, for all logs of a fit: what effects bend about.
  double volume_m3 = kSizedForVolume_m3;
};

struct Timing {
  double tick_s = 0.01;
  double average_s = 0.01;  ///< the sensor's mean is over this time before the end of a tick; 0: an instant
  int steps = 4;            ///< of a tick
};

template <class N>
class ChamberModel {
 public:
  /// `figures` must outlive the model. The chamber begins at rest: spool on `command_V`, and gas that has
  /// `start_warmth_Pa` to lose as it comes to the wall's temperature.
  ChamberModel(const Surroundings& around, const Timing& timing, EffectSet on, const N* figures,
               const N& start_Pa, double command_V, double volume_m3, const N& start_warmth_Pa = N(0.0));

  /// What the log says of the supply in the tick to come: for supply_droop, where it follows that.
  void follow_supply(double logged_Pa) { supply_droop_.follow(logged_Pa); }

  /// One tick with `command_V` held; returns the sensor's reading at its end. `volume_m3`: at the ends of the steps,
  /// one more than there are steps, and of as many as are known of those that follow.
  N tick(double command_V, std::span<const double> volume_m3);

  const N& pressure_Pa() const { return pressure_Pa_; }
  /// What the sensor reads while the pressure rests.
  N resting_reading_Pa() const {
    return on(kIdSensorBias) ? sensor_bias_.reading(pressure_Pa_) : pressure_Pa_;
  }

 private:
  /// Of a step: the means of the areas, and how much sooner than evenly they are open, int (1/2 - s) area ds, 0 <= s <= 1.
  struct Openings {
    N inlet_m2{}, exhaust_m2{};
    N inlet_sooner_m2{}, exhaust_sooner_m2{};
  };
  /// The same of two parts of a step, the first of which lasts for `share` of it.
  struct Halves {
    Openings first, second;
    N share;
  };
  struct Flow {
    N flow, by_upstream, by_downstream;
  };
  /// Where a step or a part of it leads: pressure, and its mean; flows in the mean.
  struct Advance {
    N end_Pa{}, mean_Pa{}, inlet{}, exhaust{};
  };
  struct Balance {
    N rate, slope, inlet, exhaust, exhaust_slope;
    N sooner;  ///< of the rate
  };

  static constexpr int kSpoolParts = 3;

  bool on(Id id) const { return (on_ >> id & 1U) != 0; }
  /// Behind a dead time alone in two, too: into `halves`.
  Openings openings_over(double command_V, int step, Halves& halves);
  bool in_halves() const { return on(kIdDeadTime) && !on(kIdSpoolLag); }
  Openings openings(const N& command_V) const;
  Flow inlet_plate(const N& supply_Pa, const N& chamber_Pa) const {
    return plate(supply_Pa, chamber_Pa, false);
  }
  Flow exhaust_plate(const N& chamber_Pa, const N& behind_Pa) const {
    return plate(chamber_Pa, behind_Pa, true);
  }
  Flow plate(const N& first_Pa, const N& second_Pa, bool exhaust) const;
  /// From the first of two pressures to the second, of a flow from the higher to the lower and its slopes in these.
  template <class Mask>
  static Flow directed(const Mask& backwards, const N& flow, const N& by_up, const N& by_down) {
    return {select(backwards, -flow, flow), select(backwards, -by_down, by_up),
            select(backwards, -by_up, by_down)};
  }
  Balance balance(const N& pressure_Pa, const Openings& open, const N& supply_Pa, const N& behind_Pa) const;
  N step(const Openings& open, const N& volume_m3, const N& squeeze_1_s, const Halves* halves);
  /// Where the sensor sits.
  N read_Pa() const { return on(kIdTubeDynamics) ? tube_.read_Pa(pressure_Pa_) : pressure_Pa_; }

  Timing timing_;
  EffectSet on_;
  const N* valve_;
  double gas_J_kg_, step_s_;
  double alpha_, critical_, choked_;  ///< (11), 1/theta of (13), phi at choking for each Pa over alpha
  N supply_Pa_, ambient_Pa_;
  N pressure_Pa_;

  DeadTime<N> dead_time_;
  ValveHysteresis<N> hysteresis_;
  SpoolLag<N> spool_;
  NullDrift<N> null_drift_;
  AreaShape<N> area_shape_;
  FlowFunction<N> flow_function_;
  SupplyDroop<N> supply_droop_;
  ExhaustBackpressure<N> backpressure_;
  ChamberLeak<N> leak_;
  TubeDynamics<N> tube_;
  HeatTransfer<N> heat_;
  VolumeError<N> volume_error_;
  SensorLag<N> sensor_lag_;
  SensorBias<N> sensor_bias_;
};

template <class N>
ChamberModel<N>::ChamberModel(const Surroundings& around, const Timing& timing, EffectSet on,
                              const N* figures, const N& start_Pa, double command_V, double volume_m3,
                              const N& start_warmth_Pa)
    : timing_(timing),
      on_(on),
      valve_(figures),
      gas_J_kg_(around.gas.specific_gas_constant_J_kg_K() * around.gas.temperature_K),
      step_s_(timing.tick_s / timing.steps),
      supply_Pa_(around.supply_Pa),
      ambient_Pa_(around.ambient_Pa),
      pressure_Pa_(start_Pa) {
  const plant::ThinPlateConstants plate =
      plant::thin_plate_constants(around.gas, around.discharge_coefficient);
  alpha_ = plate.alpha_s_m;
  critical_ = 1.0 / plate.theta;
  choked_ = plate.beta_s_m / plate.alpha_s_m;
  const auto x = [&](Id id) { return figures + kFirstFigure[id]; };
  dead_time_.prepare(x(kIdDeadTime), timing.tick_s, command_V);
  hysteresis_.prepare(x(kIdValveHysteresis), command_V);
  spool_.prepare(x(kIdSpoolLag), step_s_ / kSpoolParts, command_V,
                 0.5 * (valve_[kOpenAbove] + valve_[kExhaustBelow]));
  null_drift_.prepare(x(kIdNullDrift), timing.tick_s);
  area_shape_.prepare(x(kIdAreaShape));
  flow_function_.prepare(x(kIdFlowFunction));
  supply_droop_.prepare(x(kIdSupplyDroop), step_s_, supply_Pa_);
  backpressure_.prepare(x(kIdExhaustBackpressure), gas_J_kg_, around.gas.kappa, step_s_, ambient_Pa_);
  leak_.prepare(x(kIdChamberLeak), ambient_Pa_, around.volume_m3, volume_m3);
  tube_.prepare(x(kIdTubeDynamics), gas_J_kg_, around.gas.kappa, step_s_, start_Pa);
  volume_error_.prepare(x(kIdVolumeError), around.volume_m3);
  N volume = on_ & (1U << kIdVolumeError) ? volume_error_.volume(volume_m3) : N(volume_m3);
  if ((on_ & (1U << kIdTubeDynamics)) != 0) volume += tube_.at_chamber_m3();
  heat_.prepare(x(kIdHeatTransfer), around.gas.specific_gas_constant_J_kg_K(), around.ambient_Pa,
                (start_Pa - start_warmth_Pa) * volume * (1.0 / gas_J_kg_));
  sensor_lag_.prepare(x(kIdSensorLag), step_s_, start_Pa);
  sensor_bias_.prepare(x(kIdSensorBias), around.ambient_Pa, around.supply_Pa, timing.tick_s, command_V,
                       0.5 * (valve_[kOpenAbove] + valve_[kExhaustBelow]));
}

/// The openings over a step. Their mean is not the opening at the mean command: a command or a spool on its way
/// from one port to the other crosses the valve's null. With a spool the step's thirds are averaged.
template <class N>
typename ChamberModel<N>::Openings ChamberModel<N>::openings_over(double command_V, int step,
                                                                  Halves& halves) {
  const auto stuck = [&](const N& u) { return on(kIdValveHysteresis) ? hysteresis_.follow(u) : u; };
  const auto drifted = [&](const N& x) { return on(kIdNullDrift) ? null_drift_.at(x) : x; };
  const auto share = [&](double parts) { return (step + parts) / timing_.steps; };
  if (on(kIdSpoolLag)) {
    Openings sum{N(0.0), N(0.0)};
    for (int i = 0; i < kSpoolParts; ++i) {
      const double sooner = 0.5 - (i + 0.5) / kSpoolParts;
      const N u = on(kIdDeadTime) ? dead_time_
                                        .during(share(static_cast<double>(i) / kSpoolParts),
                                                share(static_cast<double>(i + 1) / kSpoolParts))
                                        .mean()
                                  : N(command_V);
      const Openings open = openings(drifted(spool_.follow(stuck(u))));
      sum.inlet_m2 += (1.0 / kSpoolParts) * open.inlet_m2;
      sum.exhaust_m2 += (1.0 / kSpoolParts) * open.exhaust_m2;
      sum.inlet_sooner_m2 += (sooner / kSpoolParts) * open.inlet_m2;
      sum.exhaust_sooner_m2 += (sooner / kSpoolParts) * open.exhaust_m2;
    }
    return sum;
  }
  if (on(kIdDeadTime)) {
    const auto held = dead_time_.during(share(0.0), share(1.0));
    const Openings first = openings(drifted(stuck(held.first)));
    const Openings second = openings(drifted(stuck(held.second)));
    halves = {first, second, held.share};
    return {second.inlet_m2 + held.share * (first.inlet_m2 - second.inlet_m2),
            second.exhaust_m2 + held.share * (first.exhaust_m2 - second.exhaust_m2), N(0.0), N(0.0)};
  }
  return openings(drifted(stuck(N(command_V))));
}

/// (3), with a gain a port and the width w.
template <class N>
typename ChamberModel<N>::Openings ChamberModel<N>::openings(const N& command_V) const {
  N inlet_V = command_V - valve_[kOpenAbove];
  N exhaust_V = valve_[kExhaustBelow] - command_V;
  if (on(kIdAreaShape)) {
    inlet_V = area_shape_.inlet(inlet_V);
    exhaust_V = area_shape_.exhaust(exhaust_V);
  }
  const N w2 = valve_[kTransition] * valve_[kTransition];
  const N to_supply = valve_[kInletGain] * inlet_V - valve_[kInletLeak];
  const N to_ambient = valve_[kExhaustGain] * exhaust_V - valve_[kExhaustLeak];
  return {valve_[kInletLeak] + 0.5 * (root(to_supply * to_supply + w2) + to_supply),
          valve_[kExhaustLeak] + 0.5 * (root(to_ambient * to_ambient + w2) + to_ambient), N(0.0), N(0.0)};
}

/// phi(p_1, p_2) of (1b) over a square metre, with its slopes. Within 1e-4 of equal pressures the root of (1c) goes
/// over into its chord. Where every lane is choked, as an exhaust is most of the time, nothing of (1c) is calculated.
template <class N>
typename ChamberModel<N>::Flow ChamberModel<N>::plate(const N& first_Pa, const N& second_Pa,
                                                      bool exhaust) const {
  constexpr double kLaminar = 3e-5;
  const auto backwards = first_Pa < second_Pa;
  const N up = larger(first_Pa, second_Pa);
  const N ratio = smaller(first_Pa, second_Pa) / up;
  const N r = larger(on(kIdFlowFunction) ? flow_function_.ratio(ratio, exhaust) : ratio, N(critical_));
  if (!any(r > N(critical_))) {
    const N G = on(kIdFlowFunction) ? choked_ * flow_function_.discharge(ratio) : N(choked_);
    return directed(backwards, alpha_ * up * G, alpha_ * G, N(0.0));
  }
  // G = q^5 w, q = r^(1/7), w = sqrt(1 - q^2)
  N s = 1.3417914215325433 + r * (-0.6825335151030851 + r * (0.48550449020479086 - r * 0.14480858119683884));
  const N s2 = s * s;
  const N s4 = s2 * s2;
  const N e = 1.0 - r * s4 * s2 * s;
  s *= 1.0 + e * (1.0 / 7.0 + e * (4.0 / 49.0 + e * (20.0 / 343.0)));
  const N t2 = s * s;
  const N q = r * t2 * t2 * t2;
  const N q2 = q * q;
  const N q4 = q2 * q2;
  const N w2 = (1.0 + q) * (1.0 - r) / (q4 * q2 + (1.0 + q) * (1.0 + q2 + q4));
  const N per_w = 1.0 / root(larger(w2, N(kLaminar)));
  N G = q4 * q * w2 * per_w;
  // dG/dr = (5 w^2 - q^2)/(7 q^2 w); zero where choked, the chord's where laminar
  N by_ratio = select(w2 < N(kLaminar), -0.2857 * per_w, (5.0 * w2 - q2) / (7.0 * q2) * per_w);
  by_ratio = select(r > N(critical_), by_ratio, N(0.0));
  if (on(kIdFlowFunction)) {
    const N factor = flow_function_.factor(G * (1.0 / choked_), ratio);
    G = G * factor;
    by_ratio = by_ratio * factor;
  }
  return directed(backwards, alpha_ * up * G, alpha_ * (G - ratio * by_ratio), alpha_ * by_ratio);
}

/// Net mass flow [kg/s] through valve and leak, its slope in the pressure at the valve, and the ports' flows.
template <class N>
typename ChamberModel<N>::Balance ChamberModel<N>::balance(const N& pressure_Pa, const Openings& open,
                                                           const N& supply_Pa, const N& behind_Pa) const {
  const Flow inlet = inlet_plate(supply_Pa, pressure_Pa);
  const Flow exhaust = exhaust_plate(pressure_Pa, behind_Pa);
  const N in = open.inlet_m2 * inlet.flow;
  const N out = open.exhaust_m2 * exhaust.flow;
  const N out_slope = open.exhaust_m2 * exhaust.by_upstream;
  return {in - out,  open.inlet_m2 * inlet.by_downstream - out_slope,
          in,        out,
          out_slope, open.inlet_sooner_m2 * inlet.flow - open.exhaust_sooner_m2 * exhaust.flow};
}

/// One step: moves the pressure, returns its mean where the sensor sits. What the flows of the step change slowly (supply,
/// pressure behind the exhaust, mass of the gas) enters as the flows at its beginning will have made it by its middle.
template <class N>
N ChamberModel<N>::step(const Openings& open, const N& volume_m3, const N& squeeze_1_s,
                        const Halves* halves) {
  const N begin = pressure_Pa_;
  const N& at_valve = on(kIdTubeDynamics) ? tube_.at_valve_Pa() : pressure_Pa_;
  N supply = supply_Pa_;
  N behind = ambient_Pa_;
  const N n = on(kIdHeatTransfer) ? heat_.exponent() : N(1.4);
  const N per_mass = n * gas_J_kg_ / volume_m3;  // Pa for a kilogram
  if (on(kIdSupplyDroop)) {
    const Flow now = inlet_plate(supply_droop_.supply_Pa(), at_valve);
    supply = supply_droop_.supply_at_middle_Pa(open.inlet_m2 * now.flow, open.inlet_m2 * now.by_upstream);
  }
  if (on(kIdExhaustBackpressure)) {
    const N fall = on(kIdTubeDynamics) ? N(0.0) : 0.5 * step_s_ * per_mass;
    behind = backpressure_.behind_at_middle_Pa(at_valve, fall, [&](const N& from_Pa, const N& behind_Pa) {
      const Flow now = exhaust_plate(from_Pa, behind_Pa);
      return Flow{open.exhaust_m2 * now.flow, open.exhaust_m2 * now.by_upstream,
                  open.exhaust_m2 * now.by_downstream};
    });
  }
  N compression = n * squeeze_1_s;
  N pull(0.0);  // of the heat on the rate, at p = 0
  // `exhaust_kg_s`: of what leaves as warm as the gas is, at T_0; the net flow has it at T_0, too
  const auto warm = [&](const N& net_kg_s, const N& exhaust_kg_s) {
    if (!on(kIdHeatTransfer)) return;
    const N& leaving = heat_.leaving();  // as in the step before
    const N mass = heat_.mass_kg() + 0.5 * step_s_ * (net_kg_s + exhaust_kg_s * (1.0 - 1.0 / leaving));
    const N at_wall = mass * gas_J_kg_ / volume_m3;  // the pressure of this mass at the wall's temperature
    const N flow_kg_s = net_kg_s + exhaust_kg_s * (1.0 - leaving);
    const N relaxation = heat_.relaxation_at_middle_1_s(
        mass, begin, 0.5 * step_s_ * (per_mass * flow_kg_s - compression * begin), 0.5 * step_s_, at_wall,
        volume_m3);
    compression += relaxation;
    pull = relaxation * at_wall;
  };

  N inlet, exhaust, mean, mean_read;
  if (on(kIdTubeDynamics)) {
    N leak(0.0), leak_slope(0.0);
    if (on(kIdChamberLeak)) {
      leak = leak_.flow(begin);
      leak_slope = leak_.slope(begin);
    }
    warm(tube_.flow_kg_s() - leak, N(0.0));
    inlet = exhaust = mean = mean_read = N(0.0);
    const auto advance = [&](const Openings& ports, const N& part) {
      const auto valve = [&](const N& at_valve_Pa, double share) {
        const Balance b = balance(at_valve_Pa, ports, supply, behind);
        inlet += part * share * b.inlet;
        exhaust += part * share * b.exhaust;
        return b;
      };
      const auto moved = tube_.advance(
          pressure_Pa_,
          {per_mass, pull - per_mass * (leak - leak_slope * begin), compression + per_mass * leak_slope},
          {behind, supply}, valve, part);
      pressure_Pa_ = moved.end_Pa;
      mean += part * moved.mean_Pa;
      mean_read += part * moved.mean_read_Pa;
    };
    if (halves == nullptr) {
      advance(open, N(1.0));
    } else {
      advance(halves->first, halves->share);
      advance(halves->second, 1.0 - halves->share);
    }
  } else {
    const auto with_leak = [&](Balance b, const N& p) {
      if (on(kIdChamberLeak)) {
        b.rate -= leak_.flow(p);
        b.slope -= leak_.slope(p);
      }
      return b;
    };
    // The enthalpy that leaves is that of gas as warm as it is; what comes back in is not.
    const auto leaving = [&](Balance b) {
      if (on(kIdHeatTransfer)) {
        const N more = select(b.exhaust > N(0.0), heat_.leaving() - 1.0, N(0.0));
        b.rate -= more * b.exhaust;
        b.slope -= more * b.exhaust_slope;
      }
      return b;
    };
    // Over `span_s` with these openings, from a pressure whose balance without warmth is `cool`.
    const auto advance = [&](const N& from, const Openings& ports, const Balance& cool, const N& span_s) {
      const Balance first = leaving(cool);
      const N f = per_mass * first.rate - compression * from + pull;
      const N J = per_mass * first.slope - compression;
      const N trial = larger(from + span_s * exponential(span_s * J).phi_1 * f, N(1e3));
      const Balance second = leaving(with_leak(balance(trial, ports, supply, behind), trial));
      const N f_trial = per_mass * second.rate - compression * trial + pull;
      const N way = trial - from;
      const N chord =
          select(magnitude(way) < N(0.1), J, (f_trial - f) / select(magnitude(way) < N(0.1), N(1.0), way));
      const Exponential<N> z = exponential(smaller(span_s * chord, N(1.0)));
      Advance made{from + span_s * z.phi_1 * f, from + span_s * z.phi_2 * f,
                   0.5 * (first.inlet + second.inlet), 0.5 * (first.exhaust + second.exhaust)};
      if (on(kIdSpoolLag)) {
        // What flows sooner is in the mean longer, and has longer to decay; but it meets the flow of the step's begin, from
        // which it takes as much at the end: of one port alone the end knows the mean area only.
        const N moved = span_s * per_mass;
        made.end_Pa += moved * (z.e * first.sooner - second.sooner);
        made.mean_Pa += moved * z.phi_1 * first.sooner;
      }
      made.end_Pa = larger(made.end_Pa, N(1e3));
      return made;
    };
    const auto cool_at = [&](const N& p, const Openings& ports) {
      return with_leak(balance(p, ports, supply, behind), p);
    };
    const Balance cool = cool_at(begin, open);
    warm(cool.rate, larger(cool.exhaust, N(0.0)));
    Advance made;
    if (halves == nullptr) {
      made = advance(begin, open, cool, N(step_s_));
    } else {
      const N& share = halves->share;
      made = advance(begin, halves->first, cool_at(begin, halves->first), step_s_ * share);
      const Advance then =
          advance(made.end_Pa, halves->second, cool_at(made.end_Pa, halves->second), step_s_ * (1.0 - share));
      const auto mean_of = [&](const N& of_first, const N& of_second) {
        return share * of_first + (1.0 - share) * of_second;
      };
      made = {then.end_Pa, mean_of(made.mean_Pa, then.mean_Pa), mean_of(made.inlet, then.inlet),
              mean_of(made.exhaust, then.exhaust)};
    }
    pressure_Pa_ = made.end_Pa;
    mean = mean_read = made.mean_Pa;
    inlet = made.inlet;
    exhaust = made.exhaust;
  }
  if (on(kIdSupplyDroop)) supply_droop_.draw(inlet);
  if (on(kIdExhaustBackpressure)) backpressure_.vent(exhaust);
  if (on(kIdHeatTransfer)) {
    // the mass that the step's own balance of energy has moved, and of what left warm so much less
    const N out = on(kIdTubeDynamics) ? N(0.0) : larger(exhaust, N(0.0));
    const N warmer = out * (heat_.leaving() - 1.0 / heat_.leaving());
    heat_.gain((pressure_Pa_ - begin + step_s_ * (compression * mean - pull)) / per_mass + step_s_ * warmer,
               pressure_Pa_ * volume_m3 / gas_J_kg_);
  }
  return mean_read;
}

template <class N>
N ChamberModel<N>::tick(double command_V, std::span<const double> volume_m3) {
  if (on(kIdDeadTime)) dead_time_.hold(command_V);
  if (on(kIdSensorBias)) sensor_bias_.tick(command_V);
  N sum(0.0);
  N reading(0.0);
  const double averaged = std::min(timing_.average_s / step_s_, static_cast<double>(timing_.steps));  // steps
  N rise(0.0);  // over these, or the last where an instant is read
  const double risen = averaged > 0.0 ? averaged : 1.0;
  const bool opens_on = on(kIdDeadTime) || on(kIdSpoolLag);  // within the tick
  Openings open;
  Halves halves{};
  for (int i = 0; i < timing_.steps; ++i) {
    if (i == 0 || opens_on) open = openings_over(command_V, i, halves);
    const std::span<const double> ends_m3 = volume_m3.subspan(static_cast<std::size_t>(i));
    const double logged = 0.5 * (ends_m3[0] + ends_m3[1]);
    const typename VolumeError<N>::Motion actual =
        on(kIdVolumeError)
            ? volume_error_.step(ends_m3, step_s_)
            : typename VolumeError<N>::Motion{N(logged), N((ends_m3[1] - ends_m3[0]) * (1.0 / step_s_))};
    if (on(kIdChamberLeak)) leak_.at(logged);
    const N begin = read_Pa();
    const N volume = on(kIdTubeDynamics) ? actual.volume_m3 + tube_.at_chamber_m3() : actual.volume_m3;
    N mean = step(open, volume, actual.rate_m3_s / volume,
                  in_halves() && any(halves.share < N(1.0)) ? &halves : nullptr);
    N from = begin;  // of the reading
    N end = read_Pa();
    if (on(kIdSensorLag)) {
      from = sensor_lag_.reading_Pa();
      mean = sensor_lag_.follow(begin, end, mean);
      end = sensor_lag_.reading_Pa();
    }
    const int later = timing_.steps - 1 - i;
    sum += last_share(averaged - later, from, mean, end);
    rise += std::clamp(risen - later, 0.0, 1.0) * (end - from);
    reading = end;
  }
  if (on(kIdNullDrift)) null_drift_.end_tick();
  if (averaged > 0.0) reading = sum * (1.0 / averaged);
  reading += (1.0 / (risen * step_s_)) * valve_[kStampedEarly] * rise;
  return on(kIdSensorBias) ? sensor_bias_.reading(reading) : reading;
}

}  // namespace plenum::host::effects
