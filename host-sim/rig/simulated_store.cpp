#include "host-sim/rig/simulated_store.hpp"

#include <fcntl.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "board/drivers/slot_files.hpp"
#include "firmware/config/parameter_record.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::rig {
namespace {

using namespace plenum::board::drivers;
using plenum::ports::StoreResult;

}  // namespace

SimulatedStore::SimulatedStore(const std::optional<std::filesystem::path>& folder) : folder_(folder) {
  if (!folder_) {
    for (auto& slot : memory_) slot.resize(plenum::config::kMaxSlotBytes);
    return;
  }
  std::error_code error;
  std::filesystem::create_directories(*folder_, error);
  if (error) throw trace::InputError(folder_->string() + ": cannot make this folder: " + error.message());
  if (::access(folder_->c_str(), W_OK) != 0) {
    throw trace::InputError(folder_->string() + ": cannot be written: " + std::strerror(errno));
  }
  held_ = hold_folder(*folder_);
  if (held_ < 0) {
    throw trace::InputError(folder_->string() +
                            (errno == EWOULDBLOCK
                                 ? ": another program has this store open, expected one at a time"
                                 : std::string(": cannot be opened: ") + std::strerror(errno)));
  }
  for (std::uint8_t slot = 0; slot < kSlots; ++slot) {
    if (open(slot, 0) || errno == ENOENT) continue;
    const int cause = errno;
    close();
    throw trace::InputError(slot_path(*folder_, slot).string() +
                            ": cannot be opened for writing: " + std::strerror(cause));
  }
}

bool SimulatedStore::open(std::uint8_t slot, int flags) noexcept {
  file_[slot] = ::open(slot_path(*folder_, slot).c_str(), O_RDWR | O_CLOEXEC | flags, 0666);
  return file_[slot] >= 0;
}

void SimulatedStore::close() noexcept {
  close_slots(file_);
  close_slots(std::span(&held_, 1));
}

SimulatedStore::~SimulatedStore() {
  close();
}

bool SimulatedStore::read(std::uint8_t slot, std::size_t offset, std::span<std::uint8_t> bytes) noexcept {
  if (!in_a_slot(slot, offset, bytes.size())) return false;
  if (!folder_) {
    std::copy_n(memory_[slot].begin() + static_cast<std::ptrdiff_t>(offset), bytes.size(), bytes.begin());
    return true;
  }
  if (file_[slot] >= 0) return read_at(file_[slot], offset, bytes);
  std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});  // nothing was written yet
  return true;
}

StoreResult SimulatedStore::write(std::uint8_t slot, std::size_t offset,
                                  std::span<const std::uint8_t> bytes) noexcept {
  if (!in_a_slot(slot, offset, bytes.size())) return StoreResult::failed;
  if (!folder_) {
    std::copy(bytes.begin(), bytes.end(), memory_[slot].begin() + static_cast<std::ptrdiff_t>(offset));
    return StoreResult::done;
  }
  if (file_[slot] < 0 && !(open(slot, O_CREAT) && sync_folder(*folder_))) return StoreResult::failed;
  return write_at(file_[slot], offset, bytes) ? StoreResult::done : StoreResult::failed;
}

StoreResult SimulatedStore::sync(std::uint8_t slot) noexcept {
  if (slot >= kSlots) return StoreResult::failed;
  return file_[slot] < 0 || ::fsync(file_[slot]) == 0 ? StoreResult::done : StoreResult::failed;
}

}  // namespace plenum::host::rig
