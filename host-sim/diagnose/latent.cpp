#include "host-sim/diagnose/latent.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <span>

#include "host-sim/diagnose/linear_chamber.hpp"
#include "host-sim/identify/in_parallel.hpp"

namespace plenum::host::diagnose {
namespace {

using effects::Equation;
using effects::Figures;
using effects::kValveFigures;

/// What a term, or the disturbance, of size one does to a tick's inputs, and to its reading directly.
struct Action {
  Inputs input{};
  double reading = 0.0;
  double own = 0.0;  // the same in the unit of the equation's disturbance
};

struct Term {
  std::string group;
  double spread = 1.0;  // standard deviation expected
};

/// One at a centre, falling to zero at its neighbours; flat beyond the ends.
double hat(std::span<const double> centres, std::size_t i, double x) {
  if (i > 0 && x < centres[i])
    return std::clamp((x - centres[i - 1]) / (centres[i] - centres[i - 1]), 0.0, 1.0);
  if (i + 1 < centres.size() && x > centres[i])
    return std::clamp((centres[i + 1] - x) / (centres[i + 1] - centres[i]), 0.0, 1.0);
  return 1.0;
}

struct Noise {
  double size = 0.0, memory_s = 0.0;
};

/// The flow m = flow(m) of a restriction behind another, between 0 and `open`, that without the other: flow() falls
/// with m. By false position, Illinois' way.
template <class Function>
double in_series(double open, const Function& flow) {
  double low = 0.0;
  double at_low = flow(0.0);
  double high = open;
  double at_high = flow(open) - open;
  if (at_low * at_high >= 0.0) return open;
  double m = open;
  for (int i = 0; i < 6; ++i) {
    m = high - at_high * (high - low) / (at_high - at_low);
    const double at = flow(m) - m;
    if (at * at_high < 0.0) {
      low = high;
      at_low = at_high;
    } else {
      at_low *= 0.5;
    }
    high = m;
    at_high = at;
    if (at == 0.0) break;
  }
  return m;
}

constexpr std::size_t kLeastRows = 50;
/// A form that no term holds leaves hundreds of nats at the wrong equation's advantage: with this the answers given with
/// 0.92 were right in 0.94 of 99 blind cases, those with 0.5 in 0.6.
constexpr double kTemper = 12.0;

/// One equation under suspicion.
class Suspect {
 public:
  Suspect(const Scene& scene, const std::vector<const Record*>& records, const Figures& recalibrated,
          Equation equation)
      : scene_(scene), chamber_(scene), records_(records), equation_(equation) {
    figures_ = recalibrated;
    gain_ = 0.5 * (scene.nominal[effects::kInletGain] + scene.nominal[effects::kExhaustGain]);
    for (const Record* record : records) {
      Track t;
      const std::size_t ticks = record->rows() - 1;
      for (std::size_t k = 0; k < ticks; ++k) {
        t.about.pressure.push_back(record->measured_Pa[k]);
        t.about.middle_Pa.push_back(record->measured_Pa[k]);
      }
      t.about.d.assign(ticks, 0.0);
      t.begin_Pa = record->measured_Pa.front();
      tracks_.push_back(std::move(t));
    }
    flow_scale_ = gain_ * chamber_.plate().phi(scene.around.supply_Pa, scene.around.ambient_Pa);
    name_terms();
    weigh_lags();
    term_.assign(terms_.size(), 0.0);
  }

  LatentEquation examine() {
    noise_ = {start_size(), 0.3};
    double at = sweep();
    double damping = 0.0;
    for (int pass = 0; pass < kPasses; ++pass) {
      const double begun = at;
      // what ticks taken as linear promise is believed when a sweep has shown it
      for (const bool near : {false, true}) {
        const Point before = present();
        choose_noise(near);
        renew();
        const double l = sweep();
        if (l > at) {
          at = l;
          break;
        }
        go_back(before);
        if (near) sweep();
      }
      const System system = evaluate();
      const Point before = present();
      for (int attempt = 0; attempt < kAttempts; ++attempt) {
        take(system.change(damping));
        const double l = sweep();
        if (l > at) {
          at = l;
          damping = damping > 0.02 ? 0.1 * damping : 0.0;
          break;
        }
        damping = std::max(10.0 * damping, 0.01);
        go_back(before);
        if (attempt + 1 == kAttempts) sweep();
      }
      if (at < begun + kWorthAPass) break;
    }
    smooth();
    log_likelihood_ = at - evaluate().occam;
    return answer();
  }

 private:
  static constexpr int kPasses = 8;
  static constexpr int kAttempts = 3;
  static constexpr double kWorthAPass = 5.0;  // [nat]

  /// What the filter expected of each tick before its reading, which the terms are taken at (a pressure that knows the
  /// reading would explain it), and the disturbance that the inputs are taken at.
  struct About {
    std::vector<double> pressure, middle_Pa, d;
  };
  struct Track {
    double begin_Pa = 0.0;
    About about;
    std::vector<double> smooth_d;  // the next to take the inputs at
    std::vector<double> at_Pa;     // the filter's pressure, about which each tick is linear
    std::vector<Inputs> inputs;
    std::vector<Action> act;  // [tick][term]
    std::vector<Action> disturb;
    std::vector<std::array<double, 4>> figure_inlet,
        figure_exhaust;  // [part of a tick]: of an area by a figure
    std::vector<Linear> linear;
    std::vector<double> sensor;  // what the sensor adds
    std::vector<Outcome> by_d;
    std::vector<double> columns;  // [tick][end, reading][figures, terms]
    std::vector<double> rough;    // [Pa] of a tick that no equation is to blame for
  };

  struct Point {
    Figures figures{};
    std::vector<double> term;
    Noise noise;
    std::vector<About> about;  // a record
  };

  /// The normal equations of figures and terms, whitened.
  struct System {
    double occam = 0.0;  // [nat] what the terms' freedom costs
    Eigen::MatrixXd H;
    Eigen::VectorXd g;

