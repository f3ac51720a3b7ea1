// A block server written for these tests alone, from CiA 301, 7.2.4.3, behind a link that does something to one frame.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "host-sim/client/link.hpp"
#include "host-sim/client/sdo_client.hpp"

namespace plenum::host::client {

/// One value at any index. Answers at once; falls silent only when a frame did not reach it.
class BlockServer {
 public:
  using Data = std::array<std::uint8_t, 8>;

  std::vector<std::uint8_t> value;
  bool tells_size = true;
  bool crc = true;
  std::uint8_t block_size = 5;
  bool acknowledges_after_silence = false;  ///< of an unfinished block; otherwise it aborts

  std::vector<Data> request(const Data& data) {
    answers_.clear();
    if (data[0] == 0x80) {
      state_ = State::idle;
    } else if (state_ == State::receiving) {
      segment(data);
    } else if ((data[0] & 0xF9U) == 0xC0U && (data[0] & 0x02U) != 0) {
      named_ = data;
      received_.clear();
      announced_ = canopen::load_le(std::span(data).subspan<4, 4>());
      good_ = 0;
      state_ = State::receiving;
      answer({low(crc ? 0xA4U : 0xA0U), data[1], data[2], data[3], block_size});
    } else if (state_ == State::received && (data[0] & 0xE3U) == 0xC1U) {
      end_download(data);
    } else if ((data[0] & 0xFBU) == 0xA0U) {
      named_ = data;
      offset_ = 0;
      state_ = State::asked;
      asked_block_ = data[4];
      Data first{low((crc ? 0xC4U : 0xC0U) | (tells_size ? 2U : 0U)), data[1], data[2], data[3]};
      if (tells_size)
        canopen::store_le(static_cast<std::uint32_t>(value.size()), std::span(first).subspan<4, 4>());
      answer(first);
    } else if (state_ == State::asked && data[0] == 0xA3) {
      send_block();
    } else if (state_ == State::sending && data[0] == 0xA2) {
      acknowledged(data);
    } else if (state_ == State::sent && data[0] == 0xA1) {
      state_ = State::idle;
    }
    return answers_;
  }

