// The SDO server of a node: expedited and segmented transfers (CiA 301, 7.2.4.3), one at a time.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/canopen/object_dictionary.hpp"

namespace plenum::canopen {

class SdoServer {
 public:
  using Bytes = std::array<std::uint8_t, 8>;

  /// Handles one request of eight bytes. Returns true when `response` is to be sent. A new initiate request
  /// ends a transfer under way; a download takes effect with its last segment, or not at all.
  ///
  /// A write that has to wait (Abort::pending) is answered by elapse(). Until then every request but an abort is refused
  /// with 0800 0022h, and the wait goes on.
  bool request(Device& device, const Bytes& request, Bytes& response) noexcept;

  /// Time passes. Returns true when `response` is to be sent: the answer to a write whose order is done, or the abort of
  /// a transfer that has timed out.
  bool elapse(Device& device, std::uint32_t elapsed_us, Bytes& response) noexcept;

  void reset() noexcept {
    state_ = State::idle;
    index_ = 0;
    sub_ = 0;
  }

 private:
  enum class State : std::uint8_t { idle, download, upload, waiting };

  Abort initiate_download(Device& device, const Bytes& request, Bytes& response) noexcept;
  Abort download_segment(Device& device, const Bytes& request, Bytes& response) noexcept;
  Abort initiate_upload(Device& device, const Bytes& request, Bytes& response) noexcept;
  Abort upload_segment(const Bytes& request, Bytes& response) noexcept;
  bool end_wait(Device& device, std::uint32_t elapsed_us, Bytes& response) noexcept;
  void abort_transfer(Device& device, Abort abort, Bytes& response) noexcept;

  State state_ = State::idle;
  std::uint16_t index_ = 0;
  std::uint8_t sub_ = 0;
  Found found_;
  std::uint8_t toggle_ = 0;  ///< the bit expected next, in place (00h or 10h)
  bool size_announced_ = false;
  std::uint32_t size_ = 0;  ///< announced, or held in the buffer
  std::uint32_t done_ = 0;  ///< bytes moved so far
  std::uint32_t silence_us_ = 0;
  Bytes withheld_{};  ///< the answer to a write that waits
  std::array<std::uint8_t, kMaxDomainBytes> buffer_{};
};

}  // namespace plenum::canopen
