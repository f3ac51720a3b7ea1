// What a conversation with a board can come to, besides its result. Each message is one line: what, where, what was
// expected.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace plenum::host::client {

/// The board answered with an abort.
class SdoAbort : public std::runtime_error {
 public:
  SdoAbort(const std::string& what, std::uint16_t index_, std::uint8_t sub_, std::uint32_t code_)
      : std::runtime_error(what), index(index_), sub(sub_), code(code_) {}
  std::uint16_t index;
  std::uint8_t sub;
  std::uint32_t code;
};

/// The board did not answer, or did not come to a state, in time.
class Timeout : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Others use all that there is: the board's SDO channel, which has room for one, or the identifiers of streams.
class ChannelTaken : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What came back is no CANopen, or not what was asked for.
class ProtocolError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The board understood and said no: a model that fails its checks, a fault that stands.
class Refused : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace plenum::host::client
