// Instructions of one frame at a node, counted by callgrind (frame.py runs it).
//
// A frame is what Node::receive() does with it and next_frame() with its answer; a segment of a block upload,
// which no frame asks for by itself, is its next_frame() alone. Labels that begin with "tick" are what a frame leaves to a tick: how a
// reset is worked off, how an image is judged. What a tick does otherwise is counted by tick.cpp. The data sheet is read in blocks, whose
// segments are dearer than those of the segmented protocol (2236 and 1730 instructions) and tens of thousands. The
// node stands on the slots, settings and recorder of a board, with the configuration that is dear for each type.
#include <valgrind/callgrind.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "firmware/canopen/crc16.hpp"
#include "firmware/canopen/node.hpp"
#include "firmware/canopen/objects.hpp"
#include "firmware/config/greybox_parameters.hpp"
#include "firmware/config/model_image.hpp"
#include "firmware/config/parameter_record.hpp"
#include "firmware/config/parameter_slots.hpp"
#include "firmware/shadow_run.hpp"

namespace {

using namespace plenum;
using Bytes = std::initializer_list<std::uint8_t>;

constexpr std::uint8_t kNode = 1;
constexpr std::uint32_t kRequest = canopen::cob::kSdoRequest + kNode;
constexpr std::uint8_t kWatched = 99;

ports::CanFrame frame_of(std::uint32_t id, std::span<const std::uint8_t> data) {
  ports::CanFrame frame;
  frame.id = id;
  frame.length = static_cast<std::uint8_t>(data.size());
  std::copy(data.begin(), data.end(), frame.data.begin());
  return frame;
}

std::uint8_t byte_of(std::uint32_t value, unsigned number) {
  return static_cast<std::uint8_t>(value >> (8 * number));
}

std::string name_of(std::uint16_t index, std::uint8_t sub) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%04Xh:%u", unsigned{index}, unsigned{sub});
  return text.data();
}

class Bench {
 public:
  explicit Bench(std::uint8_t node_id = kNode)
      : node_({.node_id = node_id,
               .identity = {.vendor_id = 0x11, .product_code = 0x22, .revision = 0x33, .serial = 0x44}},
              image_, slots_, settings_, recorder_) {
    node_.prepare();
    drain();
  }

  /// A frame that is counted, with all that it makes the node say.
  void count(const std::string& label, const ports::CanFrame& frame) {
    CALLGRIND_TOGGLE_COLLECT;
    node_.receive(frame);
    drain();
    CALLGRIND_TOGGLE_COLLECT;
    CALLGRIND_DUMP_STATS_AT(label.c_str());
  }
  void count(const std::string& label, std::uint32_t id, Bytes data) { count(label, frame_of(id, data)); }

  void count_tick(const std::string& label) {
    CALLGRIND_TOGGLE_COLLECT;
    tick();
    CALLGRIND_TOGGLE_COLLECT;
    CALLGRIND_DUMP_STATS_AT(label.c_str());
  }

