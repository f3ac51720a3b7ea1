// Block transfers of the SDO client (CiA 301, 7.2.4.3.9 to 7.2.4.3.16).
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host-sim/client/sdo_client.hpp"
#include "host-sim/client/sdo_frames.hpp"

namespace plenum::host::client {
namespace {

using canopen::Abort;
using sdo::byte;
using sdo::kSegmentBytes;

constexpr std::uint8_t kLastSegment = 0x80;
constexpr std::uint8_t kSequenceMask = 0x7F;
constexpr std::uint8_t kLargestBlock = 127;
constexpr int kTries = 3;  ///< blocks in a row of which nothing arrives
constexpr int kMostPassedOver =
    2 * kLargestBlock;  ///< the rest of a block that has lost a segment, each doubled

constexpr std::size_t segments_of(std::size_t bytes) {
  return (bytes + kSegmentBytes - 1) / kSegmentBytes;
}

}  // namespace

std::uint16_t crc16(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0;
  for (const std::uint8_t one : bytes) {
    crc ^= unsigned{one} << 8U;
    for (int bit = 0; bit < 8; ++bit) crc = ((crc << 1U) ^ ((crc & 0x8000U) != 0 ? 0x1021U : 0U)) & 0xFFFFU;
  }
  return static_cast<std::uint16_t>(crc);
}

// ---- reading ----

/// One block upload, after its initiate response.
class SdoClient::BlockReader {
 public:
  BlockReader(SdoClient& client, const Object& object, const Bytes& first, std::optional<std::size_t> total)
      : client_(client),
        object_(object),
        crc_((first[0] & 0x04U) != 0),
        total_(total),
        limit_(total.value_or(client.config_.largest_bytes)),
        accepted_(first) {}

  std::vector<std::uint8_t> run(const TransferProgress& progress) {
    client_.send({0xA3});
    bool first = true;
    while (!read_block(first, progress)) first = false;
    finish();
    return std::move(bytes_);
  }

 private:
  /// Takes the segments of one block and acknowledges them. True when the last one of the value was among them.
  bool read_block(bool first, const TransferProgress& progress) {
    const std::uint8_t size = client_.config_.block_size;
    std::uint8_t good = 0;
    for (bool ended = false, asked_again = false; !ended;) {
      const auto segment = client_.next(object_, false, client_.config_.timeout_s);
      if (!segment) {
        const bool nothing_to_repeat = first && good == 0;
        if (asked_again || nothing_to_repeat || !crc_) client_.time_out(object_, client_.config_.timeout_s);
        asked_again = true;
        acknowledge(good == 0 ? acknowledged_ : good);
        good = 0;
        continue;
      }
      if (*segment == accepted_) {  // doubled on the way
        pass_over();
        continue;
      }
      const auto sequence = static_cast<std::uint8_t>((*segment)[0] & kSequenceMask);
      if (sequence == 0 || sequence > size) {
        client_.fail(object_, Abort::invalid_sequence,
                     fmt::format("segment {} of a block, expected 1..{}", sequence, size));
      }
      if (sequence != good + 1) pass_over();
      if (sequence <= good) continue;
      ended = ((*segment)[0] & kLastSegment) != 0 || sequence == size;
      if (sequence != good + 1) continue;  // one was lost: the server sends again from there
      good = sequence;
      asked_again = false;
      take(*segment);
    }
    acknowledge(good);
    idle_ = good == 0 ? idle_ + 1 : 0;
    if (idle_ == kTries) {
      client_.fail(object_, Abort::timed_out,
                   fmt::format("{} blocks without their first segment, expected one that is whole", kTries));
    }
    if (progress) progress(std::min(bytes_.size(), limit_), total_);
    return good != 0 && (accepted_[0] & kLastSegment) != 0;
  }

  /// A frame that brings nothing new: no time-out ends a server that sends such frames for ever.
  void pass_over() {
    if (++passed_over_ <= kMostPassedOver) return;
    client_.fail(object_, Abort::invalid_sequence,
                 fmt::format("{} segments in a row that were not the next one, expected that", passed_over_));
  }

  void take(const Bytes& segment) {
    accepted_ = segment;
    passed_over_ = 0;
    bytes_.insert(bytes_.end(), segment.begin() + 1, segment.end());
    if (bytes_.size() < limit_ + kSegmentBytes) return;
    client_.fail(object_, Abort::length_mismatch,
                 fmt::format("more than {} bytes, expected {}", limit_,
                             total_ ? "those announced" : "no more than are accepted"));
  }

  /// Our answer to the last block may be what was lost: it is given a second time.
  Bytes await_end() {
    const double timeout_s = client_.config_.timeout_s;
    auto end = client_.next(object_, false, timeout_s);
    if (!end && crc_) {
      acknowledge(acknowledged_);
      end = client_.next(object_, false, timeout_s);
    }
    if (!end) client_.time_out(object_, timeout_s);
    return *end;
  }

  void acknowledge(std::uint8_t sequence) {
    client_.send({0xA2, sequence, client_.config_.block_size});
    acknowledged_ = sequence;
  }

