#include "firmware/control/greybox.hpp"

#include <algorithm>

#include "firmware/config/valve_curve.hpp"

namespace plenum::control {
namespace {

using numeric::abs;
using numeric::clamp;
using numeric::max;
using numeric::min;

/// [mL/L] Conductances in litres, so that a fixed-point reciprocal of a volume keeps its digits.
constexpr Scalar kPerLitre = Scalar(1000);

/// A hundredth of a 16 bit converter's step over 1000 kPa, far below the noise of any sensor.
constexpr Scalar kClose_kPa = Scalar(2e-4);

/// A share of its rate this small is none: there the pressure comes to rest.
constexpr Scalar kAtRest = Scalar(1e-7);

/// So many corners are not, but of a table in which a bit has flipped.
constexpr std::size_t kMostPassed = 2 * Greybox::kCorners;

/// Share of the way that a guess may miss.
constexpr Scalar kGuessed = Scalar(0.01);

/// Of flows that differ by less than this share none is greater.
constexpr Scalar kAlike = Scalar(1e-4);

/// Nodes and ends that lie closer are one command: a step of a converter of 16 bits is 1.5e-4 V.
constexpr Scalar kOneCommand_V = Scalar(1e-4);

/// Below this slope Newton's step is not taken.
constexpr Scalar kLeastNewton_kPa_V = Scalar(1e-6);

/// Nearer than this a slope is not told from two rates.
constexpr Scalar kNear_kPa = Scalar(1);

/// (r - r_b)/(r_a - r_b) at the ends of the chords: sines of equal angles, between which all chords of an ellipse err alike,
/// the last one halved because an index below 1/2 falls steeper still.
constexpr std::array<Scalar, Greybox::kChords + 1> kChordEnd = {
    0.0F,        0.17364818F, 0.34202014F, 0.50000000F, 0.64278761F, 0.76604444F,
    0.86602540F, 0.93969262F, 0.98480775F, 0.99619470F, 1.0F};

/// Arguments of smax() at which C(u) is tabulated, dense where it bends; and openings [V], for what the ports do further.
constexpr std::array<Scalar, 15> kBend = {-12.0F, -5.0F, -2.6F, -1.6F, -1.0F, -0.6F, -0.25F, 0.0F,
                                          0.25F,  0.6F,  1.0F,  1.6F,  2.6F,  5.0F,  12.0F};
constexpr std::array<Scalar, 16> kOpening_V = {0.12F, 0.3F, 0.5F, 0.75F, 1.05F, 1.4F, 1.8F, 2.25F,
                                               2.75F, 3.3F, 4.0F, 4.8F,  5.7F,  6.7F, 7.8F, 9.0F};
static_assert(2 + 2 * (kBend.size() + kOpening_V.size()) == Greybox::kNodes);

constexpr Scalar kThinPlateCritical = Scalar(0.5282818);

/// psi_0 of (G3), for a ratio between the critical one and 1.
Scalar thin_plate(Scalar ratio) noexcept {
  constexpr Scalar kChoked = Scalar(0.06698485);  // of the difference below, at the critical ratio
  const Scalar difference =
      numeric::power(ratio, Scalar(2.0 / 1.4)) - numeric::power(ratio, Scalar(2.4 / 1.4));
  return numeric::sqrt(max(difference, Scalar(0)) / kChoked);
}

/// The opening at which the argument of smax() is `x`, were the area linear.
Scalar opening_V(const config::ValveCurve& port, Scalar x) noexcept {
  return (x * port.transition_mL_s + port.leak_mL_s) / port.gain_mL_s_V;
}

/// std::sort would call itself: a stack of a depth that the values decide.
template <std::size_t count>
void sort(std::array<Scalar, count>& values) noexcept {
  std::make_heap(values.begin(), values.end());
  std::sort_heap(values.begin(), values.end());
}

/// [1] No line loses, and none is charged, beyond these; so that no number overflows.
constexpr Scalar kLeastSupply = Scalar(0.2);
constexpr Scalar kMostSupply = Scalar(2);

/// From one value to another; zero where both stand at the same place.
Scalar slope(Scalar from, Scalar to, Scalar width) noexcept {
  return width > Scalar(0) ? (to - from) / width : Scalar(0);
}

/// artanh(z)/z and, of that A, (1 - 1/A)/z^2, of y = z^2 up to kSmallBend: interpolated at Chebyshev's points, relative errors
/// below 3e-8 and 5e-7.
constexpr Scalar kSmallBend = Scalar(0.16);
constexpr Scalar artanh_ratio(Scalar y) noexcept {
  return Scalar(1) + y * (Scalar(0.33332502) +
                          y * (Scalar(0.20040956) + y * (Scalar(0.1359152) + y * Scalar(0.15727369))));
}
constexpr Scalar artanh_lag(Scalar y) noexcept {
  return Scalar(0.33333319) + y * (Scalar(0.08891775) + y * (Scalar(0.045677907) + y * Scalar(0.038560992)));
}

}  // namespace

/// (G3) by its chords.
class Greybox::FlowFunction {
 public:
  explicit FlowFunction(std::span<const Scalar, kParameters> of) noexcept
      : discharge_slope_(of[kDischargeSlope]) {
    const Scalar width = of[kCrackingRatio] - of[kCriticalRatio];
    const auto ratio_at = [&](Scalar along) noexcept { return of[kCriticalRatio] + width * along; };
    const auto psi_at = [&](Scalar along) noexcept {
      const Scalar as_plate = thin_plate(kThinPlateCritical + (Scalar(1) - kThinPlateCritical) * along);
      if (as_plate <= Scalar(0)) return Scalar(0);
      return discharge(ratio_at(along)) *
             numeric::power(min(as_plate, Scalar(1)), Scalar(2) * of[kSubsonicIndex]);
    };
    for (std::size_t i = 0; i < ratio_.size(); ++i) {
      ratio_[i] = ratio_at(kChordEnd[i]);
      share_[i] = psi_at(kChordEnd[i]);
    }
    // A chord lies below the curve, in the mean by 2/3 of what it does half way: its ends go up by that, so that the chords
    // lie about the curve. Those at the critical ratio, where the straight line of choked flow goes on, and at 0 stay.
    std::array<Scalar, kChords> below;
    for (std::size_t i = 0; i < below.size(); ++i) {
      below[i] =
          psi_at(Scalar(0.5) * (kChordEnd[i] + kChordEnd[i + 1])) - Scalar(0.5) * (share_[i] + share_[i + 1]);
    }
    for (std::size_t i = 1; i < below.size(); ++i) share_[i] += Scalar(1.0 / 3) * (below[i - 1] + below[i]);
  }