    Eigen::VectorXd change(double damping) const {
      Eigen::MatrixXd damped = H;
      damped.diagonal() *= 1.0 + damping;
      const Eigen::VectorXd scale = damped.diagonal().cwiseSqrt().cwiseInverse();
      const Eigen::MatrixXd scaled = scale.asDiagonal() * damped * scale.asDiagonal();
      return scale.cwiseProduct(scaled.ldlt().solve(scale.cwiseProduct(g)));
    }
  };

  std::size_t columns() const { return kValveFigures + terms_.size(); }

  void name_terms() {
    const auto add = [&](const char* group, double spread, std::size_t count) {
      for (std::size_t i = 0; i < count; ++i) terms_.push_back({group, spread});
    };
    constexpr double kNever = 1e-9;  // at rest a volume error is a gain of both ports
    const bool moves = volume_moves();
    switch (equation_) {
      case Equation::command:
        add("the command before", 0.5, kLagParts.size());
        add("the command's reversals", 0.5, kPlays_V.size());
        break;
      case Equation::valve_area:
        add("the supply port's opening", 0.3, kOpenings.size() - 1);
        add("the exhaust port's opening", 0.3, kOpenings.size() - 1);
        break;
      case Equation::mass_flow:
        add("the pressure ratio", 0.3, kRatios.size() - 1);
        add("the pressure ratio", 0.3, kRatios.size() - 1);
        add("the pressure", 0.3, 2);
        add("the exhaust flow", 0.5, kSilencers.size());
        add("the flow before", 0.5, kFlowLags.size());
        add("the flow's way to the chamber", 0.5, kWays.size());
        add("the flow's way to the chamber", moves ? 0.2 : kNever, 1);
        break;
      case Equation::supply:
        add("the flow drawn", 0.1, kSupply_s.size() + 1);
        break;
      case Equation::energy:
        add("the gas's temperature", 0.5, 2 * kHeat_s.size());
        add("the volume", moves ? 0.2 : kNever, 2);
        add("the volume's motion", moves ? 0.5 : kNever, kVolumeLags.size() + 1);
        break;
      case Equation::sensor:
        add("the pressure's rate", 0.5, kSensorLags.size() + 1);
        add("the pressure", 0.05, 3);
        break;
    }
  }

  void weigh_lags() {
    for (std::size_t j = 0; j < kLagParts.size(); ++j) {
      const int from = j > 0 ? kLagParts[j - 1] : 0;
      const int middle = kLagParts[j];
      const int to = j + 1 < kLagParts.size() ? kLagParts[j + 1] : middle + 1;
      const double sum = 0.5 * (to - from);
      lagging_.emplace_back();
      for (int part = 0; part < kParts; ++part) {
        auto& weights = lagging_.back()[static_cast<std::size_t>(part)];
        for (int lag = from + 1; lag < to; ++lag) {
          const double weight = lag <= middle ? static_cast<double>(lag - from) / (middle - from)
                                              : static_cast<double>(to - lag) / (to - middle);
          const auto ago = static_cast<std::size_t>((lag - part + kParts - 1) / kParts);
          if (ago == 0) continue;
          if (weights.empty() || weights.back().first != ago) weights.emplace_back(ago, 0.0);
          weights.back().second += weight / sum;
        }
      }
    }
  }

  bool volume_moves() const {
    return std::any_of(records_.begin(), records_.end(), [](const Record* record) {
      const auto [low, high] =
          std::minmax_element(record->drive.volume_m3.begin(), record->drive.volume_m3.end());
      return *high - *low > 0.02 * *low;
    });
  }

  double start_size() const {
    switch (equation_) {
      case Equation::command:
      case Equation::valve_area:
      case Equation::mass_flow:
        return 0.05;
      case Equation::supply:
        return 0.02;
      case Equation::energy:
        return 0.5;
      case Equation::sensor:
        return 0.01;
    }
    return 0.0;
  }
  double per_unit() const {  // of the disturbance as reported, in that of the filter
    switch (equation_) {
      case Equation::supply:
      case Equation::sensor:
        return scene_.around.supply_Pa;
      case Equation::mass_flow:
        return flow_scale_;
      default:
        return 1.0;
    }
  }
  Ports ports(double u) const { return ports_of(figures_, u); }

  /// What the terms of an equation are made of, a tick.
  struct Background {
    const Record* record = nullptr;
    std::vector<double> u;
    std::vector<Ports> at;
    std::vector<std::vector<double>> played;  // [width][tick]
    std::vector<std::vector<Ports>> at_played;
    std::vector<double> in_flow, ex_flow;  // at the pressure expected
    std::vector<std::vector<double>>
        followed;  // [time constant][tick]: what the terms depend on, with its memory
    double mean_volume = 0.0;
  };

  Background background(const Record& record, const Track& t) const {
    const std::size_t ticks = t.about.pressure.size();
    const double Pa = scene_.around.ambient_Pa;
    Background b;
    b.record = &record;
    b.u.assign(record.drive.command_V.begin(),
               record.drive.command_V.begin() + static_cast<std::ptrdiff_t>(ticks));
    if (equation_ == Equation::command) {
      for (std::size_t k = 0; k < ticks; ++k) b.u[k] += t.about.d[k];
      for (const double width : kPlays_V) play(width, b);
    }
    b.at.resize(ticks);
    b.in_flow.resize(ticks);
    b.ex_flow.resize(ticks);
    for (std::size_t k = 0; k < ticks; ++k) {
      const double middle = t.about.middle_Pa[k];
      b.at[k] = ports(b.u[k]);
      b.in_flow[k] = b.at[k].inlet.area * chamber_.plate().phi(scene_.around.supply_Pa, middle);
      b.ex_flow[k] = b.at[k].exhaust.area * chamber_.plate().phi(middle, Pa);
    }
    const double tick_s = record.drive.timing.tick_s;
    if (equation_ == Equation::supply) {
      for (const double tau : kSupply_s) b.followed.push_back(smoothed(b.in_flow, tau, tick_s));
    } else if (equation_ == Equation::mass_flow) {
      for (const auto& [resistance, tau] : kSilencers)
        b.followed.push_back(smoothed(pressure_behind(resistance, b, t), tau, tick_s));
    } else if (equation_ == Equation::energy) {
      for (const double power : {0.0, 1.0}) {
        for (const double tau : kHeat_s) b.followed.push_back(cooling(tau, power, t, tick_s));
      }
    }
    const std::vector<double>& v = record.drive.volume_m3;
    b.mean_volume = std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
    return b;
  }

