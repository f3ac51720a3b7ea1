#include "firmware/config/model_image.hpp"

#include <algorithm>
#include <bit>

#include "firmware/config/crc32.hpp"
#include "firmware/config/limits.hpp"
#include "firmware/config/valve_curve.hpp"

namespace plenum::config {
namespace {

constexpr std::uint32_t kImageMagic = 0x324D4C50U;  // "PLM2"
constexpr std::size_t kCountAt = 10;
constexpr std::size_t kCrcBytes = 4;

constexpr std::size_t size_of(std::size_t count) noexcept {
  return kImageHeaderBytes + 4 * count + kCrcBytes;
}
static_assert(size_of(kMaxParameters) == kMaxImageBytes);

enum Tassa9 : std::uint8_t {
  c1,
  c2,
  c3,
  c4,
  c5,
  c6,
  c7,
  c8,
  c9,
  c_gamma,
  supply,
  ambient,
  dead_time,
  kTassa9Count
};
/// Images that say nothing of the valve's dead time end before it.
constexpr std::size_t kTassa9Required = dead_time;

// Table I of "Modeling and Identification of Pneumatic Actuators" where it states a range; the rest is what a
// valve and a chamber of this size can be. The floats next to -1 and 1 stand for the open bounds of c3 and
// c8.
constexpr std::array<ParameterSpec, kTassa9Count> kTassa9 = {{
    {"c1_V", 2.0F, 8.0F},
    {"c2_per_V", 1e-4F, 100.0F},
    {"c3_per_V3", -0.99999994F, 1000.0F},
    {"c4_kPa_s_per_mL", -1000.0F, 1000.0F},
    {"c5_per_mL", -1000.0F, 1000.0F},
    {"c6_per_mL", 0.0F, 1000.0F},
    {"c7_per_V_s", 1e-6F, 1e6F},
    {"c8", -0.99999994F, 0.99999994F},
    {"c9_V", kRateMargin_V, 10.0F},
    {"c_gamma_V", 0.001F, 2.0F},
    {"supply_kPa", 50.0F, 2000.0F},
    {"ambient_kPa", 10.0F, 200.0F},
    {"dead_time_s", 0.0F, 0.12F},
}};

/// Where the parameters of a command's curve stand in a kind that has one.
struct CurvePlaces {
  std::uint8_t c1, c2, c3, c8, c9, c_gamma, supply, ambient;
};
constexpr CurvePlaces kTassa9Curve = {c1, c2, c3, c8, c9, c_gamma, supply, ambient};

// tassa9 without its c4.
constexpr auto kTassa9r = [] {
  std::array<ParameterSpec, kTassa9Count - 1> schema{};
  std::size_t filled = 0;
  for (std::size_t i = 0; i < kTassa9.size(); ++i) {
    if (i != c4) schema[filled++] = kTassa9[i];
  }
  return schema;
}();
constexpr CurvePlaces kTassa9rCurve = {c1, c2, c3, c8 - 1, c9 - 1, c_gamma - 1, supply - 1, ambient - 1};

// In the order of GreyboxParameter: what valves from drops to a hundred litres a second and their chambers can be.
constexpr std::array<ParameterSpec, kGreyboxParameters> kGreybox = {{
    {"open_above_V", -5.0F, 15.0F},
    {"exhaust_below_V", -5.0F, 15.0F},
    {"inlet_conductance_mL_per_s_V", 1e-3F, 1e5F},
    {"exhaust_conductance_mL_per_s_V", 1e-3F, 1e5F},
    {"inlet_leak_mL_per_s", 0.0F, 1e5F},
    {"exhaust_leak_mL_per_s", 0.0F, 1e5F},
    {"transition_mL_per_s", 1e-4F, 1e5F},
    {"inlet_slope", -6.0F, 20.0F},
    {"inlet_curve", -20.0F, 20.0F},
    {"inlet_bend", -40.0F, 40.0F},
    {"exhaust_slope", -6.0F, 20.0F},
    {"exhaust_curve", -20.0F, 20.0F},
    {"exhaust_bend", -40.0F, 40.0F},
    {"critical_ratio", 0.05F, 0.8F},
    {"subsonic_index", 0.25F, 1.5F},
    {"cracking_ratio", 0.85F, 1.0F},
    {"discharge_slope", -0.8F, 0.8F},
    {"dead_volume_mL", -5000.0F, 5000.0F},
    {"volume_exponent", 1.0F, 1.4F},
    {"chamber_leak_mL_per_s", 0.0F, 1e5F},
    {"dead_time_s", 0.0F, 0.08F},
    {"spool_period_s", 0.0F, 0.5F},
    {"spool_damping", 0.3F, 2.0F},
    {"hysteresis_V", 0.0F, 1.5F},
    {"sensor_lag_s", 0.0F, 0.3F},
    {"supply_kPa", 50.0F, 2000.0F},
    {"ambient_kPa", 10.0F, 200.0F},
    {"supply_resistance_s_per_L", 0.0F, 20.0F},
    {"supply_recovery_s", 0.0F, 3.0F},
    {"supply_followed_share", 0.0F, 1.5F},
}};
/// Images that say nothing of the supply's line end before it.
constexpr std::size_t kGreyboxRequired = kSupplyResistance;

class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> bytes) noexcept : bytes_(bytes) {}
  void u16(std::uint16_t x) noexcept { put(x, 2); }
  void u32(std::uint32_t x) noexcept { put(x, 4); }
  void f32(float x) noexcept { put(std::bit_cast<std::uint32_t>(x), 4); }
  std::span<const std::uint8_t> written() const noexcept { return bytes_.first(at_); }

