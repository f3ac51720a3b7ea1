#include "firmware/canopen/sdo_server.hpp"

#include <algorithm>

#include "firmware/canopen/sdo_commands.hpp"

namespace plenum::canopen {

using namespace sdo;

namespace {

/// Segments of a block upload in one tick. A bus of 1 Mbit/s carries some 75 frames in 10 ms: this bounds what
/// may stand in a driver's queue before the PDOs of the next tick.
constexpr std::uint8_t kSegmentsATick = 64;

constexpr std::uint8_t kAbortRequest = 0x80;

/// It begins a transfer; what does not, goes on with one or ends it.
bool is_initiate(const SdoServer::Bytes& request) {
  const unsigned command = request[0] >> 5;
  if (command == kBlockDownload) return (request[0] & 0x01U) == 0;
  if (command == kBlockUpload) return (request[0] & 0x03U) == 0;
  return command == kInitiateDownload || command == kInitiateUpload;
}

void refuse(Device& device, Abort abort, std::uint16_t index, std::uint8_t sub, SdoServer::Bytes& response) {
  multiplex(response, kAbortRequest, index, sub);
  store_le(static_cast<std::uint32_t>(abort), std::span(response).subspan<4, 4>());
  ++device.counters.sdo_aborts;
}

}  // namespace

bool SdoServer::request(Device& device, const Bytes& request, Bytes& response) noexcept {
  const bool again = closed_ && request == closed_by_;
  closed_ = false;
  if (again) return false;
  const State before = state_;
  const bool answers = take(device, request, response);
  const bool began_to_wait = before != State::waiting && state_ == State::waiting;
  const bool ended = before != State::idle && !is_initiate(request) && state_ == State::idle;
  closed_ = (began_to_wait || ended) && response[0] != kAbortRequest;
  closed_by_ = request;
  return answers;
}

/// Segments that were under way when their transfer ended are no requests, whatever their numbers would order. Whoever begins with
/// another number, or later than a time-out, is heard.
bool SdoServer::is_stray(const Bytes& request) noexcept {
  const unsigned number = request[0] & 0x7FU;
  const bool next = number == stray_ || (stray_anew_ && number == 1);
  const bool again = number != 0 && number + 1U == stray_;
  if (state_ != State::idle || stray_ == 0 || (!next && !again)) {
    stray_ = 0;
    return false;
  }
  const bool last = (request[0] & kLastSegment) != 0;
  stray_ = last ? std::uint8_t{0} : static_cast<std::uint8_t>(number + 1);
  stray_anew_ = false;
  return true;
}

bool SdoServer::take(Device& device, const Bytes& request, Bytes& response) noexcept {
  response = {};
  if (is_stray(request)) {
    silence_us_ = 0;
    return false;
  }
  const unsigned command = request[0] >> 5;
  if (state_ == State::waiting && command != kAbortTransfer) {
    refuse(device, Abort::device_state, index_of(request), request[3], response);
    return true;
  }
  if (state_ == State::idle)
    reset();  // a segment that belongs to no transfer is aborted in the name of no object
  // in a sub-block every frame is a segment, whatever its command seems to say; only one that goes on with it is a sign of life
  if (state_ == State::block_download) return block_download_segment(device, request, response);
  silence_us_ = 0;
  if (state_ == State::block_download_end && request == ended_by_) return false;
  switch (command) {
    case kInitiateDownload:
      return conclude(device, initiate_download(device, request, response), response);
    case kDownloadSegment:
      return conclude(device, download_segment(device, request, response), response);
    case kInitiateUpload:
      return conclude(device, initiate_upload(device, request, response), response);
    case kUploadSegment:
      return conclude(device, upload_segment(device, request, response), response);
    case kBlockUpload:
      return block_upload(device, request, response);
    case kBlockDownload:
      return conclude(device, block_download(device, request, response), response);
    case kAbortTransfer:
      reset();
      return false;
    default:
      return conclude(device, Abort::unknown_command, response);
  }
}

/// Sends the answer that stands in `response`, withholds it, or puts an abort in its place.
bool SdoServer::conclude(Device& device, Abort abort, Bytes& response) noexcept {
  if (abort == Abort::none) return true;
  if (abort == Abort::pending) {
    withheld_ = response;
    state_ = State::waiting;
    return false;
  }
  refuse(device, abort, index_, sub_, response);
  reset();
  return true;
}

bool SdoServer::elapse(Device& device, std::uint32_t elapsed_us, Bytes& response) noexcept {
  share_ = kSegmentsATick;
  if (is_initiate(closed_by_)) closed_ = false;  // a tick later it is a request of its own
  const Abort outcome =
      state_ == State::waiting ? found_.entry->outcome(device, found_.place) : Abort::pending;
  // an order is taken away when it is done, also one whose client has not waited for it
  if (device.order.done && device.order.what != StoreOrder::What::lss) device.order = {};
  if (state_ == State::waiting) return end_wait(device, outcome, elapsed_us, response);
  const std::uint32_t timeout_us = device.config.sdo_timeout_us;
  if (state_ == State::idle) {
    silence_us_ += std::min(elapsed_us, timeout_us - std::min(silence_us_, timeout_us));
    if (silence_us_ >= timeout_us) stray_ = 0;
    return false;
  }
  const bool was_patient = silence_us_ < timeout_us / 2;
  silence_us_ += std::min(elapsed_us, timeout_us);
  if (silence_us_ >= timeout_us) return conclude(device, Abort::timed_out, response);
  if (state_ != State::block_download || sequence_ == 0 || !was_patient || silence_us_ < timeout_us / 2)
    return false;
  // the rest of the sub-block is lost, and with it the segment that ends it
  ended_by_ = {};
  confirm_sub_block(response);
  return true;
}

bool SdoServer::end_wait(Device& device, Abort outcome, std::uint32_t elapsed_us, Bytes& response) noexcept {
  if (outcome == Abort::pending) {
    silence_us_ += std::min(elapsed_us, device.config.store_timeout_us);
    if (silence_us_ < device.config.store_timeout_us) return false;
    outcome = Abort::timed_out;
  }
  if (outcome != Abort::none) return conclude(device, outcome, response);
  response = withheld_;
  reset();
  return true;
}

/// What every download begins with. `sized`: bytes 4 to 7 of the request tell the size.
Abort SdoServer::open_download(const Bytes& request, bool sized) noexcept {
  reset();
  index_ = index_of(request);
  sub_ = request[3];
  found_ = find(index_, sub_);
  if (found_.entry == nullptr) return found_.abort;
  const Entry& entry = *found_.entry;
  if (entry.access == Access::read_only || entry.access == Access::constant) return Abort::read_only;
  size_announced_ = sized;
  size_ = sized ? size_in(request) : 0;
  done_ = 0;
  const std::size_t fixed_size = size_of(entry.type);
  most_ = static_cast<std::uint32_t>(fixed_size != 0 ? fixed_size : entry.most_bytes);
  if (!sized) return Abort::none;
  if (size_ > most_) return Abort::length_too_high;
  if (size_ < (fixed_size != 0 ? fixed_size : 1)) return Abort::length_too_low;
  return Abort::none;
}

Abort SdoServer::initiate_download(Device& device, const Bytes& request, Bytes& response) noexcept {
  const bool expedited = (request[0] & 0x02U) != 0;
  const bool sized = (request[0] & 0x01U) != 0;
  const Abort abort = open_download(request, sized && !expedited);
  if (abort != Abort::none) return abort;
  multiplex(response, 0x60, index_, sub_);
  if (expedited) {
    const std::size_t fixed_size = size_of(found_.entry->type);
    std::size_t size = 4U - ((request[0] >> 2) & 0x03U);
    if (!sized) size = fixed_size != 0 ? fixed_size : 4;
    return write_object(device, found_, std::span(request).subspan(4, size));
  }
  toggle_ = 0;
  state_ = State::download;
  return Abort::none;
}

Abort SdoServer::download_segment(Device& device, const Bytes& request, Bytes& response) noexcept {
  if (state_ != State::download) return Abort::unknown_command;
  if ((request[0] & kToggleBit) != toggle_) return Abort::toggle_not_alternated;
  const std::size_t count = kSegmentBytes - ((request[0] >> 1) & 0x07U);
  const bool last = (request[0] & 0x01U) != 0;
  if (size_announced_ && done_ + count > size_) return Abort::length_mismatch;
  if (done_ + count > most_) return Abort::length_too_high;
  std::copy_n(request.begin() + 1, count, buffer_.begin() + static_cast<std::ptrdiff_t>(done_));
  done_ += static_cast<std::uint32_t>(count);
  response[0] = static_cast<std::uint8_t>(0x20U | toggle_);
  toggle_ ^= kToggleBit;
  return last ? finish_download(device) : Abort::none;
}

/// The whole value is here: it takes effect, or not at all.
Abort SdoServer::finish_download(Device& device) noexcept {
  if (size_announced_ && done_ != size_) return Abort::length_mismatch;
  const Abort abort = write_object(device, found_, std::span(buffer_).first(done_));
  if (abort == Abort::none) reset();
  return abort;
}

/// What every upload begins with.
Abort SdoServer::open_upload(Device& device, const Bytes& request) noexcept {
  reset();
  index_ = index_of(request);
  sub_ = request[3];
  found_ = find(index_, sub_);
  if (found_.entry == nullptr) return found_.abort;
  if (found_.entry->access == Access::write_only) return Abort::write_only;
  return source_.open(device, found_, buffer_);
}

Abort SdoServer::initiate_upload(Device& device, const Bytes& request, Bytes& response) noexcept {
  const Abort abort = open_upload(device, request);
  if (abort == Abort::none) answer_upload(device, response);
  return abort;
}

/// Up to four bytes go with the answer, more of them in segments.
void SdoServer::answer_upload(Device& device, Bytes& response) noexcept {
  const std::uint32_t size = source_.size();
  if (size != 0 && size <= 4) {
    multiplex(response, static_cast<std::uint8_t>(0x43U | (4U - size) << 2), index_, sub_);
    std::array<std::uint8_t, kSegmentBytes> bytes{};
    source_.next(device, bytes);
    std::copy_n(bytes.begin(), size, response.begin() + 4);
    return;
  }
  multiplex(response, size != 0 ? 0x41 : 0x40, index_, sub_);
  store_le(size, std::span(response).subspan<4, 4>());
  toggle_ = 0;
  state_ = State::upload;
}

Abort SdoServer::upload_segment(Device& device, const Bytes& request, Bytes& response) noexcept {
  if (state_ != State::upload) return Abort::unknown_command;
  if ((request[0] & kToggleBit) != toggle_) return Abort::toggle_not_alternated;
  const std::size_t count = source_.next(device, std::span(response).subspan<1, kSegmentBytes>());
  if (source_.is_short()) return Abort::device_state;
  const bool last = source_.at_end();
  response[0] = static_cast<std::uint8_t>(toggle_ | (kSegmentBytes - count) << 1 | (last ? 1U : 0U));
  toggle_ ^= kToggleBit;
  if (last) reset();
  return Abort::none;
}

}  // namespace plenum::canopen
