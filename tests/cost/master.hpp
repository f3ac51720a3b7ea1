// A master that asks of a controller whatever a bus can bring, in the order that its random numbers say: models one by one and in
// sets, the data sheet, the log, settings good and bad, resets, LSS, orders to the store, and frames that mean nothing.
//
// Every call of the controller goes through a Watch, which counts or measures it:
//   void watch(Call, auto&& call)     performs `call`
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <random>
#include <span>
#include <vector>

#include "firmware/canopen/crc16.hpp"
#include "firmware/config/model_desk.hpp"
#include "firmware/config/model_set.hpp"
#include "tests/cost/chambers_alike.hpp"

namespace plenum::cost {

/// send: all frames that a controller has to send, by next_frame().
enum class Call : std::uint8_t { prepare, receive, step, send };

template <class Random, class Watch>
class Master {
 public:
  using Bytes = std::vector<std::uint8_t>;

  /// All three must outlive it. The chambers are active.
  Master(Random& random, ChambersAlike<Random>& chambers, Watch& watch)
      : random_(random), chambers_(chambers), controller_(chambers.controller()), watch_(watch) {}

  /// Asks for one thing, and lets some ticks pass.
  void act() {
    switch (below(11)) {
      case 0:
      case 1:
        upload_set();
        break;
      case 2:
      case 3:
        upload_one();
        break;
      case 4:
        upload(kDataSheet, 0);
        break;
      case 5:
        fetch_log();
        break;
      case 6:
        for (int i = 0; i < 20; ++i) write_anything();
        break;
      case 7:
        reset();
        break;
      case 8:
        for (int i = 0; i < 20; ++i) receive(canopen::cob::kLssRequest, lss_request());
        break;
      case 9:
        set_at_rest();
        break;
      default:
        for (int i = 0; i < 20; ++i) receive(below(0x800), bytes(below(9)));
    }
    tick();
    finish_order();
    tick();
  }

  /// A setting of a chamber that comes as a block, on a board at rest: of all that may come the deepest.
  void set_by_block() {
    constexpr std::uint32_t kChamberTicks = 0x2408;
    constexpr std::array<std::uint8_t, 2> kResidualTicks{50, 0};
    reset_by(canopen::NmtCommand::reset_node);
    download(kChamberTicks, 1, kResidualTicks);
  }

 private:
  static constexpr std::size_t kMostSent = 256;
  static constexpr std::uint8_t kBlock = 127;
  static constexpr std::uint32_t kDataSheet = 0x1021;

  std::uint32_t below(std::uint32_t n) {
    return std::uniform_int_distribution<std::uint32_t>(0, n - 1)(random_);
  }
  Bytes bytes(std::uint32_t count) {
    Bytes made;
    while (made.size() < count) made.push_back(static_cast<std::uint8_t>(below(256)));
    return made;
  }

  void receive(std::uint32_t id, std::span<const std::uint8_t> data) {
    const ports::CanFrame frame = frame_of(id, data);
    watch_(Call::receive, [&] { controller_.receive(frame); });
  }
  void receive(std::uint32_t id, std::initializer_list<std::uint8_t> data) {
    receive(id, std::span(data.begin(), data.size()));
  }

  void send() {
    sent_ = 0;
    watch_(Call::send, [&] {
      while (sent_ < kMostSent && controller_.next_frame(frame_[sent_])) ++sent_;
    });
  }

  void tick() {
    chambers_.next_scene();
    for (const ports::CanFrame& frame : chambers_.setpoints())
      receive(frame.id, std::span(frame.data).first(frame.length));
    const Inputs inputs = chambers_.inputs();
    watch_(Call::step, [&] { controller_.step(inputs); });
    send();
  }

