// How late ticks begin: counts by logarithmic bins, four to an octave, so that a bin is at most a quarter wide. It knows its
// greatest value exactly, and any percentile to the width of a bin.
//
//     bin      0  1  2  3 | 4  5  6  7 |  8  10  12  14 | ...
//     from us  0  1  2  3 | 4  5  6  7 |  8  10  12  14 | ... 114688 and above
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace plenum::telemetry {

class LatencyHistogram {
 public:
  static constexpr std::size_t kBins = 64;

  void add(std::uint32_t latency_us) noexcept {
    ++count_[bin_of(latency_us)];
    max_us_ = std::max(max_us_, latency_us);
  }

  /// Ticks that began so late since the start; wraps.
  std::uint32_t count(std::size_t bin) const noexcept { return count_[bin]; }
  std::uint32_t max_us() const noexcept { return max_us_; }

  /// At most this late are 999 of 1000 ticks: the upper end of the bin in which that falls. 0 before the first.
  std::uint32_t p999_us() const noexcept {
    std::uint64_t all = 0;
    for (const std::uint32_t ticks : count_) all += ticks;
    std::uint64_t later = all;
    for (std::size_t bin = 0; bin + 1 < kBins; ++bin) {
      later -= count_[bin];
      if (later * 1000 <= all) return std::min(lowest_us(bin + 1) - 1, max_us_);
    }
    return max_us_;
  }

  /// The least latency of a bin.
  static constexpr std::uint32_t lowest_us(std::size_t bin) noexcept {
    if (bin < kQuarters) return static_cast<std::uint32_t>(bin);
    return static_cast<std::uint32_t>(kQuarters + bin % kQuarters) << (bin / kQuarters - 1);
  }

  static constexpr std::size_t bin_of(std::uint32_t latency_us) noexcept {
    if (latency_us < kQuarters) return latency_us;
    const auto octave = static_cast<std::size_t>(std::bit_width(latency_us)) - 1;
    const std::size_t quarter = latency_us >> (octave - 2) & (kQuarters - 1);
    return std::min(kQuarters * (octave - 1) + quarter, kBins - 1);
  }

  friend bool operator==(const LatencyHistogram&, const LatencyHistogram&) noexcept = default;

 private:
  static constexpr std::size_t kQuarters = 4;  ///< bins to an octave

  std::array<std::uint32_t, kBins> count_{};
  std::uint32_t max_us_ = 0;
};

}  // namespace plenum::telemetry
