#include "board/drivers/iio_attribute.hpp"

#include <fcntl.h>
#include <sys/types.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <system_error>
#include <utility>

namespace plenum::board::drivers {

std::optional<std::string> attribute_text(const std::filesystem::path& path) {
  constexpr std::size_t kLongest = 4096;  // the kernel writes a page at most
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  std::string text(kLongest, '\0');
  ssize_t size = 0;
  do {
    size = ::read(file, text.data(), text.size());
  } while (size < 0 && errno == EINTR);
  const int cause = errno;
  ::close(file);
  errno = cause;
  if (size < 0) return std::nullopt;
  text.resize(static_cast<std::size_t>(size));
  if (text.ends_with('\n')) text.pop_back();
  return text;
}

std::optional<double> attribute_number(const std::filesystem::path& path) {
  const std::optional<std::string> text = attribute_text(path);
  if (!text) return std::nullopt;
  double number = 0.0;
  const char* const end = text->data() + text->size();
  const auto [at, error] = std::from_chars(text->data(), end, number);
  if (error == std::errc{} && at == end) return number;
  errno = EINVAL;
  return std::nullopt;
}

IioAttribute::IioAttribute(const std::filesystem::path& path) noexcept
    : file_(::open(path.c_str(), O_WRONLY | O_CLOEXEC)), error_(file_ < 0 ? errno : 0) {}

IioAttribute::IioAttribute(IioAttribute&& other) noexcept
    : file_(std::exchange(other.file_, -1)), error_(std::exchange(other.error_, EBADF)) {}

IioAttribute::~IioAttribute() {
  if (file_ >= 0) ::close(file_);
}

int IioAttribute::put(long value) const noexcept {
  std::array<char, 24> text{};
  char* const end = std::to_chars(text.begin(), text.end() - 1, value).ptr;
  *end = '\n';
  return put(std::string_view(text.begin(), end + 1));
}

int IioAttribute::put(std::string_view text) const noexcept {
  if (error_ != 0) return error_;
  ssize_t count = 0;
  do {
    count = ::pwrite(file_, text.data(), text.size(), 0);
  } while (count < 0 && errno == EINTR);
  return count < 0 ? errno : 0;
}

}  // namespace plenum::board::drivers