  void send(std::uint32_t id, Bytes data) {
    node_.receive(frame_of(id, data));
    drain();
  }
  void write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, unsigned size) {
    node_.receive(frame_of(kRequest, expedited(index, sub, value, size)));
    drain();
  }
  void tick() {
    node_.tick(config::kTick_us);
    drain();
  }
  void start() { send(canopen::cob::kNmt, {1, kNode}); }

  /// The segments of a block upload, each of them counted; in every second sub-block the last ones are lost.
  void count_block_upload(const std::string& label, std::uint16_t index) {
    constexpr std::uint8_t kBlock = 127;
    send(kRequest, {0xA4, byte_of(index, 0), byte_of(index, 1), 0, kBlock, 0, 0, 0});
    count_request(label + " started", {0xA3, 0, 0, 0, 0, 0, 0, 0});
    bool is_last = false;
    for (int sub_block = 0; !is_last; ++sub_block) {
      std::uint8_t sequence = 0;
      while (sequence < kBlock && !is_last) {
        node_.tick(config::kTick_us);  // its share
        ports::CanFrame frame;
        while (sequence < kBlock && !is_last && count_segment(label, frame)) {
          if (frame.id != canopen::cob::kSdoResponse + kNode) continue;
          expect(frame.data[0] != 0x80, "an upload is not aborted");
          sequence = frame.data[0] & 0x7FU;
          is_last = (frame.data[0] & 0x80U) != 0;
        }
      }
      const bool lost = sub_block % 2 == 1 && !is_last;
      count_request(label + " confirmed", {0xA2, lost ? std::uint8_t{1} : sequence, kBlock, 0, 0, 0, 0, 0});
    }
    count(label + " ended", kRequest, {0xA1, 0, 0, 0, 0, 0, 0, 0});
  }

  /// Reads every value, and writes it back.
  void count_expedited() {
    for (const canopen::Entry& row : canopen::object_dictionary()) {
      for (const unsigned instance : {0U, row.instances - 1U}) {
        for (const std::uint8_t sub : {row.sub, row.last_sub}) {
          count_object(row, static_cast<std::uint16_t>(row.index + row.stride * instance), sub);
        }
      }
    }
    count("SDO no object", frame_of(kRequest, std::array<std::uint8_t, 8>{0x40, 0xFF, 0xFF, 0xFF}));
  }

  /// Images of each kind, in blocks and in segments, taken and refused; then eight of the dearest at once, and their commit.
  void count_models() {
    for (const config::ModelKind kind :
         {config::ModelKind::tassa9, config::ModelKind::tassa9r, config::ModelKind::greybox}) {
      const std::vector<std::uint8_t> image = image_of(model(kind));
      count_image(image, true);
      std::vector<std::uint8_t> spoilt = image;
      spoilt.back() ^= 1U;
      count_image(spoilt, false);
    }
    config::ModelParameters folded = model(config::ModelKind::greybox);
    folded.value[config::kExhaustBend] = -40.0F;  // the last condition that is looked at, and it fails
    count_image(image_of(folded), false);
    const std::vector<std::uint8_t> image = image_of(model(config::ModelKind::greybox));
    count_set(image);
    std::array<std::uint32_t, config::kChambers> crcs{};
    crcs.fill(config::trailing_crc(image));
    write(canopen::object::kCommit, 1, 0xFF, 1);
    write(canopen::object::kCommit, 2, config::commit_crc(crcs), 4);
    count("commit of 8 models",
          frame_of(kRequest, expedited(canopen::object::kCommit, 3, config::kForceKey, 4)));
    expect(slots_.apply_at_tick_edge() == 0xFF, "eight models are committed");
    count_segmented_upload("segmented upload of a model", canopen::object::kActiveModel);
    count_block_upload("block upload of a model", canopen::object::kActiveModel);
  }

  void count_segmented_upload(const std::string& label, std::uint16_t index) {
    count(label + " begun", kRequest, {0x40, byte_of(index, 0), byte_of(index, 1), 0, 0, 0, 0, 0});
    std::uint8_t toggle = 0;
    do {
      count(label, kRequest, {static_cast<std::uint8_t>(0x60U | toggle), 0, 0, 0, 0, 0, 0, 0});
      expect(last_.data[0] != 0x80, "an upload is not aborted");
      toggle ^= 0x10U;
    } while ((last_.data[0] & 0x81U) == 0);
  }

  void count_process_data() {
    map_dearest_pdos();
    start();
    for (unsigned pdo = 0; pdo < canopen::kRpdos; ++pdo)
      count("RPDO", frame_of(0x201 + 0x100 * pdo, std::array<std::uint8_t, 8>{0, 1, 0, 1, 0, 1, 0, 1}));
    count("SYNC", 0x80, {});
    tick();
    for (unsigned pdo = 0; pdo < canopen::kRpdos; ++pdo)
      count("RPDO out of range",
            frame_of(0x201 + 0x100 * pdo, std::array<std::uint8_t, 8>{0, 1, 0, 1, 0, 1, 0, 0xFF}));
    for (std::uint8_t number = 0; number < 8; ++number)
      write(0x1016, static_cast<std::uint8_t>(number + 1), (kWatched - 7U + number) << 16 | 1000U, 4);
    count("heartbeat", 0x700 + kWatched, {5});
    count("foreign", 0x77F, {5});
    count("foreign", 0x555, {1, 2, 3, 4, 5, 6, 7, 8});
    count("foreign", 0x585, {1, 2, 3, 4, 5, 6, 7, 8});
    count("malformed", kRequest, {0x40, 0, 0x10});
    count("malformed", 0x80, {1, 2, 3});
    count("malformed", canopen::cob::kNmt, {1});
    count("malformed", 0x201, {1, 2, 3});
  }

  void count_nmt() {
    config::RowWriter rows(kept_);
    node_.collect(canopen::Kept::communication, rows);
    node_.collect(canopen::Kept::application, rows);
    node_.keep(std::span(kept_).first(rows.size()), kNode);
    for (const std::uint8_t command : Bytes{2, 1, 128, 7}) count("NMT", canopen::cob::kNmt, {command, kNode});
    count_reset("NMT reset communication", 130, "tick that resets the communication");
    count_reset("NMT reset node", 129, "tick that resets the node");
  }

  /// Every tick from the command to the boot-up message.
  void count_reset(const std::string& command_label, std::uint8_t command, const std::string& tick_label) {
    count(command_label, canopen::cob::kNmt, {command, kNode});
    int ticks = 0;
    for (; node_.state() == canopen::NmtState::initialising; ++ticks) count_tick(tick_label);
    std::fprintf(stderr, "%s: %d ticks to the boot-up message\n", command_label.c_str(), ticks);
  }

  void count_lss() {
    count("LSS fastscan", canopen::cob::kLssRequest, {0x51, 0, 0, 0, 0, 0x80, 0, 0});
    for (std::uint8_t number = 0; number < 4; ++number) {
      const auto value = static_cast<std::uint8_t>(0x11U * (number + 1U));
      for (std::uint8_t bit = 32; bit-- > 0;)
        count("LSS fastscan", canopen::cob::kLssRequest,
              {0x51, static_cast<std::uint8_t>(value >> bit << bit), 0, 0, 0, bit, number,
               static_cast<std::uint8_t>((number + (bit == 0 ? 1 : 0)) % 4)});
    }
    count("LSS inquire", canopen::cob::kLssRequest, {0x5A, 0, 0, 0, 0, 0, 0, 0});
    count("LSS configure", canopen::cob::kLssRequest, {0x11, 5, 0, 0, 0, 0, 0, 0});
    count("LSS switch", canopen::cob::kLssRequest, {0x04, 0, 0, 0, 0, 0, 0, 0});
    constexpr int kMostTicks = 10;
    for (int ticks = 0; ticks < kMostTicks && node_.node_id() != 5; ++ticks)
      count_tick("tick that takes a node id");
    expect(node_.node_id() == 5, "a master that gave a name is heard");
  }

  /// 1024 rows of the capture, frozen.
  void fill_recorder() {
    telemetry::Recorder::Samples samples;
    for (std::uint32_t tick = 0; tick < telemetry::kLogTicks; ++tick) {
      for (telemetry::Recorder::Sample& sample : samples)
        sample = {.pressure_Pa = 3.0e5F + static_cast<float>(tick),
                  .volume_m3 = 1.0e-4F,
                  .command_V = 5.0F,
                  .measured = true};
      recorder_.write(tick, false, samples);
    }
    write(canopen::object::kCapture, 1, 1, 1);
  }

  bool failed() const { return failed_; }

 private:
  static config::ModelParameters model(config::ModelKind kind) {
    constexpr std::array kTassa9 = {5.02F, 2.5F,  4.0F, -0.05F, 0.003F,   0.02F,  40.0F,
                                    0.1F,  0.08F, 0.1F, 620.0F, 101.325F, 0.0031F};
    constexpr std::array kTassa9r = {5.02F, 2.5F,  4.0F, 0.003F, 0.02F,    40.0F,
                                     0.1F,  0.08F, 0.1F, 620.0F, 101.325F, 0.0031F};
    constexpr std::array kGreybox = {5.08F, 4.92F, 60.0F, 64.0F, 1.0F, 1.0F,   2.0F,   1.0F, -0.5F, 0.2F,
                                     0.6F,  0.3F,  0.1F,  0.53F, 0.5F, 1.0F,   0.1F,   5.0F, 1.4F,  0.1F,
                                     0.0F,  0.1F,  0.8F,  0.02F, 0.1F, 700.0F, 101.3F, 0.2F, 0.3F,  1.0F};
    const std::span<const float> values = kind == config::ModelKind::tassa9 ? std::span<const float>(kTassa9)
                                          : kind == config::ModelKind::tassa9r
                                              ? std::span<const float>(kTassa9r)
                                              : std::span<const float>(kGreybox);
    if (values.size() != config::parameter_schema(kind).size())
      throw std::logic_error("frame: a kind of model has got other parameters, expected a value for each");
    config::ModelParameters parameters{.kind = kind, .count = static_cast<std::uint16_t>(values.size())};
    std::copy(values.begin(), values.end(), parameters.value.begin());
    return parameters;
  }
  static std::vector<std::uint8_t> image_of(const config::ModelParameters& parameters) {
    std::vector<std::uint8_t> image(config::kMaxImageBytes);
    image.resize(config::encode(parameters, image));
    return image;
  }

  static std::array<std::uint8_t, 8> expedited(std::uint16_t index, std::uint8_t sub, std::uint32_t value,
                                               unsigned size) {
    return {static_cast<std::uint8_t>(0x23U | (4 - size) << 2),
            byte_of(index, 0),
            byte_of(index, 1),
            sub,
            byte_of(value, 0),
            byte_of(value, 1),
            byte_of(value, 2),
            byte_of(value, 3)};
  }

  /// Without it the counts say nothing.
  void expect(bool holds, const char* claim) {
    if (!holds) std::fprintf(stderr, "does not hold: %s\n", claim);
    failed_ = failed_ || !holds;
  }

  void drain() {
    ports::CanFrame frame;
    while (node_.next_frame(frame)) last_ = frame;
  }

  /// Without the segments that follow.
  void count_request(const std::string& label, Bytes data) {
    const ports::CanFrame frame = frame_of(kRequest, data);
    CALLGRIND_TOGGLE_COLLECT;
    node_.receive(frame);
    CALLGRIND_TOGGLE_COLLECT;
    CALLGRIND_DUMP_STATS_AT(label.c_str());
  }

  bool count_segment(const std::string& label, ports::CanFrame& frame) {
    CALLGRIND_TOGGLE_COLLECT;
    const bool sent = node_.next_frame(frame);
    CALLGRIND_TOGGLE_COLLECT;
    CALLGRIND_DUMP_STATS_AT(label.c_str());
    return sent;
  }

  void count_object(const canopen::Entry& row, std::uint16_t index, std::uint8_t sub) {
    const std::string name = ": " + name_of(index, sub);
    count("SDO read" + name, kRequest, {0x40, byte_of(index, 0), byte_of(index, 1), sub, 0, 0, 0, 0});
    const bool expedited = (last_.data[0] & 0xE3U) == 0x43;
    if (row.access != canopen::Access::read_write || !expedited) return;
    std::array<std::uint8_t, 8> request = last_.data;  // 43h and the like: with 20h less, a write
    request[0] = static_cast<std::uint8_t>(request[0] - 0x20U);
    count("SDO write" + name, frame_of(kRequest, request));
    request[7] = request[6] = request[5] = request[4] = 0xFF;
    count("SDO write refused" + name, frame_of(kRequest, request));
  }

  /// In blocks and in segments, each judged at the edge of a tick, in which it is answered.
  void count_image(std::span<const std::uint8_t> image, bool is_good) {
    constexpr std::uint8_t kLow = canopen::object::kStagedModel & 0xFFU;
    const auto size = static_cast<std::uint32_t>(image.size());
    count("block download", kRequest, {0xC6, kLow, 0x21, 0, byte_of(size, 0), 0, 0, 0});
    count_block(image);
    expect_answer(is_good ? 0xA1 : 0x80);
    count("segmented download", kRequest, {0x21, kLow, 0x21, 0, byte_of(size, 0), 0, 0, 0});
    expect_answer(count_segments(image, is_good));
  }

  /// Of a download that waits for a tick.
  void expect_answer(std::uint8_t command) {
    count_edge();
    tick();
    expect(last_.data[0] == command, "an image is judged as it is");
  }

  void count_edge() {
    CALLGRIND_TOGGLE_COLLECT;
    static_cast<void>(slots_.apply_at_tick_edge());
    CALLGRIND_TOGGLE_COLLECT;
    CALLGRIND_DUMP_STATS_AT("tick's edge that judges an image");
  }

  void count_block(std::span<const std::uint8_t> image) {
    std::uint8_t sequence = 0;
    for (std::size_t done = 0; done < image.size(); done += 7) {
      const std::size_t size = std::min<std::size_t>(7, image.size() - done);
      const bool is_last = done + size == image.size();
      constexpr std::uint8_t kBlock = 127;
      std::array<std::uint8_t, 8> segment{};
      segment[0] = static_cast<std::uint8_t>(++sequence | (is_last ? 0x80U : 0U));
      std::copy_n(image.begin() + static_cast<std::ptrdiff_t>(done), size, segment.begin() + 1);
      count("block download segment", frame_of(kRequest, segment));
      if (sequence == kBlock) sequence = 0;
    }
    const std::uint16_t crc = canopen::crc16(image);
    const auto unused = static_cast<std::uint32_t>((7 - image.size() % 7) % 7);
    count("block download ended", kRequest,
          {static_cast<std::uint8_t>(0xC1U | unused << 2), byte_of(crc, 0), byte_of(crc, 1), 0, 0, 0, 0, 0});
  }

  /// Returns the command of the answer that is due.
  std::uint8_t count_segments(std::span<const std::uint8_t> image, bool is_good) {
    std::uint8_t toggle = 0;
    for (std::size_t done = 0; done < image.size(); done += 7, toggle ^= 0x10U) {
      const std::size_t size = std::min<std::size_t>(7, image.size() - done);
      const bool is_last = done + size == image.size();
      std::array<std::uint8_t, 8> segment{
          static_cast<std::uint8_t>(toggle | (7 - size) << 1 | (is_last ? 1U : 0U))};
      std::copy_n(image.begin() + static_cast<std::ptrdiff_t>(done), size, segment.begin() + 1);
      count(is_last ? "segmented download, last" : "segmented download", frame_of(kRequest, segment));
    }
    return is_good ? static_cast<std::uint8_t>(0x20U | (toggle ^ 0x10U)) : std::uint8_t{0x80};
  }

  /// Eight images in one block transfer, and the ticks that stage them.
  void count_set(std::span<const std::uint8_t> image) {
    std::vector<std::uint8_t> set{0xFF};
    for (std::size_t chamber = 0; chamber < config::kChambers; ++chamber)
      set.insert(set.end(), image.begin(), image.end());
    const auto size = static_cast<std::uint32_t>(set.size());
    count("block download", kRequest, {0xC6, 0x22, 0x21, 1, byte_of(size, 0), byte_of(size, 1), 0, 0});
    count_block(set);
    expect(last_.data[0] == 0xA1, "a set is taken");
    for (std::size_t chamber = 0; chamber < config::kChambers; ++chamber) count_edge();
    expect(!slots_.set_progress().staging && slots_.set_progress().refused == 0, "a set is staged");
  }

  /// Four RPDOs of four set points, twelve TPDOs of eight bytes, all with each SYNC.
  void map_dearest_pdos() {
    for (unsigned pdo = 0; pdo < canopen::kRpdos; ++pdo)
      map(0x1400 + pdo, 0x201 + 0x100 * pdo, canopen::object::kSetpoint, 1, 16, 4);
    for (unsigned pdo = 0; pdo < canopen::kTpdos; ++pdo)
      map(0x1800 + pdo, 0x4000'0181 + pdo, canopen::object::kErrorRegister, 0, 8, 8);
  }

  void map(unsigned index, std::uint32_t cob_id, std::uint32_t object, std::uint32_t sub, std::uint32_t bits,
           std::uint8_t count) {
    const auto communication = static_cast<std::uint16_t>(index);
    const auto mapping = static_cast<std::uint16_t>(index + 0x200);
    write(communication, 1, canopen::cob::kInvalid | cob_id, 4);
    write(mapping, 0, 0, 1);
    for (std::uint8_t number = 0; number < count; ++number) {
      const std::uint32_t place = object == canopen::object::kSetpoint ? object + 0x800U * number : object;
      write(mapping, static_cast<std::uint8_t>(number + 1), place << 16 | sub << 8 | bits, 4);
    }
    write(mapping, 0, count, 1);
    write(communication, 2, 1, 1);
    write(communication, 1, cob_id, 4);
    expect(last_.data[0] == 0x60, "a PDO is mapped");
  }

  canopen::ProcessImage image_;
  telemetry::Recorder recorder_;
  ShadowRun shadow_run_{recorder_, 2.0F};
  config::ParameterSlots slots_{&shadow_run_};
  config::SettingsDesk settings_;
  canopen::Node node_;
  std::array<std::uint8_t, config::kMaxBodyBytes> kept_{};
  ports::CanFrame last_;  ///< what the node said last
  bool failed_ = false;
};

}  // namespace

int main() {
  const auto bench = std::make_unique<Bench>();
  bench->fill_recorder();
  bench->count_models();
  bench->count_block_upload("block upload of the capture", canopen::object::kCaptureBuffer);
  bench->count_segmented_upload("segmented upload of the capture", canopen::object::kCaptureBuffer);
  bench->count_block_upload("block upload of the data sheet", 0x1021);
  bench->count_process_data();
  bench->count_nmt();
  const auto named_later = std::make_unique<Bench>(canopen::kUnconfiguredNodeId);
  named_later->count_lss();
  const auto scribbled_on = std::make_unique<Bench>();
  scribbled_on->count_expedited();
  return bench->failed() || named_later->failed() ? 1 : 0;
}