  /// The command through a play of this width.
  void play(double width, Background& b) const {
    std::vector<double> x(b.u.size());
    std::vector<Ports> at(b.u.size());
    double last = b.u[0];
    for (std::size_t k = 0; k < x.size(); ++k) {
      last = std::clamp(last, b.u[k] - 0.5 * width, b.u[k] + 0.5 * width);
      x[k] = last;
      at[k] = ports(last);
    }
    b.played.push_back(std::move(x));
    b.at_played.push_back(std::move(at));
  }

  /// First order, a tick's value held.
  static std::vector<double> smoothed(std::vector<double> x, double tau, double tick_s) {
    const double keep = tau > 0.0 ? std::exp(-tick_s / tau) : 0.0;
    double s = 0.0;
    for (double& value : x) {
      s = keep * s + (1.0 - keep) * value;
      value = s;
    }
    return x;
  }

  /// Behind an exhaust whose silencer resists so much, over ambient, less one.
  std::vector<double> pressure_behind(double resistance, const Background& b, const Track& t) const {
    const double Pa = scene_.around.ambient_Pa;
    std::vector<double> over(b.u.size());
    for (std::size_t k = 0; k < over.size(); ++k) {
      const auto behind = [&](double flow) { return std::hypot(1.0, resistance * flow / flow_scale_); };
      const double flow = in_series(b.ex_flow[k], [&](double m) {
        return b.at[k].exhaust.area * chamber_.plate().phi(t.about.middle_Pa[k], Pa * behind(m));
      });
      over[k] = behind(flow) - 1.0;
    }
    return over;
  }

  /// Rate at which the pressure falls [1/s] as gas that was warmed by compression comes back to the wall's temperature
  /// within tau; that of a chamber at half the supply with its mass to this power.
  std::vector<double> cooling(double tau, double power, const Track& t, double tick_s) const {
    std::vector<double> fall(t.about.pressure.size());
    double settled = 0.0;
    for (std::size_t k = 0; k < fall.size(); ++k) {
      const double pressure = t.about.pressure[k];
      const double warmth = (1.0 - 1.0 / chamber_.kappa()) * std::log(pressure / scene_.around.ambient_Pa);
      if (k == 0) settled = warmth;
      const double rate = std::pow(0.5 * scene_.around.supply_Pa / pressure, power) / tau;
      settled -= std::expm1(-tick_s * rate) * (warmth - settled);
      fall[k] = std::expm1(settled - warmth) * rate;
    }
    return fall;
  }

  void act(const Record& record, Track& t) const {
    const std::size_t ticks = t.about.pressure.size();
    const double Pa = scene_.around.ambient_Pa;
    const std::size_t n = terms_.size();
    t.act.assign(ticks * n, {});
    t.disturb.assign(ticks, {});
    t.inputs.assign(ticks, {});
    t.figure_inlet.assign(ticks * kParts, {});
    t.figure_exhaust.assign(ticks * kParts, {});
    const Background b = background(record, t);
    for (std::size_t k = 0; k < ticks; ++k) {
      Inputs& base = t.inputs[k];
      base[kSupply] = scene_.around.supply_Pa;
      base[kBehind] = Pa;
      for (std::size_t part = 0; part < kParts; ++part) {
        base[kInlet + part] = b.at[k].inlet.area;
        base[kExhaust + part] = b.at[k].exhaust.area;
        t.figure_inlet[k * kParts + part] = b.at[k].inlet.by;
        t.figure_exhaust[k * kParts + part] = b.at[k].exhaust.by;
      }
      Action* const a = t.act.data() + k * n;
      switch (equation_) {
        case Equation::command:
          act_on_command(b, t, k, a, t.disturb[k]);
          break;
        case Equation::valve_area:
          act_on_valve_area(b, k, a, t.disturb[k]);
          break;
        case Equation::mass_flow:
          act_on_mass_flow(b, t, k, a, t.disturb[k]);
          break;
        case Equation::supply:
          act_on_supply(b, k, a, t.disturb[k]);
          break;
        case Equation::energy:
          act_on_energy(b, t, k, a, t.disturb[k]);
          break;
        case Equation::sensor:
          act_on_sensor(t, k, a, t.disturb[k]);
          break;
      }
      for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t c = 0; c < kInputs; ++c) base[c] += term_[j] * a[j].input[c];
      }
      for (std::size_t c = kInlet; c < kSupply; ++c) base[c] = std::max(base[c], 0.0);
      base[kSupply] = std::max(base[kSupply], 1.05 * Pa);
      base[kBehind] = std::clamp(base[kBehind], 0.9 * Pa, scene_.around.supply_Pa);
    }
  }

  void act_on_command(const Background& b, Track& t, std::size_t k, Action* a, Action& w) const {
    std::size_t i = 0;
    for (std::size_t part = 0; part < kParts; ++part) {
      w.input[kInlet + part] = b.at[k].inlet.slope;
      w.input[kExhaust + part] = -b.at[k].exhaust.slope;
    }
    w.own = 1.0;
    for (std::size_t j = 0; j < kLagParts.size(); ++j, ++i) {
      for (std::size_t part = 0; part < kParts; ++part) {
        for (const auto& [ticks_ago, weight] : lagging_[j][part]) {
          const std::size_t then = k - std::min(k, ticks_ago);
          a[i].input[kInlet + part] += weight * (b.at[then].inlet.area - b.at[k].inlet.area);
          a[i].input[kExhaust + part] += weight * (b.at[then].exhaust.area - b.at[k].exhaust.area);
          a[i].own += weight * (b.u[then] - b.u[k]) / kParts;
          if (std::abs(term_[i]) < 0.02) continue;
          for (std::size_t f = 0; f < 4; ++f) {
            t.figure_inlet[k * kParts + part][f] +=
                term_[i] * weight * (b.at[then].inlet.by[f] - b.at[k].inlet.by[f]);
            t.figure_exhaust[k * kParts + part][f] +=
                term_[i] * weight * (b.at[then].exhaust.by[f] - b.at[k].exhaust.by[f]);
          }
        }
      }
    }
    for (std::size_t j = 0; j < kPlays_V.size(); ++j, ++i) {
      const Ports& x = b.at_played[j][k];
      for (std::size_t part = 0; part < kParts; ++part) {
        a[i].input[kInlet + part] = x.inlet.area - b.at[k].inlet.area;
        a[i].input[kExhaust + part] = x.exhaust.area - b.at[k].exhaust.area;
        for (std::size_t f = 0; f < 4; ++f) {
          t.figure_inlet[k * kParts + part][f] += term_[i] * (x.inlet.by[f] - b.at[k].inlet.by[f]);
          t.figure_exhaust[k * kParts + part][f] += term_[i] * (x.exhaust.by[f] - b.at[k].exhaust.by[f]);
        }
      }
      a[i].own = b.played[j][k] - b.u[k];
    }
  }

