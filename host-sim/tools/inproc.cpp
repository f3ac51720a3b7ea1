#include "host-sim/tools/inproc.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "host-sim/effects/catalogue.hpp"
#include "host-sim/rig/rig.hpp"
#include "host-sim/rig/standard_rigs.hpp"
#include "host-sim/tools/command_line.hpp"
#include "host-sim/tools/recorded_log.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/log_csv.hpp"

namespace plenum::host::tools {
namespace {

constexpr double kRate_Hz = 100.0;

/// The figures of the standard MPYE rig that its user would know; its noise is that of the converter's mean.
trace::RigDescription mpye_description() {
  const rig::MpyeRig standard;
  const rig::BoardConfig board;
  trace::RigDescription description;
  description.supply.pressure_Pa = standard.supply_Pa;
  description.ambient.pressure_Pa = standard.ambient_Pa;
  description.sensor.pressure_noise_Pa =
      std::round(board.adc.sample_noise_V / std::sqrt(board.adc.samples_per_tick) * 100'000.0);
  return description;
}

using Figures = std::map<std::string, std::map<std::string, double>>;

double number_of(std::string_view text, std::string_view option) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw std::invalid_argument(fmt::format("--effect {}: '{}' is no number", option, text));
  }
  return value;
}

/// Adds "ID=VALUE", of the effect's first parameter, or "ID=PARAMETER:VALUE,PARAMETER:VALUE".
void switch_on(std::string_view option, Figures& effects) {
  const std::size_t equals = option.find('=');
  if (equals == std::string_view::npos) {
    throw std::invalid_argument(fmt::format(
        "--effect {}: no value, expected ID=VALUE or ID=PARAMETER:VALUE,... of `plenum effects`", option));
  }
  const std::string id(option.substr(0, equals));
  const auto found = effects::find(id);
  auto& figures = effects[id];
  if (!found) return;  // refused with the list of those there are, by effects::chamber_effects()
  std::string_view rest = option.substr(equals + 1);
  for (bool first = true;; first = false) {
    const std::size_t comma = rest.find(',');
    const std::string_view item = rest.substr(0, comma);
    const std::size_t colon = item.find(':');
    if (colon == std::string_view::npos && !first) {
      throw std::invalid_argument(
          fmt::format("--effect {}: '{}' names no parameter, expected PARAMETER:VALUE", option, item));
    }
    const std::string name(colon == std::string_view::npos
                               ? effects::kCatalogue[*found]->parameters.front().name
                               : item.substr(0, colon));
    figures[name] = number_of(item.substr(colon == std::string_view::npos ? 0 : colon + 1), option);
    if (comma == std::string_view::npos) return;
    rest.remove_prefix(comma + 1);
  }
}

}  // namespace

void RigChoice::add_to(Arguments& arguments, const std::string& title) {
  Option valves =
      arguments.option("--plant", plant,
                       "Valves: measured MPYE tables, or thin-plate orifices, which all have where "
                       "--effect or the rig switches one on");
  valves.one_of({"mpye", "thin-plate"}).show_default().group(title);
  arguments
      .option("--rig", rig_file, "What is known of the rig (default: 7 bar supply, 1 bar ambient, absolute)")
      .type_name("RIG.toml");
  arguments
      .option("--effect", effects,
              "Switch on what the nominal model leaves out (repeatable): ID=VALUE of its "
              "first parameter, or ID=PARAMETER:VALUE,.. of `plenum effects`")
      .type_name("ID=VALUE")
      .one_at_a_time()
      .group(title);
  arguments
      .option("--chambers", chambers, "Chambers of a board; no other one may be in use where they are driven")
      .within(1, 8)
      .show_default();
  arguments.option("--seed", seed, "Seed of volumes, noise and excitation: the same seed repeats every bit")
      .within(0U, 4294967295U)
      .show_default();
  arguments.option("--volume-swing", volume_swing, "How far volumes move: amplitude over mean; 0: not at all")
      .within(0.0, 0.9)
      .show_default()
      .group(title);
  arguments
      .flag("--spool,!--no-spool", spool, "Valve spools lag by 65 Hz, damping 0.7 (mpye only; default: on)")
      .group(title);
  arguments.when_read([this, valves] {
    const bool acts = !effects.empty() || (!rig_file.empty() && !trace::read_rig(rig_file).effects.empty());
    if (acts && !valves.given()) plant = "thin-plate";
  });
}

