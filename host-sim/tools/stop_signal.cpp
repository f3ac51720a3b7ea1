#include "host-sim/tools/stop_signal.hpp"

namespace plenum::host::tools {
namespace {

volatile std::sig_atomic_t stop_asked = 0;

void ask_to_stop(int) {
  stop_asked = 1;
  struct sigaction at_once {};
  at_once.sa_handler = SIG_DFL;
  ::sigaction(SIGINT, &at_once, nullptr);
  ::sigaction(SIGTERM, &at_once, nullptr);
}

}  // namespace

StopSignal::StopSignal() {
  stop_asked = 0;
  struct sigaction action {};
  action.sa_handler = ask_to_stop;
  ::sigaction(SIGINT, &action, &interrupt_before_);
  ::sigaction(SIGTERM, &action, &terminate_before_);
}

StopSignal::~StopSignal() {
  ::sigaction(SIGINT, &interrupt_before_, nullptr);
  ::sigaction(SIGTERM, &terminate_before_, nullptr);
}

bool StopSignal::asked() const {
  return stop_asked != 0;
}

}  // namespace plenum::host::tools
