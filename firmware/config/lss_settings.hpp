// How a node is reached: what LSS (CiA 305) configures, kept apart from every other parameter so that neither a model nor
// 1011h can cut a board off.
#pragma once

#include <cstdint>

namespace plenum::config {

struct LssSettings {
  std::uint8_t node_id = 0;         ///< 1..127; 0: none stored, the installer's counts
  std::uint16_t bit_rate_kbit = 0;  ///< [kbit/s]; 0: none stored, the installer's counts

  friend bool operator==(const LssSettings&, const LssSettings&) noexcept = default;
};

}  // namespace plenum::config
