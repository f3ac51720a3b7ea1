#include "firmware/config/lss_settings.hpp"

namespace plenum::config {
namespace {

constexpr std::uint8_t kMostNodeId = 127;

}  // namespace

bool take_row(LssSettings& settings, const RecordRow& row) noexcept {
  const std::span<const std::uint8_t> value = row.value;
  if (row.index != 0) return false;
  if (row.sub == kNodeIdRow && value.size() == 1 && value[0] <= kMostNodeId) {
    settings.node_id = value[0];
  } else if (row.sub == kBitRateRow && value.size() == 2) {
    settings.bit_rate_kbit = static_cast<std::uint16_t>(value[0] | value[1] << 8);
  } else {
    return false;
  }
  return true;
}

LssSettings lss_in(std::span<const std::uint8_t> body) noexcept {
  LssSettings settings;
  RowReader rows(body);
  for (RecordRow row; rows.next(row);) take_row(settings, row);
  return settings;
}

}  // namespace plenum::config