  void act_on_valve_area(const Background& b, std::size_t k, Action* a, Action& w) const {
    std::size_t i = 0;
    for (std::size_t part = 0; part < kParts; ++part) {
      w.input[kInlet + part] = b.at[k].inlet.area;
      w.input[kExhaust + part] = b.at[k].exhaust.area;
    }
    w.own = 1.0;
    const double in_V = b.u[k] - figures_[effects::kOpenAbove];
    const double ex_V = figures_[effects::kExhaustBelow] - b.u[k];
    for (const bool inlet : {true, false}) {
      const double o = inlet ? in_V : ex_V;
      for (std::size_t j = 1; j < kOpenings.size(); ++j, ++i) {
        if (o <= 0.0) continue;
        const double h = hat(kOpenings, j, o / (o + 2.0));
        const double area = figures_[inlet ? effects::kInletGain : effects::kExhaustGain] * o * h;
        for (std::size_t part = 0; part < kParts; ++part)
          a[i].input[(inlet ? kInlet : kExhaust) + part] = area;
        a[i].own = h;
      }
    }
  }

  void act_on_mass_flow(const Background& b, const Track& t, std::size_t k, Action* a, Action& w) const {
    std::size_t i = 0;
    const double P = scene_.around.supply_Pa;
    const double Pa = scene_.around.ambient_Pa;
    const double scale = flow_scale_;
    const double middle = t.about.middle_Pa[k];
    const double v = b.record->drive.volume_m3[k * static_cast<std::size_t>(b.record->drive.timing.steps)];
    w.input[kFlow] = -gain_ * chamber_.plate().phi(middle, Pa);
    w.own = w.input[kFlow] / scale;
    for (const bool inlet : {true, false}) {
      const double r = inlet ? middle / P : Pa / middle;
      const double area = inlet ? b.at[k].inlet.area : b.at[k].exhaust.area;
      const double flow = inlet ? b.in_flow[k] : -b.ex_flow[k];
      for (std::size_t j = 1; j < kRatios.size(); ++j, ++i) {
        const double h = hat(kRatios, j, std::min(r, 1.0));
        for (std::size_t part = 0; part < kParts; ++part)
          a[i].input[(inlet ? kInlet : kExhaust) + part] = area * h;
        a[i].own = flow * h / scale;
      }
    }
    const double leak = -chamber_.plate().phi(middle, Pa) / chamber_.plate().phi(P, Pa);
    const double laminar = -(middle * middle - Pa * Pa) / (P * P - Pa * Pa);
    for (const double flow : {leak, laminar}) {
      a[i].input[kFlow] = scale * flow;
      a[i++].own = flow;
    }
    for (const std::vector<double>& x : b.followed) {
      a[i].input[kBehind] = Pa * x[k];
      a[i].own = -b.at[k].exhaust.area * chamber_.plate().flux(middle, Pa).by_second * Pa * x[k] / scale;
      ++i;
    }
    const double net = b.in_flow[k] - b.ex_flow[k];
    for (const std::size_t lag : kFlowLags) {
      const std::size_t then = k - std::min(k, lag);
      a[i].input[kFlow] = b.in_flow[then] - b.ex_flow[then] - net;
      a[i].own = a[i].input[kFlow] / scale;
      ++i;
    }
    for (const double wide : kWays) {
      const double flow = in_series(net, [&](double m) {
        const double loss = P * m / (wide * scale);
        const double valve = std::sqrt(std::max(middle * middle + loss * std::abs(loss), 0.01 * Pa * Pa));
        return b.at[k].inlet.area * chamber_.plate().phi(P, valve) -
               b.at[k].exhaust.area * chamber_.plate().phi(valve, Pa);
      });
      a[i].input[kFlow] = flow - net;
      a[i++].own = (flow - net) / scale;
    }
    a[i].input[kVolume] = b.mean_volume;
    a[i].own = -net / scale * b.mean_volume / v;
  }

  void act_on_supply(const Background& b, std::size_t k, Action* a, Action& w) const {
    std::size_t i = 0;
    const double P = scene_.around.supply_Pa;
    const double scale = flow_scale_;
    w.input[kSupply] = P;
    w.own = 1.0;
    for (const std::vector<double>& x : b.followed) {
      a[i].input[kSupply] = -P * x[k] / scale;
      a[i].own = -x[k] / scale;
      ++i;
    }
    a[i].own = -b.in_flow[k] * std::abs(b.in_flow[k]) / (scale * scale);
    a[i].input[kSupply] = P * a[i].own;
  }

