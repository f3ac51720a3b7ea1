// Settings of a board for a while: what a recording changes is as it was once it is over.
#pragma once

#include <functional>
#include <vector>

#include "host-sim/client/settings.hpp"
#include "host-sim/client/stream.hpp"

namespace plenum::host::client {

class BorrowedSettings {
 public:
  /// Reads those that are `wanted`; whoever has this may change them. Throws as Session does.
  BorrowedSettings(Session& session, const std::function<bool(const SettingId&)>& wanted);
  /// Reads `objects`, which need not be settings.
  BorrowedSettings(Session& session, std::vector<Setting> objects);
  /// Gives back what was not; a board or a bus that fails then is not heard of.
  ~BorrowedSettings();
  BorrowedSettings(const BorrowedSettings&) = delete;
  BorrowedSettings& operator=(const BorrowedSettings&) = delete;

  /// Throws Refused when the board does not take back what it had, and as Session does.
  void give_back();

 private:
  Session& session_;
  std::vector<Setting> before_;  ///< empty: given back
};

/// To be asked first: throws Refused where the board streams already. Two programs would take each other's stream away, and what one has
/// borrowed is no setting.
void require_no_stream(Session& session);

/// The capture stream for a while: the board's TPDOs 5 to 12 and 2228h:2, and TPDO4 where the supply is streamed.
class BorrowedStream {
 public:
  /// Throws as Session::configure_stream().
  BorrowedStream(Session& session, const StreamConfig& config);
  const Stream& stream() const { return stream_; }

  /// As BorrowedSettings, whose destructor does the same.
  void give_back() { settings_.give_back(); }

 private:
  BorrowedSettings settings_;
  Stream stream_;
};

}  // namespace plenum::host::client