  Scalar ratio(std::size_t end) const noexcept { return ratio_[end]; }
  Scalar psi(std::size_t end) const noexcept { return share_[end]; }
  /// (1 + k (r* - r)), which is psi where the flow is choked
  Scalar discharge(Scalar ratio) const noexcept {
    return Scalar(1) + discharge_slope_ * (kThinPlateCritical - ratio);
  }

 private:
  Scalar discharge_slope_ = 0;
  std::array<Scalar, kChords + 1> ratio_{};
  std::array<Scalar, kChords + 1> share_{};
};

/// (G2)
void Greybox::Curve::configure(const FlowFunction& flow, Scalar source_kPa) noexcept {
  corner_kPa.front() = Scalar(0);
  flow_kPa.front() = source_kPa * flow.discharge(Scalar(0));
  for (std::size_t end = 0; end <= kChords; ++end) {
    corner_kPa[1 + end] = source_kPa * flow.ratio(end);
    flow_kPa[1 + end] = source_kPa * flow.psi(end);
    const Scalar beyond_kPa = source_kPa / flow.ratio(end);
    corner_kPa[kCorners - 2 - end] = beyond_kPa;
    flow_kPa[kCorners - 2 - end] = -beyond_kPa * flow.psi(end);
  }
  corner_kPa[kSource] = source_kPa;
  flow_kPa[kSource] = Scalar(0);
  corner_kPa.back() = kMostPressure_kPa;
  flow_kPa.back() = -kMostPressure_kPa * flow.discharge(source_kPa / kMostPressure_kPa);
  for (std::size_t i = 0; i + 1 < kCorners; ++i)
    slope[i] = control::slope(flow_kPa[i], flow_kPa[i + 1], corner_kPa[i + 1] - corner_kPa[i]);
}

std::size_t Greybox::Curve::side_of(Scalar pressure_kPa) const noexcept {
  const auto above = std::upper_bound(corner_kPa.begin() + 1, corner_kPa.end() - 1, pressure_kPa);
  return static_cast<std::size_t>(above - corner_kPa.begin()) - 1;
}

Scalar Greybox::Curve::at(std::size_t side, Scalar pressure_kPa) const noexcept {
  return flow_kPa[side] + slope[side] * (pressure_kPa - corner_kPa[side]);
}

Scalar Greybox::Curve::corner_at_kPa(std::size_t corner, Scalar size) const noexcept {
  return corner + 1 < kCorners ? size * corner_kPa[corner] : kMostPressure_kPa;
}

void Greybox::configure(std::span<const Scalar, kParameters> parameters, Scalar command_low_V,
                        Scalar command_high_V) noexcept {
  dead_volume_mL_ = parameters[kDeadVolume];
  volume_exponent_ = parameters[kVolumeExponent];
  supply_kPa_ = parameters[kSupply];
  ambient_kPa_ = parameters[kAmbient];
  leak_L_s_kPa_ = Scalar(0.5) * parameters[kChamberLeak] / kPerLitre / ambient_kPa_;
  const FlowFunction flow(parameters);
  inlet_.configure(flow, supply_kPa_);
  exhaust_.configure(flow, ambient_kPa_);

  const config::ValveCurve inlet = config::inlet_of(parameters);
  const config::ValveCurve exhaust = config::exhaust_of(parameters);
  std::size_t filled = 0;
  const auto add_opening = [&](Scalar of_inlet_V, Scalar of_exhaust_V) noexcept {
    node_V_[filled++] = parameters[kOpenAbove] + of_inlet_V;
    node_V_[filled++] = parameters[kExhaustBelow] - of_exhaust_V;
  };
  for (const Scalar x : kBend) add_opening(opening_V(inlet, x), opening_V(exhaust, x));
  for (const Scalar opening : kOpening_V) add_opening(opening, opening);
  node_V_[filled++] = command_low_V;
  node_V_[filled++] = command_high_V;
  for (Scalar& node : node_V_) node = clamp(node, command_low_V, command_high_V);
  sort(node_V_);
  for (std::size_t i = 0; i < kNodes; ++i) {
    node_[i] = {inlet.conductance_mL_s(node_V_[i] - parameters[kOpenAbove]) / kPerLitre,
                exhaust.conductance_mL_s(parameters[kExhaustBelow] - node_V_[i]) / kPerLitre};
  }
  // a port that has opened does not shut again as the command goes on: beyond its largest opening it is saturated
  for (std::size_t i = 1; i < kNodes; ++i) {
    node_[i].inlet = max(node_[i].inlet, node_[i - 1].inlet);
    node_[kNodes - 1 - i].exhaust = max(node_[kNodes - 1 - i].exhaust, node_[kNodes - i].exhaust);
  }
  for (std::size_t i = 0; i + 1 < kNodes; ++i) {
    const Scalar width_V = node_V_[i + 1] - node_V_[i];
    slope_[i] = {slope(node_[i].inlet, node_[i + 1].inlet, width_V),
                 slope(node_[i].exhaust, node_[i + 1].exhaust, width_V)};
  }
  const Scalar widest_L_s =
      node_.back().inlet + node_.front().exhaust + leak_L_s_kPa_ * (kGap_kPa + ambient_kPa_);
  least_volume_mL_ = max(kLeastVolume_mL, widest_L_s * (kTick_s * kPerLitre / kMostFilled));
}

/// (G1) with all put in but the pressure: of each flow the share in f.
struct Greybox::Law {
  Scalar inlet, exhaust, leak, moved;

