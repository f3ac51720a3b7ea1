// The frames of a bus as a log of can-utils, and where frames are missing from it.
#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "host-sim/client/link.hpp"

namespace plenum::host::client {

class BusRecorder {
 public:
  /// Frames that the link lost.
  struct Gap {
    std::uint64_t before_frame = 0;  ///< number, from 0, of the frame that comes next in the log
    double time_s = 0.0;             ///< at which that frame was taken, since the recording began
    std::uint64_t lost = 0;
  };

  /// `channel`: the name of the bus in the log. A frame has the time that its stamp says; where the link has no stamps, that at which it
  /// was taken, counted from `begin_us` [us since 1970]. Link and log must outlive the recorder.
  BusRecorder(Link& link, std::ostream& log, std::string channel, std::uint64_t begin_us);

  /// Takes the next frame, for which it waits `timeout_s` at most, and writes it, where frames have been lost before it behind an
  /// error frame that says so (wire::kReceiveOverflow). Returns false when none came.
  bool take(double timeout_s);

  std::uint64_t frames() const { return frames_; }
  std::uint64_t lost() const { return lost_; }
  const std::vector<Gap>& gaps() const { return gaps_; }

 private:
  Link& link_;
  std::ostream& log_;
  std::string channel_;
  std::uint64_t begin_us_;
  double begin_s_;
  std::uint64_t frames_ = 0;
  std::uint64_t lost_ = 0;
  std::vector<Gap> gaps_;
};

}  // namespace plenum::host::client
