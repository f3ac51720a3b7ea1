#include "board/resting_volts.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <stdexcept>
#include <string>

#include "board/environment.hpp"
#include "firmware/config/model_image.hpp"

namespace plenum::board {
namespace {

constexpr std::uint64_t kMagic = 0x3130'5453'4552'4c50;  // "PLREST01"
constexpr const char* kFile = "resting";

bool admissible(float volts) noexcept {
  return volts >= 0.0F && volts <= plenum::config::kCommandSpan_V;
}

/// A descriptor of the file, of that size; -1: there is none.
int made(const std::filesystem::path& folder, std::size_t size) noexcept {
  if (folder.empty()) return -1;
  const int file = ::open((folder / kFile).c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (file < 0 || ::ftruncate(file, static_cast<off_t>(size)) == 0) return file;
  ::close(file);
  return -1;
}

}  // namespace

RestingVolts::RestingVolts(std::span<const float> first, const std::filesystem::path& folder) {
  const int file = made(folder, sizeof(Page));
  void* const page = ::mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE,
                            file < 0 ? MAP_SHARED | MAP_ANONYMOUS : MAP_SHARED, file, 0);
  const int error = errno;
  if (file >= 0) ::close(file);
  if (page == MAP_FAILED)
    throw std::runtime_error(std::string("resting volts: ") + std::strerror(error) +
                             ", expected a page of memory");
  page_ = new (page) Page{};
  for (std::size_t chamber = 0; chamber < first.size(); ++chamber) page_->volts[chamber] = first[chamber];
  std::atomic_thread_fence(std::memory_order_release);
  page_->magic = kMagic;
}

RestingVolts::~RestingVolts() {
  ::munmap(page_, sizeof(Page));
}

void RestingVolts::set(std::size_t chamber, float volts) noexcept {
  if (admissible(volts)) page_->volts[chamber].store(volts, std::memory_order_relaxed);
}

std::optional<RestingVolts::Volts> RestingVolts::left_in(const std::filesystem::path& folder) {
  if (folder.empty()) return std::nullopt;
  const int file = ::open((folder / kFile).c_str(), O_RDONLY | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  struct {
    std::uint64_t magic = 0;
    Volts volts{};
  } left;
  static_assert(sizeof left == sizeof(Page));
  const ssize_t size = ::read(file, &left, sizeof left);
  ::close(file);
  const bool whole = size == sizeof left && left.magic == kMagic &&
                     std::all_of(left.volts.begin(), left.volts.end(), admissible);
  return whole ? std::optional(left.volts) : std::nullopt;
}

std::filesystem::path RestingVolts::runtime_folder() {
  return environment("RUNTIME_DIRECTORY");
}

}  // namespace plenum::board
