#include "firmware/canopen/sdo_server.hpp"

#include <algorithm>

namespace plenum::canopen {
namespace {

// command specifiers of the client, in bits 7..5
constexpr unsigned kDownloadSegment = 0;
constexpr unsigned kInitiateDownload = 1;
constexpr unsigned kInitiateUpload = 2;
constexpr unsigned kUploadSegment = 3;
constexpr unsigned kAbortTransfer = 4;

constexpr std::uint8_t kToggleBit = 0x10;
constexpr std::size_t kSegmentBytes = 7;

void multiplex(SdoServer::Bytes& response, std::uint8_t command, std::uint16_t index, std::uint8_t sub) {
  response = {command, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8), sub, 0, 0, 0,
              0};
}

std::uint16_t index_of(const SdoServer::Bytes& request) {
  return static_cast<std::uint16_t>(load_le(std::span(request).subspan<1, 2>()));
}

void refuse(Device& device, Abort abort, std::uint16_t index, std::uint8_t sub, SdoServer::Bytes& response) {
  multiplex(response, 0x80, index, sub);
  store_le(static_cast<std::uint32_t>(abort), std::span(response).subspan<4, 4>());
  ++device.counters.sdo_aborts;
}

}  // namespace

bool SdoServer::request(Device& device, const Bytes& request, Bytes& response) noexcept {
  if (state_ == State::waiting && request[0] >> 5 != kAbortTransfer) {
    refuse(device, Abort::device_state, index_of(request), request[3], response);
    return true;
  }
  if (state_ == State::idle)
    reset();  // a segment that belongs to no transfer is aborted in the name of no object
  silence_us_ = 0;
  response = {};
  Abort abort = Abort::unknown_command;
  switch (request[0] >> 5) {
    case kInitiateDownload:
      abort = initiate_download(device, request, response);
      break;
    case kDownloadSegment:
      abort = download_segment(device, request, response);
      break;
    case kInitiateUpload:
      abort = initiate_upload(device, request, response);
      break;
    case kUploadSegment:
      abort = upload_segment(request, response);
      break;
    case kAbortTransfer:
      reset();
      return false;
    default:  // block transfers name an object as the initiate requests do
      index_ = index_of(request);
      sub_ = request[3];
      break;
  }
  if (abort == Abort::pending) {
    withheld_ = response;
    state_ = State::waiting;
    return false;
  }
  if (abort != Abort::none) abort_transfer(device, abort, response);
  return true;
}

bool SdoServer::elapse(Device& device, std::uint32_t elapsed_us, Bytes& response) noexcept {
  if (device.order.done || state_ == State::waiting) return end_wait(device, elapsed_us, response);
  if (state_ == State::idle) return false;
  silence_us_ += std::min(elapsed_us, device.config.sdo_timeout_us);
  if (silence_us_ < device.config.sdo_timeout_us) return false;
  abort_transfer(device, Abort::timed_out, response);
  return true;
}

/// An order is taken away when it is done, also one whose client has not waited for it.
bool SdoServer::end_wait(Device& device, std::uint32_t elapsed_us, Bytes& response) noexcept {
  const bool was_waiting = state_ == State::waiting;
  Abort abort = Abort::timed_out;
  if (device.order.done) {
    abort = device.order.result;
    device.order = {};
  } else {
    silence_us_ += std::min(elapsed_us, device.config.store_timeout_us);
    if (silence_us_ < device.config.store_timeout_us) return false;
  }
  if (!was_waiting) return false;
  if (abort == Abort::none) {
    response = withheld_;
    reset();
  } else {
    abort_transfer(device, abort, response);
  }
  return true;
}

