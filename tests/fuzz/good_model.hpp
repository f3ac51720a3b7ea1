// A model that every check passes, in force.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/config/parameter_slots.hpp"
#include "tests/fuzz/require.hpp"

namespace plenum::fuzz {

/// In the first `chambers` chambers, so that there is something to spoil.
inline void put_good_models_in_force(config::ParameterSlots& slots, std::uint8_t chambers) {
  constexpr std::array<float, 12> kGood = {5.02F, 2.5F, 4.0F,  -0.05F, 0.003F, 0.02F,
                                           40.0F, 0.1F, 0.08F, 0.1F,   620.0F, 101.325F};
  config::ModelParameters good{.kind = config::ModelKind::tassa9, .count = kGood.size()};
  std::ranges::copy(kGood, good.value.begin());
  std::array<std::uint8_t, config::kMaxImageBytes> room{};
  const std::span<const std::uint8_t> image = std::span(room).first(config::encode(good, room));
  std::array<std::uint32_t, config::kChambers> crcs{};
  crcs.fill(config::trailing_crc(image));
  for (std::uint8_t c = 0; c < chambers; ++c)
    require(static_cast<bool>(slots.stage(c, image)), "the good model is staged");
  const auto mask = static_cast<std::uint8_t>((1U << chambers) - 1);
  const std::uint32_t crc = config::commit_crc(std::span(crcs).first(chambers));
  require(slots.commit(mask, crc, config::kCommitKey) == config::CommitResult::accepted,
          "the good models are committed");
  require(slots.apply_at_tick_edge() == mask, "the good models are taken over");
}

}  // namespace plenum::fuzz
