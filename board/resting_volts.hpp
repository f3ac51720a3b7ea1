// What each output is to hold when nobody regulates any more [V]: what the installer's file says at first, the settings in force
// from the first tick on.
//
// Three make the outputs safe: the loop, its guard, and, when both are dead, `plenumd --safe`. So the values are in a page of a
// file of the service's runtime directory, in memory: the loop writes it without a system call, the guard has inherited it, and
// `--safe` reads what has been left.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "firmware/config/limits.hpp"

namespace plenum::board {

class RestingVolts {
 public:
  using Volts = std::array<float, plenum::config::kChambers>;

  /// `first`: one a chamber. In a file of `folder`; in a page that only this process and its children have, where that is empty or the file cannot be
  /// made. Throws std::runtime_error when the kernel gives no page.
  RestingVolts(std::span<const float> first, const std::filesystem::path& folder);
  /// Leaves the file to who comes after.
  ~RestingVolts();
  RestingVolts(const RestingVolts&) = delete;
  RestingVolts& operator=(const RestingVolts&) = delete;

  /// What no output can hold is left out.
  void set(std::size_t chamber, float volts) noexcept;
  std::span<const std::atomic<float>> now() const noexcept { return page_->volts; }

  /// What has been left in `folder`; nothing where there is no such file, or none that is whole.
  static std::optional<Volts> left_in(const std::filesystem::path& folder);

  /// $RUNTIME_DIRECTORY, as the service manager says it; empty without one.
  static std::filesystem::path runtime_folder();

 private:
  struct Page {
    std::uint64_t magic;  ///< last to be written
    std::array<std::atomic<float>, plenum::config::kChambers> volts;
  };

  Page* page_;
};

}  // namespace plenum::board
