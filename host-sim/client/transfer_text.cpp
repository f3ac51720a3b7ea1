#include "host-sim/client/transfer_text.hpp"

#include <fmt/format.h>

#include "firmware/canopen/object_dictionary.hpp"

namespace plenum::host::client {

std::string text_of(const Transfer& transfer) {
  const canopen::Found found = canopen::find(transfer.index, transfer.sub);
  if (found.entry == nullptr) return fmt::format("{:04X}h:{}", transfer.index, transfer.sub);
  const std::string bytes = transfer.total  ? fmt::format(", {} of {} bytes", transfer.done, *transfer.total)
                            : transfer.done ? fmt::format(", {} bytes", transfer.done)
                                            : "";
  constexpr std::uint16_t kOwn = 0x2000;  // below it are those of PDOs
  const std::string name = found.entry->name + bytes;
  return found.entry->instances > 1 && transfer.index >= kOwn
             ? fmt::format("chamber {}: {}", found.place.instance + 1, name)
             : name;
}

}  // namespace plenum::host::client
