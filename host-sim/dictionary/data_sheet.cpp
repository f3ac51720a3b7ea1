#include "host-sim/dictionary/data_sheet.hpp"

#include <array>
#include <memory>

namespace plenum::host::dictionary {

std::string electronic_data_sheet(const canopen::Identity& identity) {
  const auto device = std::make_unique<DataSheet>(identity);
  std::string text;
  std::array<std::uint8_t, canopen::DataSheet::kRepeat> block{};
  while (const std::size_t count = device->sheet.read(static_cast<std::uint32_t>(text.size()), block))
    text.append(block.begin(), block.begin() + static_cast<std::ptrdiff_t>(count));
  return text;
}

}  // namespace plenum::host::dictionary
