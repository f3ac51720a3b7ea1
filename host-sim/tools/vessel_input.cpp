#include "host-sim/tools/vessel_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/orifice/filter.hpp"
#include "host-sim/tools/bench_input.hpp"
#include "host-sim/tools/command_line.hpp"
#include "host-sim/tools/model_charts.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/recording.hpp"

namespace plenum::host::tools {
namespace {

namespace orifice = identify::orifice;

constexpr double kAtRest = 0.01;         // of its mean: more is a volume that moves
constexpr double kSameCommand_V = 1e-3;  // a 16-bit DAC's steps of 10 V are finer
constexpr double kGreatest_bar = 100.0;  // more is another unit
const std::vector<std::string> kSealed{"t_s", "p_bar"};

struct Part {
  std::size_t first = 0;
  std::size_t last = 0;  ///< the row after the last one
};

/// The rows between --from and --to. Throws std::invalid_argument.
Part asked_part(const std::string& name, const std::vector<double>& time_s, double from_s,
                std::optional<double> to_s) {
  const auto row_at = [&](double t_s) {
    return static_cast<std::size_t>(std::lower_bound(time_s.begin(), time_s.end(), t_s) - time_s.begin());
  };
  const Part asked{row_at(from_s), to_s ? row_at(*to_s) : time_s.size()};
  if (asked.last < asked.first + 3) {
    throw std::invalid_argument(fmt::format("{}: {} rows from --from {:g} s on, expected 3 or more", name,
                                            asked.last - std::min(asked.first, asked.last), from_s));
  }
  return asked;
}

/// The rows in which the command of `first` is held.
Part held_from(const trace::Log& log, std::size_t first, std::size_t end) {
  Part part{first, first};
  while (part.last < end && std::abs(log.command_V[part.last] - log.command_V[first]) < kSameCommand_V)
    ++part.last;
  return part;
}

/// Whether the first row of `part` has the pressure before a step of the command: the mean of the tick before it.
bool begins_before_its_step(const trace::Log& log, const Part& part) {
  return part.first > 0 && log.pressure_average_s > 0.0 &&
         std::abs(log.command_V[part.first] - log.command_V[part.first - 1]) >= kSameCommand_V;
}

/// The rows asked for, which are at one command and one volume; without the first where that is of the command
/// before. Throws CannotIdentify.
Part at_rest(const trace::NamedLog& of, Part asked) {
  const std::vector<double>& time_s = of.log.time_s;
  Part longest;
  for (std::size_t at = asked.first; at < asked.last;) {
    const Part held = held_from(of.log, at, asked.last);
    if (held.last - held.first > longest.last - longest.first) longest = held;
    at = held.last;
  }
  if (longest.last - longest.first < asked.last - asked.first) {
    throw identify::CannotIdentify(fmt::format(
        "{}: the command changes; expected one orifice at one command: the longest part at one is --from "
        "{}{}",
        of.name, time_s[longest.first],
        longest.last < time_s.size() ? fmt::format(" --to {}", time_s[longest.last]) : std::string()));
  }
  const auto begin = of.log.volume_m3.begin();
  const auto [least, most] = std::minmax_element(begin + static_cast<std::ptrdiff_t>(asked.first),
                                                 begin + static_cast<std::ptrdiff_t>(asked.last));
  if (*most - *least > kAtRest * *most) {
    throw identify::CannotIdentify(
        fmt::format("{}: the volume moves from {:.6g} to {:.6g} mL; expected a vessel at rest", of.name,
                    1e6 * *least, 1e6 * *most));
  }
  if (begins_before_its_step(of.log, asked)) ++asked.first;
  return asked;
}

orifice::VesselRecord record_of(const trace::Log& log, const trace::RigDescription& rig, const Part& part) {
  const bool fills = log.pressure_Pa[part.last - 1] > log.pressure_Pa[part.first];
  const bool from_measured = fills && !log.supply_Pa.empty();
  orifice::VesselRecord record{.flow = fills ? orifice::Flow::kCharge : orifice::Flow::kDischarge,
                               .time_s = log.time_s,
                               .vessel_Pa = log.pressure_Pa,
                               .far_Pa = log.supply_Pa};
  for (double& t_s : record.time_s) t_s -= 0.5 * log.pressure_average_s;  // of which a row is the mean
  if (!from_measured)
    record.far_Pa.assign(log.time_s.size(), fills ? rig.supply.pressure_Pa : rig.ambient.pressure_Pa);
  record = orifice::rows_of(record, part.first, part.last);
  return from_measured ? orifice::steady_far_side(std::move(record)) : record;
}

/// Where a vessel begins to fall that was held before: where it has lost 3 % of its gauge pressure, if that took over twice as
/// long as the next 3 %. None where it falls from the start, or never so far.
std::optional<double> held_until_s(const orifice::VesselRecord& record) {
  const auto gauge_Pa = [&](std::size_t row) { return record.vessel_Pa[row] - record.far_Pa[row]; };
  const auto below_s = [&](double share) {
    std::size_t row = record.time_s.size() - 1;
    while (row > 0 && gauge_Pa(row - 1) <= share * gauge_Pa(0)) --row;
    return record.time_s[row];
  };
  if (gauge_Pa(record.time_s.size() - 1) > 0.94 * gauge_Pa(0)) return std::nullopt;
  const double first_s = below_s(0.97);
  const double next_s = below_s(0.94) - first_s;
  return first_s - record.time_s.front() > 2.0 * next_s ? std::optional(first_s) : std::nullopt;
}

}  // namespace

void VesselInput::add_to(Arguments& arguments) {
  arguments
      .option("LOG", files_,
              "Logs of a chamber at one command and one volume: an orifice each; or recordings of a sealed "
              "vessel, "
              "known by their columns t_s and p_bar (gauge)")
      .type_name("LOG.csv")
      .required();
  logs_.add_to(
      arguments,
      "What is known of the rig: the far side is its ambient pressure, of a vessel that fills its supply or "
      "the log's supply_Pa; the gas has its temperature (default: 700 and 101.325 kPa, 293.15 K)");
  arguments.option("--from", from_s_, "Leave out what is before [s]").show_default();
  arguments.option("--to", to_s_, "Leave out what is from there on [s] (default: the log's end)");
  arguments
      .option("--volume", volume_mL_,
              "Of a sealed vessel [mL]: makes its choked rate a conductance and an area (default: unknown)")
      .within(1e-3, 1e9);
}

VesselLog VesselInput::of_chamber(const trace::NamedLog& of, const trace::RigDescription& rig) const {
  if (volume_mL_)
    throw trace::InputError(fmt::format("--volume: {} has its own, in column volume_m3", of.name));
  const Part part = at_rest(of, asked_part(of.name, of.log.time_s, from_s_, to_s_));
  return {.name = of.name,
          .record = record_of(of.log, rig, part),
          .period_s = of.log.period_s,
          .command_V = of.log.command_V[part.first],
          .volume_m3 = mean({of.log.volume_m3.begin() + static_cast<std::ptrdiff_t>(part.first),
                             of.log.volume_m3.begin() + static_cast<std::ptrdiff_t>(part.last)})};
}

VesselLog VesselInput::of_sealed(const std::string& file, const trace::RigDescription& rig) const {
  const trace::Recording log = read_bench("orifice", file, kSealed);
  require_rising_time(log, "t_s");
  require_between(log, "p_bar", -1e-5 * rig.ambient.pressure_Pa, kGreatest_bar, "bar above ambient");
  orifice::VesselRecord record{.flow = orifice::Flow::kDischarge,
                               .time_s = log["t_s"],
                               .vessel_Pa = log["p_bar"],
                               .far_Pa = std::vector<double>(log.rows, rig.ambient.pressure_Pa)};
  for (double& p : record.vessel_Pa) p = rig.ambient.pressure_Pa + 1e5 * p;
  const Part part = asked_part(log.name, record.time_s, from_s_, to_s_);
  VesselLog found{.name = log.name, .record = orifice::rows_of(record, part.first, part.last)};
  if (const std::optional<double> held_s = held_until_s(found.record)) {
    found.notices.push_back(fmt::format(
        "{}: hardly falls at first; --from {:g} leaves out what is before its leak", log.name, *held_s));
  }
  const std::vector<double>& t_s = found.record.time_s;
  found.period_s = (t_s.back() - t_s.front()) / static_cast<double>(t_s.size() - 1);
  if (volume_mL_) found.volume_m3 = 1e-6 * *volume_mL_;
  return found;
}

std::vector<VesselLog> VesselInput::read(const trace::RigDescription& rig) const {
  std::vector<std::string> chambers;
  std::vector<std::string> sealed;
  for (const std::string& file : files_)
    (trace::has_columns(file, kSealed) ? sealed : chambers).push_back(file);
  std::vector<VesselLog> all;
  for (const trace::NamedLog& of : logs_.read(chambers, rig)) all.push_back(of_chamber(of, rig));
  for (const std::string& file : sealed) all.push_back(of_sealed(file, rig));
  return all;
}

}  // namespace plenum::host::tools
