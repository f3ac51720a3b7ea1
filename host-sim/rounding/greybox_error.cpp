#include "host-sim/rounding/greybox_error.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>
#include <vector>

#include "host-sim/rounding/rounded.hpp"

namespace rounding {
namespace {

using Curve = GreyboxTables::Curve;
using Ports = GreyboxTables::Ports;
namespace phi = plenum::numeric::phi;

constexpr double kUlp = plenum::numeric::Rounded::kUlp, kHalfUlp = plenum::numeric::Rounded::kHalfUlp;
constexpr double kMostSpeed_mL_s = 1500, kMostShare = 0.5, kTick_s = 0.01;
constexpr double kRange = 0x1p31;

// Of the core (greybox.cpp, scalar.hpp).
constexpr double kAtRest = 1e-7;                 // share of a rate that counts as none
constexpr double kSlightBend = 0.4;              // |bend| from which the logarithm is taken
constexpr double kSeriesError = 3e-8;            // of artanh_ratio(), of it
constexpr double kSeriesLagError = 5e-7;         // of artanh_lag(), of it
constexpr double kLogError = 2e-9 + 3e-10 * 17;  // of log(), for ratios down to kAtRest
constexpr double kLogRemainder = 4e-10;          // of its series, in exact numbers, too

/// The broken line through the corners [kPa].
double at(const Curve& curve, double kPa) {
  const auto& x = curve.corner_kPa;
  const auto above = std::upper_bound(x.begin() + 1, x.end() - 1, kPa);
  const auto i = static_cast<std::size_t>(above - x.begin());
  const double width = x[i] - x[i - 1];
  const double along = width > 0 ? (kPa - x[i - 1]) / width : 0;
  return curve.flow_kPa[i - 1] + along * (curve.flow_kPa[i] - curve.flow_kPa[i - 1]);
}

struct Range {
  double low, high;
};

/// The corners of these curves within a range, and its ends; rising.
std::vector<double> corners_within(const Range& range, std::initializer_list<const Curve*> curves) {
  std::vector<double> found{range.low, range.high};
  for (const Curve* curve : curves)
    for (const double kPa : curve->corner_kPa)
      if (kPa > range.low && kPa < range.high) found.push_back(kPa);
  std::sort(found.begin(), found.end());
  return found;
}

/// What is known of one flow over the pressures of a tick.
struct Flow {
  double most = 0;      ///< by amount
  double off = 0;       ///< of the line that the board walks along
  double steepest = 0;  ///< of the slopes
  double widest = 0;    ///< change over a side
};

/// The board begins on a side, by its slope, and goes on by the slopes of the sides that it passes: what they miss adds up.
Flow known_of(const Curve& board, const Curve& exact, const Range& range) {
  Flow flow;
  for (const double kPa : corners_within(range, {&board, &exact})) {
    flow.most = std::max(flow.most, std::fabs(at(exact, kPa)));
    flow.off = std::max(flow.off, std::fabs(at(board, kPa) - at(exact, kPa)));
  }
  double missed = 0;
  const std::vector<double> corners = corners_within(range, {&board});
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const double from = corners[i], to = corners[i + 1];
    if (!(to > from)) continue;
    const double middle = 0.5 * (from + to);
    const auto above = std::upper_bound(board.corner_kPa.begin() + 1, board.corner_kPa.end() - 1, middle);
    const double slope = board.slope[static_cast<std::size_t>(above - board.corner_kPa.begin()) - 1];
    const double rise = at(board, to) - at(board, from);
    missed += std::fabs(slope * (to - from) - rise);
    flow.steepest = std::max(flow.steepest, std::fabs(rise / (to - from)));
    flow.widest = std::max(flow.widest, std::fabs(rise));
  }
  flow.off += 2 * missed + kHalfUlp;  // the product on the first side, rounded
  return flow;
}

/// C_l lambda [kPa L/s], by chords from each corner of f to the next.
Flow leak_of(const GreyboxTables& board, const GreyboxTables& exact, const Range& range) {
  const double k = exact.leak_L_s_kPa, ambient = exact.ambient_kPa;
  double moved = 0;  // the board's corners
  for (const auto& [of_board, of_exact] :
       {std::pair{&board.inlet, &exact.inlet}, {&board.exhaust, &exact.exhaust}})
    for (std::size_t i = 0; i < of_exact->corner_kPa.size(); ++i)
      moved = std::max(moved, std::fabs(of_board->corner_kPa[i] - of_exact->corner_kPa[i]));
  // where the chord ends that the range ends on
  double top = exact.gap_kPa;
  for (const Curve* curve : {&exact.inlet, &exact.exhaust})
    for (const double kPa : curve->corner_kPa)
      if (kPa >= range.high) top = std::min(top, kPa);
  top = std::max(top, range.high);
  double widest = 0;
  const std::vector<double> corners = corners_within({range.low, top}, {&exact.inlet, &exact.exhaust});
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) widest = std::max(widest, corners[i + 1] - corners[i]);
  // where corners cross that lie at one place in exact numbers
  widest += 2 * moved;
  const double square = std::max(range.high * top, ambient * ambient), way = range.high - range.low;
  const double gain_off = std::fabs(board.leak_L_s_kPa - k);
  return {.most = k * square,
          .off = gain_off * square + 2 * (k + gain_off) * widest * moved +  // a chord whose ends move
                 kHalfUlp * (range.high + widest + 3) +                     // the products at the start
                 kHalfUlp * way,                                            // the slopes
          .steepest = 2 * k * top,
          .widest = 2 * k * top * widest};
}

