// Ctrl-C and SIGTERM as a question: has somebody asked to stop?
#pragma once

#include <csignal>

namespace plenum::host::tools {

/// While one lives, the first SIGINT or SIGTERM does not end the program, the second does at once; waiting system calls end
/// early. One at a time.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  bool asked() const;

 private:
  struct sigaction interrupt_before_ {};
  struct sigaction terminate_before_ {};
};

}  // namespace plenum::host::tools