  void act_on_energy(const Background& b, const Track& t, std::size_t k, Action* a, Action& w) const {
    std::size_t i = 0;
    const double P = scene_.around.supply_Pa;
    const double middle = t.about.middle_Pa[k];
    const effects::Timing& timing = b.record->drive.timing;
    const auto steps = static_cast<std::size_t>(timing.steps);
    const std::vector<double>& volume = b.record->drive.volume_m3;
    const double v = volume[k * steps];
    const double v_next = volume[(k + 1) * steps];
    const double per_rate = 0.5 * (v + v_next) * middle / (chamber_.kappa() * chamber_.RT());
    w.input[kFlow] = b.mean_volume * P / (chamber_.kappa() * chamber_.RT());
    w.own = w.input[kFlow] / per_rate;
    for (std::size_t j = 0; j < b.followed.size(); ++j, ++i) {
      a[i].own = b.followed[j][k];
      a[i].input[kFlow] = per_rate * a[i].own;
    }
    const double flow_rate = (b.in_flow[k] - b.ex_flow[k]) * chamber_.kappa() * chamber_.RT() / (middle * v);
    const double compression = -chamber_.kappa() * (v_next - v) / (timing.tick_s * v);
    a[i].input[kVolume] = b.mean_volume;
    a[i++].own = -(flow_rate + compression) * b.mean_volume / v;
    const double bend = (v - b.mean_volume);
    a[i].input[kVolume] = bend;
    a[i].input[kFlow] = per_rate * compression;
    a[i].own = -(flow_rate + compression) * bend / v + compression;
    ++i;
    for (const std::size_t lag : kVolumeLags) {
      const std::size_t then = (k - std::min(k, lag)) * steps;
      const double D = volume[then] - v;
      const double change = volume[then + steps] - v_next - D;
      a[i].input[kVolume] = D;
      const double moved = -chamber_.kappa() * change / (timing.tick_s * v);
      a[i].input[kFlow] = per_rate * moved;
      a[i].own = moved - (flow_rate + compression) * D / v;
      ++i;
    }
    a[i].own = compression;
    a[i].input[kFlow] = per_rate * compression;
  }

  void act_on_sensor(const Track& t, std::size_t k, Action* a, Action& w) const {
    std::size_t i = 0;
    const double P = scene_.around.supply_Pa;
    const double Pa = scene_.around.ambient_Pa;
    const double middle = t.about.middle_Pa[k];
    w.reading = P;
    w.own = 1.0;
    i += kSensorLags.size() + 1;  // they need the readings: derive()
    const double x = (middle - Pa) / P;
    for (const double s : {1.0, x, x * x}) {
      a[i].reading = P * s;
      a[i++].own = s;
    }
  }

  Point present() const {
    Point point{figures_, term_, noise_, {}};
    point.about.reserve(tracks_.size());
    for (const Track& t : tracks_) point.about.push_back(t.about);
    return point;
  }
  void go_back(const Point& point) {
    figures_ = point.figures;
    term_ = point.term;
    noise_ = point.noise;
    for (std::size_t r = 0; r < tracks_.size(); ++r) tracks_[r].about = point.about[r];
  }

  /// Runs the filter at the present figures and terms and takes each tick linear about it; returns likelihood().
  double sweep() {
    double sum = 0.0;
    for (std::size_t r = 0; r < records_.size(); ++r) sum += sweep(*records_[r], tracks_[r]);
    const double l = -0.5 * (sum + beyond_expected().cwiseQuotient(spreads()).squaredNorm());
    return std::isfinite(l) ? l : -std::numeric_limits<double>::infinity();
  }
  double sweep(const Record& record, Track& t) const {
    act(record, t);
    const std::size_t ticks = t.about.pressure.size();
    const effects::Timing& timing = record.drive.timing;
    const auto steps = static_cast<std::size_t>(timing.steps);
    const std::size_t m = terms_.size();
    const std::size_t n = columns();
    const double keep = std::exp(-timing.tick_s / noise_.memory_s);
    t.linear.resize(ticks);
    t.sensor.assign(ticks, 0.0);
    t.at_Pa.resize(ticks);
    t.columns.assign(ticks * n * 2, 0.0);
    t.rough.resize(ticks);
    t.by_d.resize(ticks);
    std::vector<double> read(ticks);  // what the filter takes the chamber's own reading to have been
    Filter s = begin(t, noise_);
    double sum = 0.0;
    for (std::size_t k = 0; k < ticks; ++k) {
      Linear& l = t.linear[k];
      s.x = std::clamp(s.x, 5e3, 2.0 * scene_.around.supply_Pa);
      t.at_Pa[k] = s.x;
      l = chamber_.tick(s.x, t.inputs[k], record.drive.volume_m3.data() + k * steps, timing);
      Action* const a = t.act.data() + k * m;
      if (equation_ == Equation::sensor) {
        const double P = scene_.around.supply_Pa;
        double own = 1.0;
        for (std::size_t j = 0; j < kSensorLags.size(); ++j) {
          const double then = k >= kSensorLags[j] ? read[k - kSensorLags[j]] : l.at.reading;
          a[j].reading = then - l.at.reading;
          a[j].own = a[j].reading / P;
          own -= term_[j];
        }
        a[kSensorLags.size()].reading = s.x - l.at.end;
        a[kSensorLags.size()].own = a[kSensorLags.size()].reading / P;
        for (std::size_t j = 0; j < m; ++j) t.sensor[k] += term_[j] * a[j].reading;
        read[k] = l.at.reading;
        l.by_pressure.reading *= own;
        for (Outcome& o : l.by_input) o.reading *= own;
      }
      fill_columns(t, k);
      const Update u = update(s, record, t, k);
      if (k + 1 >= record.settled_rows) sum += std::log(u.S) + u.innovation * u.innovation / u.S;
      advance(s, t, k, keep, noise_);
    }
    return sum;
  }