 private:
  void put(std::uint32_t x, std::size_t count) noexcept {
    for (std::size_t i = 0; i < count; ++i) bytes_[at_++] = static_cast<std::uint8_t>(x >> (8 * i));
  }
  std::span<std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {}
  std::uint16_t u16() noexcept { return static_cast<std::uint16_t>(take(2)); }
  std::uint32_t u32() noexcept { return take(4); }
  float f32() noexcept { return std::bit_cast<float>(take(4)); }

 private:
  std::uint32_t take(std::size_t count) noexcept {
    std::uint32_t x = 0;
    for (std::size_t i = 0; i < count; ++i) x |= std::uint32_t{bytes_[at_++]} << (8 * i);
    return x;
  }
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

class Fnv1a {
 public:
  constexpr void byte(std::uint32_t x) noexcept { hash_ = (hash_ ^ (x & 0xFFU)) * 0x01000193U; }
  constexpr void word(std::uint32_t x, int bytes) noexcept {
    for (int i = 0; i < bytes; ++i) byte(x >> (8 * i));
  }
  constexpr void text(const char* s) noexcept {
    for (; *s != '\0'; ++s) byte(static_cast<std::uint8_t>(*s));
    byte(0);  // parts "ab","c" from "a","bc"
  }
  constexpr std::uint32_t hash() const noexcept { return hash_; }

