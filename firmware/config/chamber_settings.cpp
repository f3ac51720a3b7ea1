#include "firmware/config/chamber_settings.hpp"

#include "firmware/config/setting_fields.hpp"
#include "firmware/numeric/scalar.hpp"

namespace plenum::config {
namespace {

SettingVerdict check(const char* field, float value, float low, float high, SettingError error) noexcept {
  if (!numeric::is_finite(value)) return {SettingError::not_finite, field, value, low, high};
  if (value < low || value > high) return {error, field, value, low, high};
  return {};
}

template <typename Settings, typename Fields>
SettingVerdict check_each(const Settings& settings, const Fields& fields) noexcept {
  for (const auto& field : fields) {
    const auto value = static_cast<float>(settings.*field.member);
    const SettingVerdict verdict =
        check(field.name, value, field.low, field.high, SettingError::out_of_range);
    if (!verdict) return verdict;
  }
  return {};
}

// Two commands or voltages that are to differ must be told apart by the converters.
constexpr float kApart_V = 0.01F;
constexpr float kApart_kPa = 0.1F;

SettingVerdict check_together(const ChamberSettings& s) noexcept {
  const struct {
    const char* field;
    float value, low, high;
    bool crossed = false;  // a highest value has fallen below its lowest
  } relations[] = {
      {"pressure_valid_high_V", s.pressure_valid_high_V, s.pressure_valid_low_V + kApart_V, 11.0F,
       s.pressure_valid_high_V < s.pressure_valid_low_V},
      {"position_valid_high_V", s.position_valid_high_V, s.position_valid_low_V + kApart_V, 11.0F,
       s.position_valid_high_V < s.position_valid_low_V},
      {"pressure_high_kPa", s.pressure_high_kPa, s.pressure_low_kPa + kApart_kPa, 2000.0F,
       s.pressure_high_kPa < s.pressure_low_kPa},
      // A trip that the sensor cannot reach inside its valid range would never fire.
      {"over_pressure_kPa", s.over_pressure_kPa, s.pressure_high_kPa,
       pressure_kPa(s, s.pressure_valid_high_V)},
      {"null_V", s.null_V, s.command_low_V + kApart_V, s.command_high_V - kApart_V,
       s.command_high_V < s.command_low_V},
      {"vent_V", s.vent_V, 0.0F, s.null_V - kApart_V},
  };
  for (const auto& r : relations) {
    SettingVerdict verdict = check(r.field, r.value, r.low, r.high, SettingError::not_admissible);
    verdict.max_below_min = r.crossed;
    if (!verdict) return verdict;
  }
  if (s.safe_output != SafeOutput::null && s.safe_output != SafeOutput::vent) {
    return {SettingError::out_of_range, "safe_output", static_cast<float>(s.safe_output), 0.0F, 1.0F};
  }
  if (s.ramp_type > RampType::by_quadrant) {
    return {SettingError::out_of_range, "ramp_type", static_cast<float>(s.ramp_type), 0.0F, 3.0F};
  }
  return {};
}

}  // namespace

SettingVerdict validate(const ChamberSettings& settings) noexcept {
  if (const SettingVerdict verdict = check_each(settings, kChamberFloats); !verdict) return verdict;
  if (const SettingVerdict verdict = check_each(settings, kChamberTicks); !verdict) return verdict;
  return check_together(settings);
}

SettingVerdict validate(const BoardSettings& settings) noexcept {
  if (const SettingVerdict verdict = check_each(settings, kBoardFloats); !verdict) return verdict;
  return check_each(settings, kBoardTicks);
}

RampRates ramp_rates(const ChamberSettings& settings) noexcept {
  constexpr float kAtOnce_kPa_s = 1e6F;  // beyond all pressures within a tick
  switch (settings.ramp_type) {
    case RampType::none:
      return {kAtOnce_kPa_s, kAtOnce_kPa_s};
    case RampType::one_rate:
      return {settings.reference_ramp_kPa_per_s, settings.reference_ramp_kPa_per_s};
    case RampType::two_rates:
    case RampType::by_quadrant:
      break;
  }
  return {settings.reference_ramp_kPa_per_s, settings.reference_fall_kPa_per_s};
}

}  // namespace plenum::config
