// The LSS master (CiA 305): finds a board by its identity, and gives it node id and bit rate.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/link.hpp"

namespace plenum::host::client {

/// The row of table 0 of CiA 305 that has this bit rate. Throws std::invalid_argument for one that is none of CANopen.
std::uint8_t bit_timing_row(std::uint32_t bit_rate_per_s);

/// One LSS master on the bus at a time. Boards of this project answer it while they are neither OPERATIONAL nor leave INIT or
/// FAULT_INIT.
class LssMaster {
 public:
  /// `answer_s`: how long a board has for an answer; fastscan waits so long for each bit of the identity that is 1, and 20 ms for
  /// each other.
  explicit LssMaster(Link& link, double answer_s = 0.1) : link_(link), answer_s_(answer_s) {}
  /// Leaves no board in the state "configuration".
  ~LssMaster();
  LssMaster(const LssMaster&) = delete;
  LssMaster& operator=(const LssMaster&) = delete;

  /// Fastscan: the identity of one board without a node id, of several the least, which alone is in the state "configuration" then; empty
  /// when none answers.
  /// Throws ProtocolError when answers contradict each other.
  std::optional<Identity> find_unconfigured();
  /// Puts the board of that identity into "configuration". Throws Timeout.
  void select(const Identity& identity);

  // Of the board in "configuration". Each throws Timeout, or Refused with the error code of CiA 305.

  /// 1..127, or kUnconfiguredNodeId; counts from its next reset of the communication.
  void give_node_id(std::uint8_t node_id);
  /// Counts from its next start. Throws as bit_timing_row(), too.
  void give_bit_rate(std::uint32_t bit_rate_per_s);
  /// Makes it keep both.
  void store();

  /// All boards to "waiting"; one whose node id was given in place of none boots up.
  void release();

 private:
  using Bytes = std::array<std::uint8_t, 8>;

  void say(const Bytes& request);
  std::optional<Bytes> ask(const Bytes& request, unsigned answer, double timeout_s);
  bool identified(std::uint32_t number, unsigned lowest_bit, unsigned sub, unsigned next);
  void configure(const Bytes& request, const char* what, double timeout_s,
                 const char* out_of_range = "out of range");

  Link& link_;
  double answer_s_;
};

}  // namespace plenum::host::client
