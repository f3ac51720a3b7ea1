// The board's TPDOs 5 to 12 for a while.
#pragma once

#include <optional>
#include <vector>

#include "host-sim/client/settings.hpp"
#include "host-sim/client/stream.hpp"

namespace plenum::host::tools {

/// The capture stream of the first `chambers` chambers, each tick; what it takes is as it was once it is given back.
class BorrowedStream {
 public:
  /// Throws as Session does.
  BorrowedStream(client::Session& session, unsigned chambers, double largest_volume_m3);
  const client::Stream& stream() const { return *stream_; }

  /// Throws Refused when the board does not take back what it had.
  void give_back();

 private:
  client::Session& session_;
  std::vector<client::Setting> before_;
  std::optional<client::Stream> stream_;
};

}  // namespace plenum::host::tools
