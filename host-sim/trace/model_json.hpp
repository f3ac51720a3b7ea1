// An identified model as a JSON file: README.md of this room holds the format.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace plenum::host::trace {

/// Parameters of the 9-parameter model in the order in which they cross the bus, units in their names:
/// c1..c9 of (10), c_gamma, P_c, P_r, and the valve's dead time, which a file may leave out.
inline constexpr std::size_t kTassa9Count = 13;
inline constexpr std::array<std::string_view, kTassa9Count> kTassa9Names{
    "c1_V", "c2_per_V", "c3_per_V3", "c4_kPa_s_per_mL", "c5_per_mL",   "c6_per_mL",  "c7_per_V_s",
    "c8",   "c9_V",     "c_gamma_V", "supply_kPa",      "ambient_kPa", "dead_time_s"};

/// The longest of a 9-parameter model [s]: what a board can look over.
inline constexpr double kLongestDeadTime_s = 0.12;

/// Those of its repaired form, likewise: all but c4.
inline constexpr std::size_t kTassa9rCount = 12;
inline constexpr std::array<std::string_view, kTassa9rCount> kTassa9rNames{
    "c1_V", "c2_per_V", "c3_per_V3", "c5_per_mL",  "c6_per_mL",   "c7_per_V_s",
    "c8",   "c9_V",     "c_gamma_V", "supply_kPa", "ambient_kPa", "dead_time_s"};

/// Those of the grey-box model, likewise: control/greybox.hpp says what they are. A file may leave out the last three, of the
/// supply's line.
inline constexpr std::size_t kGreyboxCount = 30;
inline constexpr std::array<std::string_view, kGreyboxCount> kGreyboxNames{"open_above_V",
                                                                           "exhaust_below_V",
                                                                           "inlet_conductance_mL_per_s_V",
                                                                           "exhaust_conductance_mL_per_s_V",
                                                                           "inlet_leak_mL_per_s",
                                                                           "exhaust_leak_mL_per_s",
                                                                           "transition_mL_per_s",
                                                                           "inlet_slope",
                                                                           "inlet_curve",
                                                                           "inlet_bend",
                                                                           "exhaust_slope",
                                                                           "exhaust_curve",
                                                                           "exhaust_bend",
                                                                           "critical_ratio",
                                                                           "subsonic_index",
                                                                           "cracking_ratio",
                                                                           "discharge_slope",
                                                                           "dead_volume_mL",
                                                                           "volume_exponent",
                                                                           "chamber_leak_mL_per_s",
                                                                           "dead_time_s",
                                                                           "spool_period_s",
                                                                           "spool_damping",
                                                                           "hysteresis_V",
                                                                           "sensor_lag_s",
                                                                           "supply_kPa",
                                                                           "ambient_kPa",
                                                                           "supply_resistance_s_per_L",
                                                                           "supply_recovery_s",
                                                                           "supply_followed_share"};

struct ModelFile {
  std::string kind = "tassa9";
  std::optional<unsigned> chamber;  ///< which chamber of the board it was fitted on, if known
  std::vector<double> parameters;   ///< as parameter_names(kind), without the last ones that may be left out
  nlohmann::ordered_json fit = nlohmann::ordered_json::object();  ///< how it was found; free of contract
};

/// The parameters of a kind ("tassa9", "tassa9r", "greybox"); empty for another one.
std::span<const std::string_view> parameter_names(std::string_view kind);

/// Reads a model. Throws InputError naming file, field, what was found and what was expected: not JSON,
/// another schema or kind, a parameter missing, unknown, not a finite number, of a 9-parameter model, repaired or not, against
/// the paper's Table I (2 < c1 < 8, -1 < c3, -1 < c8 < 1, 0 < c9), c_gamma > 0 or a dead time of 0 to 0.12 s, of a grey-box
/// model against the board's ranges, of all supply > ambient > 0. What a board asks beyond that, the board checks.
ModelFile read_model(const std::filesystem::path& path);

/// As read_model, from memory; `file` is the name used in errors.
ModelFile parse_model(std::string_view text, std::string_view file);

std::string format_model(const ModelFile& model);

/// Throws InputError when `model` would not read back, or the file cannot be written.
void write_model(const std::filesystem::path& path, const ModelFile& model);

}  // namespace plenum::host::trace
