// One master uploads at a time: who holds the upload session.
//
// A CAN frame does not say who sent it, so a master that wants to be told from another one names itself by a
// token of its own, a random number, before each image that it stages:
//
//   take(token) -> stage(image)   for each image   ->   commit   ->   release(token)
//
// While a session stands, another token is refused, and so is an image without a take() before it, which is
// how a master that knows no tokens stages. A session ends with its release, or kTimeout_ticks after its last
// take(): a master that died locks nobody out for long. Where no session stands, everybody may stage as if there
// were none. Either way a commit takes nothing but the images whose CRCs it names.
#pragma once

#include <cstdint>

namespace plenum::config {

class UploadSession {
 public:
  /// 15 s: five times what the longest comparison of eight chambers takes (shadow_run.hpp).
  static constexpr std::uint32_t kTimeout_ticks = 1500;

  /// Begins the session of `token`, or goes on with it, and lets one image be staged. Returns false while that
  /// of another token stands, and for token 0, which is nobody's.
  bool take(std::uint32_t token) noexcept {
    if (token == 0 || (owner_ != 0 && token != owner_)) return false;
    owner_ = token;
    left_ticks_ = kTimeout_ticks;
    one_image_ = true;
    return true;
  }

  /// Ends the session of `token`. Returns false when it is not that one that stands.
  bool release(std::uint32_t token) noexcept {
    if (token == 0 || token != owner_) return false;
    end();
    return true;
  }

  /// Whether an image that is handed in now may be staged. Uses up what take() gave.
  bool admit() noexcept {
    const bool admitted = owner_ == 0 || one_image_;
    one_image_ = false;
    return admitted;
  }

  void end() noexcept {
    owner_ = 0;
    left_ticks_ = 0;
    one_image_ = false;
  }

  /// A tick has passed.
  void tick() noexcept {
    if (owner_ != 0 && --left_ticks_ == 0) end();
  }

  std::uint32_t owner() const noexcept { return owner_; }  ///< 0: nobody's
  std::uint32_t left_ticks() const noexcept { return left_ticks_; }

 private:
  std::uint32_t owner_ = 0;
  std::uint32_t left_ticks_ = 0;
  bool one_image_ = false;
};

}  // namespace plenum::config
