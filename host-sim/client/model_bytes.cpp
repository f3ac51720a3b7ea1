#include "host-sim/client/model_bytes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <numbers>
#include <stdexcept>

#include "firmware/canopen/objects.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/client/shortest_decimal.hpp"

namespace plenum::host::client {
namespace {

using plenum::config::ModelKind;
using plenum::config::ModelParameters;

struct Kind {
  std::string_view name;
  ModelKind kind;
};
constexpr std::array<Kind, 3> kKinds{
    {{"tassa9", ModelKind::tassa9}, {"tassa9r", ModelKind::tassa9r}, {"greybox", ModelKind::greybox}}};

ModelKind kind_named(std::string_view name) {
  const auto found =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& one) { return one.name == name; });
  if (found == kKinds.end()) {
    throw std::invalid_argument(
        fmt::format("a model of kind '{}', expected tassa9, tassa9r or greybox", name));
  }
  return found->kind;
}

/// 0 where the model says nothing of it.
double stated(const DecodedModel& model, std::string_view name) {
  const auto schema = plenum::config::parameter_schema(kind_named(model.kind)).first(model.parameters.size());
  const auto found = std::find_if(schema.begin(), schema.end(), [&](const auto& parameter) {
    return std::string_view(parameter.name) == name;
  });
  return found == schema.end() ? 0.0 : model.parameters[static_cast<std::size_t>(found - schema.begin())];
}

}  // namespace

double shortest_decimal(float value) {
  std::array<char, 32> digits{};
  const auto written = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  double decimal = 0.0;
  std::from_chars(digits.data(), written.ptr, decimal);
  return static_cast<float>(decimal) == value ? decimal : static_cast<double>(value);
}

std::vector<std::uint8_t> encode_model(std::string_view kind, std::span<const double> parameters,
                                       const ModelOrigin& origin) {
  ModelParameters model;
  model.kind = kind_named(kind);
  const std::size_t least = plenum::config::required_count(model.kind);
  const std::size_t most = plenum::config::parameter_schema(model.kind).size();
  if (parameters.size() < least || parameters.size() > most) {
    throw std::invalid_argument(fmt::format("{} parameters, expected {}{}", parameters.size(), least,
                                            least < most ? fmt::format(" to {}", most) : ""));
  }
  model.count = static_cast<std::uint16_t>(parameters.size());
  model.fit_error_kPa = static_cast<float>(origin.fit_error_kPa);
  model.fit_date_s = origin.fit_date_s;
  model.valve_serial = origin.valve_serial;
  model.sensor_serial = origin.sensor_serial;
  model.fixed_error_kPa = static_cast<float>(origin.fixed_error_kPa);
  for (std::size_t i = 0; i < parameters.size(); ++i) model.value[i] = static_cast<float>(parameters[i]);
  std::vector<std::uint8_t> image(plenum::config::kMaxImageBytes);
  image.resize(plenum::config::encode(model, image));
  return image;
}

DecodedModel decode_model(std::span<const std::uint8_t> image) {
  ModelParameters model;
  if (const auto verdict = plenum::config::decode(image, model); !verdict) {
    throw ProtocolError(fmt::format("the image of {} bytes {}, expected a model", image.size(),
                                    plenum::config::describe(verdict.error)));
  }
  DecodedModel decoded;
  for (const Kind& one : kKinds)
    if (one.kind == model.kind) decoded.kind = one.name;
  decoded.origin = {.fit_error_kPa = shortest_decimal(model.fit_error_kPa),
                    .fit_date_s = model.fit_date_s,
                    .valve_serial = model.valve_serial,
                    .sensor_serial = model.sensor_serial,
                    .fixed_error_kPa = shortest_decimal(model.fixed_error_kPa)};
  for (std::size_t i = 0; i < model.count; ++i)
    decoded.parameters.push_back(shortest_decimal(model.value[i]));
  return decoded;
}

double sensor_lag_s(const DecodedModel& model) {
  return stated(model, "sensor_lag_s");
}

double valve_delay_s(const DecodedModel& model) {
  return stated(model, "dead_time_s") +
         stated(model, "spool_damping") * stated(model, "spool_period_s") / std::numbers::pi;
}

}  // namespace plenum::host::client