 private:
  std::uint32_t hash_ = 0x811C9DC5U;
};

constexpr std::uint32_t hash_of(ModelKind kind, std::span<const ParameterSpec> schema) noexcept {
  Fnv1a fnv;
  fnv.word(static_cast<std::uint32_t>(kind), 2);
  for (const ParameterSpec& spec : schema) {
    fnv.text(spec.name);
    fnv.word(std::bit_cast<std::uint32_t>(spec.low), 4);
    fnv.word(std::bit_cast<std::uint32_t>(spec.high), 4);
  }
  return fnv.hash();
}

ImageVerdict refuse(ImageError error) noexcept {
  return {.error = error};
}

ImageVerdict refuse_number(ImageError error, std::size_t found, std::size_t expected) noexcept {
  return {error, 0, static_cast<float>(found), static_cast<float>(expected), static_cast<float>(expected)};
}

ImageVerdict validate_curve(const ModelParameters& parameters, std::span<const ParameterSpec> schema,
                            const CurvePlaces& at) noexcept {
  const auto& c = parameters.value;
  const auto blame = [&](std::uint8_t parameter, float low) noexcept -> ImageVerdict {
    return {ImageError::not_admissible, parameter, c[parameter], low, schema[parameter].high};
  };
  if (!(c[at.supply] > c[at.ambient])) return blame(at.supply, c[at.ambient]);

  // c_gamma (1 - sqrt(1 - c8^2)) without the cancellation at small c8.
  const float c8_squared = c[at.c8] * c[at.c8];
  const float c9_low =
      c[at.c_gamma] * c8_squared / (1.0F + __builtin_sqrtf(1.0F - c8_squared)) + kRateMargin_V;
  if (!(c[at.c9] >= c9_low)) return blame(at.c9, c9_low);

  const float above_V = kCommandSpan_V - c[at.c1];
  const float farthest_V = c[at.c1] > above_V ? c[at.c1] : above_V;
  const float c3_low = -c[at.c2] / (3.0F * farthest_V * farthest_V);
  if (!(c[at.c3] >= c3_low)) return blame(at.c3, c3_low);
  return {};
}

ImageVerdict validate_tassa9(const ModelParameters& parameters) noexcept {
  return validate_curve(parameters, kTassa9, kTassa9Curve);
}

ImageVerdict validate_tassa9r(const ModelParameters& parameters) noexcept {
  return validate_curve(parameters, kTassa9r, kTassa9rCurve);
}

constexpr int kOpenings = 10;  // at which a port is looked at
constexpr float opening_V(int i) noexcept {
  return kLeastOpening_V * static_cast<float>(i) / kOpenings;
}

/// The least q with which o m(o) (valve_curve.hpp) rises from each opening to the next; it is linear in q but for the bound of m,
/// with which it rises all the more.
float least_slope(float curve, float bend) noexcept {
  float least = kGreybox[kInletSlope].low;
  float by_slope_before_V = 0.0F, rest_before_V = 0.0F;
  for (int i = 1; i <= kOpenings; ++i) {
    const float o = opening_V(i);
    const float g = o / (o + 2.0F);
    const float by_slope_V = o * g;
    const float rest_V = o * (1.0F + g * g * (curve + g * bend));
    least = std::max(least, -(rest_V - rest_before_V) / (by_slope_V - by_slope_before_V));
    by_slope_before_V = by_slope_V;
    rest_before_V = rest_V;
  }
  return least;
}

/// `slope`: the parameter to blame.
ImageVerdict validate_port(const ValveCurve& port, GreyboxParameter slope) noexcept {
  numeric::Scalar before_V = 0;
  for (int i = 1; i <= kOpenings; ++i) {
    const numeric::Scalar bent_V = port.bent_V(opening_V(i));
    if (!(bent_V > before_V)) {
      const float low = least_slope(static_cast<float>(port.curve), static_cast<float>(port.bend));
      return {ImageError::not_admissible, slope, static_cast<float>(port.slope), low, kGreybox[slope].high};
    }
    before_V = bent_V;
  }
  return {};
}

/// Dead time and spool together leave the regulator no more delay than it can look over. A lag that is made up for leaves half a tick
/// at most.
ImageVerdict validate_delay(const std::array<float, kMaxParameters>& of) noexcept {
  constexpr float kPi = 3.14159265F;
  constexpr float kMost_s = (kMostValveDelay_ticks - 0.5F) * kTick_s;
  const float spool_s = of[kSpoolDamping] * of[kSpoolPeriod] / kPi;
  const float lag_s = std::min(0.5F * spool_s, kMostSpoolLag_ticks * kTick_s);
  if (of[kDeadTime] + spool_s - lag_s <= kMost_s) return {};
  const float left_s = kMost_s - of[kDeadTime];  // for the spool: half of it is lag, up to the most
  const float most_spool_s = std::min(2.0F * left_s, left_s + kMostSpoolLag_ticks * kTick_s);
  const float most_period_s = of[kSpoolDamping] > 0.0F ? kPi * most_spool_s / of[kSpoolDamping] : 0.0F;
  return {ImageError::not_admissible, kSpoolPeriod, of[kSpoolPeriod], 0.0F, most_period_s};
}

ImageVerdict validate_greybox(const ModelParameters& parameters) noexcept {
  const auto& of = parameters.value;
  const auto blame_low = [&](GreyboxParameter which, float low) noexcept -> ImageVerdict {
    return {ImageError::not_admissible, which, of[which], low, kGreybox[which].high};
  };
  if (!(of[kSupply] > of[kAmbient])) return blame_low(kSupply, of[kAmbient]);
  constexpr float kLeastSubsonic = 0.05F;
  const float cracking_low = of[kCriticalRatio] + kLeastSubsonic;
  if (!(of[kCrackingRatio] >= cracking_low)) return blame_low(kCrackingRatio, cracking_low);
  if (const ImageVerdict delay = validate_delay(of); !delay) return delay;
  const std::array<numeric::Scalar, kMaxParameters> computed = scalars(parameters);
  const ImageVerdict inlet = validate_port(inlet_of(computed), kInletSlope);
  return inlet ? validate_port(exhaust_of(computed), kExhaustSlope) : inlet;
}

/// All that a kind of model is to an image.
struct Kind {
  constexpr Kind(ModelKind which, std::span<const ParameterSpec> all, std::size_t least,
                 std::uint8_t supply_place, std::uint8_t dead_time_place,
                 ImageVerdict (*joint)(const ModelParameters&) noexcept) noexcept
      : kind(which),
        schema(all),
        required(least),
        hash(hash_of(which, all.first(least))),
        supply_at(supply_place),
        dead_time_at(dead_time_place),
        validate(joint) {}

