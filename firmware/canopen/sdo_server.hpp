// The SDO server of a node: expedited, segmented and block transfers (CiA 301, 7.2.4.3), one at a time.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/canopen/object_dictionary.hpp"
#include "firmware/canopen/sdo_source.hpp"

namespace plenum::canopen {

class SdoServer {
 public:
  using Bytes = std::array<std::uint8_t, 8>;

  /// Handles one frame of eight bytes from the client. Returns true when `response` is to be sent. A new
  /// initiate request ends a transfer under way; a download takes effect with its last segment, or, in blocks,
  /// with its end request, or not at all.
  ///
  /// A write that has to wait (Abort::pending) is answered by elapse(). Until then every request but an abort
  /// is refused with 0800 0022h, and the wait goes on.
  bool request(Device& device, const Bytes& request, Bytes& response) noexcept;

  /// The next segment of a block upload, for when the bus has room. Returns false when none is due: the
  /// sub-block waits for its confirmation, this tick's share has gone, or there is no such transfer.
  bool next_segment(Device& device, Bytes& segment) noexcept;

  /// Time passes, once a tick. Returns true when `response` is to be sent: the answer to a write that has waited and
  /// ended, the confirmation of a sub-block that has stopped short of its end, or the abort of a transfer that
  /// has timed out.
  bool elapse(Device& device, std::uint32_t elapsed_us, Bytes& response) noexcept;

  void reset() noexcept {
    if (state_ == State::block_download) {
      stray_ = static_cast<std::uint8_t>(came_ + 1);
      stray_anew_ = sequence_ == 0;
      silence_us_ = 0;
    }
    state_ = State::idle;
    index_ = 0;
    sub_ = 0;
  }

 private:
  enum class State : std::uint8_t {
    idle,
    waiting,  ///< for the outcome of a write
    download,
    upload,
    block_download,
    block_download_end,  ///< every segment is here
    block_upload_start,  ///< announced; the client is to start it
    block_upload,
    block_upload_end,  ///< every segment is confirmed
  };

  Abort open_download(const Bytes& request, bool sized) noexcept;
  Abort initiate_download(Device& device, const Bytes& request, Bytes& response) noexcept;
  Abort download_segment(Device& device, const Bytes& request, Bytes& response) noexcept;
  Abort finish_download(Device& device) noexcept;
  Abort open_upload(Device& device, const Bytes& request) noexcept;
  Abort initiate_upload(Device& device, const Bytes& request, Bytes& response) noexcept;
  void answer_upload(Device& device, Bytes& response) noexcept;
  Abort upload_segment(Device& device, const Bytes& request, Bytes& response) noexcept;

  Abort block_download(Device& device, const Bytes& request, Bytes& response) noexcept;
  bool block_download_segment(Device& device, const Bytes& request, Bytes& response) noexcept;
  Abort end_block_download(Device& device, const Bytes& request, Bytes& response) noexcept;
  void confirm_sub_block(Bytes& response) noexcept;
  bool block_upload(Device& device, const Bytes& request, Bytes& response) noexcept;
  Abort initiate_block_upload(Device& device, const Bytes& request, Bytes& response) noexcept;
  bool confirm_block_upload(Device& device, const Bytes& request, Bytes& response) noexcept;

  bool is_stray(const Bytes& request) noexcept;
  bool take(Device& device, const Bytes& request, Bytes& response) noexcept;
  bool conclude(Device& device, Abort abort, Bytes& response) noexcept;
  bool end_wait(Device& device, Abort outcome, std::uint32_t elapsed_us, Bytes& response) noexcept;

  State state_ = State::idle;
  std::uint16_t index_ = 0;
  std::uint8_t sub_ = 0;
  Found found_;
  std::uint32_t silence_us_ = 0;
  Bytes withheld_{};     ///< the answer to a write that waits
  Bytes closed_by_{};    ///< the frame that ended the last transfer, or began the wait for its outcome
  bool closed_ = false;  ///< with the newest request: when it comes twice, it is a duplicate

  // downloads
  bool size_announced_ = false;
  std::uint32_t size_ = 0;  ///< announced
  std::uint32_t most_ = 0;  ///< bytes that the object takes
  std::uint32_t done_ = 0;  ///< bytes taken so far; in blocks whole segments
  static constexpr std::size_t kBufferBytes =
      (kMaxDomainBytes + kSegmentBytes - 1) / kSegmentBytes * kSegmentBytes;
  std::array<std::uint8_t, kBufferBytes> buffer_{};  ///< what comes; or the copy of what goes

  // uploads
  SdoSource source_;
  std::uint8_t last_count_ = 0;  ///< bytes of the segment sent last

  std::uint8_t toggle_ = 0;  ///< the bit expected next, in place (00h or 10h)

  // blocks
  bool with_crc_ = false;
  std::uint16_t crc_ = 0;
  std::uint32_t crc_position_ =
      0;  ///< bytes of an upload that `crc_` covers: each once, also when sent twice
  std::uint32_t block_position_ = 0;  ///< offset at which the sub-block of an upload begins
  std::uint8_t block_size_ = 0;       ///< segments of an upload's sub-block, as the client wants it
  std::uint8_t sequence_ = 0;         ///< segments of the sub-block taken or sent so far
  std::uint8_t share_ = 0;            ///< segments that may yet be sent in this tick
  std::uint8_t came_ = 0;  ///< number of the segment of a download's sub-block that came last in its turn
  std::uint8_t seen_ =
      0;  ///< and of the last one in turn or not: where one was lost the rest of them follow each other all the same
  /// Number of the segment that comes next of a sub-block that was left unfinished; 0, or 128: none is waited for.
  std::uint8_t stray_ = 0;
  bool stray_anew_ = false;  ///< or the first one: the sub-block was confirmed, and nothing has come since
  Bytes ended_by_{};  ///< the frame that ended the last sub-block: when it comes twice, it is a duplicate
};

}  // namespace plenum::canopen