  /// An SDO request; the answer, if there is one, is its eight bytes.
  Bytes ask(const std::array<std::uint8_t, 8>& request) {
    receive(canopen::cob::kSdoRequest + kNode, request);
    send();
    for (const ports::CanFrame& frame : std::span(frame_).first(sent_)) {
      if (frame.id == canopen::cob::kSdoResponse + kNode) return {frame.data.begin(), frame.data.end()};
    }
    return {};
  }
  static std::array<std::uint8_t, 8> request(std::uint32_t command, std::uint32_t index, std::uint32_t sub,
                                             std::uint32_t value) {
    std::array<std::uint8_t, 8> made{static_cast<std::uint8_t>(command), static_cast<std::uint8_t>(index),
                                     static_cast<std::uint8_t>(index >> 8U), static_cast<std::uint8_t>(sub)};
    for (std::size_t i = 0; i < 4; ++i) made[4 + i] = static_cast<std::uint8_t>(value >> (8 * i));
    return made;
  }
  void write(std::uint32_t index, std::uint32_t sub, std::uint32_t size, std::uint32_t value) {
    ask(request(0x23U | (4U - size) << 2U, index, sub, value));
  }

  /// A block download.
  void download(std::uint32_t index, std::uint32_t sub, std::span<const std::uint8_t> value) {
    constexpr std::size_t kSegment = 7;
    if (ask(request(0xC6, index, sub, static_cast<std::uint32_t>(value.size()))).empty()) return;
    std::uint8_t sequence = 0;
    std::size_t count = 0;
    for (std::size_t at = 0; at < value.size(); at += kSegment) {
      count = std::min(kSegment, value.size() - at);
      const bool last = at + kSegment >= value.size();
      std::array<std::uint8_t, 8> segment{};
      sequence = static_cast<std::uint8_t>(sequence == kBlock ? 1 : sequence + 1);
      segment[0] = static_cast<std::uint8_t>(sequence | (last ? 0x80U : 0U));
      std::copy_n(value.begin() + static_cast<std::ptrdiff_t>(at), count, segment.begin() + 1);
      receive(canopen::cob::kSdoRequest + kNode, segment);
      if (sequence == kBlock) send();
    }
    send();
    const std::uint16_t crc = canopen::crc16(value, 0);
    ask(request(0xC1U | static_cast<std::uint32_t>(kSegment - count) << 2U, crc, 0, 0));
  }

  /// A block upload, to its end.
  void upload(std::uint32_t index, std::uint32_t sub) {
    constexpr int kMostTicks = 2000;
    const Bytes answer = ask(request(0xA4, index, sub, kBlock));
    if (answer.empty() || (answer[0] & 0xE0U) != 0xC0U) return;
    receive(canopen::cob::kSdoRequest + kNode, request(0xA3, 0, 0, 0));
    bool ended = false;
    for (int i = 0; i < kMostTicks; ++i) {
      tick();
      for (const ports::CanFrame& frame :
           std::vector(frame_.begin(), frame_.begin() + static_cast<std::ptrdiff_t>(sent_))) {
        if (frame.id != canopen::cob::kSdoResponse + kNode) continue;
        if (ended || frame.data[0] == 0x80) {  // the end of the transfer, or an abort
          receive(canopen::cob::kSdoRequest + kNode, request(0xA1, 0, 0, 0));
          return;
        }
        const std::uint32_t sequence = frame.data[0] & 0x7FU;
        ended = (frame.data[0] & 0x80U) != 0;
        if (ended || sequence == kBlock)
          receive(canopen::cob::kSdoRequest + kNode,
                  request(0xA2, sequence | std::uint32_t{kBlock} << 8U, 0, 0));
      }
    }
  }

