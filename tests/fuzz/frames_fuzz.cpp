// Any frames to the node of a board, with any pauses between them.
//
// A frame that is refused, by an abort or as rejected, changes nothing that it was meant to change; whatever the
// node says is well formed, and not more than a tick has room for; no SDO transfer outlives its time-out.
//
// An input is a row of steps: a byte whose low half says what comes (Step) and whose high half how many ticks
// follow it, and what the step needs. Bytes that are missing are 0.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>

#include "firmware/canopen/node.hpp"
#include "firmware/config/parameter_slots.hpp"
#include "firmware/shadow_run.hpp"
#include "tests/fuzz/fresh.hpp"
#include "tests/fuzz/good_model.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using namespace plenum;
using canopen::Kept;
using fuzz::require;
using ports::CanFrame;

constexpr std::uint8_t kNode = 5;
constexpr std::size_t kMostSteps = 600;
/// Segments of a tick's share, TPDOs, heartbeat, emergency, and an answer of SDO and LSS each.
constexpr int kMostFrames = 64 + static_cast<int>(canopen::kTpdos) + 1 + 1 + 2;

/// What a step is; any other number is an SDO request of eight bytes.
enum class Step : std::uint8_t {
  write = 7,       ///< by SDO, to an object that there is: its row, U16, instance, sub-index; four bytes
  nmt = 8,         ///< command
  sync = 9,        ///< length, data
  rpdo = 10,       ///< number, length, data
  lss = 11,        ///< eight bytes
  heartbeat = 12,  ///< node, state
  any = 13,        ///< identifier, two bytes, bit 15 remote, bit 14 extended; length, data
  stored = 14,     ///< the parameter store is done: 0 well, or not
  silence = 15,    ///< of so many tenths of a second, as one tick
};

/// For NMT, SDO, LSS and heartbeats (CiA 301, 7.3.5).
bool is_reserved(std::uint32_t id) {
  return id <= 0x07F || (id >= 0x101 && id <= 0x180) || (id >= 0x581 && id <= 0x5FF) ||
         (id >= 0x601 && id <= 0x67F) || (id >= 0x6E0 && id <= 0x6FF) || id >= 0x701;
}

class Input {
 public:
  explicit Input(std::span<const std::uint8_t> bytes) : rest_(bytes) {}
  bool at_end() const { return rest_.empty(); }
  std::uint8_t byte() {
    if (rest_.empty()) return 0;
    const std::uint8_t first = rest_.front();
    rest_ = rest_.subspan(1);
    return first;
  }
  CanFrame frame(std::uint32_t id, unsigned length) {
    CanFrame frame;
    frame.id = id;
    frame.length = static_cast<std::uint8_t>(std::min(length, 8U));
    for (std::size_t i = 0; i < frame.length; ++i) frame.data[i] = byte();
    return frame;
  }

 private:
  std::span<const std::uint8_t> rest_;
};

/// What stands on a board, but for the process image and the commit that is being asked for (2120h), which a refusal ends: as bytes, for it is
/// compared after each frame that is refused.
class Held {
 public:
  /// Of the same memory each time: padding, too, stays as it is where nothing is written.
  template <class T>
  void add(const T& object) {
    static_assert(std::is_trivially_copyable_v<T>);
    add_bytes(std::as_bytes(std::span(&object, 1)));
  }
  void add_bytes(std::span<const std::byte> bytes) {
    require(bytes.size() <= bytes_.size() - size_, "there is room for all that stands");
    std::memcpy(bytes_.data() + size_, bytes.data(), bytes.size());
    size_ += bytes.size();
  }
  bool operator==(const Held& other) const {
    return size_ == other.size_ && std::memcmp(bytes_.data(), other.bytes_.data(), size_) == 0;
  }

 private:
  std::array<std::byte, std::size_t{8} * 1024> bytes_;  // the first size_ are written
  std::size_t size_ = 0;
};

class Board {
 public:
  Board() {
    node_.prepare();
    drain();
    fuzz::put_good_models_in_force(slots_, 2);
  }