Abort SdoServer::initiate_download(Device& device, const Bytes& request, Bytes& response) noexcept {
  reset();
  index_ = index_of(request);
  sub_ = request[3];
  found_ = find(index_, sub_);
  if (found_.entry == nullptr) return found_.abort;
  const Entry& entry = *found_.entry;
  if (entry.access == Access::read_only || entry.access == Access::constant) return Abort::read_only;

  const bool expedited = (request[0] & 0x02U) != 0;
  const bool sized = (request[0] & 0x01U) != 0;
  const std::size_t fixed_size = size_of(entry.type);
  if (expedited) {
    std::size_t size = 4U - ((request[0] >> 2) & 0x03U);
    if (!sized) size = fixed_size != 0 ? fixed_size : 4;
    multiplex(response, 0x60, index_, sub_);
    return write_object(device, found_, std::span(request).subspan(4, size));
  } else {
    size_announced_ = sized;
    size_ = sized ? load_le(std::span(request).subspan<4, 4>()) : 0;
    if (sized) {
      if (size_ > (fixed_size != 0 ? fixed_size : buffer_.size())) return Abort::length_too_high;
      if (size_ < (fixed_size != 0 ? fixed_size : 1)) return Abort::length_too_low;
    }
    done_ = 0;
    toggle_ = 0;
    state_ = State::download;
  }
  multiplex(response, 0x60, index_, sub_);
  return Abort::none;
}

Abort SdoServer::download_segment(Device& device, const Bytes& request, Bytes& response) noexcept {
  if (state_ != State::download) return Abort::unknown_command;
  if ((request[0] & kToggleBit) != toggle_) return Abort::toggle_not_alternated;
  const std::size_t count = kSegmentBytes - ((request[0] >> 1) & 0x07U);
  const bool last = (request[0] & 0x01U) != 0;
  if (size_announced_ && done_ + count > size_) return Abort::length_mismatch;
  if (done_ + count > buffer_.size()) return Abort::length_too_high;
  std::copy_n(request.begin() + 1, count, buffer_.begin() + static_cast<std::ptrdiff_t>(done_));
  done_ += static_cast<std::uint32_t>(count);
  response[0] = static_cast<std::uint8_t>(0x20U | toggle_);
  toggle_ ^= kToggleBit;
  if (!last) return Abort::none;
  if (size_announced_ && done_ != size_) return Abort::length_mismatch;
  const Abort abort = write_object(device, found_, std::span<const std::uint8_t>(buffer_.data(), done_));
  if (abort == Abort::none) reset();
  return abort;
}

Abort SdoServer::initiate_upload(Device& device, const Bytes& request, Bytes& response) noexcept {
  reset();
  index_ = index_of(request);
  sub_ = request[3];
  found_ = find(index_, sub_);
  if (found_.entry == nullptr) return found_.abort;
  const Entry& entry = *found_.entry;
  if (entry.access == Access::write_only) return Abort::write_only;

  // a copy, so that what changes between two segments cannot mix old and new
  if (entry.read_bytes != nullptr) {
    const std::span<const std::uint8_t> bytes = entry.read_bytes(device, found_.place);
    if (bytes.empty() || bytes.size() > buffer_.size()) return Abort::no_data;
    std::copy(bytes.begin(), bytes.end(), buffer_.begin());
    size_ = static_cast<std::uint32_t>(bytes.size());
  } else {
    std::uint32_t bits = 0;
    const Abort abort = entry.read_value(device, found_.place, bits);
    if (abort != Abort::none) return abort;
    size_ = static_cast<std::uint32_t>(size_of(entry.type));
    store_le(bits, std::span(buffer_).first(size_));
  }

  if (size_ <= 4) {
    multiplex(response, static_cast<std::uint8_t>(0x43U | (4U - size_) << 2), index_, sub_);
    std::copy_n(buffer_.begin(), size_, response.begin() + 4);
  } else {
    multiplex(response, 0x41, index_, sub_);
    store_le(size_, std::span(response).subspan<4, 4>());
    done_ = 0;
    toggle_ = 0;
    state_ = State::upload;
  }
  return Abort::none;
}

Abort SdoServer::upload_segment(const Bytes& request, Bytes& response) noexcept {
  if (state_ != State::upload) return Abort::unknown_command;
  if ((request[0] & kToggleBit) != toggle_) return Abort::toggle_not_alternated;
  const std::size_t count = std::min<std::size_t>(kSegmentBytes, size_ - done_);
  std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(done_), count, response.begin() + 1);
  done_ += static_cast<std::uint32_t>(count);
  const bool last = done_ == size_;
  response[0] = static_cast<std::uint8_t>(toggle_ | (kSegmentBytes - count) << 1 | (last ? 1U : 0U));
  toggle_ ^= kToggleBit;
  if (last) reset();
  return Abort::none;
}

void SdoServer::abort_transfer(Device& device, Abort abort, Bytes& response) noexcept {
  refuse(device, abort, index_, sub_, response);
  reset();
}

}  // namespace plenum::canopen
