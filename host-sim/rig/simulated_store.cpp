#include "host-sim/rig/simulated_store.hpp"

#include <fcntl.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "firmware/config/parameter_record.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::rig {
namespace {

using plenum::ports::StoreResult;

std::filesystem::path path_of(const std::filesystem::path& folder, std::uint8_t slot) {
  return folder / (slot == 0 ? "slot-a.bin" : "slot-b.bin");
}

/// Syncs a folder's entries: a new file is not there after a power cut before its name is.
bool sync_folder(const std::filesystem::path& folder) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return false;
  const bool done = ::fsync(file) == 0;
  ::close(file);
  return done;
}

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
  for (std::uint8_t slot = 0; slot < kSlots; ++slot) {
    if (open(slot, 0) || errno == ENOENT) continue;
    const int cause = errno;
    close();
    throw trace::InputError(path_of(*folder_, slot).string() +
                            ": cannot be opened for writing: " + std::strerror(cause));
  }
}

bool SimulatedStore::open(std::uint8_t slot, int flags) noexcept {
  file_[slot] = ::open(path_of(*folder_, slot).c_str(), O_RDWR | O_CLOEXEC | flags, 0666);
  return file_[slot] >= 0;
}

SimulatedStore::~SimulatedStore() {
  close();
}

void SimulatedStore::close() noexcept {
  for (int& file : file_) {
    if (file >= 0) ::close(file);
    file = -1;
  }
}

bool SimulatedStore::read(std::uint8_t slot, std::size_t offset, std::span<std::uint8_t> bytes) noexcept {
  if (slot >= kSlots || offset + bytes.size() > plenum::config::kMaxSlotBytes) return false;
  if (!folder_) {
    std::copy_n(memory_[slot].begin() + static_cast<std::ptrdiff_t>(offset), bytes.size(), bytes.begin());
    return true;
  }
  std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});  // beyond the end of the file nothing was written
  if (file_[slot] < 0) return true;
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t got =
        ::pread(file_[slot], bytes.data() + at, bytes.size() - at, static_cast<off_t>(offset + at));
    if (got < 0 && errno != EINTR) return false;
    if (got == 0) break;
    if (got > 0) at += static_cast<std::size_t>(got);
  }
  return true;
}

StoreResult SimulatedStore::write(std::uint8_t slot, std::size_t offset,
                                  std::span<const std::uint8_t> bytes) noexcept {
  if (slot >= kSlots || offset + bytes.size() > plenum::config::kMaxSlotBytes) return StoreResult::failed;
  if (!folder_) {
    std::copy(bytes.begin(), bytes.end(), memory_[slot].begin() + static_cast<std::ptrdiff_t>(offset));
    return StoreResult::done;
  }
  if (file_[slot] < 0 && !(open(slot, O_CREAT) && sync_folder(*folder_))) return StoreResult::failed;
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t put =
        ::pwrite(file_[slot], bytes.data() + at, bytes.size() - at, static_cast<off_t>(offset + at));
    if (put < 0 && errno != EINTR) return StoreResult::failed;
    if (put > 0) at += static_cast<std::size_t>(put);
  }
  return StoreResult::done;
}

StoreResult SimulatedStore::sync(std::uint8_t slot) noexcept {
  if (slot >= kSlots) return StoreResult::failed;
  return file_[slot] < 0 || ::fsync(file_[slot]) == 0 ? StoreResult::done : StoreResult::failed;
}

}  // namespace plenum::host::rig