  /// Called after a second without a frame.
  std::vector<Data> silence() {
    answers_.clear();
    if (state_ == State::receiving && good_ > 0 && acknowledges_after_silence) {
      acknowledge();
    } else if (state_ != State::idle) {
      abort(0x0504'0000);
    }
    return answers_;
  }

 private:
  enum class State { idle, receiving, received, asked, sending, sent };

  static std::uint8_t low(unsigned value) { return static_cast<std::uint8_t>(value); }
  void answer(const Data& data) { answers_.push_back(data); }
  void abort(std::uint32_t code) {
    Data data{0x80, named_[1], named_[2], named_[3]};
    canopen::store_le(code, std::span(data).subspan<4, 4>());
    answer(data);
    state_ = State::idle;
  }

  void segment(const Data& data) {
    const unsigned sequence = data[0] & 0x7FU;
    const bool last = (data[0] & 0x80U) != 0;
    if (sequence == good_ + 1U) {
      ++good_;
      received_.insert(received_.end(), data.begin() + 1, data.end());
      if (last) state_ = State::received;
    }
    if (last || sequence == block_size) acknowledge();
  }
  void acknowledge() {
    answer({0xA2, good_, block_size});
    good_ = 0;
  }
  void end_download(const Data& data) {
    received_.resize(received_.size() - (data[0] >> 2U & 7U));
    if (crc && canopen::load_le(std::span(data).subspan<1, 2>()) != crc16(received_))
      return abort(0x0504'0004);
    if (received_.size() != announced_) return abort(0x0607'0010);
    value = received_;
    state_ = State::idle;
    answer({0xA1});
  }

  void send_block() {
    sent_ = 0;
    for (std::size_t at = offset_; at < value.size() && sent_ < asked_block_; at += 7) {
      const std::size_t count = std::min<std::size_t>(7, value.size() - at);
      Data data{low(++sent_ | (at + 7 >= value.size() ? 0x80U : 0U))};
      std::copy_n(value.begin() + static_cast<std::ptrdiff_t>(at), count, data.begin() + 1);
      answer(data);
    }
    state_ = State::sending;
  }
  void acknowledged(const Data& data) {
    if (data[1] > sent_) return abort(0x0504'0003);
    offset_ += 7 * std::size_t{data[1]};
    asked_block_ = data[2];
    if (offset_ < value.size()) return send_block();
    Data end{low(0xC1U | static_cast<unsigned>(offset_ - value.size()) << 2U)};
    if (crc) canopen::store_le(crc16(value), std::span(end).subspan<1, 2>());
    answer(end);
    state_ = State::sent;
  }

  State state_ = State::idle;
  Data named_{};
  std::vector<Data> answers_;
  std::vector<std::uint8_t> received_;
  std::size_t announced_ = 0;
  std::uint8_t good_ = 0;
  std::size_t offset_ = 0;
  std::uint8_t asked_block_ = 0;
  std::uint8_t sent_ = 0;
};

enum class LinkFault {
  none,
  lost,
  doubled,
  overtaken,  ///< it alone comes 0.7 s late, after others
  late        ///< it and all that follow it in its direction come 0.7 s late
};

class FaultyLink final : public Link {
 public:
  BlockServer server;

  /// Does `fault` to frame `number`, counted from 0 in both directions from now on.
  void spoil(std::size_t number, LinkFault fault) {
    fault_ = fault;
    faulty_ = number;
    frames_ = 0;
    lag_s_ = {};
  }
  std::size_t frames() const { return frames_; }
  /// The spoilt frame was one to the client, and no answer to a block: nobody can tell a second one of those from that
  /// to the next block. What a server makes of doubled requests is its own affair.
  bool spoilt_for_the_client_alone() const { return for_client_; }

  void send(const CanFrame& frame) override { travel(frame.data, true); }

  std::optional<CanFrame> receive(double timeout_s) override {
    const double until_s = now_s_ + timeout_s;
    while (true) {
      const auto first =
          std::min_element(under_way_.begin(), under_way_.end(),
                           [](const Travelling& a, const Travelling& b) { return a.at_s < b.at_s; });
      const double silent_s = heard_s_ + 1.0;
      const double next_s = first == under_way_.end() ? silent_s : std::min(first->at_s, silent_s);
      if (next_s > until_s) {
        now_s_ = until_s;
        return std::nullopt;
      }
      now_s_ = std::max(now_s_, next_s);
      if (first == under_way_.end() || first->at_s > silent_s) {
        heard_s_ = now_s_;
        for (const auto& data : server.silence()) travel(data, false);
        continue;
      }
      const Travelling one = *first;
      under_way_.erase(first);
      if (!one.to_server) return CanFrame{.id = 0x585, .length = 8, .data = one.data};
      heard_s_ = now_s_;
      for (const auto& data : server.request(one.data)) travel(data, false);
    }
  }
  double now_s() const override { return now_s_; }

 private:
  struct Travelling {
    double at_s;
    bool to_server;
    BlockServer::Data data;
  };

  void travel(const BlockServer::Data& data, bool to_server) {
    constexpr double kFrame_s = 1.0e-4;
    constexpr double kLate_s = 0.7;  // longer than a client waits for an answer, shorter than for a block's
    free_s_ = std::max(free_s_, now_s_) + kFrame_s;
    const bool faulty = frames_++ == faulty_;
    const LinkFault fault = faulty ? fault_ : LinkFault::none;
    for_client_ = for_client_ || (faulty && !to_server && data[0] != 0xA2);
    if (fault == LinkFault::late) lag_s_[to_server ? 1 : 0] = kLate_s;
    const double at_s = free_s_ + lag_s_[to_server ? 1 : 0] + (fault == LinkFault::overtaken ? kLate_s : 0.0);
    if (fault != LinkFault::lost) under_way_.push_back({at_s, to_server, data});
    if (fault == LinkFault::doubled) under_way_.push_back({free_s_ += kFrame_s, to_server, data});
  }

  std::vector<Travelling> under_way_;
  double now_s_ = 0.0;
  double free_s_ = 0.0;   ///< when the wire is free
  double heard_s_ = 0.0;  ///< when the server last heard a frame
  LinkFault fault_ = LinkFault::none;
  std::size_t faulty_ = 0;
  std::size_t frames_ = 0;
  bool for_client_ = false;
  std::array<double, 2> lag_s_{};
};

}  // namespace plenum::host::client
