// The nominal chamber over one tick, with its tangents by pressure, openings, supply, ambient, added flow and volume: (1) to (4)
// of "Modeling and Identification of Pneumatic Actuators", as effects::ChamberModel integrates them.
#pragma once

#include <array>
#include <cstddef>

#include "host-sim/identify/chamber/fit.hpp"
#include "host-sim/plant/orifice.hpp"

namespace plenum::host::diagnose {

using identify::chamber::Scene;

inline constexpr int kParts = 4;  // of a tick: each has its own openings
enum Input : std::size_t {
  kInlet,
  kExhaust = kInlet + kParts,
  kSupply = kExhaust + kParts,
  kBehind,
  kFlow,
  kVolume,
  kInputs
};
using Inputs = std::array<double, kInputs>;

struct Outcome {
  double end = 0.0, reading = 0.0;
};

/// A tick of a record, linear about (pressure, inputs).
struct Linear {
  Outcome at;
  Outcome by_pressure;
  std::array<Outcome, kInputs> by_input;
  double reading_by_early = 0.0;  ///< [Pa/s] by how much it is stamped early
};

/// A port's area [m2] by (3), with a gain a port, and its slopes.
struct Opening {
  double area = 0.0;
  double slope = 0.0;          // by the opening in volts
  std::array<double, 4> by{};  // threshold, gain, leak, width
};

struct Ports {
  Opening inlet, exhaust;
};
/// Of the valve's figures at a command.
Ports ports_of(const effects::Figures& valve, double command_V);

class LinearChamber {
 public:
  explicit LinearChamber(const Scene& scene)
      : plate_(plant::thin_plate_constants(scene.around.gas, scene.around.discharge_coefficient)),
        kappa_(scene.around.gas.kappa),
        RT_(scene.around.gas.specific_gas_constant_J_kg_K() * scene.around.gas.temperature_K) {}

  double kappa() const { return kappa_; }
  double RT() const { return RT_; }
  const plant::ThinPlate& plate() const { return plate_; }

  /// One tick as effects::ChamberModel does it, and its tangents: those of the linear equation with the chord's slope.
  /// `stamped_early_s`: the reading is that of so much later.
  Linear tick(double pressure, const Inputs& in, const double* volume, const effects::Timing& timing,
              double stamped_early_s) const;

 private:
  plant::ThinPlate plate_;
  double kappa_, RT_;
};

}  // namespace plenum::host::diagnose