/// Conductance of a port: the most, and how far the board's is from it at any command, itself rounded.
struct Port {
  double most = 0;
  double off = 0;
};

Port known_of(const GreyboxTables& board, const GreyboxTables& exact, double Ports::*of) {
  const auto interpolated = [of](const GreyboxTables& tables, double command_V) {
    const auto& x = tables.node_V;
    const auto above = std::upper_bound(x.begin() + 1, x.end() - 1, command_V);
    const auto i = static_cast<std::size_t>(above - x.begin());
    return tables.node[i - 1].*of + tables.slope[i - 1].*of * (command_V - x[i - 1]);
  };
  Port port;
  double steepest = 0;
  for (const GreyboxTables* tables : {&board, &exact}) {
    for (std::size_t i = 0; i < tables->node_V.size(); ++i) {
      // from either side: the board's pieces need not meet
      for (const double command_V : {tables->node_V[i], std::nextafter(tables->node_V[i], 0.0)}) {
        port.most = std::max(port.most, interpolated(exact, command_V));
        port.off =
            std::max(port.off, std::fabs(interpolated(board, command_V) - interpolated(exact, command_V)));
      }
    }
    for (const Ports& slope : tables->slope) steepest = std::max(steepest, std::fabs(slope.*of));
  }
  port.off += kHalfUlp * (steepest + 1);  // the command's rounding, and the product's
  return port;
}

/// (G1) with the worst of all states put in: of each flow the most that its share in f can be [1 a tick], and how far the board's is
/// from it.
struct Coefficient {
  double most = 0;
  double off = 0;
};

struct Law {
  Coefficient inlet, exhaust, leak, moved;
};

/// Of a chamber with what its sensor does not count: a millilitre, or that, or what a smaller one counts as.
double least_mL(const GreyboxTables& of) {
  return std::max({1.0, of.dead_volume_mL, of.least_volume_mL});
}

Law law_of(const GreyboxTables& board, const GreyboxTables& exact) {
  const double volume_mL = least_mL(exact);
  const double volume_off_mL =
      std::max(2 * kHalfUlp, std::fabs(board.least_volume_mL - exact.least_volume_mL));
  const Coefficient per_volume{
      .most = exact.tick_s_mL_L / volume_mL,
      // numerator; chamber and dead volume, each rounded, or the least; the quotient
      .off = std::fabs(board.tick_s_mL_L - exact.tick_s_mL_L) / volume_mL +
             exact.tick_s_mL_L * volume_off_mL / (volume_mL * (volume_mL - volume_off_mL)) + kHalfUlp};
  const auto times = [&](const Port& port) {
    return Coefficient{
        .most = per_volume.most * port.most,
        .off = per_volume.most * port.off + per_volume.off * (port.most + port.off) + kHalfUlp};
  };
  // n v' [L/s] in the least volume; that of the greatest speed in all others, of a smaller share
  const double speed_mL_s = kMostShare * volume_mL / kTick_s;
  const double of_speed = std::fabs(exact.volume_exponent) / 1000;
  const double moved_off = speed_mL_s * (kHalfUlp / 1000 + kHalfUlp) + of_speed * kHalfUlp + kHalfUlp;
  Law law{.inlet = times(known_of(board, exact, &Ports::inlet)),
          .exhaust = times(known_of(board, exact, &Ports::exhaust)),
          .leak = per_volume,
          .moved = {.most = kMostShare * std::fabs(exact.volume_exponent)}};
  law.moved.off = per_volume.most * moved_off + per_volume.off * of_speed * speed_mL_s +
                  kHalfUlp * (1 + of_speed * kMostSpeed_mL_s);
  return law;
}

/// The largest of a function of bounds over the arguments of an exponential of a tick, in parts of them.
template <class Function>
double largest_over_parts(double low, double high, Function&& of) {
  constexpr int kParts = 400;
  const auto x = [&](int i) {  // dense about 0
    const double share = 2.0 * i / kParts - 1;
    return share < 0 ? low * share * share : high * std::pow(share, 6);
  };
  double largest = 0;
  for (int i = 0; i < kParts; ++i) largest = std::max(largest, of(x(i), x(i + 1)));
  return largest;
}

/// The sides of f that a tick may pass.
struct Sides {
  double rising;        ///< J_+: the most that the slope of f is above 0 [1 a tick]
  double away = 0;      ///< E: the most that J p exceeds f by [kPa a tick]
  double widest = 0;    ///< [kPa]
  double farthest = 1;  ///< from one corner to the next, as a ratio
  double corners = 1;   ///< how many
};

