#include "host-sim/trace/model_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/legible.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::trace {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kSchema = "plenum-model/1";
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Of a parameter.
struct Range {
  double low;
  double high;
};

/// As kTassa9Names: the paper's Table I, and what is a voltage or a pressure is positive.
constexpr std::array<Range, kTassa9Count> kTassa9Ranges{{{2.0, 8.0},
                                                         {-kInfinity, kInfinity},
                                                         {-1.0, kInfinity},
                                                         {-kInfinity, kInfinity},
                                                         {-kInfinity, kInfinity},
                                                         {-kInfinity, kInfinity},
                                                         {-kInfinity, kInfinity},
                                                         {-1.0, 1.0},
                                                         {0.0, kInfinity},
                                                         {0.0, kInfinity},
                                                         {0.0, kInfinity},
                                                         {0.0, kInfinity},
                                                         {0.0, kLongestDeadTime_s}}};

constexpr std::size_t kC4 = 3;  // of kTassa9Names
constexpr auto kTassa9rRanges = [] {
  std::array<Range, kTassa9rCount> ranges{};
  std::copy_n(kTassa9Ranges.begin(), kC4, ranges.begin());
  std::copy(kTassa9Ranges.begin() + kC4 + 1, kTassa9Ranges.end(), ranges.begin() + kC4);
  return ranges;
}();

constexpr std::array<Range, kGreyboxCount> kGreyboxRanges{
    {{-5.0, 15.0},  {-5.0, 15.0},   {1e-3, 1e5},   {1e-3, 1e5},   {0.0, 1e5},   {0.0, 1e5},
     {1e-4, 1e5},   {-6.0, 20.0},   {-20.0, 20.0}, {-40.0, 40.0}, {-6.0, 20.0}, {-20.0, 20.0},
     {-40.0, 40.0}, {0.05, 0.8},    {0.25, 1.5},   {0.85, 1.0},   {-0.8, 0.8},  {-5000.0, 5000.0},
     {1.0, 1.4},    {0.0, 1e5},     {0.0, 0.08},   {0.0, 0.5},    {0.3, 2.0},   {0.0, 1.5},
     {0.0, 0.3},    {50.0, 2000.0}, {10.0, 200.0}, {0.0, 20.0},   {0.0, 3.0},   {0.0, 1.5}}};

struct Kind {
  std::string_view name;
  std::span<const std::string_view> names;
  std::span<const Range> ranges;
  std::size_t required;   ///< of the names, from the first
  std::size_t open;       ///< so many ranges, from the first; the others are the board's, which are closed
  std::size_t supply_at;  ///< the ambient pressure is next to it

  bool is_open(std::size_t parameter) const { return parameter < open; }
  bool holds(std::size_t parameter, double value) const {
    const auto [low, high] = ranges[parameter];
    return is_open(parameter) ? value > low && value < high : value >= low && value <= high;
  }
};
constexpr std::array<Kind, 3> kKinds{
    {{"tassa9", kTassa9Names, kTassa9Ranges, kTassa9Count - 1, kTassa9Count - 1, kTassa9Count - 3},
     {"tassa9r", kTassa9rNames, kTassa9rRanges, kTassa9rCount - 1, kTassa9rCount - 1, kTassa9rCount - 3},
     {"greybox", kGreyboxNames, kGreyboxRanges, kGreyboxCount - 3, 0, kGreyboxCount - 5}}};
constexpr std::string_view kKindsInWords = R"("tassa9", "tassa9r" or "greybox")";

const Kind* kind_of(std::string_view name) {
  const auto found =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& kind) { return kind.name == name; });
  return found == kKinds.end() ? nullptr : &*found;
}

std::string shown(const Json& value) {
  return legible(value.dump());
}

const Json& field(const Json& object, std::string_view name, std::string_view file,
                  std::string_view expected) {
  const auto found = object.find(name);
  if (found == object.end()) {
    throw InputError(fmt::format("{}: field '{}' is missing, expected {}", file, name, expected));
  }
  return *found;
}

void expect_text(const Json& object, std::string_view name, std::string_view expected,
                 std::string_view file) {
  const Json& value = field(object, name, file, fmt::format("\"{}\"", expected));
  if (!value.is_string() || value.get<std::string>() != expected) {
    throw InputError(
        fmt::format("{}: field '{}' is {}, expected \"{}\"", file, name, shown(value), expected));
  }
}

