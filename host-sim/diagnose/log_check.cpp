#include "host-sim/diagnose/log_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/log_csv.hpp"

namespace plenum::host::diagnose {
namespace {

using trace::InputError;
using trace::RigDescription;

constexpr double kKappa = 1.4;
/// Choked flow of dry air per area, pressure and 1/sqrt(temperature) [kg sqrt(K)/(m2 s Pa)].
constexpr double kChoked = 0.0404;
constexpr double kGasConstant_J_per_kg_K = 287.06;
/// Over which a pressure's rate is taken: long enough for noise to average out, short against a fill.
constexpr double kRateOver_s = 0.05;

double quantile(std::vector<double> values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

double least(const std::vector<double>& values) {
  return *std::min_element(values.begin(), values.end());
}

double greatest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

double span_Pa(const RigDescription& rig) {
  return rig.supply.pressure_Pa - rig.ambient.pressure_Pa;
}

std::size_t rate_rows(const trace::Log& log) {
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(kRateOver_s / log.period_s)));
}

/// More rows than a glitch or the edge of a transient has.
bool many(std::ptrdiff_t rows, const trace::Log& log) {
  return static_cast<double>(rows) > std::max(0.01 * static_cast<double>(log.size()), 0.1 / log.period_s);
}

// ---- pressure

struct Unit {
  const char* name;
  double in_Pa;
};
/// The larger first: 1 to 7 could be hPa of a tiny gauge pressure, but is bar.
constexpr std::array<Unit, 7> kUnits{{{"MPa", 1e6},
                                      {"bar", 1e5},
                                      {"psi", 6894.757},
                                      {"kPa", 1e3},
                                      {"hPa (mbar)", 100.0},
                                      {"cmH2O", 98.0665},
                                      {"Pa", 1.0}}};

/// How far below ambient a sound reading may be, beyond what growth of the volume explains: sensors err.
constexpr double kBelowAmbient = 0.7;
/// Of ambient: what is open to it comes that near to 0 by gauge, and no chamber's vacuum is so deep.
constexpr double kNearZero = 0.1;
/// Of ambient: who is never above that has no supply.
constexpr double kAtAmbient = 1.05;
/// How far above the supply: it may be off, and sensors err.
constexpr double kAboveSupply = 1.5;

/// The pressure of each row, were it `gain` p + `reference_Pa`, if the chamber still had the least (or the
/// greatest) volume that it had before: one that is closed goes below ambient as it grows, and above the supply
/// as it shrinks. One that the log finds below ambient (or above the supply) may have had the
/// least (or greatest) volume of the whole log before.
struct VolumeFree {
  std::vector<double> low_Pa;
  std::vector<double> high_Pa;
};
VolumeFree volume_free(const trace::Log& log, const RigDescription& rig, double gain, double reference_Pa) {
  VolumeFree result;
  const double least_ever_m3 = least(log.volume_m3), greatest_ever_m3 = greatest(log.volume_m3);
  double least_m3 = log.volume_m3.front();
  double greatest_m3 = least_m3;
  bool found_below = true, found_above = true;
  for (std::size_t i = 0; i < log.size(); ++i) {
    least_m3 = std::min(least_m3, log.volume_m3[i]);
    greatest_m3 = std::max(greatest_m3, log.volume_m3[i]);
    const double p = gain * log.pressure_Pa[i] + reference_Pa;
    found_below = found_below && p < rig.ambient.pressure_Pa;
    found_above = found_above && p > rig.supply.pressure_Pa;
    result.low_Pa.push_back(p *
                            std::pow(log.volume_m3[i] / (found_below ? least_ever_m3 : least_m3), kKappa));
    result.high_Pa.push_back(
        p * std::pow(log.volume_m3[i] / (found_above ? greatest_ever_m3 : greatest_m3), kKappa));
  }
  return result;
}

/// What the numbers of this log would be in range as; empty where no unit of the table makes sense of them.
std::string likeness(const trace::Log& log, const RigDescription& rig) {
  const auto fits = [&](double in_Pa, double reference_Pa) {
    const VolumeFree p = volume_free(log, rig, in_Pa, reference_Pa);
    return quantile(p.low_Pa, 0.005) >= kBelowAmbient * rig.ambient.pressure_Pa &&
           quantile(p.high_Pa, 0.995) <= kAboveSupply * rig.supply.pressure_Pa;
  };
  for (const Unit& unit : kUnits) {
    if (unit.in_Pa > 1.0 && fits(unit.in_Pa, 0.0)) return fmt::format("looks like {}, ", unit.name);
  }
  for (const Unit& unit : kUnits) {
    if (!fits(unit.in_Pa, rig.ambient.pressure_Pa)) continue;
    if (unit.in_Pa * quantile(log.pressure_Pa, 0.005) < kNearZero * rig.ambient.pressure_Pa) {
      return fmt::format("looks like gauge pressure in {}, ", unit.name);
    }
    const bool always = unit.in_Pa * greatest(log.pressure_Pa) < kAtAmbient * rig.ambient.pressure_Pa;
    return fmt::format("below ambient{}: {}; ", unit.in_Pa > 1.0 ? fmt::format(" in {}", unit.name) : "",
                       always ? "a vacuum is not supported, and gauge pressure would come near 0"
                              : "gauge pressure, or a vacuum, which is not supported");
  }
  return "";
}

void require_pressure(const NamedLog& of, const RigDescription& rig) {
  const trace::Log& log = of.log;
  const double ambient_Pa = rig.ambient.pressure_Pa;
  const double low_Pa = least(log.pressure_Pa);
  const double high_Pa = greatest(log.pressure_Pa);
  const std::string range = fmt::format("{:.6g} to {:.6g}", low_Pa, high_Pa);
  const VolumeFree p = volume_free(log, rig, 1.0, 0.0);
  const auto below = std::count_if(p.low_Pa.begin(), p.low_Pa.end(),
                                   [&](double one) { return one < kBelowAmbient * ambient_Pa; });
  const auto above = std::count_if(p.high_Pa.begin(), p.high_Pa.end(),
                                   [&](double one) { return one > kAboveSupply * rig.supply.pressure_Pa; });
  if (quantile(log.pressure_Pa, 0.995) < 0.2 * ambient_Pa || many(below, log)) {
    throw InputError(
        fmt::format("{}: column pressure_Pa: {}, {}expected absolute pressure in Pa, ambient is {:.6g}",
                    of.name, range, likeness(log, rig), ambient_Pa));
  }
  if (many(above, log)) {
    throw InputError(fmt::format(
        "{}: column pressure_Pa: {}, far above the supply, expected absolute pressure in Pa up to the rig's "
        "supply.pressure_Pa = {:.6g}",
        of.name, range, rig.supply.pressure_Pa));
  }
  if (low_Pa <= 0.0) {
    const auto row =
        std::min_element(log.pressure_Pa.begin(), log.pressure_Pa.end()) - log.pressure_Pa.begin();
    throw InputError(
        fmt::format("{}: row {}, column pressure_Pa: {:.6g}, expected absolute pressure, above 0", of.name,
                    row + 1, low_Pa));
  }
}

/// The supply while little is drawn from it.
double undrawn_Pa(const trace::Log& log) {
  return quantile(log.supply_Pa, 0.9);
}

void require_supply(const NamedLog& of, const RigDescription& rig) {
  if (of.log.supply_Pa.empty()) return;
  const double supply_Pa = undrawn_Pa(of.log);
  if (!(supply_Pa > 0.8 * rig.supply.pressure_Pa && supply_Pa < 1.25 * rig.supply.pressure_Pa)) {
    throw InputError(
        fmt::format("{}: column supply_Pa comes to {:.6g}, expected absolute pressure in Pa near the rig's "
                    "supply.pressure_Pa = {:.6g}: where the column is right, correct the rig",
                    of.name, supply_Pa, rig.supply.pressure_Pa));
  }
  const auto low = std::min_element(of.log.supply_Pa.begin(), of.log.supply_Pa.end());
  if (*low >= kBelowAmbient * rig.ambient.pressure_Pa) return;
  throw InputError(
      fmt::format("{}: row {}, column supply_Pa: {:.6g}, expected absolute pressure in Pa, ambient is {:.6g}",
                  of.name, low - of.log.supply_Pa.begin() + 1, *low, rig.ambient.pressure_Pa));
}

// ---- command

/// Any valve may be given so much: 12 V, and a margin.
constexpr double kAnyValve_V = 12.6;
/// What a valve may be given, over the thresholds at which its ports open: twice those about, and a margin.
constexpr double kOfThresholds = 2.5;
constexpr double kMostValve_V = 25.2;  ///< 24 V, and a margin
constexpr double kPerCent = 105.0;     ///< likewise

void require_command(const NamedLog& of, const RigDescription& rig) {
  const RigDescription::Valve& valve = rig.valve;
  const double low_V = least(of.log.command_V);
  const double high_V = greatest(of.log.command_V);
  const double threshold_V = std::max(std::abs(valve.open_above_V), std::abs(valve.exhaust_below_V));
  const double highest_V = std::min(kMostValve_V, std::max(kAnyValve_V, kOfThresholds * threshold_V));
  const auto refuse = [&](const char* likeness) {
    throw InputError(fmt::format(
        "{}: column command_V: {:.6g} to {:.6g}, {}, expected volts, up to {:.3g} where the rig's ports "
        "open below {:.6g} and above {:.6g} V (valve.exhaust_below_V, valve.open_above_V)",
        of.name, low_V, high_V, likeness, highest_V, valve.exhaust_below_V, valve.open_above_V));
  };
  if (const double most_V = std::max(high_V, -low_V); most_V > highest_V) {
    refuse(most_V > kPerCent       ? "too large"
           : most_V > kMostValve_V ? "looks like per cent"
                                   : "looks like per cent, or like a valve of more volts");
  }
  const bool moves = high_V - low_V > 0.05;
  if (moves && high_V <= 1.05 && low_V >= -1.05 && valve.exhaust_below_V > 1.5) {
    refuse("looks normalised to 1");
  }
}

// ---- volume

/// Choked flow through the widest opening of this log, at the rig's figures, as the pV it could move [Pa m3/s].
double nominal_capacity_Pa_m3_s(const trace::Log& log, const RigDescription& rig) {
  const RigDescription::Valve& valve = rig.valve;
  constexpr double kLeastOpening_V = 1.0;  ///< so that leaks of closed ports do not count as the capacity
  const double inlet_V = std::max(greatest(log.command_V) - valve.open_above_V, kLeastOpening_V);
  const double exhaust_V = std::max(valve.exhaust_below_V - least(log.command_V), kLeastOpening_V);
  const double area_m2 = valve.discharge_coefficient * std::max(valve.inlet_area_per_V_m2 * inlet_V,
                                                                valve.exhaust_area_per_V_m2 * exhaust_V);
  return kKappa * kGasConstant_J_per_kg_K * std::sqrt(rig.gas.temperature_K) * kChoked * area_m2 *
         rig.supply.pressure_Pa;
}

/// Flow that the log shows, V p' + kappa p V', as a multiple of what the valve could pass; nearly the greatest.
double flow_over_capacity(const trace::Log& log, const RigDescription& rig) {
  const std::size_t n = rate_rows(log);
  if (log.size() < n + 2) return 0.0;
  std::vector<double> flows;
  flows.reserve(log.size() - n);
  for (std::size_t i = 0; i + n < log.size(); ++i) {
    const double volume_m3 = 0.5 * (log.volume_m3[i] + log.volume_m3[i + n]);
    const double pressure_Pa = 0.5 * (log.pressure_Pa[i] + log.pressure_Pa[i + n]);
    flows.push_back(std::abs(volume_m3 * (log.pressure_Pa[i + n] - log.pressure_Pa[i]) +
                             kKappa * pressure_Pa * (log.volume_m3[i + n] - log.volume_m3[i])) /
                    (static_cast<double>(n) * log.period_s));
  }
  return quantile(std::move(flows), 0.99) / nominal_capacity_Pa_m3_s(log, rig);
}

void require_positive_volume(const NamedLog& of) {
  const auto& volume_m3 = of.log.volume_m3;
  const auto row = std::find_if(volume_m3.begin(), volume_m3.end(), [](double v) { return !(v > 0.0); });
  if (row == volume_m3.end()) return;
  throw InputError(fmt::format("{}: row {}, column volume_m3: {:.6g}, expected above 0", of.name,
                               row - volume_m3.begin() + 1, *row));
}

void require_volume(const NamedLog& of, const RigDescription& rig) {
  constexpr double kLeast_m3 = 1e-6;
  constexpr double kGreatest_m3 = 0.1;
  // Data sheets are off by less: pressure that moves so much faster belongs to a smaller chamber.
  constexpr double kImpossibleFlow = 50.0;
  const double low_m3 = least(of.log.volume_m3);
  const double high_m3 = greatest(of.log.volume_m3);
  const double flow = flow_over_capacity(of.log, rig);
  if (low_m3 >= kLeast_m3 && high_m3 <= kGreatest_m3 && flow <= kImpossibleFlow) return;
  const std::string found = fmt::format("{}: column volume_m3: {:.6g} to {:.6g}", of.name, low_m3, high_m3);
  if (low_m3 < kLeast_m3)
    throw InputError(fmt::format("{}, expected m3, {:g} to {:g}", found, kLeast_m3, kGreatest_m3));
  throw InputError(fmt::format(
      "{}, looks like {}: the pressure moves {:.3g} times as fast there as the rig's valve could fill it, "
      "expected m3, {:g} to {:g}, and the areas of [valve] in m2/V",
      found, flow > 1e3 * kImpossibleFlow ? "millilitres" : "litres", flow, kLeast_m3, kGreatest_m3));
}

// ---- information

std::string names_of(const std::vector<NamedLog>& logs) {
  return logs.size() == 1 ? logs.front().name
                          : fmt::format("{} and {} more", logs.front().name, logs.size() - 1);
}

void require_excitation(const std::vector<NamedLog>& logs, const RigDescription& rig) {
  constexpr double kResting_V = 0.02;
  double low_V = logs.front().log.command_V.front();
  double high_V = low_V;
  for (const NamedLog& of : logs) {
    low_V = std::min(low_V, least(of.log.command_V));
    high_V = std::max(high_V, greatest(of.log.command_V));
  }
  if (high_V - low_V < kResting_V) {
    throw CannotDiagnose(
        fmt::format("{}: no excitation: column command_V rests at {:.4g} V, expected a command that moves",
                    names_of(logs), 0.5 * (low_V + high_V)));
  }
  if (low_V >= rig.valve.exhaust_below_V && high_V <= rig.valve.open_above_V) {
    throw CannotDiagnose(
        fmt::format("{}: no excitation: column command_V is {:.4g} to {:.4g} V and opens no port, expected "
                    "below exhaust_below_V = {:.4g} or above open_above_V = {:.4g} of the rig",
                    names_of(logs), low_V, high_V, rig.valve.exhaust_below_V, rig.valve.open_above_V));
  }
}

double standard_deviation(const std::vector<double>& values) {
  double mean = 0.0;
  for (const double value : values) mean += value;
  mean /= static_cast<double>(values.size());
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size()));
}

