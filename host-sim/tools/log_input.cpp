#include "host-sim/tools/log_input.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <set>
#include <stdexcept>

#include "host-sim/diagnose/log_check.hpp"
#include "host-sim/rig/effects_chamber.hpp"
#include "host-sim/tools/command_line.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/log_csv.hpp"
#include "host-sim/trace/respiraworks.hpp"

namespace plenum::host::tools {
namespace {

constexpr const char* kRespiraworks = "respiraworks";
/// The ventilator's supply is not published; README.md of host-sim/identify says what that means for a fit.
constexpr double kRespiraworksSupply_Pa = 110'000.0;

}  // namespace

void LogInput::add_to(Arguments& arguments, const std::string& rig_help) {
  command_ = arguments.name();
  arguments.option("--rig", rig_file_, rig_help).type_name("RIG.toml");
  arguments.option("--format", format_, "Of the logs: csv, or respiraworks (ventilator runs)")
      .one_of({"csv", kRespiraworks})
      .show_default();
}

bool LogInput::of_ventilator() const {
  return format_ == kRespiraworks;
}

trace::RigDescription LogInput::rig() const {
  if (has_rig()) {
    assumed_.clear();
    trace::RigDescription rig = trace::read_rig(rig_file_, &assumed_);
    try {
      static_cast<void>(effects::chamber_effects(rig.effects));
    } catch (const std::invalid_argument& error) {
      throw trace::InputError(fmt::format("{}: {}", rig_file_, error.what()));
    }
    return rig;
  }
  trace::RigDescription rig;
  if (of_ventilator()) rig.supply.pressure_Pa = kRespiraworksSupply_Pa;
  return rig;
}

trace::Log LogInput::log_of(const std::string& file, const trace::RigDescription& rig) const {
  if (of_ventilator()) return trace::import_respiraworks(file, {.ambient_Pa = rig.ambient.pressure_Pa});
  return has_rig() ? trace::read_log(file, rig, &notices_) : trace::read_log(file, &notices_);
}

std::vector<trace::NamedLog> LogInput::read(const std::vector<std::string>& files,
                                            const trace::RigDescription& rig) const {
  std::vector<trace::NamedLog> logs;
  logs.reserve(files.size());
  for (const std::string& file : files) {
    const std::filesystem::path path(file);
    const std::filesystem::path name = path.filename();
    const bool first = names_.insert(name.string()).second;
    logs.push_back({(first ? name : path.parent_path().filename() / name).string(), log_of(file, rig)});
  }
  if (!logs.empty()) diagnose::require_units(logs, rig);
  const std::vector<std::string> of_logs = diagnose::notices(logs, rig);
  notices_.insert(notices_.end(), of_logs.begin(), of_logs.end());
  std::set<unsigned> chambers;
  for (const std::string& file : files) {
    if (const auto chamber = chamber_in_name(file)) chambers.insert(*chamber);
  }
  if (chambers.size() > 1)
    notices_.push_back(
        fmt::format("logs of chambers {} together, expected those of one", fmt::join(chambers, ", ")));
  tell(notices_);
  notices_.clear();
  return logs;
}

void LogInput::tell(const std::vector<std::string>& notices) const {
  for (const std::string& notice : notices) fmt::print(stderr, "plenum {}: {}\n", command_, notice);
}

void LogInput::print_assumed(const Output& output) const {
  if (!assumed_.empty())
    output.print("{}: not stated and taken as: {}\n", rig_file_, fmt::join(assumed_, ", "));
}

std::optional<unsigned> chamber_in_name(const std::string& file) {
  constexpr std::string_view kStem = "chamber-";
  const std::string name = std::filesystem::path(file).stem().string();
  const std::size_t at = name.rfind(kStem);
  if (at == std::string::npos || name.size() != at + kStem.size() + 1) return std::nullopt;
  const char digit = name.back();
  return digit >= '1' && digit <= '8' ? std::optional(static_cast<unsigned>(digit - '0')) : std::nullopt;
}

}  // namespace plenum::host::tools
