#include "host-sim/tools/fit_origin.hpp"

#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string_view>

namespace plenum::host::tools {
namespace {

/// A whole number that takes all of the text.
std::optional<std::int64_t> whole_number(std::string_view text) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// Of "2026-11-24", at its beginning in UTC.
std::optional<std::int64_t> day_s(std::string_view text) {
  constexpr std::string_view kForm = "YYYY-MM-DD";
  if (text.size() != kForm.size() || text[4] != '-' || text[7] != '-') return std::nullopt;
  const auto year = whole_number(text.substr(0, 4)), month = whole_number(text.substr(5, 2)),
             day = whole_number(text.substr(8, 2));
  if (!year || !month || !day || *month < 0 || *day < 0) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(static_cast<int>(*year)),
                                         std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  if (!date.ok()) return std::nullopt;
  return std::chrono::seconds(std::chrono::sys_days(date).time_since_epoch()).count();
}

std::uint32_t stated_s(const char* where, const std::string& text) {
  constexpr std::int64_t kMost = std::numeric_limits<std::uint32_t>::max();
  const std::optional<std::int64_t> day = day_s(text);
  const std::optional<std::int64_t> date_s = day ? day : whole_number(text);
  if (date_s && *date_s >= 0 && *date_s <= kMost) return static_cast<std::uint32_t>(*date_s);
  throw std::invalid_argument(fmt::format(
      "{} {}: expected a date as 2026-11-24, or seconds since 1970, 0 to {}", where, text, kMost));
}

}  // namespace

void add_fit_date(Arguments& arguments, std::string& date) {
  arguments
      .option(
          "--date", date,
          "When the model was fitted, to be told in it: 2026-11-24, or seconds since 1970 (default: that of "
          "SOURCE_DATE_EPOCH, else now)")
      .type_name("DATE");
}

std::uint32_t fit_date_s(const std::string& date) {
  if (!date.empty()) return stated_s("--date", date);
  if (const char* epoch = std::getenv("SOURCE_DATE_EPOCH"); epoch != nullptr && *epoch != '\0')
    return stated_s("SOURCE_DATE_EPOCH", epoch);
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint32_t>(std::chrono::duration_cast<std::chrono::seconds>(now).count());
}

void state_origin(trace::ModelFile& model, std::uint32_t date_s, const trace::RigDescription& rig) {
  model.fit["date_s"] = date_s;
  const auto chamber = model.chamber ? rig.chamber.find(*model.chamber) : rig.chamber.end();
  if (chamber == rig.chamber.end()) return;
  if (chamber->second.valve_serial != 0) model.fit["valve_serial"] = chamber->second.valve_serial;
  if (chamber->second.sensor_serial != 0) model.fit["sensor_serial"] = chamber->second.sensor_serial;
}

}  // namespace plenum::host::tools
