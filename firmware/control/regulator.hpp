// Pressure regulator of one chamber: model inversion as feedforward, and estimates of what the model misses.
//
// Each tick, at its start:
//   1. observe  The pressure measured over the tick just past (a mean: it lags by half a tick) corrects the
//               estimate of the pressure now, and three estimates of what the model misses:
//                 d      a steady disturbance [kPa a tick]: leaks, supply, sensor offset
//                 theta  a share of the isothermal compression -p v' h/v [1]: the published model puts v'
//                        elsewhere
//                 c(u)   a correction of the valve curve (CommandTrim)
//               Each is moved along its sensitivity, weighted by how far it is believed to be off:
//                 step_i = m_i^2 phi_i e / (noise^2 + sum_j m_j^2 phi_j^2)
//                 phi_i  = d mean / d estimate_i; that of c(u) as it was when the command was chosen
//               the first step of a Kalman filter with the deviations m_i. (Normalising each estimate on its
//               own was tried: the estimates then chase each other.) Without a measurement the model carries
//               the estimate on: coast().
//               What the tick took from the supply is carried on, and what a sensor says of it (SupplyLine).
//   2. predict  The valve answers a command late (ValvePath); the pressure is carried over that delay with the
//               commands that still act (a Smith predictor).
//   3. invert   Once a tick: the place of the spool that takes it, in one tick of action, to
//                 target = reference + share of the present error that may stay - disturbance
//               The reference is the one for the end of that action, known in advance where the set-point
//               stream has preview. ValvePath says which command puts the spool there.
//
// Valve and sensor are prompt and true but for the delay of the configuration, until a model knows better
// (take_over()). The readings of a sensor that lags are taken for what they say of the pressure (SensorLag).
//
// The estimates move with the command that was really sent, after limits: at a limit nothing winds up. The
// observer runs whether or not the regulator drives, so that it takes over without a bump. All estimates are
// bounded.
//
// The regulator knows its model only by PressureModel.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/config/seal.hpp"
#include "firmware/control/command_trim.hpp"
#include "firmware/control/pressure_model.hpp"
#include "firmware/control/reference_shaper.hpp"
#include "firmware/control/sensor_lag.hpp"
#include "firmware/control/sent_commands.hpp"
#include "firmware/control/supply_line.hpp"
#include "firmware/control/valve_path.hpp"

namespace plenum::control {

class Regulator {
 public:
  struct Config {
    Scalar command_low_V = Scalar(3);
    Scalar command_high_V = Scalar(7);
    /// Time from a command to the valve's answer, in ticks, 0 to ValvePath::kMostDelay_ticks, where the model leaves it
    /// out: a spool of natural frequency f and damping z answers like a delay of z/(pi f), and about 1.3 times as late
    /// when it has a dead band to cross.
    Scalar valve_delay_ticks = Scalar(0.3);
    Scalar pressure_gain = Scalar(1.1);  ///< of the observer, on the residual [1]
    /// How far the estimates are believed to be off; 0: that one is not learned.
    Scalar disturbance_deviation_kPa = Scalar(0.6);
    Scalar compression_deviation = Scalar(0.3);
    Scalar trim_deviation_V = Scalar(0.07);
    Scalar residual_noise_kPa = Scalar(2);      ///< the part of a residual that none of them explains
    Scalar disturbance_limit_kPa = Scalar(40);  ///< largest disturbance believed, a tick
    Scalar compression_limit = Scalar(2);       ///< largest share of the compression believed
    Scalar trim_limit_V = Scalar(1);            ///< largest correction of the command believed
    /// The share of a tracking error that is left after one tick, [1]: caution. It grows with the residuals
    /// of late: where the model is known to miss, a full correction would be overdone.
    Scalar error_left = Scalar(0.1);
    Scalar error_left_per_kPa = Scalar(0.05);  ///< for each kPa of their mean over the last ten ticks or so
    Scalar error_left_most = Scalar(0.8);
    Scalar error_left_limit_kPa = Scalar(10);  ///< the most left of any error: a step is answered at once
  };

  struct Command {
    Scalar command_V = 0;
    /// What the model alone would send on the reference; in closed loop to first order, for the record only.
    Scalar feedforward_V = 0;
    bool saturated = false;
  };

  void configure(const Config& config) noexcept;

  /// Valve, sensor and supply as a model knows them. go_on() or reset() follows.
  void take_over(const ValvePath::Config& valve, Scalar sensor_lag_ticks,
                 const SupplyLine::Config& supply = {}) noexcept;

  /// The supply [kPa] over the tick just past; before observe() or coast(). Where nothing is measured it stays as it was last.
  void supply_measured(Scalar supply_kPa) noexcept { line_.measured(supply_kPa); }

  /// How many ticks of reference regulate() and feedforward() look at.
  std::size_t ahead() const noexcept { return sent_.whole_ticks() + 2; }

  /// The chamber stands at `pressure_kPa`, the valve at `command_V`; nothing is known of the model's faults.
  void reset(Scalar pressure_kPa, Scalar command_V) noexcept;

  /// Another model: what had been learned was the old one's faults. The commands that are still on their way stay.
  void go_on(Scalar pressure_kPa) noexcept;