/// White noise estimated from the steps between rows; a moving pressure adds to it.
double step_noise(const std::vector<double>& values) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < values.size(); ++i) steps.push_back(std::abs(values[i] - values[i - 1]));
  return steps.empty() ? 0.0 : 1.4826 * quantile(std::move(steps), 0.5) / std::sqrt(2.0);
}

bool moves(const trace::Log& log, const RigDescription& rig) {
  const double deviation_Pa = standard_deviation(log.pressure_Pa);
  if (deviation_Pa <= 3.0 * rig.sensor.pressure_noise_Pa) return false;
  // The sensor may be noisier than its sheet says.
  const bool small = greatest(log.pressure_Pa) - least(log.pressure_Pa) < 0.02 * span_Pa(rig);
  return !(small && deviation_Pa < 3.0 * step_noise(log.pressure_Pa));
}

void require_movement(const std::vector<NamedLog>& logs, const RigDescription& rig) {
  if (std::any_of(logs.begin(), logs.end(), [&](const NamedLog& of) { return moves(of.log, rig); })) return;
  const trace::Log& first = logs.front().log;
  throw CannotDiagnose(fmt::format(
      "{}: no excitation: column pressure_Pa is {:.6g} to {:.6g} and does not move beyond noise "
      "(sensor.pressure_noise_Pa = {:g}), expected a pressure that follows the command",
      names_of(logs), least(first.pressure_Pa), greatest(first.pressure_Pa), rig.sensor.pressure_noise_Pa));
}