  void fill_columns(Track& t, std::size_t k) const {
    const std::size_t n = columns();
    const Linear& l = t.linear[k];
    double* end = t.columns.data() + k * n * 2;
    double* reading = end + n;
    const auto add = [&](std::size_t column, std::size_t input, double by) {
      end[column] += by * l.by_input[input].end;
      reading[column] += by * l.by_input[input].reading;
    };
    for (std::size_t part = 0; part < kParts; ++part) {
      const std::array<double, 4>& in = t.figure_inlet[k * kParts + part];
      const std::array<double, 4>& ex = t.figure_exhaust[k * kParts + part];
      add(effects::kOpenAbove, kInlet + part, in[0]);
      add(effects::kInletGain, kInlet + part, in[1]);
      add(effects::kInletLeak, kInlet + part, in[2]);
      add(effects::kTransition, kInlet + part, in[3]);
      add(effects::kExhaustBelow, kExhaust + part, ex[0]);
      add(effects::kExhaustGain, kExhaust + part, ex[1]);
      add(effects::kExhaustLeak, kExhaust + part, ex[2]);
      add(effects::kTransition, kExhaust + part, ex[3]);
    }
    for (std::size_t j = 0; j < terms_.size(); ++j) {
      const Action& a = t.act[k * terms_.size() + j];
      for (std::size_t c = 0; c < kInputs; ++c) {
        if (a.input[c] != 0.0) add(kValveFigures + j, c, a.input[c]);
      }
      reading[kValveFigures + j] += a.reading;
    }
    Outcome& d = t.by_d[k];
    d = {0.0, t.disturb[k].reading};
    for (std::size_t c = 0; c < kInputs; ++c) {
      d.end += t.disturb[k].input[c] * l.by_input[c].end;
      d.reading += t.disturb[k].input[c] * l.by_input[c].reading;
    }
    t.rough[k] = kRough_Pa + kRoughShare * std::abs(l.at.end - t.at_Pa[k]);
  }

  Eigen::VectorXd spreads() const {
    Eigen::VectorXd s(static_cast<Eigen::Index>(columns()));
    s << 0.2, 0.2, 0.5 * gain_, 0.5 * gain_, 0.1 * gain_, 0.1 * gain_, 0.1 * gain_,
        Eigen::VectorXd::Zero(static_cast<Eigen::Index>(terms_.size()));
    for (std::size_t j = 0; j < terms_.size(); ++j)
      s[static_cast<Eigen::Index>(kValveFigures + j)] = terms_[j].spread;
    return s;
  }
  Eigen::VectorXd beyond_expected() const {
    Eigen::VectorXd s(static_cast<Eigen::Index>(columns()));
    for (std::size_t j = 0; j < kValveFigures; ++j)
      s[static_cast<Eigen::Index>(j)] = figures_[j] - scene_.nominal[j];
    for (std::size_t j = 0; j < terms_.size(); ++j)
      s[static_cast<Eigen::Index>(kValveFigures + j)] = term_[j];
    return s;
  }

  struct Filter {
    double x = 0.0, d = 0.0;
    double xx = 0.0, xd = 0.0, dd = 0.0;  // covariance
  };
  Filter begin(const Track& t, const Noise& noise) const {
    const double spread = kStartSpread * scene_.around.supply_Pa;
    return {t.begin_Pa, 0.0, spread * spread, 0.0, noise.size * noise.size};
  }

  System evaluate() const {
    const auto n = static_cast<Eigen::Index>(columns());
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(n + 1, n + 1);
    constexpr Eigen::Index kBatch = 64;
    Eigen::MatrixXd batch = Eigen::MatrixXd::Zero(n + 1, kBatch);
    Eigen::VectorXd xs(n), ds(n), c(n), x_new(n);
    for (std::size_t r = 0; r < records_.size(); ++r) {
      const Record& record = *records_[r];
      const Track& t = tracks_[r];
      const double keep = std::exp(-record.drive.timing.tick_s / noise_.memory_s);
      Filter s = begin(t, noise_);
      xs.setZero();
      ds.setZero();
      Eigen::Index at = 0;
      for (std::size_t k = 0; k < t.about.pressure.size(); ++k) {
        const Eigen::Map<const Eigen::VectorXd> end(t.columns.data() + k * columns() * 2, n);
        const Eigen::Map<const Eigen::VectorXd> reading(t.columns.data() + k * columns() * 2 + columns(), n);
        const Update u = update(s, record, t, k);
        c.noalias() = u.C * xs + u.E * ds + reading;
        if (k + 1 >= record.settled_rows) {
          const double w = 1.0 / std::sqrt(u.S);
          batch.col(at).head(n) = w * c;
          batch(n, at) = w * u.innovation;
          if (++at == kBatch) {
            gram.selfadjointView<Eigen::Upper>().rankUpdate(batch);
            at = 0;
          }
        }
        xs.noalias() -= u.Kx * c;
        ds.noalias() -= u.Kd * c;
        advance(s, t, k, keep, noise_);
        x_new.noalias() = t.linear[k].by_pressure.end * xs + t.by_d[k].end * ds + end;
        xs.swap(x_new);
        ds *= keep;
      }
      if (at > 0) gram.selfadjointView<Eigen::Upper>().rankUpdate(batch.leftCols(at));
    }
    gram = Eigen::MatrixXd(gram.selfadjointView<Eigen::Upper>());
    const Eigen::VectorXd precision = spreads().array().square().inverse();
    const Eigen::VectorXd beyond = beyond_expected();
    Eigen::MatrixXd H = gram.topLeftCorner(n, n);
    H.diagonal() += precision;
    System system;
    system.g = gram.col(n).head(n) - precision.cwiseProduct(beyond);
    system.H = H;
    const Eigen::VectorXd scale = H.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::LDLT<Eigen::MatrixXd> solver(scale.asDiagonal() * H * scale.asDiagonal());
    // a term that is not seen costs nothing: it could have been left out
    const Eigen::VectorXd variance =
        solver.solve(Eigen::MatrixXd::Identity(n, n)).diagonal().cwiseProduct(scale.cwiseAbs2());
    for (std::size_t j = 0; j < terms_.size(); ++j) {
      const double error = std::sqrt(variance[static_cast<Eigen::Index>(kValveFigures + j)]);
      if (std::abs(term_[j]) > kSeen * error)
        system.occam += std::max(0.0, std::log(terms_[j].spread / error));
    }
    return system;
  }

  void advance(Filter& s, const Track& t, std::size_t k, double keep, const Noise& noise) const {
    const Linear& l = t.linear[k];
    const double A = l.by_pressure.end;
    const double G = t.by_d[k].end;
    const double x = l.at.end + A * (s.x - t.at_Pa[k]) + G * (s.d - t.about.d[k]);
    const double xx = A * A * s.xx + 2.0 * A * G * s.xd + G * G * s.dd + t.rough[k] * t.rough[k];
    const double xd = keep * (A * s.xd + G * s.dd);
    s = {x, keep * s.d, xx, xd, keep * keep * s.dd + (1.0 - keep * keep) * noise.size * noise.size};
  }