  Law(const Tick& tick, const Ports& open) noexcept
      : inlet(tick.per_volume * open.inlet),
        exhaust(tick.per_volume * open.exhaust),
        leak(tick.per_volume),
        moved(tick.per_volume * tick.moved_L_s) {}

  /// f [kPa a tick]
  Scalar rate_kPa(const Flows& flows, Scalar pressure_kPa) const noexcept {
    return inlet * flows.inlet + exhaust * flows.exhaust - leak * flows.leak - moved * pressure_kPa;
  }
  /// J [1 a tick]
  Scalar slope(const Flows& slopes) const noexcept { return rate_kPa(slopes, Scalar(1)); }
};

/// The part of a step from where the pressure is to the corner ahead.
struct Greybox::Passage {
  Scalar way_kPa;              ///< without its sign, as the rates are
  Scalar rate_kPa, ahead_kPa;  ///< |f| where the pressure is, and at the corner [kPa a tick]
  Scalar bend;                 ///< the difference of both over their sum
  Scalar ticks = 0;

  Passage(Scalar way, Scalar rate, Scalar ahead) noexcept
      : way_kPa(way), rate_kPa(rate), ahead_kPa(ahead), bend((ahead - rate) / (ahead + rate)) {
    // way ln(ahead/rate)/(ahead - rate), as ln(ahead/rate) = 2 artanh(bend)
    ticks = slight() ? Scalar(2) * way / (ahead + rate) * artanh_ratio(bend * bend)
                     : way * numeric::log(ahead / rate) / (ahead - rate);
  }

