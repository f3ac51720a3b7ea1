#include "host-sim/client/storing.hpp"

#include <fmt/format.h>

#include "firmware/canopen/objects.hpp"
#include "firmware/canopen/process_image.hpp"

namespace plenum::host::client {

void await_stored(Session& session, double timeout_s) {
  using plenum::canopen::StorePhase;
  constexpr double kPoll_s = 0.01;
  for (const double end_s = session.link().now_s() + timeout_s;; session.listen(kPoll_s)) {
    const auto phase =
        static_cast<StorePhase>(session.read<std::uint8_t>(plenum::canopen::object::kStoredSet, 1));
    if (phase == StorePhase::idle) return;
    if (phase == StorePhase::failing) {
      throw Refused(fmt::format(
          "node {}: the models are in force, but could not be stored: {} failed attempts", session.node_id(),
          session.read<std::uint32_t>(plenum::canopen::object::kStoredSet, 6)));
    }
    if (session.link().now_s() >= end_s) {
      throw Timeout(fmt::format("node {}: not stored after {:g} s", session.node_id(), timeout_s));
    }
  }
}

}  // namespace plenum::host::client
