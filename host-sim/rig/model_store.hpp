// Where a simulated board keeps its models: in memory, or in a folder of its own, a file a chamber.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "firmware/config/limits.hpp"
#include "firmware/ports/parameter_store.hpp"

namespace plenum::host::rig {

class ModelStore final : public plenum::ports::ParameterStore {
 public:
  /// With a folder, records are files chamber-N.plm in it, replaced whole; it is made when it does not exist.
  /// Throws trace::InputError when it cannot be made or a record in it cannot be read.
  explicit ModelStore(const std::optional<std::filesystem::path>& folder = std::nullopt);

  std::size_t load(std::uint8_t id, std::span<std::uint8_t> bytes) noexcept override;
  bool store(std::uint8_t id, std::span<const std::uint8_t> bytes) noexcept override;

 private:
  std::optional<std::filesystem::path> folder_;
  std::array<std::vector<std::uint8_t>, plenum::config::kChambers> record_;
};

}  // namespace plenum::host::rig