  /// Where the pressure is on the way in the mean over the passage: its share in the way. Of one that takes no time it does not matter.
  Scalar mean() const noexcept {
    return slight() || ticks <= Scalar(0) ? Scalar(0.5) * (Scalar(1) - bend * artanh_lag(bend * bend))
                                          : (way_kPa / ticks - rate_kPa) / (ahead_kPa - rate_kPa);
  }

 private:
  bool slight() const noexcept { return bend * bend < kSmallBend; }
};

/// The last part of a step, which ends short of a corner.
struct Greybox::Rest {
  Scalar rate_kPa;  ///< |f| where it begins [kPa a tick]
  Scalar slope;     ///< J [1 a tick]
  Scalar ticks;
  Scalar phi_1;

  Scalar phi_2() const noexcept { return numeric::phi_2(-slope * ticks, phi_1); }
};

/// The integral over a step of how far the pressure has gone, up or down.
class Greybox::MeanRise {
 public:
  void operator()(const Passage& piece) noexcept {
    kPa_ticks_ += piece.ticks * (gone_kPa_ + piece.mean() * piece.way_kPa);
    gone_kPa_ += piece.way_kPa;
  }
  void operator()(const Rest& piece) noexcept {
    kPa_ticks_ += piece.ticks * (gone_kPa_ + piece.rate_kPa * piece.ticks * piece.phi_2());
  }
  Scalar kPa_ticks() const noexcept { return kPa_ticks_; }

 private:
  Scalar gone_kPa_ = 0;
  Scalar kPa_ticks_ = 0;
};

Moving Greybox::moving(const ChamberMotion& motion) const noexcept {
  const Scalar volume_mL = clamp(motion.volume_mL + dead_volume_mL_, least_volume_mL_, kMostVolume_mL);
  const Scalar speed_mL_s = clamp(motion.volume_rate_mL_s, -kMostSpeed_mL_s, kMostSpeed_mL_s);
  return {.first = kTick_s * kPerLitre / volume_mL,
          .second = volume_exponent_ / kPerLitre * speed_mL_s,
          .third = clamp(motion.supply, kLeastSupply, kMostSupply)};
}

Greybox::Tick Greybox::tick(Scalar pressure_kPa, const Moving& moves) const noexcept {
  Tick now{.pressure_kPa = clamp(pressure_kPa, Scalar(0), kMostPressure_kPa),
           .supply = moves.third,
           .per_volume = moves.first,
           .moved_L_s = moves.second};
  now.sides = sides_of(now.pressure_kPa, now.supply);
  now.between = stretch(now.sides, now.supply);
  now.flows = flows(now.sides, now.between, now.pressure_kPa, now.supply);
  return now;
}

Greybox::Sides Greybox::sides_of(Scalar pressure_kPa, Scalar supply) const noexcept {
  return {.inlet = inlet_.side_of(pressure_kPa / supply), .exhaust = exhaust_.side_of(pressure_kPa)};
}

Greybox::Stretch Greybox::stretch(const Sides& sides, Scalar supply) const noexcept {
  return {
      .low_kPa = max(inlet_.corner_at_kPa(sides.inlet, supply), exhaust_.corner_kPa[sides.exhaust]),
      .high_kPa = min(inlet_.corner_at_kPa(sides.inlet + 1, supply), exhaust_.corner_kPa[sides.exhaust + 1])};
}

Greybox::Flows Greybox::flows(const Sides& sides, const Stretch& between, Scalar pressure_kPa,
                              Scalar supply) const noexcept {
  const Curve& inlet = inlet_;
  const Scalar along_kPa = pressure_kPa - supply * inlet.corner_kPa[sides.inlet];
  const Scalar low_kPa = between.low_kPa, gap_from_kPa = gap_kPa(low_kPa);
  return {.inlet = supply * inlet.flow_kPa[sides.inlet] + inlet.slope[sides.inlet] * along_kPa,
          .exhaust = exhaust_.at(sides.exhaust, pressure_kPa),
          .leak = leak_L_s_kPa_ * (gap_from_kPa + ambient_kPa_) * (gap_from_kPa - ambient_kPa_) +
                  (low_kPa > kGap_kPa ? leak_L_s_kPa_ * (Scalar(2) * kGap_kPa) * (low_kPa - kGap_kPa)
                                      : Scalar(0)) +
                  leak_L_s_kPa_ * (gap_from_kPa + gap_kPa(between.high_kPa)) * (pressure_kPa - low_kPa)};
}

Greybox::Flows Greybox::slopes(const Sides& sides, const Stretch& between) const noexcept {
  return {.inlet = inlet_.slope[sides.inlet],
          .exhaust = exhaust_.slope[sides.exhaust],
          .leak = leak_L_s_kPa_ * (gap_kPa(between.low_kPa) + gap_kPa(between.high_kPa))};
}

/// On the way along a curve, drawn larger by `size`: the corner ahead, up or down.
template <bool up>
class Greybox::Way {
 public:
  Way(const Curve& curve, Scalar size, std::size_t side) noexcept : curve_(curve), size_(size), side_(side) {
    look();
  }
  Scalar ahead_kPa() const noexcept { return ahead_kPa_; }
  Scalar slope() const noexcept { return curve_.slope[side_]; }
  /// At the pressure of a corner: past those of the curve that lie there. Returns whether there were any.
  bool pass(Scalar here_kPa) noexcept {
    bool passed = false;
    while (ahead_kPa_ == here_kPa && (up ? side_ + 2 < kCorners : side_ > 0)) {
      side_ = up ? side_ + 1 : side_ - 1;
      passed = true;
      look();
    }
    return passed;
  }