trace::RigDescription RigChoice::description() const {
  if (!rig_text.empty()) return trace::parse_rig(rig_text, "rig of the store");
  if (rig_file.empty()) return plant == "mpye" ? mpye_description() : trace::RigDescription{};
  trace::RigDescription description = trace::read_rig(rig_file);
  const auto& sampling = description.sampling;
  if (sampling.rate_Hz != kRate_Hz || sampling.pressure_average_s != 1.0 / kRate_Hz) {
    throw trace::InputError(fmt::format(
        "{}: [sampling] rate_Hz = {:g}, pressure_average_s = {:g}, expected 100 and 0.01: those of a board",
        rig_file, sampling.rate_Hz, sampling.pressure_average_s));
  }
  const auto& valve = description.valve;
  if (valve.exhaust_below_V < 0.0 || valve.open_above_V > 10.0) {
    throw trace::InputError(fmt::format(
        "{}: [valve] exhaust_below_V = {:g}, open_above_V = {:g}, expected 0 to 10: a board's outputs",
        rig_file, valve.exhaust_below_V, valve.open_above_V));
  }
  return description;
}

rig::RigConfig RigChoice::config(const std::optional<std::filesystem::path>& store) const {
  trace::RigDescription world = description();
  for (const std::string& option : effects) switch_on(option, world.effects);
  if (plant == "mpye" && !world.effects.empty()) {
    throw std::invalid_argument(
        fmt::format("--plant mpye: effect {} acts on thin-plate valves alone, expected --plant thin-plate",
                    world.effects.begin()->first));
  }
  rig::RigConfig config =
      plant == "mpye"
          ? rig::mpye_rig({.boards = boards,
                           .chambers = chambers,
                           .spool = spool,
                           .volume_swing = volume_swing,
                           .supply_Pa = world.supply.pressure_Pa,
                           .ambient_Pa = world.ambient.pressure_Pa,
                           .seed = seed})
          : rig::thin_plate_rig(
                world, {.boards = boards, .chambers = chambers, .volume_swing = volume_swing, .seed = seed});
  config.board.front().store = store;
  return config;
}

void write_recording(const std::filesystem::path& folder, const std::vector<client::CapturedRow>& rows,
                     unsigned chambers, bool with_reference, const trace::RigDescription& description) {
  trace::write_rig(folder / "rig.toml", description);
  for (unsigned c = 0; c < chambers; ++c) {
    trace::write_log(folder / fmt::format("chamber-{}.csv", c + 1), log_of(rows, c, with_reference));
  }
}

RecordedSoFar::RecordedSoFar(std::filesystem::path folder, unsigned chambers, bool with_reference,
                             const trace::RigDescription& description, const Output& output)
    : folder_(std::move(folder)),
      chambers_(chambers),
      with_reference_(with_reference),
      description_(description),
      output_(output) {}

RecordedSoFar::~RecordedSoFar() {
  if (rows_.size() < kLeastLogRows) return;
  try {
    write_recording(folder_, rows_, chambers_, with_reference_, description_);
    output_.print("{} rows from before this run broke off are in {}\n", rows_.size(), folder_.string());
  } catch (const std::exception&) {  // what ended the recording is the one to tell
  }
}

SetpointRange setpoint_range(const trace::RigDescription& description) {
  const double low_Pa = description.ambient.pressure_Pa;
  const double span_Pa = description.supply.pressure_Pa - low_Pa;
  return {low_Pa + 0.05 * span_Pa, low_Pa + 0.90 * span_Pa};
}

}  // namespace plenum::host::tools
