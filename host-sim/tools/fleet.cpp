#include "host-sim/tools/fleet.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host-sim/client/model_bytes.hpp"
#include "host-sim/rounding/tick_error.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::tools {
namespace {

/// A whole number of the free part of a model file; 0 when it is not there.
std::uint32_t count_in(const nlohmann::ordered_json& fit, const char* name) {
  const auto found = fit.find(name);
  return found != fit.end() && found->is_number_unsigned() ? found->get<std::uint32_t>() : 0;
}

constexpr const char* kError = "rms_one_step_kPa";
constexpr const char* kDate = "date_s";
constexpr const char* kValve = "valve_serial";
constexpr const char* kSensor = "sensor_serial";

}  // namespace

double fixed_error_kPa(const trace::ModelFile& file) {
  const double bound_kPa = rounding::tick_error_kPa(file.kind, file.parameters).value_or(0.0);
  return std::isfinite(bound_kPa) ? bound_kPa : 0.0;
}

client::ModelUpload upload_of(const trace::ModelFile& file, unsigned chamber, double fixed_error_kPa) {
  const auto error = file.fit.find(kError);
  const client::ModelOrigin origin{
      .fit_error_kPa = error != file.fit.end() && error->is_number() ? error->get<double>() : 0.0,
      .fit_date_s = count_in(file.fit, kDate),
      .valve_serial = count_in(file.fit, kValve),
      .sensor_serial = count_in(file.fit, kSensor),
      .fixed_error_kPa = fixed_error_kPa};
  return {static_cast<std::uint8_t>(chamber - 1), client::encode_model(file.kind, file.parameters, origin)};
}

trace::ModelFile file_of(std::span<const std::uint8_t> image, unsigned chamber) {
  const client::DecodedModel decoded = client::decode_model(image);
  trace::ModelFile file;
  file.chamber = chamber;
  file.kind = decoded.kind;
  file.parameters = decoded.parameters;
  file.fit[kError] = decoded.origin.fit_error_kPa;
  if (decoded.origin.fit_date_s != 0) file.fit[kDate] = decoded.origin.fit_date_s;
  if (decoded.origin.valve_serial != 0) file.fit[kValve] = decoded.origin.valve_serial;
  if (decoded.origin.sensor_serial != 0) file.fit[kSensor] = decoded.origin.sensor_serial;
  return file;
}

}  // namespace plenum::host::tools
