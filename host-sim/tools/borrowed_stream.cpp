#include "host-sim/tools/borrowed_stream.hpp"

#include <fmt/format.h>

#include <utility>

namespace plenum::host::tools {

namespace object = canopen::object;

BorrowedStream::BorrowedStream(client::Session& session, unsigned chambers, double largest_volume_m3)
    : session_(session) {
  for (client::Setting& setting : client::read_settings(session)) {
    const std::uint16_t index = setting.id.index;
    const bool communication =
        index >= object::kTpdoCommunication + 4 && index < object::kTpdoCommunication + 12;
    const bool mapping = index >= object::kTpdoMapping + 4 && index < object::kTpdoMapping + 12;
    if (communication || mapping || index == object::kCodeScale) before_.push_back(std::move(setting));
  }
  stream_.emplace(session.configure_stream({.chambers = static_cast<std::uint8_t>((1U << chambers) - 1U),
                                            .largest_volume_m3 = largest_volume_m3}));
}

void BorrowedStream::give_back() {
  const auto troubles = client::write_settings(session_, before_);
  if (troubles.empty()) return;
  throw client::Refused(fmt::format("node {}: {} of the stream's settings are not as they were before: {}",
                                    session_.node_id(), troubles.size(), troubles.front().reason));
}

}  // namespace plenum::host::tools