void check_values(const Kind& kind, std::span<const double> values, std::string_view file) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!kind.holds(i, values[i])) {
      throw InputError(fmt::format("{}: field 'parameters.{}' is {}, expected a number {} {} {} {}", file,
                                   kind.names[i], values[i], kind.is_open(i) ? "above" : "from",
                                   kind.ranges[i].low, kind.is_open(i) ? "and below" : "to",
                                   kind.ranges[i].high));
    }
  }
  const double supply_kPa = values[kind.supply_at], ambient_kPa = values[kind.supply_at + 1];
  if (!(supply_kPa > ambient_kPa)) {
    throw InputError(fmt::format("{}: field 'parameters.supply_kPa' is {}, expected above ambient_kPa = {}",
                                 file, supply_kPa, ambient_kPa));
  }
}

const Kind& kind_in(const Json& document, std::string_view file) {
  const Json& value = field(document, "kind", file, kKindsInWords);
  const Kind* kind = value.is_string() ? kind_of(value.get<std::string>()) : nullptr;
  if (kind == nullptr) {
    throw InputError(fmt::format("{}: field 'kind' is {}, expected {}", file, shown(value), kKindsInWords));
  }
  return *kind;
}

}  // namespace

std::span<const std::string_view> parameter_names(std::string_view kind) {
  const Kind* found = kind_of(kind);
  return found == nullptr ? std::span<const std::string_view>() : found->names;
}

ModelFile parse_model(std::string_view text, std::string_view file) {
  Json document;
  try {
    document = Json::parse(text);
  } catch (const Json::parse_error& error) {
    throw InputError(
        fmt::format("{}: byte {}: not JSON, expected a model of schema {}", file, error.byte, kSchema));
  } catch (const Json::out_of_range&) {
    throw InputError(fmt::format("{}: a number is too large, expected numbers of double precision", file));
  }
  if (!document.is_object()) {
    throw InputError(fmt::format("{}: {}, expected an object of schema {}", file, shown(document), kSchema));
  }
  expect_text(document, "schema", kSchema, file);
  const Kind& kind = kind_in(document, file);
  ModelFile model;
  model.kind = kind.name;
  if (const auto chamber = document.find("chamber"); chamber != document.end() && !chamber->is_null()) {
    if (!chamber->is_number_unsigned() || chamber->get<std::uint64_t>() > 255) {
      throw InputError(fmt::format("{}: field 'chamber' is {}, expected a whole number from 0 to 255", file,
                                   shown(*chamber)));
    }
    model.chamber = chamber->get<unsigned>();
  }
  const Json& parameters = field(document, "parameters", file, "an object of named numbers");
  if (!parameters.is_object()) {
    throw InputError(fmt::format("{}: field 'parameters' is {}, expected an object of named numbers", file,
                                 shown(parameters)));
  }
  for (const auto& [name, value] : parameters.items()) {
    if (std::find(kind.names.begin(), kind.names.end(), name) == kind.names.end()) {
      throw InputError(fmt::format("{}: field 'parameters.{}' is unknown, expected {}", file, legible(name),
                                   fmt::join(kind.names, ", ")));
    }
  }
  for (const std::string_view name : kind.names) {
    const auto found = parameters.find(name);
    const bool may_end = model.parameters.size() >= kind.required;
    if (may_end && model.parameters.size() == parameters.size()) break;  // of all that the file has
    if (found == parameters.end()) {
      throw InputError(fmt::format("{}: field 'parameters.{}' is missing, expected a number", file, name));
    }
    if (!found->is_number()) {
      throw InputError(
          fmt::format("{}: field 'parameters.{}' is {}, expected a number", file, name, shown(*found)));
    }
    model.parameters.push_back(found->get<double>());
  }
  check_values(kind, model.parameters, file);
  if (const auto fit = document.find("fit"); fit != document.end()) {
    if (!fit->is_object()) {
      throw InputError(fmt::format("{}: field 'fit' is {}, expected an object", file, shown(*fit)));
    }
    model.fit = *fit;
  }
  return model;
}

ModelFile read_model(const std::filesystem::path& path) {
  return parse_model(read_whole_file(path), path.string());
}

std::string format_model(const ModelFile& model) {
  Json document;
  document["schema"] = kSchema;
  document["kind"] = model.kind;
  if (model.chamber) document["chamber"] = *model.chamber;
  const std::span<const std::string_view> names = parameter_names(model.kind);
  for (std::size_t i = 0; i < model.parameters.size(); ++i)
    document["parameters"][names[i]] = model.parameters[i];
  document["fit"] = model.fit;
  return document.dump(2) + '\n';
}

void write_model(const std::filesystem::path& path, const ModelFile& model) {
  const std::string text = format_model(model);
  parse_model(text, "model to write");
  write_whole_file(path, text);
}

}  // namespace plenum::host::trace