  void step(Input& input) {
    const std::uint8_t first = input.byte();
    const std::uint32_t id = node_.node_id();
    switch (static_cast<Step>(first & 0x0FU)) {
      case Step::write:
        receive(write_of_object(input, id));
        break;
      case Step::nmt: {
        CanFrame frame = input.frame(canopen::cob::kNmt, 1);
        frame.length = 2;
        frame.data[1] = static_cast<std::uint8_t>(id);
        receive(frame);
        break;
      }
      case Step::sync:
        receive(input.frame(canopen::cob::kSync, input.byte()));
        break;
      case Step::rpdo: {
        const std::uint32_t number = input.byte() % canopen::kRpdos;
        receive(input.frame(canopen::cob::kRpdo1 + 0x100U * number + id, input.byte()));
        break;
      }
      case Step::lss:
        receive(input.frame(canopen::cob::kLssRequest, 8));
        break;
      case Step::heartbeat:
        receive(input.frame(canopen::cob::kHeartbeat + (input.byte() & 0x7FU), 1));
        break;
      case Step::any:
        receive(any_frame(input));
        break;
      case Step::stored:
        finish_order(input.byte());
        break;
      case Step::silence:
        tick(100'000U * input.byte());
        break;
      default:
        receive(input.frame(canopen::cob::kSdoRequest + id, 8));
        break;
    }
    for (int ticks = first >> 4U; ticks > 0; --ticks) tick(config::kTick_us);
  }

  /// What no frame was to change has not changed; and after a second, or five where the store was waited for,
  /// no transfer is under way.
  void conclude() {
    require(!known_ || held() == held_, "what is no write changes no parameter");
    CanFrame question{
        .id = canopen::cob::kSdoRequest + node_.node_id(), .length = 8, .data = {0x40, 0x00, 0x10}};
    for (int tenth = 0; tenth < 60; ++tenth) {
      node_.receive(question);  // of another client: no sign of life of a transfer
      node_.tick(100'000);
      drain();
    }
    if (node_.state() == canopen::NmtState::initialising) return;  // without a node id
    CanFrame frame;
    frame.length = 2;
    frame.data = {128, node_.node_id()};
    node_.receive(frame);
    drain();
    frame.id = canopen::cob::kSdoRequest + node_.node_id();
    frame.length = 8;
    frame.data = {0x60};
    node_.receive(frame);
    require(node_.next_frame(frame), "a segment of no transfer is answered");
    constexpr std::array<std::uint8_t, 8> kOfNoObject = {0x80, 0, 0, 0, 0x01, 0x00, 0x04, 0x05};
    require(frame.data == kOfNoObject, "no SDO transfer outlives its time-out");
  }

 private:
  static CanFrame write_of_object(Input& input, std::uint32_t id) {
    const std::span<const canopen::Entry> rows = canopen::object_dictionary();
    const std::uint32_t low = input.byte();
    const canopen::Entry& row = rows[(low | std::uint32_t{input.byte()} << 8U) % rows.size()];
    const std::uint32_t index = row.index + std::uint32_t{input.byte()} % row.instances * row.stride;
    const std::uint32_t sub = row.sub + std::uint32_t{input.byte()} % (row.last_sub - row.sub + 1U);
    CanFrame frame = input.frame(canopen::cob::kSdoRequest + id, 4);
    frame.length = 8;
    std::copy_n(frame.data.begin(), 4, frame.data.begin() + 4);
    const std::size_t left_out =
        (4 - canopen::size_of(row.type)) % 4;  // of a long value four bytes are written, too
    frame.data[0] = static_cast<std::uint8_t>(0x23U | left_out << 2U);
    frame.data[1] = static_cast<std::uint8_t>(index);
    frame.data[2] = static_cast<std::uint8_t>(index >> 8U);
    frame.data[3] = static_cast<std::uint8_t>(sub);
    return frame;
  }
  static CanFrame any_frame(Input& input) {
    const std::uint32_t low = input.byte();
    const std::uint32_t high = input.byte();
    CanFrame frame = input.frame((low | high << 8U) & 0x7FFU, input.byte());
    frame.remote = (high & 0x80U) != 0;
    frame.extended = (high & 0x40U) != 0;
    return frame;
  }

  Held held() const {
    Held held;
    const canopen::Communication& communication = node_.communication();
    held.add(communication.sync_cob_id);
    held.add(communication.cycle_period_us);
    held.add(communication.sync_overflow);
    held.add(communication.emergency_cob_id);
    held.add(communication.heartbeat_ms);
    held.add(communication.on_communication_error);
    held.add(communication.on_device_error);
    for (std::size_t i = 0; i < canopen::HeartbeatConsumer::kWatches; ++i)
      held.add(communication.heartbeats.entry(i));
    for (const canopen::Rpdo& rpdo : communication.rpdo) held.add(rpdo.parameters());
    for (const canopen::Tpdo& tpdo : communication.tpdo) held.add(tpdo.parameters);
    held.add(settings_.board());
    for (std::uint8_t c = 0; c < config::kChambers; ++c) {
      held.add(settings_.chamber(c));
      const std::span<const std::uint8_t> image = slots_.active_image(c);
      held.add(image.size());
      held.add_bytes(std::as_bytes(image));
    }
    held.add(slots_.generation());
    held.add(recorder_.state());
    held.add(recorder_.selected());
    held.add(recorder_.length());
    held.add(node_.state());
    return held;
  }

  /// May have changed what held() shows, where it was not refused. An SDO write is always answered, and an order
  /// to the store, whose answer is withheld, writes nothing here.
  static bool may_write(const CanFrame& frame, bool answered) {
    const unsigned command = frame.data[0] >> 5U;
    const bool downloads = command == 0 || command == 1 || command == 6;
    const bool is_sdo = (frame.id & ~0x7FU) == canopen::cob::kSdoRequest;
    return frame.id == canopen::cob::kNmt || frame.id == canopen::cob::kLssRequest ||
           (is_sdo && downloads && answered);
  }

  void receive(const CanFrame& frame) {
    if (!known_) held_ = held();
    known_ = true;
    const canopen::ProcessImage image = image_;
    const canopen::Counters counters = node_.counters();
    node_.receive(frame);
    const bool refused =
        node_.counters().rejected != counters.rejected || node_.counters().sdo_aborts != counters.sdo_aborts;
    if (refused) {
      require(image_ == image, "a refused frame leaves the process image");
      require(held() == held_, "a refused frame leaves parameters, models and recorder");
    }
    const bool answered = drain() != 0;
    if (!refused && may_write(frame, answered)) known_ = false;
  }

  void tick(std::uint32_t elapsed_us) {
    const auto moving = [this] { return std::pair(node_.state(), recorder_.state()); };
    const auto before = moving();
    // a reset that was asked for is worked off now
    if (slots_.apply_at_tick_edge() != 0 || node_.state() == canopen::NmtState::initialising) known_ = false;
    settings_.take_changed();
    ++image_.tick_count;
    recorder_.write(image_.tick_count, false, {});
    shadow_run_.step(slots_);
    node_.tick(elapsed_us);
    drain();
    known_ = known_ && moving() == before;
  }

  /// As the keeper of the parameters does it.
  void finish_order(std::uint8_t result) {
    canopen::StoreOrder& order = node_.order();
    if (order.what == canopen::StoreOrder::What::none) return;
    order.result = result == 0 ? canopen::Abort::none : canopen::Abort::hardware_error;
    order.done = true;
    if (result != 0) return;
    config::RowWriter rows(kept_);
    if (order.what == canopen::StoreOrder::What::store) {
      node_.collect(Kept::communication, rows);
      node_.collect(Kept::application, rows);
    }
    node_.keep(std::span(kept_).first(rows.size()), node_.node_id());
  }

  /// Returns how many frames the node had to say.
  int drain() {
    CanFrame frame;
    int count = 0;
    for (; count <= kMostFrames && node_.next_frame(frame); ++count) check(frame);
    require(count <= kMostFrames, "a tick's frames are bounded");
    require(node_.counters().queue_overflow == 0, "a queue that is emptied in each tick never overflows");
    return count;
  }

  void check(const CanFrame& frame) const {
    require(!frame.extended && !frame.remote && frame.id <= canopen::cob::kIdMask && frame.length <= 8,
            "a frame is one of 11 bits and up to 8 bytes");
    if (frame.id == canopen::cob::kSdoResponse + node_.node_id()) {
      require(frame.length == 8, "an SDO answer has eight bytes");
    } else if (frame.id == canopen::cob::kLssResponse) {
      require(frame.length == 8, "an LSS answer has eight bytes");
    } else if (frame.id == canopen::cob::kHeartbeat + node_.node_id()) {
      require(frame.length == 1, "a heartbeat has one byte");
    } else {
      require(!is_reserved(frame.id), "a PDO keeps off the identifiers of others");
    }
  }

  canopen::ProcessImage image_;
  telemetry::Recorder recorder_;
  ShadowRun shadow_run_{recorder_, 2.0F};
  config::ParameterSlots slots_{&shadow_run_};
  config::SettingsDesk settings_;
  std::array<std::uint8_t, config::kMaxBodyBytes> kept_{};
  canopen::Node node_{
      {.node_id = kNode,
       .identity = {.vendor_id = 0x11, .product_code = 0x22, .revision = 0x33, .serial = 0x44}},
      image_,
      slots_,
      settings_,
      recorder_};
  Held held_;           ///< as of the last frame that may have changed it
  bool known_ = false;  ///< held_ is what stands
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  auto& board = plenum::fuzz::fresh<Board>();
  Input input({data, size});
  for (std::size_t steps = 0; steps < kMostSteps && !input.at_end(); ++steps) board.step(input);
  board.conclude();
  return 0;
}
