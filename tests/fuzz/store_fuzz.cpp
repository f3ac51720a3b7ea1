// Any bytes in the two slots of a board's parameter store, either of which may be unreadable: what a damaged disk holds, or a
// stranger has written to it.
//
// The board starts, with a node id, whatever it finds. What it has taken over it stores again, and another board takes all of that over,
// models and values alike.
//
// An input is a byte of Mends, a U16: the bytes of slot 0, and the bytes of both.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/config/parameter_record.hpp"
#include "firmware/controller.hpp"
#include "firmware/parameter_keeper.hpp"
#include "tests/fuzz/fresh.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using namespace plenum;
using canopen::Kept;
using canopen::StoreOrder;
using fuzz::require;
using ports::StoreResult;

/// Bit n of the first byte: slot n has the header of what follows it, so that the search reaches what lies behind the CRCs; bit
/// 2 + n: it cannot be read.
constexpr unsigned kMended = 0;
constexpr unsigned kUnreadable = 2;

struct Medium final : ports::ParameterStore {
  std::array<std::array<std::uint8_t, config::kMaxSlotBytes>, kSlots> bytes{};
  std::array<bool, kSlots> unreadable{};

  bool read(std::uint8_t slot, std::size_t offset, std::span<std::uint8_t> to) noexcept override {
    std::copy_n(bytes[slot].begin() + static_cast<std::ptrdiff_t>(offset), to.size(), to.begin());
    return !unreadable[slot];
  }
  StoreResult write(std::uint8_t slot, std::size_t offset,
                    std::span<const std::uint8_t> from) noexcept override {
    std::copy(from.begin(), from.end(), bytes[slot].begin() + static_cast<std::ptrdiff_t>(offset));
    return StoreResult::done;
  }
  StoreResult sync(std::uint8_t) noexcept override { return StoreResult::done; }

  void fill(std::uint8_t slot, std::span<const std::uint8_t> from, bool mend) {
    from = from.first(std::min(from.size(), config::kMaxSlotBytes));
    std::copy(from.begin(), from.end(), bytes[slot].begin());
    if (!mend || from.size() < config::kRecordHeaderBytes) return;
    const std::span<const std::uint8_t> body = from.subspan(config::kRecordHeaderBytes);
    const config::HeaderBytes header =
        config::encode_header({.generation = canopen::load_le(from.subspan(8, 4)),
                               .length = static_cast<std::uint32_t>(body.size()),
                               .body_crc = config::crc32(body)});
    std::copy(header.begin(), header.end(), bytes[slot].begin());
  }
};

/// What a board has taken over, as it would store it.
struct Taken {
  std::array<std::uint8_t, config::kMaxBodyBytes> body{};
  std::size_t size = 0;

  bool operator==(const Taken& other) const {
    return std::ranges::equal(std::span(body).first(size), std::span(other.body).first(other.size));
  }
};

struct Machine {
  Medium medium;
  ParameterKeeper keeper{medium};
  Controller controller{Settings{}};

  void start() {
    keeper.start(controller);
    require(!controller.node().is_resetting(), "a start is over when it returns");
    require(controller.node().state() == canopen::NmtState::pre_operational, "the board can be reached");
  }
  Taken taken() const {
    Taken taken;
    config::RowWriter rows(taken.body);
    for (std::uint8_t c = 0; c < config::kChambers; ++c) {
      rows.add({.index = static_cast<std::uint16_t>(canopen::object::kActiveModel + c),
                .value = controller.active_image(c)});
    }
    controller.node().collect(Kept::communication, rows);
    controller.node().collect(Kept::application, rows);
    taken.size = rows.size();
    return taken;
  }
  void store() {
    constexpr int kMostPieces = 64;
    StoreOrder& order = controller.node().order();
    order.what = StoreOrder::What::store;
    order.sub = 1;
    for (int piece = 0; piece < kMostPieces && !order.done; ++piece) keeper.step(controller);
    require(order.done, "storing ends");
  }
};
struct First : Machine {};
struct Second : Machine {};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kHeadBytes = 3;
  if (size < kHeadBytes) return 0;
  const auto flag = [data](unsigned bit) { return (data[0] >> bit & 1U) != 0; };
  const std::span<const std::uint8_t> both(data + kHeadBytes, size - kHeadBytes);
  const std::size_t cut = std::min<std::size_t>(canopen::load_le({data + 1, 2}), both.size());

  Machine& first = plenum::fuzz::fresh<First>();
  first.medium.fill(0, both.first(cut), flag(kMended));
  first.medium.fill(1, both.subspan(cut), flag(kMended + 1));
  first.medium.unreadable = {flag(kUnreadable), flag(kUnreadable + 1)};
  first.start();
  const Taken taken = first.taken();
  first.store();
  if (first.controller.node().order().result != canopen::Abort::none) return 0;  // both slots cannot be read

  Machine& second = plenum::fuzz::fresh<Second>();
  second.medium.bytes = first.medium.bytes;
  second.start();
  require(second.keeper.image().loaded != config::LoadResult::empty, "what was stored is found");
  require(second.taken() == taken, "what was taken over is stored, and taken over again");
  return 0;
}