  ModelKind kind;
  std::span<const ParameterSpec> schema;
  std::size_t required;    ///< of them, from the first
  std::uint32_t hash;      ///< of what is required
  std::uint8_t supply_at;  ///< the ambient pressure is next to it
  std::uint8_t dead_time_at;
  ImageVerdict (*validate)(const ModelParameters&) noexcept;  ///< the joint conditions

  bool takes(std::size_t count) const noexcept { return count >= required && count <= schema.size(); }
};
constexpr std::array<Kind, 3> kKinds = {{
    {ModelKind::tassa9, kTassa9, kTassa9Required, supply, dead_time, validate_tassa9},
    {ModelKind::greybox, kGreybox, kGreyboxRequired, kSupply, kDeadTime, validate_greybox},
    {ModelKind::tassa9r, kTassa9r, kTassa9Required - 1, supply - 1, dead_time - 1, validate_tassa9r},
}};
static_assert(ambient == supply + 1 && kAmbient == kSupply + 1);

/// Null: this firmware does not know it.
const Kind* find_kind(ModelKind kind) noexcept {
  for (const Kind& one : kKinds) {
    if (one.kind == kind) return &one;
  }
  return nullptr;
}

ImageVerdict refuse_count(const Kind& kind, std::size_t found) noexcept {
  return {ImageError::wrong_count, 0, static_cast<float>(found), static_cast<float>(kind.required),
          static_cast<float>(kind.schema.size())};
}

}  // namespace

std::array<numeric::Scalar, kMaxParameters> scalars(const ModelParameters& parameters) noexcept {
  std::array<numeric::Scalar, kMaxParameters> values;
  std::copy(parameters.value.begin(), parameters.value.end(), values.begin());
  return values;
}

std::span<const ParameterSpec> parameter_schema(ModelKind kind) noexcept {
  const Kind* known = find_kind(kind);
  return known == nullptr ? std::span<const ParameterSpec>() : known->schema;
}

std::size_t required_count(ModelKind kind) noexcept {
  const Kind* known = find_kind(kind);
  return known == nullptr ? 0 : known->required;
}

std::uint32_t schema_hash(ModelKind kind) noexcept {
  const Kind* known = find_kind(kind);
  return known == nullptr ? hash_of(kind, {}) : known->hash;
}

const char* describe(ImageError error) noexcept {
  switch (error) {
    case ImageError::none:
      return "is accepted";
    case ImageError::too_short:
      return "is shorter than a header and its CRC";
    case ImageError::bad_magic:
      return "does not begin with PLM2";
    case ImageError::unknown_kind:
      return "is of a model kind that this firmware does not know";
    case ImageError::schema_mismatch:
      return "was written for another schema of its kind";
    case ImageError::wrong_count:
      return "has not a parameter count of its kind";
    case ImageError::wrong_size:
      return "has not the size that its parameter count asks for";
    case ImageError::bad_crc:
      return "does not match its CRC";
    case ImageError::not_finite:
      return "is not a finite number";
    case ImageError::out_of_range:
      return "is out of range";
    case ImageError::not_admissible:
      return "does not go with the other parameters";
    case ImageError::commit_pending:
      return "came while a commit waits for the tick's edge";
    case ImageError::no_such_chamber:
      return "names a chamber that the board does not have";
    case ImageError::predicts_worse:
      return "predicts the chamber's log worse than the model in force";
    case ImageError::wrong_serial:
      return "is of another valve or sensor than the board's settings name";
    case ImageError::staged_by_another:
      return "came while another master's upload session stands";
    case ImageError::inverse_fails:
      return "has an inverse that misses what it is asked for";
    case ImageError::no_authority:
      return "has a valve that does not act within the chamber's commands";
  }
  return "is refused for an unknown reason";
}