 private:
  void look() noexcept { ahead_kPa_ = curve_.corner_at_kPa(up ? side_ + 1 : side_, size_); }

  const Curve& curve_;
  Scalar size_;
  std::size_t side_;
  Scalar ahead_kPa_ = 0;
};

/// Goes from corner to corner, up or down; returns the pressure at the end [kPa].
template <bool up, class Visit>
Scalar Greybox::go(const Tick& tick, const Law& law, Scalar rate_kPa, Scalar ticks,
                   Visit&& visit) const noexcept {
  Way<up> inlet(inlet_, tick.supply, tick.sides.inlet);
  Way<up> exhaust(exhaust_, Scalar(1), tick.sides.exhaust);
  Scalar by_inlet = law.inlet * inlet.slope(), by_exhaust = law.exhaust * exhaust.slope();
  const Scalar by_leak = law.leak * leak_L_s_kPa_;
  Scalar behind_kPa = gap_kPa(up ? tick.between.low_kPa : tick.between.high_kPa);
  Scalar from_kPa = tick.pressure_kPa;
  Scalar left = ticks;
  for (std::size_t passed = 0;; ++passed) {
    const Scalar corner_kPa =
        up ? min(inlet.ahead_kPa(), exhaust.ahead_kPa()) : max(inlet.ahead_kPa(), exhaust.ahead_kPa());
    const Scalar way_kPa = max(up ? corner_kPa - from_kPa : from_kPa - corner_kPa, Scalar(0));
    const Scalar slope = by_inlet + by_exhaust - by_leak * (behind_kPa + gap_kPa(corner_kPa)) - law.moved;
    const Scalar ahead_kPa = rate_kPa + slope * way_kPa;
    // at the mean of both rates it would be there sooner than it is
    const bool moves =
        ahead_kPa > kAtRest * rate_kPa && rate_kPa > kAtRest * ahead_kPa && passed < kMostPassed;
    if (moves && left * (rate_kPa + ahead_kPa) > Scalar(2) * way_kPa) {
      const Passage piece(way_kPa, rate_kPa, ahead_kPa);
      if (piece.ticks < left) {
        visit(piece);
        if (up ? corner_kPa >= kMostPressure_kPa : corner_kPa <= Scalar(0)) return corner_kPa;
        left -= piece.ticks;
        rate_kPa = ahead_kPa;
        from_kPa = corner_kPa;
        behind_kPa = gap_kPa(corner_kPa);
        if (inlet.pass(corner_kPa)) by_inlet = law.inlet * inlet.slope();
        if (exhaust.pass(corner_kPa)) by_exhaust = law.exhaust * exhaust.slope();
        continue;
      }
    }
    const Rest piece{rate_kPa, slope, left, numeric::phi_1(-slope * left)};
    visit(piece);
    const Scalar last_kPa = min(rate_kPa * left * piece.phi_1, way_kPa);
    return up ? from_kPa + last_kPa : from_kPa - last_kPa;
  }
}

/// Returns the pressure at the end [kPa]. It goes one way.
template <class Visit>
Scalar Greybox::travel(const Tick& tick, const Ports& open, Scalar ticks, Visit&& visit) const noexcept {
  const Law law(tick, open);
  const Scalar rate_kPa = law.rate_kPa(tick.flows, tick.pressure_kPa);
  return rate_kPa > Scalar(0) ? go<true>(tick, law, rate_kPa, ticks, visit)
                              : go<false>(tick, law, -rate_kPa, ticks, visit);
}

/// The one whose first node is the last that is not above the command.
std::size_t Greybox::segment(Scalar command_V) const noexcept {
  const auto above = std::upper_bound(node_V_.begin() + 1, node_V_.end() - 1, command_V);
  return static_cast<std::size_t>(above - node_V_.begin()) - 1;
}

Greybox::Ports Greybox::conductances(std::size_t segment, Scalar command_V) const noexcept {
  const Scalar along_V = command_V - node_V_[segment];
  return {node_[segment].inlet + slope_[segment].inlet * along_V,
          node_[segment].exhaust + slope_[segment].exhaust * along_V};
}

Opening Greybox::opening(Scalar command_V) const noexcept {
  const Scalar command = clamp(command_V, node_V_.front(), node_V_.back());
  const Ports open = conductances(segment(command), command);
  return {.first = open.inlet, .second = open.exhaust};
}

Prediction Greybox::step(Scalar pressure_kPa, const Opening& open, const Moving& moves,
                         Scalar ticks) const noexcept {
  const Tick now = tick(pressure_kPa, moves);
  MeanRise rise;
  const Scalar end_kPa = travel(now, {.inlet = open.first, .exhaust = open.second}, ticks, rise);
  const Scalar gone_kPa = ticks > Scalar(0) ? rise.kPa_ticks() / ticks : Scalar(0);
  return {.end_kPa = end_kPa,
          .mean_kPa = end_kPa < now.pressure_kPa ? now.pressure_kPa - gone_kPa : now.pressure_kPa + gone_kPa};
}

Draw Greybox::draw(Scalar pressure_kPa, const Opening& open, const Moving& moves) const noexcept {
  const Scalar supply = moves.third;
  const Scalar of_whole_kPa = clamp(pressure_kPa, Scalar(0), kMostPressure_kPa) / supply;
  const std::size_t side = inlet_.side_of(of_whole_kPa);
  const Scalar flow_kPa = inlet_.at(side, of_whole_kPa);
  // phi(S P, p) = S phi(P, p/S)
  return {.flow_kPa_L_s = open.first * (supply * flow_kPa),
          .by_supply_kPa_L_s = open.first * (flow_kPa - inlet_.slope[side] * of_whole_kPa)};
}

/// Between ambient and supply all. Above the supply's pressure an open inlet empties the chamber, below the ambient's an open
/// exhaust fills it: there the limit is the first node at which the pressure rises or falls fastest, the valve as good as shut. Not
/// where that node keeps the pressure so close to them (r_a) that nothing flows back.
Greybox::Range Greybox::answers(const Tick& tick) const noexcept {
  Range among;
  const bool above = tick.pressure_kPa > tick.supply * supply_kPa_;
  if (!above && tick.pressure_kPa >= ambient_kPa_) return among;
  const Flows& here = tick.flows;
  const Scalar sign = above ? Scalar(1) : Scalar(-1);
  std::size_t best = 0;
  const auto flow = [&](std::size_t i) noexcept {
    return sign * (node_[i].inlet * here.inlet + node_[i].exhaust * here.exhaust);
  };
  Scalar best_flow = flow(0);
  for (std::size_t i = 1; i < kNodes; ++i) {
    const Scalar at_node = flow(i);
    if (at_node - best_flow > kAlike * abs(best_flow)) {
      best = i;
      best_flow = at_node;
    }
  }
  if ((above ? here.inlet : here.exhaust) == Scalar(0)) {
    const Scalar end_kPa = travel(tick, node_[best], Scalar(1), [](const auto&) noexcept {});
    const bool flows_back = above ? end_kPa > inlet_.corner_at_kPa(kSource + 1, tick.supply)
                                  : end_kPa < exhaust_.corner_kPa[kSource - 1];
    if (!flows_back) return among;
  }
  (above ? among.last : among.first) = best;
  return among;
}

/// What the end gains by the command on a segment, `by` the conductances [kPa/V].
Scalar Greybox::slope_by(const Ports& by, std::size_t segment) const noexcept {
  return numeric::product_within<kSteepest>(by.inlet, slope_[segment].inlet) +
         numeric::product_within<kSteepest>(by.exhaust, slope_[segment].exhaust);
}

/// The command at which the ports have gained so much, `by` their conductances, since it was `from_V`; a limit of the
/// range where they cannot.
Scalar Greybox::gaining_V(const Range& among, const Ports& by, Scalar from_V,
                          Scalar wanted_kPa) const noexcept {
  const std::size_t here = segment(from_V);
  const Scalar slope_kPa_V = slope_by(by, here);
  if (slope_kPa_V > kLeastNewton_kPa_V) {
    const Scalar to_V = from_V + numeric::ratio_within<kBeyond>(wanted_kPa, slope_kPa_V);
    if (to_V >= node_V_[here] && to_V <= node_V_[here + 1])
      return clamp(to_V, node_V_[among.first], node_V_[among.last]);
  }
  const Ports open = conductances(here, from_V);
  const auto gain_kPa = [&](std::size_t node) noexcept {
    return by.inlet * (node_[node].inlet - open.inlet) + by.exhaust * (node_[node].exhaust - open.exhaust);
  };
  std::size_t low = among.first, high = among.last;
  if (gain_kPa(low) >= wanted_kPa) return node_V_[low];
  if (gain_kPa(high) <= wanted_kPa) return node_V_[high];
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (gain_kPa(middle) > wanted_kPa ? high : low) = middle;
  }
  const Scalar low_kPa = gain_kPa(low);
  const Scalar share = (wanted_kPa - low_kPa) / (gain_kPa(high) - low_kPa);
  return node_V_[low] + share * (node_V_[high] - node_V_[low]);
}

