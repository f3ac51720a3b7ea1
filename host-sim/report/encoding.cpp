#include "host-sim/report/encoding.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

namespace plenum::host::report {
namespace {

struct Grid {
  double from, step;
};

// An even grid to well within a float's resolution of its span, so that storing three numbers loses nothing.
std::optional<Grid> even_grid(std::span<const double> values) {
  if (values.size() < 3 || !std::ranges::all_of(values, [](double v) { return std::isfinite(v); })) return {};
  const double intervals = static_cast<double>(values.size() - 1);
  const double from = values.front();
  const double step = (values.back() - from) / intervals;
  const double tolerance = 1e-8 * std::abs(values.back() - from);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::abs(values[i] - (from + step * static_cast<double>(i))) > tolerance) return {};
  return Grid{from, step};
}

std::string floats_little_endian_base64(std::span<const double> values) {
  std::vector<unsigned char> bytes;
  bytes.reserve(4 * values.size());
  for (const double value : values) {
    const float narrow = static_cast<float>(value);
    const auto bits = std::bit_cast<std::uint32_t>(
        std::isfinite(narrow) ? narrow : std::numeric_limits<float>::quiet_NaN());
    for (unsigned shift = 0; shift < 32; shift += 8)
      bytes.push_back(static_cast<unsigned char>(bits >> shift));
  }
  return base64(bytes);
}

std::string superscript(int exponent) {
  static constexpr std::array<std::string_view, 10> kDigits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string out;
  for (const char c : std::to_string(exponent))
    out += c == '-' ? "⁻" : kDigits[static_cast<std::size_t>(c - '0')];
  return out;
}

/// A plain number of no sign, its integer part grouped by three from 10 000 on.
std::string grouped(std::string plain) {
  const std::size_t integer = std::min(plain.find('.'), plain.size());
  if (integer > 4)
    for (std::size_t at = integer; at > 3; at -= 3) plain.insert(at - 3, "\u202f");
  return plain;
}

std::string without_trailing_zeros(std::string number) {
  if (number.find('.') == std::string::npos) return number;
  number.erase(number.find_last_not_of('0') + 1);
  if (number.back() == '.') number.pop_back();
  return number;
}

}  // namespace

std::string escape_html(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string script_safe(const nlohmann::ordered_json& value) {
  // Bytes that are no UTF-8 become U+FFFD: a report about a damaged file must still open.
  const std::string text = value.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

std::string base64(std::span<const unsigned char> bytes) {
  static constexpr std::string_view kAlphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t present = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < present ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) out += k <= present ? kAlphabet[group >> (18 - 6 * k) & 63U] : '=';
  }
  return out;
}

std::string significant(double value, int digits) {
  if (!std::isfinite(value)) return "–";
  if (value == 0.0) return "0";
  const std::string scientific = fmt::format("{:.{}e}", std::abs(value), digits - 1);
  const std::size_t e = scientific.find('e');
  const int exponent = std::stoi(scientific.substr(e + 1));  // of the rounded value: 0.99996 has that of 1
  const std::string sign = value < 0 ? "−" : "";
  if (exponent < -4 || exponent >= 7)
    return sign + without_trailing_zeros(scientific.substr(0, e)) + "×10" + superscript(exponent);
  return sign + grouped(without_trailing_zeros(
                    fmt::format("{:.{}f}", std::abs(value), std::max(0, digits - 1 - exponent))));
}

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "–";
  const std::string plain = fmt::format("{:.{}f}", std::abs(value), decimals);
  const bool zero = plain.find_first_not_of("0.") == std::string::npos;
  return (value < 0 && !zero ? "−" : "") + grouped(plain);
}

std::size_t ArrayPool::add(std::span<const double> values) {
  nlohmann::ordered_json entry;
  if (const auto grid = even_grid(values))
    entry = {{"from", grid->from}, {"step", grid->step}, {"count", values.size()}};
  else
    entry = {{"f32", floats_little_endian_base64(values)}};
  const auto [at, is_new] = index_of_.try_emplace(entry.dump(), arrays_.size());
  if (is_new) arrays_.push_back(std::move(entry));
  return at->second;
}

}  // namespace plenum::host::report