constexpr double kOpen_V = 0.3;  ///< beyond a threshold that may be off

/// Whether the pressure at this row can go no further: it is at supply or ambient, or rests at the end of its
/// range although a port is open.
bool is_saturated(const trace::Log& log, std::size_t row, double low_Pa, double high_Pa,
                  const RigDescription& rig) {
  const double p = log.pressure_Pa[row];
  const double near_Pa = 0.01 * span_Pa(rig) + 3.0 * rig.sensor.pressure_noise_Pa;
  if (std::abs(p - rig.supply.pressure_Pa) < near_Pa || std::abs(p - rig.ambient.pressure_Pa) < near_Pa) {
    return true;
  }
  const double end_Pa = 0.02 * (high_Pa - low_Pa) + 3.0 * rig.sensor.pressure_noise_Pa;
  return (log.command_V[row] > rig.valve.open_above_V + kOpen_V && high_Pa - p < end_Pa) ||
         (log.command_V[row] < rig.valve.exhaust_below_V - kOpen_V && p - low_Pa < end_Pa);
}

void require_unsaturated(const std::vector<NamedLog>& logs, const RigDescription& rig) {
  constexpr double kMost = 0.95;
  std::size_t saturated = 0;
  std::size_t rows = 0;
  for (const NamedLog& of : logs) {
    const double low_Pa = quantile(of.log.pressure_Pa, 0.005);
    const double high_Pa = quantile(of.log.pressure_Pa, 0.995);
    rows += of.log.size();
    for (std::size_t i = 0; i < of.log.size(); ++i) {
      if (is_saturated(of.log, i, low_Pa, high_Pa, rig)) ++saturated;
    }
  }
  const double share = static_cast<double>(saturated) / static_cast<double>(rows);
  if (share < kMost) return;
  throw CannotDiagnose(fmt::format(
      "{}: saturated: column pressure_Pa rests at supply, ambient or its own end in {:.1f} % of the "
      "rows, expected less than {:g} %",
      names_of(logs), 100.0 * share, 100.0 * kMost));
}

