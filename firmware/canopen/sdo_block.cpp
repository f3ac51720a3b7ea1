// The block transfers of the SDO server (CiA 301, 7.2.4.3.9 to 7.2.4.3.16).
#include <algorithm>

#include "firmware/canopen/crc16.hpp"
#include "firmware/canopen/sdo_commands.hpp"
#include "firmware/canopen/sdo_server.hpp"

namespace plenum::canopen {

using namespace sdo;

namespace {

constexpr std::uint8_t kConfirmSubBlock = 0xA2;
constexpr std::uint8_t kEndOfUpload = 0xC1;

// subcommands of the client: of a download in bit 0, of an upload in bits 1..0
constexpr unsigned kEndDownload = 1;
constexpr unsigned kInitiate = 0;
constexpr unsigned kEnd = 1;
constexpr unsigned kConfirm = 2;
constexpr unsigned kStart = 3;

bool is_block_size(unsigned segments) {
  return segments >= 1 && segments <= kMaxBlockSize;
}

}  // namespace

// ---- download ----

Abort SdoServer::block_download(Device& device, const Bytes& request, Bytes& response) noexcept {
  if ((request[0] & 0x01U) == kEndDownload) return end_block_download(device, request, response);
  const Abort abort = open_download(request, (request[0] & kSizeBit) != 0);
  if (abort != Abort::none) return abort;
  with_crc_ = (request[0] & kCrcBit) != 0;
  crc_ = 0;
  sequence_ = came_ = seen_ = 0;
  ended_by_ = request;  // coming twice it is no segment
  multiplex(response, 0xA0U | kCrcBit, index_, sub_);
  response[4] = kMaxBlockSize;
  state_ = State::block_download;
  return Abort::none;
}

/// A segment out of its turn is left alone; the confirmation tells the client where to go on.
bool SdoServer::block_download_segment(Device& device, const Bytes& request, Bytes& response) noexcept {
  const unsigned sequence = request[0] & 0x7FU;
  const bool last = (request[0] & kLastSegment) != 0;
  if (sequence == 0) {
    if (!last) return conclude(device, Abort::invalid_sequence, response);
    reset();  // 80h: the client aborts, and what it sent before has come before
    stray_ = 0;
    return false;
  }
  if (sequence_ == 0 && request == ended_by_) {
    ended_by_ = {};
    return false;
  }
  if (sequence == sequence_ + 1U || sequence == seen_ + 1U) silence_us_ = 0;
  seen_ = static_cast<std::uint8_t>(sequence);
  if (sequence == sequence_ + 1U) {
    came_ = static_cast<std::uint8_t>(sequence);
    if (size_announced_ && done_ >= size_) return conclude(device, Abort::length_mismatch, response);
    if (done_ >= most_) return conclude(device, Abort::length_too_high, response);
    // the segment before is whole, now that another follows; how much of the last one counts its end request tells
    if (done_ != 0) crc_ = crc16(std::span(buffer_).subspan(done_ - kSegmentBytes, kSegmentBytes), crc_);
    std::copy_n(request.begin() + 1, kSegmentBytes, buffer_.begin() + static_cast<std::ptrdiff_t>(done_));
    done_ += kSegmentBytes;
    ++sequence_;
    if (last) state_ = State::block_download_end;
  }
  if (!last && sequence != kMaxBlockSize) return false;
  ended_by_ = request;
  came_ = 0;
  confirm_sub_block(response);
  return true;
}

void SdoServer::confirm_sub_block(Bytes& response) noexcept {
  response = {kConfirmSubBlock, sequence_, kMaxBlockSize, 0, 0, 0, 0, 0};
  sequence_ = 0;
}

Abort SdoServer::end_block_download(Device& device, const Bytes& request, Bytes& response) noexcept {
  if (state_ != State::block_download_end) return Abort::unknown_command;
  const std::span<const std::uint8_t> last =
      std::span(buffer_).subspan(done_ - kSegmentBytes, kSegmentBytes - (request[0] >> 2 & 0x07U));
  done_ -= static_cast<std::uint32_t>(kSegmentBytes - last.size());
  if (done_ > most_) return Abort::length_too_high;
  if (with_crc_ && crc16(last, crc_) != load_le(std::span(request).subspan<1, 2>())) return Abort::crc_error;
  response[0] = 0xA1;
  return finish_download(device);
}

// ---- upload ----

bool SdoServer::block_upload(Device& device, const Bytes& request, Bytes& response) noexcept {
  switch (request[0] & 0x03U) {
    case kInitiate:
      return conclude(device, initiate_block_upload(device, request, response), response);
    case kStart:
      if (state_ == State::block_upload) return false;  // a duplicate
      if (state_ != State::block_upload_start) break;
      state_ = State::block_upload;
      return false;
    case kConfirm:
      if (state_ == State::block_upload_end && request == ended_by_) return false;
      if (state_ != State::block_upload) break;
      return confirm_block_upload(device, request, response);
    case kEnd:
      if (state_ != State::block_upload_end) break;
      reset();
      return false;
  }
  return conclude(device, Abort::unknown_command, response);
}

Abort SdoServer::initiate_block_upload(Device& device, const Bytes& request, Bytes& response) noexcept {
  const Abort abort = open_upload(device, request);
  if (abort != Abort::none) return abort;
  if (!is_block_size(request[4])) return Abort::invalid_block_size;
  const std::uint32_t size = source_.size();
  if (size != 0 && size <= request[5]) {  // the protocol switch threshold
    answer_upload(device, response);
    return Abort::none;
  }
  with_crc_ = (request[0] & kCrcBit) != 0;
  crc_ = 0;
  crc_position_ = 0;
  block_position_ = 0;
  block_size_ = request[4];
  sequence_ = 0;
  ended_by_ = {};
  multiplex(response, static_cast<std::uint8_t>(0xC0U | kCrcBit | (size != 0 ? kSizeBit : 0U)), index_, sub_);
  store_le(size, std::span(response).subspan<4, 4>());
  state_ = State::block_upload_start;
  return Abort::none;
}

bool SdoServer::next_segment(Device& device, Bytes& segment) noexcept {
  const bool at_end = sequence_ != 0 && source_.at_end();
  if (state_ != State::block_upload || at_end || sequence_ == block_size_ || share_ == 0) return false;
  --share_;
  silence_us_ = 0;
  segment = {};
  const std::uint32_t position = source_.position();
  last_count_ =
      static_cast<std::uint8_t>(source_.next(device, std::span(segment).subspan<1, kSegmentBytes>()));
  if (source_.is_short()) return conclude(device, Abort::device_state, segment);
  if (with_crc_ && position == crc_position_) {
    crc_ = crc16(std::span(segment).subspan(1, last_count_), crc_);
    crc_position_ = source_.position();
  }
  ++sequence_;
  segment[0] = static_cast<std::uint8_t>(sequence_ | (source_.at_end() ? kLastSegment : 0U));
  return true;
}

/// What the client has not got is read and sent again, from there on.
bool SdoServer::confirm_block_upload(Device& device, const Bytes& request, Bytes& response) noexcept {
  const std::uint8_t taken = request[1];
  if (taken > sequence_) {
    if (request == ended_by_) return false;
    return conclude(device, Abort::invalid_sequence, response);
  }
  if (taken == sequence_ && taken != 0 && source_.at_end()) {
    response[0] = static_cast<std::uint8_t>(kEndOfUpload | (kSegmentBytes - last_count_) << 2);
    store_le(crc_, std::span(response).subspan<1, 2>());
    ended_by_ = request;
    state_ = State::block_upload_end;
    return true;
  }
  if (!is_block_size(request[2])) return conclude(device, Abort::invalid_block_size, response);
  block_position_ += static_cast<std::uint32_t>(kSegmentBytes * taken);
  if (taken < sequence_) source_.seek(block_position_);
  block_size_ = request[2];
  sequence_ = 0;
  ended_by_ = request;
  return false;
}

}  // namespace plenum::canopen
