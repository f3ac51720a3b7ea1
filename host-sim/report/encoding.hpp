// How text and numbers enter a page.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace plenum::host::report {

/// Text for element content and quoted attributes: & < > " ' become entities.
std::string escape_html(std::string_view text);

/// JSON that may stand inside a <script> element: no "<" survives, so neither "</script>" nor "<!--" can.
std::string script_safe(const nlohmann::ordered_json& value);

/// RFC 4648, with padding.
std::string base64(std::span<const unsigned char> bytes);

/// `value` for people: `digits` significant digits without trailing zeros (more where the integer part has
/// more), grouped by three from 10 000 on, powers of ten beyond 1e7 and below 1e-4, and a dash for what is
/// not finite.
std::string significant(double value, int digits = 4);

/// `value` to so many decimals, grouped and signed likewise.
std::string fixed(double value, int decimals);

/// The number arrays of a page, each stored once.
class ArrayPool {
 public:
  /// Index of the array in the pool; equal arrays get equal indices.
  std::size_t add(std::span<const double> values);

  /// The pool as the page reads it: {"from","step","count"} for an even grid, else {"f32": base64, little
  /// endian}.
  const nlohmann::ordered_json& json() const { return arrays_; }

 private:
  nlohmann::ordered_json arrays_ = nlohmann::ordered_json::array();
  std::unordered_map<std::string, std::size_t> index_of_;
};

}  // namespace plenum::host::report