  void finish() {
    Bytes end = await_end();
    while (end == accepted_) {  // doubled on the way
      pass_over();
      end = await_end();
    }
    if ((end[0] & 0xE3U) != 0xC1U) {
      client_.fail(object_, Abort::unknown_command,
                   fmt::format("command {:02X}h, expected the end of a block upload", end[0]));
    }
    bytes_.resize(bytes_.size() - ((end[0] >> 2U) & 7U));
    if (total_ && bytes_.size() != *total_) {
      client_.fail(object_, Abort::length_mismatch,
                   fmt::format("{} bytes, expected the {} announced", bytes_.size(), *total_));
    }
    const std::uint32_t announced = canopen::load_le(std::span(end).subspan<1, 2>());
    if (crc_ && announced != crc16(bytes_)) {
      client_.fail(
          object_, Abort::crc_error,
          fmt::format("{} bytes of CRC {:04X}h, expected {:04X}h", bytes_.size(), crc16(bytes_), announced));
    }
    client_.send({0xA1});
  }

  SdoClient& client_;
  const Object& object_;
  bool crc_;
  std::optional<std::size_t> total_;
  std::size_t limit_;
  std::vector<std::uint8_t> bytes_;
  Bytes accepted_;                 ///< the newest frame taken: what a doubled one repeats
  std::uint8_t acknowledged_ = 0;  ///< the newest answer
  int idle_ = 0;
  int passed_over_ = 0;
};

std::vector<std::uint8_t> SdoClient::read_blocks(const Object& object, const Bytes& first,
                                                 const TransferProgress& progress) {
  const std::uint8_t command = first[0];
  if ((command & 0xE1U) != 0xC0U) {
    fail(object, Abort::unknown_command,
         fmt::format("command {:02X}h, expected an initiate block upload response", command));
  }
  std::optional<std::size_t> total;
  if ((command & 0x02U) != 0) total = canopen::load_le(std::span(first).subspan<4, 4>());
  return BlockReader(*this, object, first, total).run(progress);
}

// ---- writing ----

bool SdoClient::write_blocks(const Object& object, std::span<const std::uint8_t> bytes,
                             const TransferProgress& progress) {
  Bytes request = sdo::request(0xC6, object.index, object.sub);
  canopen::store_le(static_cast<std::uint32_t>(bytes.size()), std::span(request).subspan<4, 4>());
  Bytes answer{};
  try {
    answer = exchange(object, request, true);
  } catch (const SdoAbort& refusal) {
    if (disturbance_.heard || refusal.code != static_cast<std::uint32_t>(Abort::unknown_command)) throw;
    server_knows_blocks_ = false;
    return false;
  }
  if ((answer[0] & 0xE3U) != 0xA0U) {
    fail(object, Abort::unknown_command,
         fmt::format("command {:02X}h, expected an initiate block download response", answer[0]));
  }
  const bool crc = (answer[0] & 0x04U) != 0;
  std::uint8_t block_size = answer[4];
  std::size_t done = 0;
  for (int idle = 0; done < bytes.size();) {
    if (block_size < 1 || block_size > kLargestBlock) {
      fail(object, Abort::invalid_block_size, fmt::format("a block size of {}, expected 1..127", block_size));
    }
    const std::size_t segments = std::min<std::size_t>(block_size, segments_of(bytes.size() - done));
    send_block(object, bytes.subspan(done), segments);
    answer = await_block_answer(object, 2);
    if (answer[1] > segments) {
      fail(object, Abort::invalid_sequence,
           fmt::format("{} segments taken, expected no more than the {} sent", answer[1], segments));
    }
    done = std::min(bytes.size(), done + kSegmentBytes * answer[1]);
    block_size = answer[2];
    idle = answer[1] == 0 ? idle + 1 : 0;
    if (idle == kTries) {
      fail(object, Abort::timed_out,
           fmt::format("{} blocks of which it took nothing, expected some", kTries));
    }
    if (progress) progress(done, bytes.size());
  }
  const std::size_t unused = kSegmentBytes * segments_of(bytes.size()) - bytes.size();
  Bytes end{byte(0xC1U | static_cast<unsigned>(unused) << 2U)};
  if (crc) canopen::store_le(crc16(bytes), std::span(end).subspan<1, 2>());
  send(end);
  await_block_answer(object, 1);
  return true;
}

/// `segments` of those that `bytes` begins with. Listens between them: a server that aborts is not sent the rest.
void SdoClient::send_block(const Object& object, std::span<const std::uint8_t> bytes, std::size_t segments) {
  for (std::size_t i = 0; i < segments; ++i) {
    while (next(object, false, 0.0)) {
      // an answer before the block has ended is an earlier one, doubled on the way
    }
    const auto rest = bytes.subspan(i * kSegmentBytes);
    Bytes segment{byte(static_cast<unsigned>(i + 1) | (rest.size() <= kSegmentBytes ? kLastSegment : 0U))};
    std::copy_n(rest.begin(), std::min(kSegmentBytes, rest.size()), segment.begin() + 1);
    send(segment);
  }
}

/// Passes over answers that belong to an earlier step of the transfer: they were doubled on the way.
SdoClient::Bytes SdoClient::await_block_answer(const Object& object, std::uint8_t subcommand) {
  for (double left_s = config_.block_timeout_s, end_s = link_.now_s() + left_s; left_s > 0.0;
       left_s = end_s - link_.now_s()) {
    const auto answer = next(object, false, left_s);
    if (!answer) break;
    if ((*answer)[0] == (0xA0U | subcommand)) return *answer;
    const bool earlier = ((*answer)[0] & 0xFBU) == 0xA0U || (subcommand == 1 && (*answer)[0] == 0xA2U);
    if (!earlier) {
      fail(object, Abort::unknown_command,
           fmt::format("command {:02X}h, expected {:02X}h of a block download", (*answer)[0],
                       0xA0U | subcommand));
    }
  }
  time_out(object, config_.block_timeout_s);
}

}  // namespace plenum::host::client
