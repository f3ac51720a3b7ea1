#include "tests/virtual-board/guest/chambers.hpp"

#include <algorithm>
#include <cmath>

namespace plenum::virtual_board {
namespace {

namespace plant = host::plant;

constexpr double kSmallest_m3 =
    150e-6;                     // mean of the first chamber; each further one is a tenth of it larger
constexpr double kSwing = 0.2;  // amplitude over mean
constexpr double kPaPerVolt = 100'000.0;
constexpr double kUnpowered_V = 5.0;
constexpr double kCodes = 65536.0;

double mean_m3(std::size_t chamber) {
  return kSmallest_m3 * (1.0 + 0.1 * static_cast<double>(chamber));
}

}  // namespace

Chambers::Chambers() {
  for (std::size_t c = 0; c < kChambers; ++c) {
    const double place = static_cast<double>(c);
    const plant::VolumeMotion motion(
        mean_m3(c),
        {{{.amplitude_m3 = kSwing * mean_m3(c), .frequency_Hz = 0.3 + 0.07 * place, .phase_rad = 0.7 * place},
          {},
          {}}});
    chamber_.emplace_back(plant::ThinPlateValve({}), plant::ChamberConfig{}, motion);
  }
}

void Chambers::advance(double duration_s, std::span<const double, kChambers> command_V, bool powered) {
  for (std::size_t c = 0; c < kChambers; ++c) {
    chamber_[c].advance(powered ? command_V[c] : kUnpowered_V, duration_s);
  }
}

std::array<double, Chambers::kInputs> Chambers::readings_V() const {
  std::array<double, kInputs> readings{};
  for (std::size_t c = 0; c < kChambers; ++c) {
    readings[c] = chamber_[c].pressure_Pa() / kPaPerVolt;
    readings[kChambers + c] = chamber_[c].volume_m3() / (2.0 * mean_m3(c)) * 10.0;
  }
  readings[2 * kChambers] = chamber_.front().supply_Pa() / kPaPerVolt;
  return readings;
}

int code_of(double volts, double low_V, double span_V) {
  const double step_V = span_V / kCodes;
  return static_cast<int>(
      std::clamp(std::round(volts / step_V), low_V / step_V, (low_V + span_V) / step_V - 1.0));
}

}  // namespace plenum::virtual_board
