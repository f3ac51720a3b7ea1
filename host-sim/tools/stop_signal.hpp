// Ctrl-C and SIGTERM as a question: has somebody asked to stop?
#pragma once

#include <csignal>

namespace plenum::host::tools {

/// While one lives, SIGINT and SIGTERM do not end the program; waiting system calls end early. One at a time.
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
