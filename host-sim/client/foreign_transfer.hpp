// What another master does on the SDO channel of a node, as a bystander hears it.
//
// CiA 301 gives the default channel one client, and no frame tells who sent it: two masters that use it at once end each
// other's transfers. But CAN brings every frame to everybody, so that a client can hear that the channel is taken before it
// speaks, and afterwards that somebody spoke in between.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace plenum::host::client {

class ForeignTransfer {
 public:
  using Bytes = std::array<std::uint8_t, 8>;

  /// After so long a silence the server has ended a transfer: its time-out (Config::sdo_timeout_us), and some ticks [s].
  static constexpr double kDead_s = 1.1;

  /// A request that somebody else has sent.
  void hear_request(const Bytes& data, double now_s);
  /// An answer, whoever asked.
  void hear_answer(const Bytes& data, double now_s);
  /// An answer, and we have not asked yet: a long upload may show nothing else for a while.
  void hear_stray_answer(double now_s);

  /// A transfer of another master is under way.
  bool is_open(double now_s) const { return kind_ != Kind::none && is_near(now_s); }
  /// Another master is about: it spoke not long ago.
  bool is_near(double now_s) const { return heard_s_ && now_s - *heard_s_ < kDead_s; }

 private:
  /// What decides whether an answer is the last one.
  enum class Kind : std::uint8_t { none, exchange, block_download, block_upload };

  Kind kind_ = Kind::none;
  Bytes request_{};
  std::optional<double> heard_s_;
};

}  // namespace plenum::host::client
