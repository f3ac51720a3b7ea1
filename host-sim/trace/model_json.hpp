// An identified model as a JSON file: README.md of this room holds the format.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace plenum::host::trace {

/// Parameters of the 9-parameter model in the order in which they cross the bus, units in their names:
/// c1..c9 of (10), c_gamma, P_c, P_r.
inline constexpr std::size_t kTassa9Count = 12;
inline constexpr std::array<std::string_view, kTassa9Count> kTassa9Names{
    "c1_V",       "c2_per_V", "c3_per_V3", "c4_kPa_s_per_mL", "c5_per_mL",  "c6_per_mL",
    "c7_per_V_s", "c8",       "c9_V",      "c_gamma_V",       "supply_kPa", "ambient_kPa"};

struct ModelFile {
  std::string kind = "tassa9";
  std::optional<unsigned> chamber;                ///< which chamber of the board it was fitted on, if known
  std::array<double, kTassa9Count> parameters{};  ///< as kTassa9Names
  nlohmann::ordered_json fit = nlohmann::ordered_json::object();  ///< how it was found; free of contract
};

/// Reads a model. Throws InputError naming file, field, what was found and what was expected: not JSON,
/// another schema or kind, a parameter missing, unknown, not a finite number or against the paper's Table I
/// (2 < c1 < 8, -1 < c3, -1 < c8 < 1, 0 < c9) or c_gamma > 0, supply > ambient > 0. What a board asks beyond
/// that, the board checks.
ModelFile read_model(const std::filesystem::path& path);

/// As read_model, from memory; `file` is the name used in errors.
ModelFile parse_model(std::string_view text, std::string_view file);

std::string format_model(const ModelFile& model);

/// Throws InputError when `model` would not read back, or the file cannot be written.
void write_model(const std::filesystem::path& path, const ModelFile& model);

}  // namespace plenum::host::trace
