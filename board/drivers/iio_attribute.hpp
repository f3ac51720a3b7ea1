// An attribute of the kernel: a file below /sys that holds one value as text.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace plenum::board::drivers {

/// What it says, without the end of its line. Empty: errno tells why.
std::optional<std::string> attribute_text(const std::filesystem::path& path);
/// The same as a number; text that is none is EINVAL.
std::optional<double> attribute_number(const std::filesystem::path& path);

/// An attribute, open for writing. Kept open, a value costs one system call and no look-up, and reaches no other device that
/// was given the number of one that is gone.
class IioAttribute {
 public:
  explicit IioAttribute(const std::filesystem::path& path) noexcept;
  IioAttribute(IioAttribute&& other) noexcept;
  ~IioAttribute();

  /// Why it is not open, as errno; 0: it is.
  int error() const noexcept { return error_; }

  /// 0, or the kernel's error.
  int put(long value) const noexcept;
  int put(std::string_view text) const noexcept;

 private:
  int file_;
  int error_;
};

}  // namespace plenum::board::drivers