  /// By how much the reading of a tick lies above the predicted one [kPa].
  struct Missed {
    Scalar residual_kPa = 0;
    Scalar alone_kPa =
        0;  ///< above what the model alone predicts, with nothing of what has been learned; to first order
  };
  /// Step 1, of the tick just past.
  Missed observe(const PressureModel& model, Scalar measured_kPa, const ChamberMotion& past) noexcept;

  /// In place of observe() when the tick just past brought no measurement: the model carries the estimate
  /// over it, and nothing is learned.
  void coast(const PressureModel& model, const ChamberMotion& past) noexcept;

  /// Steps 2 and 3, closed loop.
  Command regulate(const PressureModel& model, const ReferenceShaper::Reference& reference,
                   const ChamberMotion& next) noexcept;

  /// Pure feedforward: the command that takes a chamber on the reference along it. Nothing measured enters.
  Command feedforward(const PressureModel& model, const ReferenceShaper::Reference& reference,
                      const ChamberMotion& next) const noexcept;

  /// Whatever was sent to the valve this tick, by this regulator or not. Called once a tick, last.
  void sent(Scalar command_V) noexcept;

  Scalar pressure_kPa() const noexcept { return pressure_kPa_; }

  /// The estimates after the last observe() or coast() are numbers; what bounds them makes none of what is not.
  bool knows_numbers() const noexcept {
    return numeric::is_finite(pressure_kPa_ + steady_kPa_ + residual_level_kPa_ + compression_);
  }

  /// Of what configure() alone writes: config/seal.hpp.
  std::uint64_t sum_of_constants() const noexcept {
    return config::sum_of_object(config_) + config::sum_of_object(weights_) + trim_.sum_of_constants();
  }
  /// Of what take_over() alone writes, and configure() through it.
  std::uint64_t sum_of_paths() const noexcept {
    return valve_.sum_of_constants() + sensor_.sum_of_constants() + sent_.sum_of_constants() +
           line_.sum_of_constants();
  }
  /// Of every estimate, and of what was sent: d, theta and c(u) are learned slowly, or at one command alone, and learn what is false
  /// from a pressure, a spool or a command that is.
  std::uint64_t sum_of_estimates() const noexcept {
    return sent_.sum_of_acting() + trim_.sum_of_estimates() + valve_.sum_of_places() +
           sensor_.sum_of_estimate() + config::sum_of_object(pressure_kPa_) +
           config::sum_of_object(steady_kPa_) + config::sum_of_object(residual_level_kPa_) +
           config::sum_of_object(compression_) + line_.sum_of_estimates();
  }

 private:
  struct Span {
    Scalar from_kPa;
    Scalar to_kPa;
  };
  /// The reference over the tick in which a command given now acts.
  Span acting_span(const ReferenceShaper::Reference& reference) const noexcept;
  /// In a tick, given what an isothermal compression would add in it.
  Scalar disturbance_kPa(Scalar compression_kPa) const noexcept;
  /// Step 2: the pressure when a command given now begins to act, and the motion then.
  struct Acting {
    Scalar pressure_kPa;
    ChamberMotion motion;
    Moving moves;  ///< of that motion
    SupplyLine line;
    Scalar compressed;  ///< by that motion, -v' h/v

    void supplied(const PressureModel& model, Scalar supply) noexcept;
  };
  Acting stands(const PressureModel& model, Scalar pressure_kPa, const ChamberMotion& motion) const noexcept;
  Acting when_it_acts(const PressureModel& model, const ChamberMotion& next) noexcept;
  /// The model's inverse there, with the supply that the answer itself leaves.
  Inverse inverse_of(const PressureModel& model, Acting& acting, Scalar target_kPa) const noexcept;
  /// The tick just past, from the estimate at its start and the commands that acted.
  Prediction past_tick(const PressureModel& model, const ChamberMotion& past,
                       Scalar compression_kPa) noexcept;
  void forget(Scalar pressure_kPa) noexcept;
  /// What the estimates make of a tick's mean and the model alone does not, before they are moved [kPa].
  Scalar learn(Scalar residual_kPa, Scalar compression_kPa) noexcept;

  /// Of the estimates, as they learn: m_i^2 and what is made of it alone.
  struct Weights {
    Scalar noise_and_steady = 1;  ///< noise^2 + m_d^2 phi_d^2
    Scalar steady_moves = 0;      ///< m_d^2 phi_d
    Scalar compression = 0;
    Scalar trim = 0;
  };

  Config config_;
  Weights weights_;
  CommandTrim trim_;
  ValvePath valve_;
  SensorLag sensor_;
  SentCommands sent_;
  SupplyLine line_;
  Scalar pressure_kPa_ = 0;        ///< estimate at the start of the tick at hand
  Scalar steady_kPa_ = 0;          ///< d
  Scalar residual_level_kPa_ = 0;  ///< mean magnitude of the residuals of late
  Scalar compression_ = 0;         ///< theta
  Scalar planned_V_ = 0;           ///< valve command that regulate() answered this tick ...
  Inverse plan_;                   ///< ... and what the model says behind it
  bool planned_ = false;           ///< regulate() was called this tick, and no limit came between
};

}  // namespace plenum::control
