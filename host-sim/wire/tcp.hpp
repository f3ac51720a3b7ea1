// TCP sockets that never block: connecting, listening, and the words for what went wrong.
#pragma once

#include <cstdint>
#include <string>

#include "host-sim/wire/file_descriptor.hpp"

namespace plenum::host::wire {

/// A connection to `host`:`port` that sends small messages at once. Throws std::runtime_error: what, where, expected.
FileDescriptor connect_tcp(const std::string& host, std::uint16_t port, double timeout_s);

/// A socket that listens on `host`:`port`; port 0 is any free one. Throws std::runtime_error.
FileDescriptor listen_tcp(const std::string& host, std::uint16_t port);
/// The port that a listening socket has.
std::uint16_t port_of(const FileDescriptor& listening);
/// A waiting connection, set up as connect_tcp() does; none when nobody waits.
FileDescriptor accept_tcp(const FileDescriptor& listening);

}  // namespace plenum::host::wire