/// Whether the pressure runs into the level that it has from this row on: its last step is as large as those
/// before. One that comes to rest at the supply or at ambient slows down first (as the square of the time left:
/// the last two rows make a third of the way of the two before).
bool runs_in(const std::vector<double>& pressure_Pa, std::size_t row, double least_step_Pa) {
  if (row < 4) return false;
  const double last_Pa = std::abs(pressure_Pa[row] - pressure_Pa[row - 2]);
  return last_Pa > least_step_Pa && last_Pa > 0.45 * std::abs(pressure_Pa[row - 2] - pressure_Pa[row - 4]);
}

/// The end of a sensor's range, as a log may show it.
struct RangeEnd {
  double level_Pa;  ///< the greatest reading, or the least
  bool upper;
  double near_Pa;  ///< of it: what noise makes of the end, where noise comes after what is cut off
};

/// Whether the sensor may be at the end of its range at this row: there to the last bit, or, where noise comes after what is cut off,
/// near it although a port is open that takes the pressure farther.
bool at_end(const trace::Log& log, std::size_t row, const RangeEnd& end, const RigDescription& rig) {
  const double p = log.pressure_Pa[row];
  if (p == end.level_Pa) return true;
  const bool driven = end.upper ? log.command_V[row] > rig.valve.open_above_V + kOpen_V
                                : log.command_V[row] < rig.valve.exhaust_below_V - kOpen_V;
  return driven && std::abs(p - end.level_Pa) < end.near_Pa;
}

