// What a blind machine may do that the nominal model does not: each departure in a form of its own, chosen to
// differ from what a textbook (and so a catalogue of hypotheses) would write down first.
//
// Symbols: u command [V], x spool [V], p chamber [Pa], v volume [m3], m' mass flow [kg/s], t time [s] from the
// log's first row. A departure that is absent changes no bit; the value at which a present one vanishes stands
// with it. The equations are integrated in truth.cpp.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/blind/random.hpp"

namespace plenum::host::blind {

// ---- command

/// A coil in front of a spring-mass spool whose speed is limited:
///   i' = (u - i)/tau,  x'' = w^2 (i - x) - 2 zeta w x',  tau = 0.1/w, w = 2 pi f,
///   x'' times 1 - (x'/slew)^4 while it speeds up.
/// Vanishes as f -> infinity.
struct SpoolLag {
  double natural_frequency_Hz;
  double damping;
  double slew_V_s;
};

/// u(t - d); any fraction of a tick. Vanishes at 0.
struct DeadTime {
  double delay_s;
};

/// Rate-independent hysteresis after Bouc and Wen with n = 2, beta = gamma = 1/(2 z_max^2):
///   dz/du = 1 - (z/z_max)^2 (1 + sign(z du))/2,  x = u - z.  Exact along a monotone piece of u. (The catalogue has n = 1.)
/// Vanishes at z_max = 0.
struct BoucWen {
  double half_width_V;
};

/// A massless spool with friction after LuGre (Canudas de Wit and others 1995), driven by a spring:
///   tau x' = u - x - f z/z0,  z' = x' - |x'| z/(z0 g),  g = 1 + s exp(-(x'/v_s)^2).
/// f: Coulomb friction over spring rate, the half width [V]. Vanishes at f = 0 up to the lag tau of 0.1 ms.
struct LuGre {
  double half_width_V;
  double stribeck;  ///< s: excess of static over Coulomb friction
};

/// The null moves by delta(t): x = u + delta(t). Warm-up, ramp, and a wander of three slow tones.
/// Vanishes at size 0.
struct NullDrift {
  enum class Course { kWarmUp, kRamp, kWander } course;
  double size_V;
  double time_s;  ///< time constant; duration of the ramp; longest period
  std::array<double, 3> phase;
};

// ---- valve area

/// Opening o = X table(s) for s = max(x - U, 0)/X up to X volts, slope of the last piece beyond: a monotone
/// cubic (Fritsch and Carlson 1980) through values at s = 0, 1/6 .. 1. Vanishes at table(s) = s.
struct AreaShape {
  double reach_V;                ///< X
  std::array<double, 7> values;  ///< table(0) = 0 .. table(1), ascending
  std::array<double, 7> slopes;  ///< d table/d s at the same places
};
/// Fills the slopes.
AreaShape area_shape(double reach_V, const std::array<double, 7>& values);

// ---- mass flow

/// Another flow function:
/// discharge: the coefficient falls with the ratio r = p_d/p_u, C(r) = C (1 + rise (r_c - r)), r_c the critical
///            one (Perry 1949: sharp orifices rise beyond it). Vanishes at rise = 0.
/// ellipse:   choked flow times [1 - ((r - b)/(a - b))^2]^beta for b < r < a, none above a (ISO 6358), mixed
///            with the thin plate by `share`. Vanishes at share = 0.
struct FlowFunction {
  enum class Law { kDischarge, kEllipse } law;
  double rise;
  double share;
  double critical_ratio;  ///< b
  double cracking_ratio;  ///< a
  double subsonic_index;  ///< beta
};

/// Silencer behind the exhaust port: m' = G sqrt(p_e^2 - p_a^2), p_a ambient; either at once (manifold 0) or
/// through a manifold in which p_e' = kappa R T m'/V. Vanishes as G -> infinity.
struct Silencer {
  double conductance_kg_s_Pa;  ///< G
  double manifold_m3;          ///< V; 0: none
};

/// Leak to ambient: a laminar capillary m' = K (p^2 - p_a^2)/(2 p_a), and a sharp hole in parallel.
/// Vanishes at 0 and 0.
struct ChamberLeak {
  double capillary_kg_s_Pa;  ///< K
  double hole_m2;
};

/// Line between valve and chamber, in cells: p_i' = c^2/(A dx) (q_i-1 - q_i), c^2 = kappa R T,
/// q' = A/dx (p_i - p_i+1) - (32 nu/D^2 + f |q|/(2 rho A D)) q. Vanishes as length -> 0.
struct Tube {
  double length_m;
  double bore_m;
  double friction;  ///< f, turbulent
  std::size_t cells;
};

// ---- supply

/// Vessel behind the supply port, fed from the source through an orifice. Vanishes as either -> infinity.
struct Reservoir {
  double volume_m3;
  double feed_m2;
};
/// Regulator: tau p_s' = P - droop m' - p_s. Vanishes at droop 0.
struct Regulator {
  double droop_Pa_s_kg;
  double time_s;
};

// ---- energy

/// Heat between gas and wall, (kappa - 1)/v Q added to p', Q = H (T_w - T_g), H = H0 (p/p_a)^n v/v0,
/// T_g from the gas law with the mass in the chamber. Vanishes at H0 = 0.
struct WallHeat {
  double conductance_W_K;  ///< H0 at ambient pressure and mean volume
  double exponent;         ///< n
};

/// The chamber is larger than the log says by `offset`, and the potentiometer bends by a tenth of that.
/// Vanishes at 0.
struct VolumeError {
  double offset_m3;
};

/// The position sensor behind the volume column lags: the true volume is ahead by this time.
struct VolumeLag {
  double time_s;
};

// ---- sensor

/// p_s'' = w^2 (p - p_s) - 2 zeta w p_s', or of first order (zeta = 0 means that). Vanishes as tau = 1/w -> 0.
struct SensorLag {
  double time_s;
  double damping;  ///< 0: first order
};

/// reading = offset + gain p. Vanishes at 0 and 1.
struct SensorBias {
  double offset_Pa;
  double gain;
};

// ---- in no catalogue

/// A compressor's strokes: supply P (1 + size |sin| shaped) at some hertz, slowly modulated.
struct SupplyPulsation {
  double share;
  double frequency_Hz;
  double phase;
};

/// A flapper in the exhaust that sticks shut until the chamber is `break_Pa` above ambient, and falls shut below
/// `close_Pa`.
struct StickingFlapper {
  double break_Pa;
  double close_Pa;
};

/// A neighbour draws from the shared manifold: the supply falls by `drop_Pa` for `duty` of each period.
struct Neighbour {
  double drop_Pa;
  double period_s;
  double duty;
  double phase;
};

/// A stepper moves the spool in steps of `step_V`, at most one a millisecond, and loses a share of them until the
/// command next crosses the null, where it is referenced.
struct MissedSteps {
  double step_V;
  double missed;
  unsigned long long seed;
};

/// What the chamber moves vibrates, faster than the sensor behind the volume column follows.
struct VolumeTremor {
  double amplitude_m3;
  double frequency_Hz;
  double phase;
};

/// A seal that lifts now and then: a leak to ambient that is open for random stretches.
struct LiftingSeal {
  double area_m2;
  double period_s;
  double duty;
  unsigned long long seed;
};

/// All that may depart; absent: nominal.
struct Departures {
  std::optional<SpoolLag> spool_lag;
  std::optional<DeadTime> dead_time;
  std::optional<BoucWen> bouc_wen;
  std::optional<LuGre> lugre;
  std::optional<NullDrift> null_drift;
  std::optional<AreaShape> area_shape;
  std::optional<FlowFunction> flow_function;
  std::optional<Silencer> silencer;
  std::optional<ChamberLeak> chamber_leak;
  std::optional<Tube> tube;
  std::optional<Reservoir> reservoir;
  std::optional<Regulator> regulator;
  std::optional<WallHeat> wall_heat;
  std::optional<VolumeError> volume_error;
  std::optional<VolumeLag> volume_lag;
  std::optional<SensorLag> sensor_lag;
  std::optional<SensorBias> sensor_bias;
  std::optional<SupplyPulsation> supply_pulsation;
  std::optional<StickingFlapper> sticking_flapper;
  std::optional<Neighbour> neighbour;
  std::optional<MissedSteps> missed_steps;
  std::optional<VolumeTremor> volume_tremor;
  std::optional<LiftingSeal> lifting_seal;
};

/// What the sizes of a drawn departure are measured against.
struct Scale {
  double size;  ///< what is told in square metres, cubic metres or kilograms a second grows with it
  double supply_Pa;
  double ambient_Pa;
  double temperature_K;
  double volume_m3;      ///< mean
  bool moves;            ///< the volume
  double area_per_V_m2;  ///< mean of both ports
  double discharge_coefficient;
  double flow_kg_s_m2;  ///< choked flow from supply per area, coefficient included
};

struct Parameter {
  std::string name;  ///< with its unit
  double value;
};

/// One departure as drawn: what the label records.
struct Drawn {
  std::string id;
  std::string variant;
  std::vector<Parameter> parameters;
};

/// One kind of departure: how it is drawn (magnitude log-uniform) and taken away again.
struct DepartureKind {
  std::string_view id;        ///< of the contract, or of this room for what is in no catalogue
  std::string_view equation;  ///< where it acts, as in the contract
  bool catalogued;
  Drawn (*draw)(Random& random, const Scale& scale, Departures& into);
  void (*remove)(Departures& from);
};

/// Catalogued ones first, in the order of the contract.
const std::vector<DepartureKind>& departure_kinds();
/// Throws std::invalid_argument naming the id and what was expected.
const DepartureKind& departure_kind(std::string_view id);

}  // namespace plenum::host::blind
