// A machine for the safety case: the unchanged board, memory for drivers, and eight chambers of the plant's physics in lockstep.
//
// The chambers are thin-plate valves on volumes that move, each a little larger than the one before. Every tick is watched, of
// every chamber, whatever a test is about: the command is one that the installer allows, and the pressure is not above what
// the limit and the air in flight explain:
//
//   seen       the board reads the pressure and its valve obeys:    p <= L + r h (n + 1/2) + e
//   unseen     its valve may be open:                               p+ = p + r h                          (S1)
//   shut       its valve rests:                                     p+ = p (v / v+)^kappa + r_0 h         (S2)
//
// L over-pressure limit, n the ticks that it must last, h tick. The mean of the last tick that was not above L ends at most
// r h/2 above it, and at the end of the n-th on end the board answers; e is what noise and steps of the converter hide.
// r = kappa R T/v mdot_c + kappa p |v'|/v, at the smallest volume, the highest speed, the pressure of the supply and the
// choked flow of the whole command range, is the fastest rise; r_0 that of the leak at rest alone, without the motion, which
// (S2) has in closed form: a shut chamber is compressed adiabatically (4a). Exhaust, and the leak out, are left out: both take
// pressure away. (S1) and (S2) go on from the last pressure that was seen.
//
// In SI units: pressures [Pa] and volumes [m3] of the plant; what is of the board is in its units.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/board.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/plant/chamber.hpp"
#include "host-sim/ports/simulated_analog.hpp"
#include "tests/firmware/board/bench.hpp"

namespace plenum::safety_case {

/// Channel of the supply's sensor; those of pressures and positions are the chamber, and the chamber + kChambers.
inline constexpr std::size_t kSupplyChannel = 2 * kChambers;

/// Models of a kind for the chambers of a Machine: the grey box from the figures of their valve, the others identified.
const Images& models(config::ModelKind kind);

/// Readings of the simulated converter, and what a fault puts in their place.
class Readings final : public ports::AnalogInput {
 public:
  explicit Readings(std::uint64_t seed);
  void read(std::span<ports::AnalogReading> readings) noexcept override;

  host::ports::SimulatedAnalogInput converter;
  std::array<std::optional<ports::AnalogReading>, kAnalogInputs> forced{};
  std::array<ports::AnalogReading, kAnalogInputs> last{};
};

class Machine final : public host::client::Link {
 public:
  static constexpr std::uint8_t kNode = 5;
  static constexpr std::uint8_t kMaster = 0x7E;
  static constexpr std::uint16_t kHeartbeat_ms = 100;  ///< longest pause of the master's

  /// `stored`: the models that the board finds; `seed`: of the motion of volumes, the references and the noise.
  Machine(const Images& stored, config::SafeOutput safe_output, std::uint64_t seed);

  /// Starts the board: to OPERATIONAL, in this mode. The board watches the master's heartbeat.
  void start(canopen::ControlMode mode);

  // Link: requests are answered between ticks, all else takes ticks
  void send(const ports::CanFrame& frame) override;
  std::optional<ports::CanFrame> receive(double timeout_s) override;
  double now_s() const override { return 0.01 * ticks; }

  void control(std::uint16_t word) { put(0x400U + kNode, {static_cast<std::uint8_t>(word), 0}); }
  void put(std::uint32_t id, const std::vector<std::uint8_t>& data);

  /// A tick of the master, the chambers and the board.
  void tick();
  void run(int count) {
    for (int i = 0; i < count; ++i) tick();
  }
  /// These control words, two ticks each.
  void climb(std::initializer_list<std::uint16_t> words);

  const canopen::ProcessImage& image() const { return board.controller().image(); }
  safety::State state() const { return board.controller().state(); }
  double pressure_kPa(std::size_t chamber) const { return 1e-3 * plant[chamber].pressure_Pa(); }
  /// The command that chamber c has while it is not regulated.
  float safe_V(std::size_t chamber) const;
  /// Fastest rise of a chamber's pressure with `command_V` [Pa/s]: r, or r_0 without the motion.
  double rise_Pa_s(std::size_t chamber, double command_V, bool moving) const;
  /// The spool of a chamber's valve sticks at a command, or obeys again.
  void jam(std::size_t chamber, double command_V) { stuck_V_[chamber] = command_V; }
  void free_spool(std::size_t chamber) { stuck_V_[chamber].reset(); }
  /// Takes the emergencies that have been sent since the last call.
  std::vector<host::client::Emergency> take_emergencies();
  /// The first thing that a tick may not do, with its tick.
  const std::string& violation() const { return violation_; }

  std::array<bool, kChambers> unseen{};  ///< the board is not shown the pressure of this chamber
  bool setpoints = true;                 ///< the master sends what it should ...
  bool syncs = true;
  bool heartbeats = true;
  Overrun overrun = Overrun::none;
  bool storing = false;  ///< the board has time to store after each tick
  int ticks = 0;

  const Settings settings;
  std::vector<host::plant::ChamberPlant> plant;
  Readings readings;
  FakeAnalogOutput analog_out;
  FakeDigitalIo digital;
  FakeCan can;
  config::PowerCutMedium store;
  Board board;
  host::client::Session session;

 private:
  void speak();
  void move_chambers();
  void watch(std::size_t chamber);
  void accuse(std::size_t chamber, const std::string& what);

  std::array<std::optional<double>, kChambers> stuck_V_{};
  double phase_;  ///< of the references
  std::array<double, kChambers>
      explained_Pa_{};  ///< by (S1) and (S2); of a chamber that is seen its pressure
  std::array<double, kChambers> volume_before_{};  ///< [m3]
  std::vector<host::client::Emergency> emergencies_;
  std::string violation_;
};

}  // namespace plenum::safety_case