/// Rows at the end, after running into it.
std::size_t clipped_rows(const trace::Log& log, const RangeEnd& end, const RigDescription& rig) {
  const double least_step_Pa = 0.005 * span_Pa(rig);
  std::size_t rows = 0;
  for (std::size_t from = 0, to = 0; from < log.size(); from = to + 1) {
    for (to = from; to < log.size() && at_end(log, to, end, rig);) ++to;
    const bool long_enough = static_cast<double>(to - from) * log.period_s >= kRateOver_s;
    if (long_enough && runs_in(log.pressure_Pa, from, least_step_Pa)) rows += to - from;
  }
  return rows;
}

/// Whether a reading comes twice in a row only by chance, since noise moves it by more than its digits are apart: away from the
/// greatest and the least, which are looked at.
bool is_dithered(const std::vector<double>& values) {
  constexpr double kByChance = 0.02;
  const double low = least(values), high = greatest(values);
  std::size_t steps = 0, still = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] == low || values[i] == high) continue;
    ++steps;
    still += values[i] == values[i - 1] ? 1U : 0U;
  }
  return static_cast<double>(still) < kByChance * static_cast<double>(steps);
}

void require_unclipped(const NamedLog& of, const RigDescription& rig) {
  constexpr double kNoises = 6.0;  // from the greatest of many to the least
  const double near_rest_Pa = 0.03 * span_Pa(rig);
  const auto is_near = [&](double one, double other) { return std::abs(one - other) < near_rest_Pa; };
  const double least_Pa = least(of.log.pressure_Pa);
  const double greatest_Pa = greatest(of.log.pressure_Pa);
  // of readings that hardly leave their noise a hundredth tells
  const double near_Pa = std::min(kNoises * rig.sensor.pressure_noise_Pa, 0.01 * (greatest_Pa - least_Pa));
  const bool dithered = is_dithered(of.log.pressure_Pa);
  for (RangeEnd end : {RangeEnd{greatest_Pa, true, near_Pa}, RangeEnd{least_Pa, false, near_Pa}}) {
    if (is_near(end.level_Pa, rig.supply.pressure_Pa) || is_near(end.level_Pa, rig.ambient.pressure_Pa)) {
      if (!dithered) continue;  // a chamber may rest there, of which digits make one reading
      end.near_Pa = 0.0;
    }
    const std::size_t rows = clipped_rows(of.log, end, rig);
    if (!many(static_cast<std::ptrdiff_t>(rows), of.log)) continue;
    throw CannotDiagnose(fmt::format(
        "{}: saturated: column pressure_Pa is cut off at {:.6g} in {:.1f} % of the rows, expected a "
        "sensor within its range",
        of.name, end.level_Pa, 100.0 * static_cast<double>(rows) / static_cast<double>(of.log.size())));
  }
}