  Bytes image() {
    constexpr std::array kKinds = {config::ModelKind::tassa9, config::ModelKind::tassa9r,
                                   config::ModelKind::greybox, config::ModelKind::greybox};
    Bytes made(config::kMaxImageBytes);
    made.resize(config::encode(draw_subject(random_, kKinds[below(kKinds.size())]).model, made));
    return made;
  }
  void commit(std::uint32_t mask, std::span<const std::uint32_t> crcs, std::uint32_t key) {
    write(canopen::object::kCommit, 1, 1, mask);
    write(canopen::object::kCommit, 2, 4, config::commit_crc(crcs));
    write(canopen::object::kCommit, 3, 4, key);
    tick();
  }
  void upload_set() {
    const std::uint32_t mask = below(2) == 0 ? 0xFF : 1 + below(255);
    Bytes set{static_cast<std::uint8_t>(mask)};
    std::vector<std::uint32_t> crcs;
    const Bytes same = image();
    for (std::uint32_t c = 0; c < config::kChambers; ++c) {
      if ((mask >> c & 1U) == 0) continue;
      const Bytes one = below(2) == 0 ? same : image();
      crcs.push_back(config::trailing_crc(one));
      set.insert(set.end(), one.begin(), one.end());
    }
    download(canopen::object::kStagedSet, 1, set);
    constexpr std::size_t kOfCheck = 4;  // ticks a chamber, that of its staging too
    for (std::size_t i = 0; i < kOfCheck * config::kChambers; ++i) tick();
    commit(mask, crcs, config::kForceKey);
  }
  void upload_one() {
    constexpr int kOfTrial = 40;
    const std::uint32_t chamber = below(config::kChambers);
    const Bytes one = image();
    download(canopen::object::kStagedModel + chamber, 0, one);
    for (int i = 0; i < kOfTrial; ++i) tick();
    const std::uint32_t crc = config::trailing_crc(one);
    commit(1U << chamber, {&crc, 1}, below(2) == 0 ? config::kForceKey : config::kCommitKey);
  }
  void fetch_log() {
    write(canopen::object::kCapture, 1, 1, 1);  // freeze
    upload(canopen::object::kCaptureBuffer, 0);
    write(canopen::object::kCapture, 1, 1, below(3));
  }

  void write_anything() {
    constexpr std::array<std::uint16_t, 24> kIndex = {
        0x1005, 0x1014, 0x1016, 0x1017, 0x1019, 0x1029, 0x1400, 0x1600, 0x1800, 0x1A00, 0x2110, 0x2120,
        0x2121, 0x2160, 0x2228, 0x2300, 0x2310, 0x2400, 0x2408, 0x2410, 0x2418, 0x6040, 0x6043, 0x6394};
    const std::uint32_t index = kIndex[below(kIndex.size())];
    const std::uint32_t instance = below(2) == 0 ? 0 : below(8) * (index >= 0x6380 ? 0x800U : 1U);
    constexpr std::array<float, 6> kNumber = {0.0F, 1.0F, 4.5F, 100.0F, 650.0F, -3.0F};
    const std::uint32_t value =
        below(2) == 0 ? below(16) : std::bit_cast<std::uint32_t>(kNumber[below(kNumber.size())]);
    constexpr std::array<std::uint32_t, 3> kSize = {1, 2, 4};
    if (below(3) == 0) {
      ask(request(0x40, index + instance, below(12), 0));
    } else {
      write(index + instance, below(12), kSize[below(kSize.size())], value);
    }
  }
  Bytes lss_request() {
    constexpr std::array<std::uint8_t, 12> kCommand = {0x04, 0x11, 0x13, 0x15, 0x17, 0x40,
                                                       0x41, 0x46, 0x4C, 0x51, 0x5A, 0x5E};
    Bytes request = bytes(8);
    request[0] = kCommand[below(kCommand.size())];
    if (below(2) == 0) request[1] = static_cast<std::uint8_t>(below(3));
    return request;
  }
  void reset_by(canopen::NmtCommand command) {
    receive(canopen::cob::kNmt, {static_cast<std::uint8_t>(command), kNode});
    for (int i = 0; i < 20; ++i) tick();
  }
  void reset() {
    reset_by(below(2) == 0 ? canopen::NmtCommand::reset_node : canopen::NmtCommand::reset_communication);
    chambers_.go_active();
  }
  /// What only a board at rest takes; the reset after it has the delivered settings come back.
  void set_at_rest() {
    reset_by(canopen::NmtCommand::reset_node);
    for (int i = 0; i < 20; ++i) write_anything();
    reset_by(canopen::NmtCommand::reset_node);
    chambers_.go_active();
  }
  /// The parameter store has done what the bus asked of it.
  void finish_order() {
    canopen::StoreOrder& order = controller_.node().order();
    if (order.what != canopen::StoreOrder::What::none) order.done = true;
  }

  Random& random_;
  ChambersAlike<Random>& chambers_;
  Controller& controller_;
  Watch& watch_;
  std::array<ports::CanFrame, kMostSent> frame_{};
  std::size_t sent_ = 0;
};

}  // namespace plenum::cost