/// The command that reaches the target were f a straight line from the pressure to there: Newton's method for the
/// conductances, in which the end is almost straight, from `near_V`.
Greybox::Guess Greybox::guess(const Tick& tick, const Range& among, Scalar target_kPa,
                              Scalar near_V) const noexcept {
  const Scalar wanted_kPa = target_kPa - tick.pressure_kPa;
  const Sides there = sides_of(target_kPa, tick.supply);
  const bool near = there == tick.sides || abs(wanted_kPa) < kNear_kPa;
  const Flows& from = tick.flows;
  const Flows to = flows(there, stretch(there, tick.supply), target_kPa, tick.supply);
  const Flows slope = near ? slopes(tick.sides, tick.between)
                           : Flows{.inlet = (to.inlet - from.inlet) / wanted_kPa,
                                   .exhaust = (to.exhaust - from.exhaust) / wanted_kPa,
                                   .leak = (to.leak - from.leak) / wanted_kPa};
  const Scalar close_kPa = max(kClose_kPa, near ? Scalar(0) : kGuessed * abs(wanted_kPa));
  Guess made;
  made.command_V = clamp(near_V, node_V_[among.first], node_V_[among.last]);
  for (int i = 0; i < kGuesses; ++i) {
    const Law law(tick, conductances(segment(made.command_V), made.command_V));
    const Scalar rate_kPa = law.rate_kPa(from, tick.pressure_kPa);
    const Scalar x = -law.slope(slope);
    const Scalar phi_1 = numeric::phi_1(x);
    const Scalar further_kPa =
        clamp(rate_kPa * (phi_1 - numeric::phi_2(x, phi_1)), -kFarther_kPa, kFarther_kPa);  // (G5) by J
    const auto by = [&](Scalar from_kPa, Scalar by_pressure) noexcept {
      return tick.per_volume *
             (from_kPa * phi_1 + clamp(by_pressure * further_kPa, -kMostFlow_kPa, kMostFlow_kPa));
    };
    made.by = {by(from.inlet, slope.inlet), by(from.exhaust, slope.exhaust)};
    const Scalar missed_kPa = wanted_kPa - rate_kPa * phi_1;
    if (abs(missed_kPa) <= close_kPa) break;
    made.command_V = gaining_V(among, made.by, made.command_V, missed_kPa);
  }
  return made;
}

