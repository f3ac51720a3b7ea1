// The LSS slave (CiA 305): a master finds a board by its identity and gives it node id and bit rate over the bus.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/canopen/communication.hpp"

namespace plenum::canopen {

/// Table 0 of CiA 305 [kbit/s]; 0: reserved.
inline constexpr std::array<std::uint16_t, 9> kBitRates_kbit = {1000, 800, 500, 250, 125, 0, 50, 20, 10};
/// The row of this rate; empty: CiA 305 has none.
constexpr std::optional<std::uint8_t> row_of_bit_rate(std::uint32_t bit_rate_per_s) noexcept {
  for (std::size_t row = 0; row < kBitRates_kbit.size(); ++row) {
    if (bit_rate_per_s != 0 && 1000U * kBitRates_kbit[row] == bit_rate_per_s)
      return static_cast<std::uint8_t>(row);
  }
  return std::nullopt;
}

class LssSlave {
 public:
  using Bytes = std::array<std::uint8_t, 8>;

  /// Handles one frame of eight bytes from the LSS master. Returns true when `response` is to be sent. What is
  /// malformed, or not for this state, is left alone, as CiA 305 has it.
  bool request(Device& device, const Bytes& request, Bytes& response) noexcept;

  /// "Switch state global" to waiting: the one request that counts also where no other is served.
  static bool switches_to_waiting(const Bytes& request) noexcept;
  void wait() noexcept {
    state_ = State::waiting;
    selected_ = 0;
  }

  /// Time passes. Returns true when `response`, the answer to a "store configuration", is to be sent.
  bool elapse(Device& device, std::uint32_t elapsed_us, Bytes& response) noexcept;

  bool is_waiting() const noexcept { return state_ == State::waiting; }
  /// The node id for the next reset of the communication: 1..127 or kUnconfiguredNodeId; 0: none was given.
  std::uint8_t given_node_id() const noexcept { return given_node_id_; }

 private:
  enum class State : std::uint8_t { waiting, configuration };

  bool switch_selectively(const Device& device, const Bytes& request, Bytes& response) noexcept;
  bool identify(const Device& device, const Bytes& request, Bytes& response) noexcept;
  bool fastscan(const Device& device, const Bytes& request, Bytes& response) noexcept;
  bool configure(Device& device, const Bytes& request, Bytes& response) noexcept;
  bool store(Device& device, Bytes& response) noexcept;

  State state_ = State::waiting;
  std::uint8_t selected_ = 0;    ///< numbers of the identity that the master has named so far, in order
  std::uint8_t identified_ = 0;  ///< likewise, limits of "identify remote slave"
  std::uint8_t scanned_ = 0;     ///< the number of the identity that fastscan is at
  std::uint8_t given_node_id_ = 0;
  std::uint16_t given_bit_rate_kbit_ = 0;
  bool storing_ = false;  ///< the master waits for an answer
  std::uint32_t storing_us_ = 0;
};

}  // namespace plenum::canopen
