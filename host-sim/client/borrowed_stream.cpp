#include "host-sim/client/borrowed_stream.hpp"

#include <fmt/format.h>

#include <utility>

namespace plenum::host::client {
namespace {

namespace object = canopen::object;

bool is_of_stream(const SettingId& id, const StreamConfig& config) {
  const std::uint32_t least = config.supply ? kSupplyTpdo : kStreamTpdo;
  const auto in = [&](std::uint32_t first) {
    return id.index >= first + least && id.index < first + kStreamTpdo + kChambers;
  };
  return in(object::kTpdoCommunication) || in(object::kTpdoMapping) || id.index == object::kCodeScale;
}

}  // namespace

BorrowedSettings::BorrowedSettings(Session& session, const std::function<bool(const SettingId&)>& wanted)
    : session_(session), before_(read_settings(session, wanted)) {}

BorrowedSettings::BorrowedSettings(Session& session, std::vector<Setting> objects)
    : session_(session), before_(read_values(session, std::move(objects))) {}

BorrowedSettings::~BorrowedSettings() {
  try {
    give_back();
  } catch (const std::exception&) {  // an exception ends the loan, and is the one to tell
  }
}

void BorrowedSettings::give_back() {
  const std::vector<Setting> before = std::exchange(before_, {});
  const std::vector<SettingTrouble> troubles = write_settings(session_, before);
  if (troubles.empty()) return;
  throw Refused(fmt::format("node {}: {} of the settings that were borrowed are not as they were before: {}",
                            session_.node_id(), troubles.size(), troubles.front().reason));
}

void require_no_stream(Session& session) {
  for (std::uint32_t tpdo = kStreamTpdo; tpdo < kStreamTpdo + kChambers; ++tpdo) {
    const auto cob_id = session.read<std::uint32_t>(object::nth(object::kTpdoCommunication, tpdo), 1);
    const bool on = (cob_id & canopen::cob::kInvalid) == 0;
    if (!on || !stream_block({.id = cob_id & canopen::cob::kIdMask})) continue;
    throw Refused(
        fmt::format("node {}: its TPDO {} streams on {:03X}h already, expected it off: capture, regulate, "
                    "acceptance or monitor --stream is at "
                    "work on it, or was killed; plenum reset --communication ends what was left on",
                    session.node_id(), tpdo + 1, cob_id & canopen::cob::kIdMask));
  }
}

BorrowedStream::BorrowedStream(Session& session, const StreamConfig& config)
    : settings_(session, [&config](const SettingId& id) { return is_of_stream(id, config); }),
      stream_(session.configure_stream(config)) {}

}  // namespace plenum::host::client
