#include "board/bit_rate.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <span>
#include <stdexcept>
#include <vector>

#include "board/drivers/slot_files.hpp"
#include "firmware/canopen/lss.hpp"
#include "firmware/config/record_store.hpp"

namespace plenum::board {
namespace {

constexpr std::uint32_t kWhereNobodySays_bit_s = 1'000'000;

/// Slots that are only read: another user's, who may have put anything there.
class SlotReader final : public ports::ParameterStore {
 public:
  explicit SlotReader(const std::filesystem::path& folder) {
    for (std::size_t slot = 0; slot < kSlots; ++slot) {
      const std::filesystem::path path = drivers::slot_path(folder, slot);
      file_[slot] = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
      absent_[slot] = file_[slot] < 0 && errno == ENOENT;
    }
  }
  ~SlotReader() { drivers::close_slots(file_); }
  SlotReader(const SlotReader&) = delete;
  SlotReader& operator=(const SlotReader&) = delete;

  bool read(std::uint8_t slot, std::size_t offset, std::span<std::uint8_t> bytes) noexcept override {
    if (!drivers::in_a_slot(slot, offset, bytes.size())) return false;
    std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});
    struct stat file {};
    return absent_[slot] || (::fstat(file_[slot], &file) == 0 && S_ISREG(file.st_mode) &&
                             drivers::read_at(file_[slot], offset, bytes));
  }
  ports::StoreResult write(std::uint8_t /*slot*/, std::size_t /*offset*/,
                           std::span<const std::uint8_t> /*bytes*/) noexcept override {
    return ports::StoreResult::failed;
  }
  ports::StoreResult sync(std::uint8_t /*slot*/) noexcept override { return ports::StoreResult::failed; }

 private:
  std::array<int, kSlots> file_{-1, -1};
  std::array<bool, kSlots> absent_{};  ///< nothing was ever stored in it
};

}  // namespace

std::optional<plenum::config::LssSettings> stored_lss(const std::filesystem::path& folder) {
  SlotReader slots(folder);
  plenum::config::RecordStore store(slots);
  std::vector<std::uint8_t> body(plenum::config::kMaxBodyBytes);
  const plenum::config::RecordStore::Loaded loaded = store.load(body);
  if (loaded.result == plenum::config::LoadResult::lost) return std::nullopt;
  return plenum::config::lss_in(std::span(body).first(loaded.size));
}

BitRate wanted_bit_rate(const config::BoardFile& board, const plenum::config::LssSettings& stored,
                        const drivers::CanInterface& interface) {
  if (board.bit_rate_kbit) return {1000U * *board.bit_rate_kbit, "can.bit_rate_kbit"};
  if (canopen::row_of_bit_rate(1000U * stored.bit_rate_kbit))
    return {1000U * stored.bit_rate_kbit, "what LSS has stored"};
  if (interface.bit_rate) return {*interface.bit_rate, "whoever has set it up"};
  return {kWhereNobodySays_bit_s, "a board that nobody has told another"};
}

std::string bit_rate_trouble(const drivers::CanInterface& interface, const BitRate& wanted,
                             const std::string& name) {
  if (!interface.controller) return {};
  // The kernel tells the rate that the controller's clock gives, which may be another by some bit/s.
  const std::uint32_t runs = interface.bit_rate.value_or(0);
  if (drivers::is_near(runs, wanted.bit_s)) return {};
  return fmt::format("can:{}: runs at {:g} kbit/s, expected the {:g} of {} (systemctl start plenumd-bus)",
                     name, runs / 1000.0, wanted.bit_s / 1000.0, wanted.of);
}

std::string set_bit_rate(const config::BoardFile& board) {
  const std::string& name = board.interface;
  const std::optional<drivers::CanInterface> before = drivers::can_interface(name);
  if (!before) return fmt::format("can:{}: is not there yet: nothing is set", name);
  if (!before->controller) return {};
  const auto stored = stored_lss(board.store);
  if (!stored && !board.bit_rate_kbit && !before->bit_rate)
    throw std::runtime_error(
        fmt::format("can:{}: is left as it is, for what LSS has stored in {} cannot be read, expected that, "
                    "or can.bit_rate_kbit in board.toml",
                    name, board.store.string()));
  const BitRate wanted = wanted_bit_rate(board, stored.value_or(plenum::config::LssSettings{}), *before);
  if (before->up && bit_rate_trouble(*before, wanted, name).empty()) return {};
  if (!before->can_run_at(wanted.bit_s))
    throw std::runtime_error(fmt::format(
        "can:{}: its controller cannot run at the {:g} kbit/s of {}, expected a rate that its clock gives",
        name, wanted.bit_s / 1000.0, wanted.of));
  drivers::set_can_bit_rate(name, wanted.bit_s);
  return fmt::format("can:{}: set to the {:g} kbit/s of {}, was {}", name, wanted.bit_s / 1000.0, wanted.of,
                     before->up ? fmt::format("at {:g}", before->bit_rate.value_or(0) / 1000.0) : "down");
}

std::uint16_t rates_for_lss(const config::BoardFile& board,
                            const std::optional<drivers::CanInterface>& interface) {
  std::uint16_t rates = board.settings.node.bit_rates;
  if (!interface || !interface->controller) return rates;
  for (std::size_t row = 0; row < canopen::kBitRates_kbit.size(); ++row) {
    const auto bit = static_cast<std::uint16_t>(1U << row);
    if (!interface->can_run_at(1000U * canopen::kBitRates_kbit[row]))
      rates &= static_cast<std::uint16_t>(~bit);
  }
  return rates;
}

}  // namespace plenum::board