/// Where the answer lies: above one command and below another. Of an end that has not been tried the command lies beyond the range.
class Greybox::Bracket {
 public:
  Bracket(const Greybox& of, const Range& among) noexcept
      : of_(of),
        least_V_(of.node_V_[among.first]),
        most_V_(of.node_V_[among.last]),
        low_{least_V_ - Scalar(1)},
        high_{most_V_ + Scalar(1)},
        first_(among.first),
        last_(among.last) {}

  bool holds(Scalar command_V) const noexcept {
    return command_V > low_.command_V && command_V < high_.command_V;
  }

  /// Of a command within. `wanted_kPa`: the target less its end.
  void tried(Scalar command_V, Scalar wanted_kPa) noexcept {
    const bool low = wanted_kPa > Scalar(0);
    (low ? low_ : high_) = {command_V, wanted_kPa};
    // Illinois: an end that stays draws the chord less and less to itself
    if (low == was_low_) (low ? high_ : low_).wanted_kPa *= Scalar(0.5);
    was_low_ = low;
    const std::size_t in = of_.segment(command_V);
    if (low) first_ = in + 1;
    if (!low) last_ = command_V > of_.node_V_[in] ? in : in - 1;
  }

  /// The middle one of the nodes within, until there is none; then where the chord of its ends meets the target, and the middle after
  /// a chord that has not halved the width.
  Scalar next_V() noexcept {
    const Scalar width_V = high_.command_V - low_.command_V;
    if (first_ <= last_ && last_ < kNodes) {
      const Scalar node_V = of_.node_V_[(first_ + last_) / 2];
      const bool apart = node_V - low_.command_V > kOneCommand_V && high_.command_V - node_V > kOneCommand_V;
      if (apart) return node_V;  // nodes at a limit of the range may be one
    }
    if (low_.command_V < least_V_) return least_V_;
    if (high_.command_V > most_V_) return most_V_;
    const bool slow = width_V > Scalar(0.5) * width_before_V_;
    width_before_V_ = slow ? kNoWidth_V : width_V;
    const Scalar share = low_.wanted_kPa / (low_.wanted_kPa - high_.wanted_kPa);
    const Scalar chord_V = low_.command_V + share * width_V;
    return !slow && holds(chord_V) ? chord_V : low_.command_V + Scalar(0.5) * width_V;
  }

