#include "host-sim/client/sdo_client.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host-sim/client/abort_text.hpp"
#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/sdo_frames.hpp"

namespace plenum::host::client {

using canopen::Abort;
namespace cob = canopen::cob;

SdoClient::SdoClient(Link& link, std::uint8_t node_id, const SdoConfig& config,
                     std::function<void(const CanFrame&)> heard)
    : link_(link),
      node_id_(node_id),
      config_(config),
      heard_(std::move(heard)),
      random_(config.seed != 0 ? config.seed : std::random_device{}()) {}

void SdoClient::send(const Bytes& data) {
  link_.send({.id = cob::kSdoRequest + node_id_, .length = 8, .data = data});
}

/// Late answers to requests given up name another object than the initiate request that follows, and are passed over.
std::optional<SdoClient::Bytes> SdoClient::next(const Object& object, bool initiate, double timeout_s) {
  const Bytes named = sdo::request(0, object.index, object.sub);
  const double end_s = link_.now_s() + timeout_s;
  double left_s = timeout_s;
  do {
    const std::optional<CanFrame> frame = link_.receive(left_s);
    if (!frame) return std::nullopt;
    left_s = std::max(0.0, end_s - link_.now_s());
    hear(*frame);
    if (frame->extended || frame->remote || frame->id != cob::kSdoResponse + node_id_ || frame->length != 8)
      continue;
    const Bytes& data = frame->data;
    const bool names_object = std::equal(named.begin() + 1, named.begin() + 4, data.begin() + 1);
    if (initiate && !names_object) continue;
    ++answers_;
    if (data[0] == sdo::kAbort) {
      const std::uint32_t code = canopen::load_le(std::span(data).subspan<4, 4>());
      throw SdoAbort(fmt::format("node {}: {} {:04X}h:{} was aborted with {:08X}h, {}", node_id_,
                                 object.doing, object.index, object.sub, code, abort_text(code)),
                     object.index, object.sub, code);
    }
    return data;
  } while (left_s > 0.0 || timeout_s == 0.0);
  return std::nullopt;
}

SdoClient::Bytes SdoClient::exchange(const Object& object, const Bytes& request, bool initiate) {
  send(request);
  if (const auto answer = next(object, initiate, config_.timeout_s)) return *answer;
  time_out(object, config_.timeout_s);
}

void SdoClient::abort(const Object& object, Abort abort) {
  if (answers_ == 0 && disturbance_.heard) return;  // what the server has open is not ours
  Bytes request = sdo::request(sdo::kAbort, object.index, object.sub);
  canopen::store_le(static_cast<std::uint32_t>(abort), std::span(request).subspan<4, 4>());
  send(request);
}

void SdoClient::time_out(const Object& object, double timeout_s) {
  abort(object, Abort::timed_out);
  throw Timeout(fmt::format("node {}: {} {:04X}h:{} had no answer within {} s, expected one on {:03X}h{}",
                            node_id_, object.doing, object.index, object.sub, timeout_s,
                            cob::kSdoResponse + node_id_, silence_text(link_.now_s() - timeout_s)));
}

std::string SdoClient::silence_text(double since_s) {
  under_way_.reset();  // what others ask for from here on disturbs nothing of ours
  const double wait_s = beat_missed_ ? 0.0 : config_.heartbeat_wait_s;
  const double end_s = link_.now_s() + wait_s;
  const auto is_new = [&] { return beat_ && beat_->time_s >= since_s; };
  for (double left_s = wait_s; left_s > 0.0 && !is_new(); left_s = end_s - link_.now_s()) {
    if (const auto frame = link_.receive(left_s)) hear(*frame);
  }
  beat_missed_ = !is_new();
  if (beat_missed_) return wait_s > 0.0 ? fmt::format("; no heartbeat came within {} s either", wait_s) : "";
  if (beat_->state != canopen::NmtState::stopped)
    return fmt::format("; its heartbeat says that it is {}", nmt_name(beat_->state));
  return "; its heartbeat says that it is stopped, a state in which no node answers: plenum nmt "
         "--pre-operational ends it";
}

void SdoClient::fail(const Object& object, Abort code, const std::string& found) {
  abort(object, code);
  throw ProtocolError(fmt::format("node {}: {} {:04X}h:{} was answered with {}", node_id_, object.doing,
                                  object.index, object.sub, found));
}

// ---- reading ----

std::vector<std::uint8_t> SdoClient::read(std::uint16_t index, std::uint8_t sub) {
  const Object object{index, sub, "reading"};
  std::vector<std::uint8_t> bytes;
  share(object, Outcome::read,
        [&] { bytes = read_answered(object, exchange(object, sdo::request(0x40, index, sub), true)); });
  return bytes;
}

std::vector<std::uint8_t> SdoClient::read_domain(std::uint16_t index, std::uint8_t sub,
                                                 const TransferProgress& progress) {
  const Object object{index, sub, "reading"};
  std::vector<std::uint8_t> bytes;
  share(object, Outcome::read, [&] { bytes = read_long(object, progress); });
  return bytes;
}

std::vector<std::uint8_t> SdoClient::read_long(const Object& object, const TransferProgress& progress) {
  if (server_knows_blocks_) {
    Bytes request = sdo::request(0xA4, object.index, object.sub);
    request[4] = config_.block_size;
    request[5] =
        static_cast<std::uint8_t>(config_.block_from_bytes - 1);  // up to these the server may use segments
    try {
      const Bytes first = exchange(object, request, true);
      return (first[0] & 0xE0U) == 0x40U ? read_answered(object, first)
                                         : read_blocks(object, first, progress);
    } catch (const SdoAbort& abort) {
      if (disturbance_.heard || abort.code != static_cast<std::uint32_t>(Abort::unknown_command)) throw;
      server_knows_blocks_ = false;
    }
  }
  return read_answered(object, exchange(object, sdo::request(0x40, object.index, object.sub), true));
}

/// After the answer to an initiate upload.
std::vector<std::uint8_t> SdoClient::read_answered(const Object& object, const Bytes& first) {
  const std::uint8_t command = first[0];
  if ((command & 0xE0U) != 0x40U) {
    fail(object, Abort::unknown_command,
         fmt::format("command {:02X}h, expected an initiate upload response", command));
  }
  if ((command & 0x02U) != 0) {
    const std::span<const std::uint8_t> value = sdo::expedited(first);
    return {value.begin(), value.end()};
  }
  const bool sized = (command & 0x01U) != 0;
  const std::size_t announced =
      sized ? canopen::load_le(std::span(first).subspan<4, 4>()) : config_.largest_bytes;
  std::vector<std::uint8_t> bytes;
  for (std::uint8_t toggle = 0;; toggle ^= sdo::kToggleBit) {
    const Bytes segment = exchange(object, sdo::request(sdo::byte(0x60U | toggle), 0, 0), false);
    const std::uint8_t header = segment[0];
    if ((header & 0xE0U) != 0) {
      fail(object, Abort::unknown_command,
           fmt::format("command {:02X}h, expected an upload segment", header));
    }
    if ((header & sdo::kToggleBit) != toggle) {
      fail(object, Abort::toggle_not_alternated, "a toggle bit that did not alternate");
    }
    const std::size_t count = sdo::kSegmentBytes - ((header >> 1) & 7U);
    bytes.insert(bytes.end(), segment.begin() + 1, segment.begin() + 1 + static_cast<std::ptrdiff_t>(count));
    const bool last = (header & 1U) != 0;
    if (count == 0 && !last)  // of which a server could send any number
      fail(object, Abort::general, "an empty segment that is not the last one");
    if (bytes.size() > announced || (sized && last && bytes.size() != announced)) {
      fail(object, Abort::length_mismatch,
           fmt::format("{} bytes, expected the {} {}", bytes.size(), announced,
                       sized ? "announced" : "that are accepted"));
    }
    if (last) return bytes;
  }
}

// ---- writing ----

void SdoClient::write(std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> bytes,
                      const TransferProgress& progress) {
  const Object object{index, sub, "writing"};
  share(object, Outcome::written, [&] { write_any(object, bytes, progress); });
}

void SdoClient::write_any(const Object& object, std::span<const std::uint8_t> bytes,
                          const TransferProgress& progress) {
  const bool expedited = !bytes.empty() && bytes.size() <= 4;
  if (bytes.size() >= config_.block_from_bytes && server_knows_blocks_ &&
      write_blocks(object, bytes, progress))
    return;
  Bytes request = sdo::request(0x21, object.index, object.sub);
  if (expedited) {
    request[0] = sdo::byte(0x23U | static_cast<unsigned>(4 - bytes.size()) << 2);
    std::copy(bytes.begin(), bytes.end(), request.begin() + 4);
  } else {
    canopen::store_le(static_cast<std::uint32_t>(bytes.size()), std::span(request).subspan<4, 4>());
  }
  const Bytes first = exchange(object, request, true);
  if (first[0] != 0x60) {
    fail(object, Abort::unknown_command,
         fmt::format("command {:02X}h, expected an initiate download response", first[0]));
  }
  if (!expedited) write_segments(object, bytes, progress);
}

void SdoClient::write_segments(const Object& object, std::span<const std::uint8_t> bytes,
                               const TransferProgress& progress) {
  std::uint8_t toggle = 0;
  std::size_t done = 0;
  do {
    const std::size_t count = std::min(sdo::kSegmentBytes, bytes.size() - done);
    const bool last = done + count == bytes.size();
    Bytes segment{};
    segment[0] =
        sdo::byte(toggle | static_cast<unsigned>(sdo::kSegmentBytes - count) << 1 | (last ? 1U : 0U));
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(done), count, segment.begin() + 1);
    done += count;
    const Bytes answer = exchange(object, segment, false);
    if ((answer[0] & 0xE0U) != 0x20U) {
      fail(object, Abort::unknown_command,
           fmt::format("command {:02X}h, expected a download segment response", answer[0]));
    }
    if ((answer[0] & sdo::kToggleBit) != toggle) {
      fail(object, Abort::toggle_not_alternated, "a toggle bit that did not alternate");
    }
    toggle ^= sdo::kToggleBit;
    if (progress) progress(done, bytes.size());
  } while (done < bytes.size());
}

}  // namespace plenum::host::client