// ---- what is taken as it is, and told

constexpr double kApart = 0.05;

std::optional<std::string> supply_notice(const NamedLog& of, const RigDescription& rig) {
  if (of.log.supply_Pa.empty()) return {};
  const double supply_Pa = undrawn_Pa(of.log);
  if (std::abs(supply_Pa - rig.supply.pressure_Pa) < kApart * rig.supply.pressure_Pa) return {};
  return fmt::format(
      "column supply_Pa comes to {:.6g}, the rig's supply.pressure_Pa is {:.6g}: expected both alike",
      supply_Pa, rig.supply.pressure_Pa);
}

std::optional<std::string> above_supply_notice(const NamedLog& of, const RigDescription& rig) {
  const std::vector<double> high_Pa = volume_free(of.log, rig, 1.0, 0.0).high_Pa;
  const double limit_Pa = (1.0 + kApart) * rig.supply.pressure_Pa;
  const auto above = [&](double one) { return one > limit_Pa; };
  const auto rows = std::count_if(high_Pa.begin(), high_Pa.end(), above);
  const auto glitch = std::find_if(high_Pa.begin(), high_Pa.end(),
                                   [&](double one) { return one > kAboveSupply * rig.supply.pressure_Pa; });
  if (!many(rows, of.log) && glitch == high_Pa.end()) return {};
  const auto first = glitch != high_Pa.end() ? glitch : std::find_if(high_Pa.begin(), high_Pa.end(), above);
  return fmt::format(
      "column pressure_Pa is above the rig's supply.pressure_Pa = {:.6g} by more than {:g} % in {} rows, row "
      "{} is {:.6g}: expected a supply that is higher, or a sensor that reads less",
      rig.supply.pressure_Pa, 100.0 * kApart, rows, first - high_Pa.begin() + 1,
      of.log.pressure_Pa[static_cast<std::size_t>(first - high_Pa.begin())]);
}

/// Longer than this at one reading to the bit, while a port is open and the pressure has somewhere to go, is no pressure. At the log's
/// own end it is a sensor at the end of its range (require_unclipped).
constexpr double kStuck_s = 1.0;

