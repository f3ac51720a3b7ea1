// A server by script: frames written as a bus monitor prints them, "585 43 00 10 00 92 01 02 00".
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host-sim/client/link.hpp"
#include "tests/firmware/canopen/bench.hpp"

namespace plenum::host::client {

/// Answers each frame with the next line of a script: none, one, or several parted by '|'.
class ScriptedLink final : public Link {
 public:
  explicit ScriptedLink(std::deque<std::string> script) : script_(std::move(script)) {}
  void send(const CanFrame& frame) override {
    sent.push_back(canopen::text_of(frame));
    if (script_.empty()) return;
    std::istringstream line(script_.front());
    for (std::string one; std::getline(line, one, '|');) arriving_.push_back(canopen::frame_from(one));
    script_.pop_front();
  }
  std::optional<CanFrame> receive(double timeout_s) override {
    if (arriving_.empty()) {
      now_s_ += timeout_s;
      return std::nullopt;
    }
    now_s_ += 1.0e-4;
    const CanFrame frame = arriving_.front();
    arriving_.pop_front();
    return frame;
  }
  double now_s() const override { return now_s_; }

  std::vector<std::string> sent;

 private:
  std::deque<std::string> script_;
  std::deque<CanFrame> arriving_;
  double now_s_ = 0.0;
};

}  // namespace plenum::host::client
