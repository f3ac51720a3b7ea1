#include "host-sim/trace/legible.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace plenum::host::trace {
namespace {

constexpr std::size_t kMostCharacters = 60;
constexpr std::size_t kMostNames = 20;

}  // namespace

std::string legible(std::string_view text) {
  std::string shown;
  for (const char c : text) {
    if (shown.size() >= kMostCharacters) return shown + "...";
    if (c >= ' ' && c <= '~') {
      shown += c;
    } else {
      shown += fmt::format("\\x{:02X}", static_cast<unsigned char>(c));
    }
  }
  return shown;
}

std::string legible_list(const std::vector<std::string>& names) {
  std::string shown;
  for (std::size_t i = 0; i < std::min(names.size(), kMostNames); ++i) {
    if (i != 0) shown += ", ";
    shown += legible(names[i]);
  }
  return names.size() <= kMostNames ? shown : fmt::format("{} and {} more", shown, names.size() - kMostNames);
}

}  // namespace plenum::host::trace