  /// Of the innovations, and of what figures and terms are beyond what was expected of them.
  double likelihood(const Noise& noise) const {
    double sum = 0.0;
    for (std::size_t r = 0; r < records_.size(); ++r) {
      const Record& record = *records_[r];
      const Track& t = tracks_[r];
      const double keep = std::exp(-record.drive.timing.tick_s / noise.memory_s);
      Filter s = begin(t, noise);
      for (std::size_t k = 0; k < t.about.pressure.size(); ++k) {
        const Update u = update(s, record, t, k);
        if (k + 1 >= record.settled_rows) sum += std::log(u.S) + u.innovation * u.innovation / u.S;
        advance(s, t, k, keep, noise);
      }
    }
    const double l = -0.5 * (sum + beyond_expected().cwiseQuotient(spreads()).squaredNorm());
    return std::isfinite(l) ? l : -std::numeric_limits<double>::infinity();
  }

  /// Size and memory of the disturbance, or its size alone `near` the present one.
  void choose_noise(bool near) {
    double best = -std::numeric_limits<double>::infinity();
    const Noise present = noise_;
    Noise chosen = present;
    for (const double memory : kMemories_s) {
      for (int i = -8; i <= 3; ++i) {
        const Noise noise{start_size() * std::pow(10.0, 0.5 * i), memory};
        const double ratio = noise.size / present.size;
        if (near && (memory != present.memory_s || ratio > 3.5 || ratio < 0.28)) continue;
        const double l = likelihood(noise);
        if (l > best) {
          best = l;
          chosen = noise;
        }
      }
    }
    noise_ = chosen;
  }

  void take(const Eigen::VectorXd& change) {
    for (std::size_t j = 0; j < kValveFigures; ++j) figures_[j] += change[static_cast<Eigen::Index>(j)];
    for (const std::size_t j : {effects::kInletGain, effects::kExhaustGain})
      figures_[j] = std::max(figures_[j], 0.05 * gain_);
    for (const std::size_t j : {effects::kInletLeak, effects::kExhaustLeak})
      figures_[j] = std::max(figures_[j], 0.0);
    figures_[effects::kTransition] = std::max(figures_[effects::kTransition], 1e-3 * gain_);
    for (std::size_t j = 0; j < terms_.size(); ++j)
      term_[j] += change[static_cast<Eigen::Index>(kValveFigures + j)];
  }

  struct Update {
    double C = 0.0, E = 0.0, S = 0.0, Kx = 0.0, Kd = 0.0, innovation = 0.0;
  };
  /// Takes in the reading at the end of tick k.
  Update update(Filter& s, const Record& record, const Track& t, std::size_t k) const {
    const Linear& l = t.linear[k];
    Update u;
    u.C = l.by_pressure.reading;
    u.E = t.by_d[k].reading;
    const double rough = 0.5 * t.rough[k];
    u.S = u.C * u.C * s.xx + 2.0 * u.C * u.E * s.xd + u.E * u.E * s.dd + scene_.noise_Pa * scene_.noise_Pa +
          rough * rough;
    u.Kx = (u.C * s.xx + u.E * s.xd) / u.S;
    u.Kd = (u.C * s.xd + u.E * s.dd) / u.S;
    u.innovation = record.measured_Pa[k + 1] -
                   (l.at.reading + t.sensor[k] + u.C * (s.x - t.at_Pa[k]) + u.E * (s.d - t.about.d[k]));
    s.x += u.Kx * u.innovation;
    s.d += u.Kd * u.innovation;
    s.xx -= u.Kx * u.Kx * u.S;
    s.xd -= u.Kx * u.Kd * u.S;
    s.dd -= u.Kd * u.Kd * u.S;
    return u;
  }

  /// The terms are taken at what the filter expects now, and a slow drift of the command, which is more than the
  /// areas' slopes can follow, where it is now.
  void renew() {
    const bool drifts = equation_ == Equation::command && noise_.memory_s >= 1.0;
    if (drifts) smooth();
    for (Track& t : tracks_) {
      for (std::size_t k = 0; k < t.about.pressure.size(); ++k) {
        t.about.pressure[k] = t.at_Pa[k];
        t.about.middle_Pa[k] = 0.5 * (t.at_Pa[k] + std::max(t.linear[k].at.end, 5e3));
        t.about.d[k] = drifts ? t.smooth_d[k] : 0.0;
      }
    }
  }

  void smooth() {
    for (std::size_t r = 0; r < records_.size(); ++r) smooth(*records_[r], tracks_[r]);
  }
  void smooth(const Record& record, Track& t) const {
    const std::size_t ticks = t.about.pressure.size();
    const double keep = std::exp(-record.drive.timing.tick_s / noise_.memory_s);
    std::vector<Filter> filtered(ticks), predicted(ticks);
    Filter s = begin(t, noise_);
    for (std::size_t k = 0; k < ticks; ++k) {
      predicted[k] = s;
      update(s, record, t, k);
      filtered[k] = s;
      advance(s, t, k, keep, noise_);
    }
    t.smooth_d.resize(ticks);
    double x = filtered.back().x;
    double d = filtered.back().d;
    for (std::size_t k = ticks; k-- > 0;) {
      const Filter& f = filtered[k];
      if (k + 1 < ticks) {
        const double A = t.linear[k].by_pressure.end;
        const double G = t.by_d[k].end;
        const Filter& p = predicted[k + 1];
        Eigen::Matrix2d before, next, move;
        before << f.xx, f.xd, f.xd, f.dd;
        next << p.xx, p.xd, p.xd, p.dd;
        move << A, G, 0.0, keep;
        next.diagonal().array() *= 1.0 + 1e-9;
        const Eigen::Matrix2d gain = before * move.transpose() * next.inverse();
        const Eigen::Vector2d jump(x - p.x, d - p.d);
        const Eigen::Vector2d back = gain * jump;
        x = f.x + back[0];
        d = f.d + back[1];
      }
      t.smooth_d[k] = d;
    }
  }

