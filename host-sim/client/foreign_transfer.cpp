#include "host-sim/client/foreign_transfer.hpp"

#include "host-sim/client/sdo_frames.hpp"

namespace plenum::host::client {
namespace {

constexpr std::uint8_t kStartBlockUpload = 0xA3;
constexpr std::uint8_t kEndBlockUpload = 0xA1;
constexpr std::uint8_t kEndBlockDownload = 0xA1;  ///< the server's answer to the end request

constexpr bool ends_block_download(std::uint8_t command) {
  return (command & 0xE1U) == 0xC1U;
}
/// Initiate, start or confirm.
constexpr bool is_block_upload(std::uint8_t command) {
  return (command & 0xE0U) == 0xA0U;
}

/// Whether `answer` is the last one of a transfer that is no block transfer.
bool is_last(std::uint8_t request, std::uint8_t answer) {
  switch (request >> 5U) {
    case 0:  // download segment
      return (request & 0x01U) != 0 && (answer & 0xE0U) == 0x20U;
    case 1:  // initiate download: expedited
      return (request & 0x02U) != 0 && answer == 0x60U;
    case 2:  // initiate upload
      return (answer & 0xE2U) == 0x42U;
    case 3:  // upload segment
      return (answer & 0xE1U) == 0x01U;
    default:
      return false;
  }
}

}  // namespace

void ForeignTransfer::hear_request(const Bytes& data, double now_s) {
  heard_s_ = now_s;
  request_ = data;
  if (data[0] == sdo::kAbort) {
    kind_ = Kind::none;
  } else if (kind_ == Kind::block_download) {
    return;  // a segment, whatever its command seems to say; or the end, which is answered
  } else if (data[0] == kEndBlockUpload) {
    kind_ = Kind::none;
  } else if (sdo::begins_block_download(data[0]) || ends_block_download(data[0])) {
    kind_ = Kind::block_download;
  } else {
    kind_ = is_block_upload(data[0]) ? Kind::block_upload : Kind::exchange;
  }
}

void ForeignTransfer::hear_answer(const Bytes& data, double now_s) {
  if (kind_ == Kind::none) return;
  heard_s_ = now_s;
  const bool ends_block = kind_ == Kind::block_download && data[0] == kEndBlockDownload;
  const bool ends_exchange = kind_ == Kind::exchange && is_last(request_[0], data[0]);
  // to an initiate block upload of a short value the server answers as to any other
  const bool is_short =
      kind_ == Kind::block_upload && (request_[0] & 0x03U) == 0 && (data[0] & 0xE2U) == 0x42U;
  if (data[0] == sdo::kAbort || ends_block || ends_exchange || is_short) kind_ = Kind::none;
}

void ForeignTransfer::hear_stray_answer(double now_s) {
  if (kind_ != Kind::none) return;
  kind_ = Kind::block_upload;
  request_ = {kStartBlockUpload};
  heard_s_ = now_s;
}

}  // namespace plenum::host::client
