// A machine for the safety case: the unchanged board, memory for drivers, and eight chambers of the plant's physics in lockstep.
//
// The chambers are thin-plate valves on volumes that move, each a little larger than the one before. Every tick is watched, of
// every chamber, whatever a test is about: the command is one that the installer allows, and the pressure is not above what
// the limit and the air in flight explain. A chamber is in reach while the board reads its pressure and its valve has power
// and vents when it is told to, whatever else it does:
//
//   in reach, for n ticks or more          p+ <= max(P, p e^(-(a - b) h) + r_0 h),   P = L + r_L h (n + 1/2) + e
//   in reach again, the first n ticks      p+ <= max(P, p + r h)
//   out of reach, open                     p+ <= p + r h                                        (S1)
//   out of reach, shut                     p+ <= p (v / v+)^kappa + r_0 h                       (S2)
//   always                                 p+ <= p_s (v_max / v+)^kappa                         (S3)
//
// So what has never been out of reach stays below P, and what comes back from above falls to it as fast as a vent empties it.
// L over-pressure limit, n the ticks that it must last, h tick. The mean of the last tick that was not above L ends at most
// r_L h/2 above it, and at the end of the n-th on end the board answers; e is what noise and steps of the converter hide.
// r = kappa R T/v mdot_c(p) + b p_s, at the smallest volume, the highest speed, the highest pressure p_s that the supply has
// had and the whole command range, is the fastest rise where the flow is choked; r_L that from L - r h on, below which no tick
// ends above L; r_0 that of the leak at rest alone, without the motion, which (S2) has in closed form: a shut chamber is
// compressed adiabatically (4a). b = kappa |v'|/v, and a = kappa R T mdot_r/(p v) of the vented chamber at the largest volume,
// which does not depend on p where the flow is choked. Otherwise the exhaust, and the leak out, are left out: both take
// pressure away. (S3): p v^kappa grows by what flows in alone, and nothing flows in above p_s. In reach p is the pressure a
// tick ago; (S1) and (S2) go on from the last one in reach, by themselves.
//
// In SI units: pressures [Pa] and volumes [m3] of the plant; what is of the board is in its units.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
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

  /// A mistake planted in what the board is told: `settings` stay what it is judged by.
  using Mistake = std::function<void(Settings& told)>;

  /// `stored`: the models that the board finds; `seed`: of the motion of volumes, the references and the noise.
  Machine(const Images& stored, config::SafeOutput safe_output, std::uint64_t seed,
          const Mistake& mistake = {});

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
  /// P, the most that a chamber may hold that was never out of reach [Pa].
  double most_in_reach_Pa(std::size_t chamber) const;
  /// The spool of a chamber's valve sticks at a command, whatever it is told or until it is told to vent; or obeys again.
  enum class Stuck : bool { for_good, until_vented };
  void jam(std::size_t chamber, double command_V, Stuck stuck = Stuck::for_good) {
    jam_[chamber] = {command_V, stuck};
  }
  void free_spool(std::size_t chamber) { jam_[chamber].reset(); }
  /// Takes the emergencies that have been sent since the last call.
  std::vector<host::client::Emergency> take_emergencies();
  /// The first thing that a tick may not do, with its tick.
  const std::string& violation() const { return violation_; }
  /// The first pressure that is not explained, with its tick, whatever was commanded before.
  const std::string& over_pressure() const { return over_pressure_; }

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
  double spool_V(std::size_t chamber) const;
  /// What the valve of a chamber did over a tick.
  enum class Valve : std::uint8_t { obeyed, stood_open, stood_shut };
  Valve valve_over_tick(std::size_t chamber) const;
  void explain(std::size_t chamber, Valve valve);
  double inflow_Pa_s(std::size_t chamber, double command_V, double pressure_Pa) const;
  double fastest_rise_Pa_s(std::size_t chamber, double pressure_Pa) const;
  double emptying_per_s(std::size_t chamber) const;
  void watch(std::size_t chamber);
  std::string accusation(std::size_t chamber, const std::string& what) const;

  struct Jam {
    double command_V;
    Stuck stuck;
  };
  std::array<std::optional<Jam>, kChambers> jam_{};
  double phase_;                                  ///< of the references
  std::array<double, kChambers> explained_Pa_{};  ///< the right-hand sides above
  std::array<double, kChambers> volume_before_m3_{};
  std::array<int, kChambers> ticks_in_reach_{};
  double highest_supply_Pa_ = 0.0;  ///< p_s
  std::vector<host::client::Emergency> emergencies_;
  std::string violation_;
  std::string over_pressure_;
};

}  // namespace plenum::safety_case