  LatentEquation answer() const {
    LatentEquation a;
    a.equation = equation_;
    a.log_likelihood = log_likelihood_;
    a.memory_s = noise_.memory_s;
    a.unit = unit();
    const double unit = per_unit();
    std::vector<std::string> groups{"time"};  // the disturbance itself, which depends on no term
    std::vector<std::size_t> group_of;
    for (const Term& term : terms_) {
      const auto at = std::find(groups.begin(), groups.end(), term.group);
      group_of.push_back(static_cast<std::size_t>(at - groups.begin()));
      if (at == groups.end()) groups.push_back(term.group);
    }
    std::vector<double> part(groups.size()), without(groups.size(), 0.0);
    double all = 0.0, rest = 0.0, count = 0.0;
    for (const Track& t : tracks_) {
      std::vector<double> whole(t.smooth_d.size());
      for (std::size_t k = 0; k < whole.size(); ++k) {
        std::fill(part.begin(), part.end(), 0.0);
        part[0] = t.smooth_d[k] * t.disturb[k].own;
        rest += part[0] * part[0];
        for (std::size_t j = 0; j < terms_.size(); ++j)
          part[group_of[j]] += term_[j] * t.act[k * terms_.size() + j].own;
        const double sum = std::accumulate(part.begin(), part.end(), 0.0);
        whole[k] = unit * sum;
        all += sum * sum;
        for (std::size_t g = 0; g < part.size(); ++g) without[g] += (sum - part[g]) * (sum - part[g]);
        count += 1.0;
      }
      a.disturbance.push_back(std::move(whole));
    }
    a.size = unit * std::sqrt(all / count);
    a.rest = unit * std::sqrt(rest / count);
    for (std::size_t g = 0; g < groups.size(); ++g)
      a.terms.push_back({groups[g], all > 0.0 ? std::max(0.0, 1.0 - without[g] / all) : 0.0});
    std::stable_sort(a.terms.begin(), a.terms.end(),
                     [](const auto& x, const auto& y) { return x.share > y.share; });
    return a;
  }
  std::string unit() const {
    switch (equation_) {
      case Equation::command:
        return "V";
      case Equation::valve_area:
        return "";
      case Equation::mass_flow:
        return "kg/s";
      case Equation::supply:
      case Equation::sensor:
        return "Pa";
      case Equation::energy:
        return "1/s";
    }
    return "";
  }

  static constexpr std::array<double, 5> kMemories_s{0.002, 0.05, 0.3, 2.0, 20.0};
  static constexpr double kSeen = 3.0;  // standard errors
  static constexpr double kRough_Pa = 20.0;
  static constexpr double kRoughShare = 0.003;
  static constexpr double kStartSpread = 0.03;

  // What an error of each equation may depend on.
  static constexpr std::array kLagParts{1, 2, 3, 4, 6, 9, 14, 22};    // of the command, in parts of a tick
  static constexpr std::array kPlays_V{0.02, 0.06, 0.2, 0.6};         // full widths
  static constexpr std::array kOpenings{0.05, 0.15, 0.3, 0.45, 0.6};  // o/(o + 2 V)
  static constexpr std::array kRatios{0.15, 0.4, 0.6, 0.75, 0.88, 0.97};
  static constexpr std::array<std::array<double, 2>, 6> kSilencers{
      // resistance [ambient over flow_scale_], lag [s]
      {{0.15, 0.0}, {0.5, 0.0}, {1.5, 0.0}, {5.0, 0.0}, {0.5, 0.02}, {0.5, 0.1}}};
  static constexpr std::array kWays{1.0, 3.0, 10.0};                  // conductance [flow_scale_ over supply]
  static constexpr std::array<std::size_t, 4> kFlowLags{1, 2, 4, 8};  // ticks
  static constexpr std::array kSupply_s{0.0, 0.03, 0.1, 0.3, 1.0};
  static constexpr std::array kHeat_s{0.03, 0.1, 0.3, 1.0, 3.0};
  static constexpr std::array<std::size_t, 3> kVolumeLags{2, 6, 15};           // ticks
  static constexpr std::array<std::size_t, 6> kSensorLags{1, 2, 3, 5, 8, 13};  // ticks

  const Scene& scene_;
  LinearChamber chamber_;
  const std::vector<const Record*>& records_;
  Equation equation_;
  /// [lag][part of a tick]: ticks ago and weights, of a triangle over the parts around the lag.
  std::vector<std::array<std::vector<std::pair<std::size_t, double>>, kParts>> lagging_;
  double gain_ = 0.0;
  double flow_scale_ = 0.0;  // [kg/s] a port open by a volt, choked
  std::vector<Term> terms_;
  Figures figures_;
  std::vector<double> term_;
  Noise noise_;
  std::vector<Track> tracks_;
  double log_likelihood_ = 0.0;
};

}  // namespace

std::vector<LatentEquation> latent(const Scene& scene, const std::vector<const Record*>& records,
                                   const Figures& recalibrated, unsigned threads) {
  constexpr std::array kEquations{Equation::command, Equation::valve_area, Equation::mass_flow,
                                  Equation::supply,  Equation::energy,     Equation::sensor};
  std::vector<const Record*> long_enough;
  std::copy_if(records.begin(), records.end(), std::back_inserter(long_enough),
               [](const Record* record) { return record->rows() >= kLeastRows; });
  if (long_enough.empty()) return {};
  std::vector<LatentEquation> found(kEquations.size());
  identify::in_parallel(kEquations.size(), threads, [&](std::size_t i) {
    found[i] = Suspect(scene, long_enough, recalibrated, kEquations[i]).examine();
  });
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.log_likelihood > b.log_likelihood; });
  const double best = found.front().log_likelihood;
  double sum = 0.0;
  for (LatentEquation& e : found) {
    e.probability = std::isfinite(best) ? std::exp(-std::sqrt(best - e.log_likelihood) / kTemper) : 1.0;
    sum += e.probability;
  }
  for (LatentEquation& e : found) e.probability /= sum;
  return found;
}

}  // namespace plenum::host::diagnose
