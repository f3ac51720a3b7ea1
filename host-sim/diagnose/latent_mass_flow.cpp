// A disturbance of the mass flow: d of what flows, whichever way, and of a tenth of what a port open by a volt would let out to
// ambient, is lost. Terms: the pressure ratio, the pressure, a silencer, the flow before, and a hose in series. Or a leak that opens
// and closes, which does not follow the valve: d of what a port open by a volt would lose. Terms: the pressure.
#include "host-sim/diagnose/latent_terms.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace plenum::host::diagnose {
namespace {

constexpr std::array kRatios{0.15, 0.4, 0.6, 0.75, 0.88, 0.97};
constexpr std::array<std::array<double, 2>, 6> kSilencers{
    // resistance [ambient over flow_scale_], lag [s]
    {{0.15, 0.0}, {0.5, 0.0}, {1.5, 0.0}, {5.0, 0.0}, {0.5, 0.02}, {0.5, 0.1}}};
constexpr std::array kWays{1.0, 3.0, 10.0};                  // conductance [flow_scale_ over supply]
constexpr std::array<std::size_t, 4> kFlowLags{1, 2, 4, 8};  // ticks

constexpr double kMostIn = 0.2;  // of the squares of a leak, that may be gas that comes in

/// What a hole and a capillary lose [flow_scale_], that at the supply's pressure one each.
std::array<double, 2> leaks(const LatentScene& rig, double pressure_Pa) {
  const double P = rig.scene.around.supply_Pa;
  const double Pa = rig.scene.around.ambient_Pa;
  const plant::ThinPlate& plate = rig.chamber.plate();
  return {-plate.phi(pressure_Pa, Pa) / plate.phi(P, Pa),
          -(pressure_Pa * pressure_Pa - Pa * Pa) / (P * P - Pa * Pa)};
}

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

class MassFlowTerms : public LatentTerms {
 public:
  using LatentTerms::LatentTerms;

  std::vector<Term> terms() const override {
    std::vector<Term> terms;
    add(terms, "the pressure ratio", 0.3, kRatios.size() - 1);
    add(terms, "the pressure ratio", 0.3, kRatios.size() - 1);
    add(terms, "the pressure", 0.3, 2);
    add(terms, "the exhaust flow", 0.5, kSilencers.size());
    add(terms, "the flow before", 0.5, kFlowLags.size());
    add(terms, "the flow's way to the chamber", 0.5, kWays.size());
    add(terms, "the flow's way to the chamber", rig_.volume_moves ? 0.2 : kNever, 1);
    return terms;
  }
  DisturbanceScale disturbance() const override {
    return {.start_size = 0.05, .per_unit = rig_.flow_scale, .unit = "kg/s"};
  }
  void begin(const Background& b) override {
    followed_.clear();
    for (const auto& [resistance, tau] : kSilencers)
      followed_.push_back(smoothed(pressure_behind(resistance, b), tau, b.record->drive.timing.tick_s));
  }
  void act(const Background& b, std::size_t k, const TickActions& tick) const override {
    Action* const a = tick.terms;
    Action& w = tick.disturbance;
    std::size_t i = 0;
    const double P = rig_.scene.around.supply_Pa;
    const double Pa = rig_.scene.around.ambient_Pa;
    const double scale = rig_.flow_scale;
    const double middle = b.about->middle_Pa[k];
    const double v = b.record->drive.volume_m3[k * static_cast<std::size_t>(b.record->drive.timing.steps)];
    w.input[kFlow] =
        -std::hypot(0.1 * rig_.gain * rig_.chamber.plate().phi(middle, Pa), b.in_flow[k] - b.ex_flow[k]);
    w.own = w.input[kFlow] / scale;
    for (const bool inlet : {true, false}) {
      const double r = inlet ? middle / P : Pa / middle;
      const double area = inlet ? b.at[k].inlet.area : b.at[k].exhaust.area;
      const double flow = inlet ? b.in_flow[k] : -b.ex_flow[k];
      for (std::size_t j = 1; j < kRatios.size(); ++j, ++i) {
        const double h = hat(kRatios, j, std::min(r, 1.0));
        a[i].open(inlet ? kInlet : kExhaust, area * h);
        a[i].own = flow * h / scale;
      }
    }
    for (const double flow : leaks(rig_, middle)) {
      a[i].input[kFlow] = scale * flow;
      a[i++].own = flow;
    }
    for (const std::vector<double>& x : followed_) {
      a[i].input[kBehind] = Pa * x[k];
      a[i].own = -b.at[k].exhaust.area * rig_.chamber.plate().flux(middle, Pa).by_second * Pa * x[k] / scale;
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
        return b.at[k].inlet.area * rig_.chamber.plate().phi(P, valve) -
               b.at[k].exhaust.area * rig_.chamber.plate().phi(valve, Pa);
      });
      a[i].input[kFlow] = flow - net;
      a[i++].own = (flow - net) / scale;
    }
    a[i].input[kVolume] = b.mean_volume;
    a[i].own = -net / scale * b.mean_volume / v;
  }

 private:
  /// Behind an exhaust whose silencer resists so much, over ambient, less one.
  std::vector<double> pressure_behind(double resistance, const Background& b) const {
    const double Pa = rig_.scene.around.ambient_Pa;
    std::vector<double> over(b.u.size());
    for (std::size_t k = 0; k < over.size(); ++k) {
      const auto behind = [&](double flow) { return std::hypot(1.0, resistance * flow / rig_.flow_scale); };
      const double flow = in_series(b.ex_flow[k], [&](double m) {
        return b.at[k].exhaust.area * rig_.chamber.plate().phi(b.about->middle_Pa[k], Pa * behind(m));
      });
      over[k] = behind(flow) - 1.0;
    }
    return over;
  }

  std::vector<std::vector<double>> followed_;  ///< [silencer][tick]: the pressure behind it
};

/// A leak that comes and goes: what is lost does not follow the valve.
class LeakTerms : public LatentTerms {
 public:
  using LatentTerms::LatentTerms;

  std::vector<Term> terms() const override {
    std::vector<Term> terms;
    add(terms, "the pressure", 0.3, 2);
    return terms;
  }
  DisturbanceScale disturbance() const override {
    return {.start_size = 0.05, .per_unit = rig_.flow_scale, .unit = "kg/s"};
  }
  void act(const Background& b, std::size_t k, const TickActions& tick) const override {
    const std::array<double, 2> flows = leaks(rig_, b.about->middle_Pa[k]);
    for (std::size_t i = 0; i < flows.size(); ++i) {
      tick.terms[i].input[kFlow] = rig_.flow_scale * flows[i];
      tick.terms[i].own = flows[i];
    }
    tick.disturbance = tick.terms[0];
  }
  /// No gas comes in by a leak.
  bool is_possible(const std::vector<std::vector<double>>& whole) const override {
    double in = 0.0, all = 0.0;
    for (const std::vector<double>& record : whole) {
      for (const double flow : record) {
        in += flow > 0.0 ? flow * flow : 0.0;
        all += flow * flow;
      }
    }
    return in <= kMostIn * all;
  }
};

}  // namespace

std::unique_ptr<LatentTerms> leak_terms(const LatentScene& rig) {
  return std::make_unique<LeakTerms>(rig);
}

std::unique_ptr<LatentTerms> mass_flow_terms(const LatentScene& rig) {
  return std::make_unique<MassFlowTerms>(rig);
}

}  // namespace plenum::host::diagnose
