// How a node is reached: what LSS (CiA 305) configures, kept apart from every other parameter so that neither a model nor
// 1011h can cut a board off.
#pragma once

#include <cstdint>
#include <span>

#include "firmware/config/parameter_record.hpp"

namespace plenum::config {

struct LssSettings {
  std::uint8_t node_id = 0;         ///< 1..127; 0: none stored, the installer's counts
  std::uint16_t bit_rate_kbit = 0;  ///< [kbit/s]; 0: none stored. The installer's counts, where one is stated

  friend bool operator==(const LssSettings&, const LssSettings&) noexcept = default;
};

/// Their rows in a stored set stand below the object dictionary: index 0, and these sub-indices.
inline constexpr std::uint8_t kNodeIdRow = 1;   ///< U8
inline constexpr std::uint8_t kBitRateRow = 2;  ///< U16 [kbit/s]

/// Takes the value of `row` over. False: it is none of these rows, or no value that it may have.
bool take_row(LssSettings& settings, const RecordRow& row) noexcept;

/// Those of a stored set.
LssSettings lss_in(std::span<const std::uint8_t> body) noexcept;

}  // namespace plenum::config
