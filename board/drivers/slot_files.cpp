#include "board/drivers/slot_files.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "firmware/config/parameter_record.hpp"
#include "firmware/ports/parameter_store.hpp"

namespace plenum::board::drivers {

std::filesystem::path slot_path(const std::filesystem::path& folder, std::size_t slot) {
  return folder / (slot == 0 ? "slot-a.bin" : "slot-b.bin");
}

bool in_a_slot(std::uint8_t slot, std::size_t offset, std::size_t size) noexcept {
  return slot < ports::ParameterStore::kSlots && offset + size <= config::kMaxSlotBytes;
}

bool read_at(int file, std::size_t offset, std::span<std::uint8_t> bytes) noexcept {
  std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t got = ::pread(file, bytes.data() + at, bytes.size() - at, static_cast<off_t>(offset + at));
    if (got < 0 && errno != EINTR) return false;
    if (got == 0) break;
    if (got > 0) at += static_cast<std::size_t>(got);
  }
  return true;
}

bool write_at(int file, std::size_t offset, std::span<const std::uint8_t> bytes) noexcept {
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t put = ::pwrite(file, bytes.data() + at, bytes.size() - at, static_cast<off_t>(offset + at));
    if (put > 0) {
      at += static_cast<std::size_t>(put);
    } else if (put == 0 || errno != EINTR) {
      return false;
    }
  }
  return true;
}

int hold_folder(const std::filesystem::path& folder) noexcept {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0 || ::flock(file, LOCK_EX | LOCK_NB) == 0) return file;
  const int why = errno;
  ::close(file);
  errno = why;
  return -1;
}

bool sync_folder(const std::filesystem::path& folder) noexcept {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return false;
  const bool done = ::fsync(file) == 0;
  ::close(file);
  return done;
}

void close_slots(std::span<int> files) noexcept {
  for (int& file : files) {
    if (file >= 0) ::close(file);
    file = -1;
  }
}

}  // namespace plenum::board::drivers