std::optional<std::string> stuck_notice(const NamedLog& of, const RigDescription& rig) {
  const trace::Log& log = of.log;
  const double low_Pa = quantile(log.pressure_Pa, 0.005);
  const double high_Pa = quantile(log.pressure_Pa, 0.995);
  const double lowest_Pa = least(log.pressure_Pa);
  const double highest_Pa = greatest(log.pressure_Pa);
  std::size_t first = 0;
  std::size_t open = 0;  // rows since then in which a port drives the pressure
  for (std::size_t row = 1; row < log.size(); ++row) {
    if (log.pressure_Pa[row] != log.pressure_Pa[first]) {
      first = row;
      open = 0;
      continue;
    }
    const bool at_end = log.pressure_Pa[row] == lowest_Pa || log.pressure_Pa[row] == highest_Pa;
    const bool driven = log.command_V[row] > rig.valve.open_above_V + kOpen_V ||
                        log.command_V[row] < rig.valve.exhaust_below_V - kOpen_V;
    if (driven && !at_end && !is_saturated(log, row, low_Pa, high_Pa, rig)) ++open;
    if (static_cast<double>(open) * log.period_s < kStuck_s) continue;
    return fmt::format(
        "column pressure_Pa is {:.6g} to the last digit from row {} to {} although a port is open: expected "
        "a sensor that is not stuck",
        log.pressure_Pa[row], first + 1, row + 1);
  }
  return {};
}

}  // namespace

void require_units(const std::vector<NamedLog>& logs, const RigDescription& rig) {
  if (logs.empty()) throw InputError("no log, expected one at least");
  for (const NamedLog& of : logs) {
    if (of.log.size() < 2) throw InputError(fmt::format("{}: no rows, expected one a tick", of.name));
    require_command(of, rig);
    require_positive_volume(of);
    require_pressure(of, rig);
    require_supply(of, rig);
    require_volume(of, rig);
  }
}

std::vector<std::string> notices(const std::vector<NamedLog>& logs, const RigDescription& rig) {
  std::vector<std::string> told;
  for (const NamedLog& of : logs) {
    for (const auto& notice : {supply_notice(of, rig), above_supply_notice(of, rig), stuck_notice(of, rig)}) {
      if (notice) told.push_back(fmt::format("{}: {}", of.name, *notice));
    }
  }
  return told;
}

std::vector<std::string> notices_of_rests(const std::vector<NamedLog>& logs, double fitted_share) {
  constexpr double kAlike = 4.0;
  std::vector<std::string> told;
  for (const NamedLog& of : logs) {
    const auto& pressure_Pa = of.log.pressure_Pa;
    const auto rest = pressure_Pa.begin() +
                      static_cast<std::ptrdiff_t>(fitted_share * static_cast<double>(pressure_Pa.size()));
    const auto [fitted_low, fitted_high] = std::minmax_element(pressure_Pa.begin(), rest);
    const auto [low, high] = std::minmax_element(rest, pressure_Pa.end());
    const double fitted_Pa = *fitted_high - *fitted_low, rest_Pa = *high - *low;
    if (rest_Pa * kAlike >= fitted_Pa && rest_Pa <= kAlike * fitted_Pa) continue;
    told.push_back(
        fmt::format("{}: column pressure_Pa moves over {:.3g} to {:.3g} from row {} on, which is held out, "
                    "and over {:.3g} to {:.3g} before: "
                    "expected both alike, or another log held out (--heldout)",
                    of.name, *low, *high, rest - pressure_Pa.begin() + 1, *fitted_low, *fitted_high));
  }
  return told;
}

void require_rate(const std::vector<NamedLog>& logs, const RigDescription& rig) {
  for (const NamedLog& of : logs) trace::require_rate(of.log, rig, of.name);
}

void require_length(const std::vector<NamedLog>& logs) {
  double total_s = 0.0;
  std::size_t rows = 0;
  for (const NamedLog& of : logs) {
    rows += of.log.size();
    total_s += static_cast<double>(of.log.size()) * of.log.period_s;
  }
  if (total_s >= kShortest_s) return;
  throw CannotDiagnose(fmt::format("{}: too short: {} rows, {:.3g} s, expected {:g} s at least",
                                   names_of(logs), rows, total_s, kShortest_s));
}

void require_diagnosable(const std::vector<NamedLog>& logs, const RigDescription& rig) {
  require_rate(logs, rig);
  require_units(logs, rig);
  require_length(logs);
  require_excitation(logs, rig);
  require_movement(logs, rig);
  require_unsaturated(logs, rig);
  for (const NamedLog& of : logs) require_unclipped(of, rig);
}

}  // namespace plenum::host::diagnose