 private:
  struct End {
    Scalar command_V;
    Scalar wanted_kPa = 0;
  };

  const Greybox& of_;
  Scalar least_V_, most_V_;
  End low_, high_;
  std::size_t first_, last_;  ///< nodes within
  bool was_low_ = false;
  static constexpr Scalar kNoWidth_V = Scalar(1000);
  Scalar width_before_V_ = kNoWidth_V;  ///< of the last chord; kNoWidth_V: of none
};

/// The end rises with the command among the answers, so that there is one. What it gains by the conductances is taken as the guess has
/// it but for a factor, that of the last two ends: secants. Where they do not halve what is missed, the bracket is searched.
Inverse Greybox::inverse(Scalar pressure_kPa, Scalar target_kPa, const Moving& moves,
                         Scalar near_V) const noexcept {
  const Tick now = tick(pressure_kPa, moves);
  const Range among = answers(now);
  const Scalar least_V = node_V_[among.first], most_V = node_V_[among.last];
  Bracket bracket(*this, among);
  bool by_secants = true;

  const Guess first = guess(now, among, target_kPa, near_V);
  Scalar command_V = first.command_V;
  Scalar factor = Scalar(1);
  Ports open_before;
  Scalar end_before_kPa = 0, wanted_before_kPa = 0;
  Inverse best;
  Scalar best_kPa = kMostPressure_kPa;  // that it misses
  for (int i = 0; i <= kRefinements; ++i) {
    const std::size_t in = segment(command_V);
    const Ports open = conductances(in, command_V);
    const Scalar end_kPa = travel(now, open, Scalar(1), [](const auto&) noexcept {});
    if (i > 0) {
      const Scalar told_kPa = first.by.inlet * (open.inlet - open_before.inlet) +
                              first.by.exhaust * (open.exhaust - open_before.exhaust);
      const Scalar gained_kPa = end_kPa - end_before_kPa;
      const bool as_told =
          told_kPa > Scalar(0) ? gained_kPa > Scalar(0) : told_kPa < Scalar(0) && gained_kPa < Scalar(0);
      if (as_told) factor = numeric::ratio_within<kMostFactor>(gained_kPa, told_kPa);
    }
    const Scalar wanted_kPa = target_kPa - end_kPa;
    const bool halved = abs(wanted_kPa) <= Scalar(0.5) * abs(wanted_before_kPa);
    by_secants = by_secants && i < kSecants && (i < 2 || halved);
    open_before = open;
    end_before_kPa = end_kPa;
    wanted_before_kPa = wanted_kPa;
    const bool beyond = command_V == (wanted_kPa > Scalar(0) ? most_V : least_V);
    if (abs(wanted_kPa) < best_kPa) {
      best_kPa = abs(wanted_kPa);
      best = {.command_V = command_V,
              .reached_kPa = end_kPa,
              .by_command_kPa_V = numeric::product_within<kSteepest>(factor, slope_by(first.by, in))};
    }
    best.saturated = beyond && best_kPa > kClose_kPa;
    if (best_kPa <= kClose_kPa || beyond) break;

    bracket.tried(command_V, wanted_kPa);
    if (by_secants)
      command_V = gaining_V(among, first.by, command_V, numeric::ratio_within<kMostGain>(wanted_kPa, factor));
    if (!by_secants || !bracket.holds(command_V)) command_V = bracket.next_V();
    if (!bracket.holds(command_V)) break;  // of two neighbours among the numbers
  }
  return best;
}

}  // namespace plenum::control