Sides sides_of(const GreyboxTables& exact, const Law& law, const Range& range) {
  Sides sides{.rising = law.moved.most};
  const std::vector<double> corners = corners_within(range, {&exact.inlet, &exact.exhaust});
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const double from = corners[i], to = corners[i + 1];
    if (!(to > from)) continue;
    const auto slope = [&](const Curve& of) { return (at(of, to) - at(of, from)) / (to - from); };
    const auto turned = [&](const Curve& of) { return slope(of) * from - at(of, from); };
    const auto of_ports = [&](const auto& of) {
      return law.inlet.most * std::max(of(exact.inlet), 0.0) +
             law.exhaust.most * std::max(of(exact.exhaust), 0.0);
    };
    sides.rising = std::max(sides.rising, law.moved.most + of_ports(slope));
    sides.away = std::max(sides.away, of_ports(turned));
    sides.widest = std::max(sides.widest, to - from);
    sides.farthest = std::max(sides.farthest, to / from);
    ++sides.corners;
  }
  return sides;
}

/// G. Infinite where phi_1 of the core may take a growth for less: it takes one beyond e^4 for that, where the pressure does not get
/// to a corner before. It does if J p is mostly f.
double growth_of(const Sides& sides, const Range& range) {
  constexpr double kMostAway = 3, kFarthest = 13;
  const double away = sides.away / range.low;
  if (sides.rising > plenum::numeric::kGrowthHigh && (away > kMostAway || sides.farthest > kFarthest))
    return std::numeric_limits<double>::infinity();
  constexpr double kSecondOrder = 1.01;
  return kSecondOrder * std::min(std::exp(sides.rising), range.high / range.low * std::exp(away));
}

}  // namespace

double greybox_tick_error_kPa(const GreyboxTables& board, const GreyboxTables& exact) {
  const Law law = law_of(board, exact);
  // Nothing but the moving volume takes the pressure out of what lies between ambient and supply.
  const double swing = 1.001 * std::exp(law.moved.most);
  const Range range{exact.ambient_kPa / swing, exact.supply_kPa * swing};
  const Flow inlet = known_of(board.inlet, exact.inlet, range);
  const Flow exhaust = known_of(board.exhaust, exact.exhaust, range);
  const Flow leak = leak_of(board, exact, range);
  const auto sum = [&](double Flow::*of) {
    return law.inlet.most * inlet.*of + law.exhaust.most * exhaust.*of + law.leak.most * leak.*of;
  };
  const double most_rate = sum(&Flow::most) + law.moved.most * range.high;  // |f| [kPa a tick]
  const double steepest = sum(&Flow::steepest) + law.moved.most;            // |J| [1 a tick]
  const Sides sides = sides_of(exact, law, range);
  const double growth = growth_of(sides, range);
  if (!(std::max({most_rate, steepest, board.inlet.corner_kPa.back(), growth}) < kRange))
    return std::numeric_limits<double>::infinity();

  // e: the line that the board walks along; its roundings at the start, of each slope by the way on it, of each rate ahead
  const auto off = [](const Coefficient& of, const Flow& flow) {
    return of.off * (flow.most + flow.off) + of.most * flow.off;
  };
  const double way = range.high - range.low;
  const double pieces_off = off(law.inlet, inlet) + off(law.exhaust, exhaust) + off(law.leak, leak) +
                            law.moved.off * range.high + kHalfUlp * (4 * way + sides.corners + 5);

  // jumps: at a corner, by the time to it; at one that is not passed, where the rate is a share of that before it and has fallen to
  // that over one side
  const double by_log = way / kSlightBend * (kLogError + kLogRemainder + kHalfUlp);
  const double by_series = way * 1.5 * (kSeriesError + kLogRemainder);
  constexpr double kTimeUlps = 5;
  const double by_time = sides.corners * kUlp * (kTimeUlps * most_rate + 2);
  const double passages = by_log + by_series + by_time;
  const double stays = kAtRest * (sum(&Flow::widest) + law.moved.most * sides.widest);

  // at the end: the way within the last side, by an exponential
  const double least_x = -std::min(sides.rising, double{plenum::numeric::kGrowthHigh});
  const double most_x = std::max(steepest, double{plenum::numeric::kDecayHigh} + 1);
  const auto of_way = [&](double (&function)(double), double (&rounding)(double, double)) {
    return largest_over_parts(least_x, most_x, [&](double low, double high) {
      return (rounding(low, high) + kHalfUlp * phi::slope(function, low)) / phi::first(high);
    });
  };
  const double rest = sides.widest * of_way(phi::first, phi::first_rounding) + kUlp * (most_rate + 2);

  // The series, a corner that is not passed and the last exponential are as far off the solution in exact numbers: twice.
  const double end = growth * (kHalfUlp + pieces_off + passages + by_series + 2 * stays) + 2 * rest;
  // The mean of what is off on the way, and its own roundings: a passage's by its time, as jumps are; of the series for where the
  // pressure is in the mean; of the last piece; of a few products a piece.
  return end + passages / kSlightBend +
         way * (kTimeUlps * kUlp + 2 * (kSeriesError + 0.07 * kSeriesLagError)) +
         2 * sides.widest * of_way(phi::second, phi::second_rounding) + sides.corners * kUlp * (way + 4);
}

}  // namespace rounding
