// The layer setting services (CiA 305) in words, for a log or a live view.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace plenum::host::client {

/// Of the eight bytes that a master sends on 7E5h, "configure node id 9", or of those of a node's answer on 7E4h, "configure node id:
/// done". What CiA 305 does not have is an unknown service.
std::string lss_request_text(std::span<const std::uint8_t, 8> bytes);
std::string lss_answer_text(std::span<const std::uint8_t, 8> bytes);

}  // namespace plenum::host::client
