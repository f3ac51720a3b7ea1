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

StoreResult result_of(bool done) {
  return done ? StoreResult::done : StoreResult::failed;
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

SimulatedStore::SimulatedStore(const std::optional<std::filesystem::path>& folder) {
  for (auto& slot : memory_) slot.resize(folder ? 0 : plenum::config::kMaxSlotBytes);
  if (!folder) return;
  std::error_code error;
  std::filesystem::create_directories(*folder, error);
  if (error) throw trace::InputError(folder->string() + ": cannot make this folder: " + error.message());
  for (std::size_t slot = 0; slot < kSlots; ++slot) {
    const std::filesystem::path path = *folder / (slot == 0 ? "slot-a.bin" : "slot-b.bin");
    file_[slot] = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file_[slot] >= 0) continue;
    const int cause = errno;
    close();
    throw trace::InputError(path.string() + ": cannot be opened for writing: " + std::strerror(cause));
  }
  if (sync_folder(*folder)) return;
  const int cause = errno;
  close();
  throw trace::InputError(folder->string() + ": cannot be synced: " + std::strerror(cause));
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
  if (file_[slot] < 0) {
    std::copy_n(memory_[slot].begin() + static_cast<std::ptrdiff_t>(offset), bytes.size(), bytes.begin());
    return true;
  }
  std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});  // beyond the end of the file nothing was written
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
  if (file_[slot] < 0) {
    std::copy(bytes.begin(), bytes.end(), memory_[slot].begin() + static_cast<std::ptrdiff_t>(offset));
    return StoreResult::done;
  }
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t put =
        ::pwrite(file_[slot], bytes.data() + at, bytes.size() - at, static_cast<off_t>(offset + at));
    if (put < 0 && errno != EINTR) return StoreResult::failed;
    if (put > 0) at += static_cast<std::size_t>(put);
  }
  return StoreResult::done;
}

StoreResult SimulatedStore::sync(std::uint8_t slot) noexcept {
  return result_of(slot < kSlots && (file_[slot] < 0 || ::fsync(file_[slot]) == 0));
}

}  // namespace plenum::host::rig
