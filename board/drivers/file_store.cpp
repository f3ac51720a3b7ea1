#include "board/drivers/file_store.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

#include "board/drivers/slot_files.hpp"
#include "firmware/config/parameter_record.hpp"

namespace plenum::board::drivers {
namespace {

using ports::StoreResult;

[[noreturn]] void refuse(const std::filesystem::path& path, const char* found) {
  throw std::runtime_error(
      "store:" + path.string() + ": " + found +
      ", expected a folder that this user may write (the service: its StateDirectory, or a "
      "ReadWritePaths= of its own), and slots in it that are files");
}

constexpr const char* kNoRegularFile = "no regular file";

}  // namespace

FileStore::FileStore(const std::filesystem::path& folder) {
  const auto give_up = [&](const std::filesystem::path& path, const char* found) {
    close();
    refuse(path, found);
  };
  for (std::size_t slot = 0; slot < kSlots; ++slot) {
    const std::filesystem::path path = slot_path(folder, slot);
    file_[slot] = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (file_[slot] < 0) give_up(path, std::strerror(errno));
    struct stat status {};
    if (::fstat(file_[slot], &status) != 0 || !S_ISREG(status.st_mode)) give_up(path, kNoRegularFile);
    // With its blocks there from the start, a slot can be written when the disk is full. A file system that cannot do this
    // leaves it to the write to say so.
    ::fallocate(file_[slot], 0, 0, static_cast<off_t>(config::kMaxSlotBytes));
  }
  held_ = hold_folder(folder);
  if (held_ < 0)
    give_up(folder, errno == EWOULDBLOCK ? "another program stores in it" : std::strerror(errno));
  if (!sync_folder(folder)) give_up(folder, std::strerror(errno));
  try {
    worker_.emplace([this] { work(); });
  } catch (const std::runtime_error& error) {
    close();
    throw std::runtime_error("store:" + folder.string() + ": " + error.what());
  }
}

void FileStore::close() noexcept {
  close_slots(file_);
  close_slots(std::span(&held_, 1));
}

void FileStore::look(const std::filesystem::path& folder) {
  struct stat status {};
  if (::stat(folder.c_str(), &status) == 0 && !S_ISDIR(status.st_mode))
    refuse(folder, std::strerror(ENOTDIR));
  if (::eaccess(folder.c_str(), R_OK | W_OK | X_OK) != 0) refuse(folder, std::strerror(errno));
  for (std::size_t slot = 0; slot < kSlots; ++slot) {
    const std::filesystem::path path = slot_path(folder, slot);
    if (::stat(path.c_str(), &status) != 0) {
      if (errno == ENOENT) continue;  // opening makes it
      refuse(path, std::strerror(errno));
    }
    if (!S_ISREG(status.st_mode)) refuse(path, kNoRegularFile);
    if (::eaccess(path.c_str(), R_OK | W_OK) != 0) refuse(path, std::strerror(errno));
  }
}

FileStore::~FileStore() {
  worker_.reset();
  close();
}

bool FileStore::read(std::uint8_t slot, std::size_t offset, std::span<std::uint8_t> bytes) noexcept {
  return in_a_slot(slot, offset, bytes.size()) && read_at(file_[slot], offset, bytes);
}

StoreResult FileStore::write(std::uint8_t slot, std::size_t offset,
                             std::span<const std::uint8_t> bytes) noexcept {
  if (!in_a_slot(slot, offset, bytes.size()) || bytes.size() > kMostBytes) return StoreResult::failed;
  return ask({Kind::write, slot, offset, bytes});
}

StoreResult FileStore::sync(std::uint8_t slot) noexcept {
  if (slot >= kSlots) return StoreResult::failed;
  return ask({Kind::sync, slot, 0, {}});
}

StoreResult FileStore::ask(const Order& order) noexcept {
  const State state = state_.load(std::memory_order_acquire);
  if (state == State::ordered) return StoreResult::busy;
  if (state != State::idle && order == order_) {
    state_.store(State::idle, std::memory_order_relaxed);
    return state == State::done ? StoreResult::done : StoreResult::failed;
  }
  order_ = order;
  std::copy(order.bytes.begin(), order.bytes.end(), bytes_.begin());
  state_.store(State::ordered, std::memory_order_release);
  worker_->wake();
  return StoreResult::busy;
}

void FileStore::work() noexcept {
  if (state_.load(std::memory_order_acquire) != State::ordered) return;
  state_.store(carry_out() ? State::done : State::failed, std::memory_order_release);
}

bool FileStore::carry_out() const noexcept {
  const int file = file_[order_.slot];
  if (order_.kind == Kind::sync) return ::fdatasync(file) == 0;
  return write_at(file, order_.offset, std::span(bytes_).first(order_.bytes.size()));
}

bool FileStore::Order::operator==(const Order& other) const noexcept {
  return kind == other.kind && slot == other.slot && offset == other.offset &&
         bytes.data() == other.bytes.data() && bytes.size() == other.bytes.size();
}

}  // namespace plenum::board::drivers
