#include "board/bit_rate.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <array>
#include <span>
#include <vector>

#include "board/drivers/slot_files.hpp"
#include "firmware/canopen/lss.hpp"
#include "firmware/config/record_store.hpp"

namespace plenum::board {
namespace {

constexpr unsigned kUntilToldOtherwise_kbit = 1000;

/// Slots that are only read: another user's, who may have put anything there.
class SlotReader final : public ports::ParameterStore {
 public:
  explicit SlotReader(const std::filesystem::path& folder) {
    for (std::size_t slot = 0; slot < kSlots; ++slot) {
      const std::filesystem::path path = drivers::slot_path(folder, slot);
      file_[slot] = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    }
  }
  ~SlotReader() { drivers::close_slots(file_); }
  SlotReader(const SlotReader&) = delete;
  SlotReader& operator=(const SlotReader&) = delete;

  bool read(std::uint8_t slot, std::size_t offset, std::span<std::uint8_t> bytes) noexcept override {
    struct stat file {};
    return drivers::in_a_slot(slot, offset, bytes.size()) && ::fstat(file_[slot], &file) == 0 &&
           S_ISREG(file.st_mode) && drivers::read_at(file_[slot], offset, bytes);
  }
  ports::StoreResult write(std::uint8_t /*slot*/, std::size_t /*offset*/,
                           std::span<const std::uint8_t> /*bytes*/) noexcept override {
    return ports::StoreResult::failed;
  }
  ports::StoreResult sync(std::uint8_t /*slot*/) noexcept override { return ports::StoreResult::failed; }

 private:
  std::array<int, kSlots> file_{-1, -1};
};

}  // namespace

plenum::config::LssSettings stored_lss(const std::filesystem::path& folder) {
  SlotReader slots(folder);
  plenum::config::RecordStore store(slots);
  std::vector<std::uint8_t> body(plenum::config::kMaxBodyBytes);
  const std::size_t size = store.load(body).size;
  return plenum::config::lss_in(std::span(body).first(size));
}

BitRate wanted_bit_rate(const config::BoardFile& board, const plenum::config::LssSettings& stored) {
  if (board.bit_rate_kbit) return {*board.bit_rate_kbit, "can.bit_rate_kbit"};
  if (canopen::row_of_bit_rate(1000U * stored.bit_rate_kbit))
    return {stored.bit_rate_kbit, "what LSS has stored"};
  return {kUntilToldOtherwise_kbit, "a board that nobody has told another"};
}

std::string bit_rate_trouble(const drivers::CanInterface& interface, const BitRate& wanted,
                             const std::string& name) {
  if (!interface.controller || interface.bit_rate == wanted.kbit * 1000U) return {};
  return fmt::format("can:{}: runs at {:g} kbit/s, expected the {} of {}, which the service sets when it starts",
                     name, interface.bit_rate.value_or(0) / 1000.0, wanted.kbit, wanted.of);
}

std::string set_bit_rate(const config::BoardFile& board) {
  const drivers::CanInterface before = drivers::can_interface(board.interface);
  const BitRate wanted = wanted_bit_rate(board, stored_lss(board.store));
  const bool right = before.up && bit_rate_trouble(before, wanted, board.interface).empty();
  if (!before.controller || right) return {};
  drivers::set_can_bit_rate(board.interface, 1000U * wanted.kbit);
  return fmt::format("can:{}: set to the {} kbit/s of {}, was {}", board.interface, wanted.kbit, wanted.of,
                     before.up ? fmt::format("at {:g}", before.bit_rate.value_or(0) / 1000.0) : "down");
}

}  // namespace plenum::board