ImageVerdict validate(const ModelParameters& parameters) noexcept {
  const Kind* known = find_kind(parameters.kind);
  if (known == nullptr) return refuse(ImageError::unknown_kind);
  if (!known->takes(parameters.count)) return refuse_count(*known, parameters.count);
  const std::span<const ParameterSpec> schema = known->schema.first(parameters.count);
  if (!numeric::is_finite(parameters.fit_error_kPa)) {
    return {ImageError::not_finite, kFitErrorField, parameters.fit_error_kPa, 0.0F, 0.0F};
  }
  if (!numeric::is_finite(parameters.fixed_error_kPa)) {
    return {ImageError::not_finite, kFixedErrorField, parameters.fixed_error_kPa, 0.0F, 0.0F};
  }
  for (std::size_t i = 0; i < schema.size(); ++i) {
    const float value = parameters.value[i];
    const auto index = static_cast<std::uint8_t>(i);
    if (!numeric::is_finite(value)) {
      return {ImageError::not_finite, index, value, schema[i].low, schema[i].high};
    }
    if (value < schema[i].low || value > schema[i].high) {
      return {ImageError::out_of_range, index, value, schema[i].low, schema[i].high};
    }
  }
  return known->validate(parameters);
}

ImageVerdict validate_volume(const ModelParameters& parameters, float volume_mL) noexcept {
  if (parameters.kind != ModelKind::greybox) return {};
  const float dead_mL = parameters.value[kDeadVolume];
  if (volume_mL + dead_mL > 0.0F) return {};
  return {ImageError::not_admissible, kDeadVolume, dead_mL, -volume_mL, kGreybox[kDeadVolume].high};
}

SupplyPressures supply_of(const ModelParameters& parameters) noexcept {
  const Kind* known = find_kind(parameters.kind);
  if (known == nullptr) return {};
  return {.supply_kPa = parameters.value[known->supply_at],
          .ambient_kPa = parameters.value[known->supply_at + 1U]};
}

std::optional<float> dead_time_s(const ModelParameters& parameters) noexcept {
  const Kind* known = find_kind(parameters.kind);
  if (known == nullptr || parameters.count <= known->dead_time_at) return std::nullopt;
  return parameters.value[known->dead_time_at];
}

std::size_t encode(const ModelParameters& parameters, std::span<std::uint8_t> bytes) noexcept {
  const Kind* known = find_kind(parameters.kind);
  if (known == nullptr || !known->takes(parameters.count)) return 0;
  const std::size_t size = size_of(parameters.count);
  if (bytes.size() < size) return 0;

  Writer out(bytes);
  out.u32(kImageMagic);
  out.u32(known->hash);
  out.u16(static_cast<std::uint16_t>(parameters.kind));
  out.u16(parameters.count);
  out.u32(parameters.fit_date_s);
  out.f32(parameters.fit_error_kPa);
  out.u32(parameters.valve_serial);
  out.u32(parameters.sensor_serial);
  out.f32(parameters.fixed_error_kPa);
  for (std::size_t i = 0; i < parameters.count; ++i) out.f32(parameters.value[i]);
  out.u32(crc32(out.written()));
  return size;
}

std::span<const std::uint8_t> first_image(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.size() < size_of(0)) return {};
  const std::size_t count = Reader(bytes.subspan(kCountAt)).u16();
  if (count > kMaxParameters || size_of(count) > bytes.size()) return {};
  return bytes.first(size_of(count));
}

ImageVerdict decode(std::span<const std::uint8_t> bytes, ModelParameters& parameters) noexcept {
  if (bytes.size() < size_of(0)) return refuse_number(ImageError::too_short, bytes.size(), size_of(0));
  Reader in(bytes);
  if (in.u32() != kImageMagic) return refuse(ImageError::bad_magic);

  const std::uint32_t hash = in.u32();
  ModelParameters read;
  read.kind = static_cast<ModelKind>(in.u16());
  read.count = in.u16();
  const Kind* known = find_kind(read.kind);
  if (known == nullptr) return refuse(ImageError::unknown_kind);
  if (hash != known->hash) return refuse(ImageError::schema_mismatch);
  if (!known->takes(read.count)) return refuse_count(*known, read.count);
  const std::size_t size = size_of(read.count);
  if (bytes.size() != size) return refuse_number(ImageError::wrong_size, bytes.size(), size);
  if (Reader(bytes.last(kCrcBytes)).u32() != crc32(bytes.first(size - kCrcBytes))) {
    return refuse(ImageError::bad_crc);
  }

  read.fit_date_s = in.u32();
  read.fit_error_kPa = in.f32();
  read.valve_serial = in.u32();
  read.sensor_serial = in.u32();
  read.fixed_error_kPa = in.f32();
  for (std::size_t i = 0; i < read.count; ++i) read.value[i] = in.f32();
  const ImageVerdict verdict = validate(read);
  if (verdict) parameters = read;
  return verdict;
}

}  // namespace plenum::config
