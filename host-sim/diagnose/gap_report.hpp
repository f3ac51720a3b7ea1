// What a diagnosis answers: the gap, where it lies, which effects cause it, how far each closes it.
//
// All errors are RMS of the free run, in Pa, on held-out rows: the model starts from the first row and is fed
// with the measured command and volume only. A report is a value; gap_json.hpp writes it as plenum-gap/1.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::diagnose {

enum class Verdict {
  none,              ///< no gap beyond noise as configured
  calibration,       ///< recalibration alone closes it
  explained,         ///< the effects named close it
  partly_explained,  ///< a significant effect, and a significant rest; rivals of the effect are listed, too
  ambiguous,         ///< two causes close it alike: all of them are listed
  unexplained,       ///< a significant gap that no catalogued effect closes
};

/// "none", "calibration", ... as in the file.
const char* name_of(Verdict verdict);

struct Estimate {
  std::string name;  ///< with its unit: natural_frequency_Hz
  double value = 0.0;
  double low95 = 0.0;
  double high95 = 0.0;
  bool at_bound = false;

  /// By the logs' lengths, not found.
  bool is_given() const { return low95 == high95; }
};

/// A figure of the rig's [valve] table: as configured, as fitted without any effect, and as fitted together with
/// the effects of the model that with_effects_Pa is the error of, which a rig with these effects has.
struct CalibratedFigure {
  std::string name;  ///< open_above_V, ...
  double configured = 0.0;
  Estimate fitted;
  double with_effects = std::numeric_limits<double>::quiet_NaN();  ///< not known: NaN
};

struct NamedEffect {
  std::string id;
  double confidence = 0.0;  ///< probability that this effect is present
  double gap_without_Pa = 0.0;
  double gap_with_Pa = 0.0;
  double share = 0.0;  ///< of the squared error closed, whatever the order of adding; the shares sum to 1
  std::vector<Estimate> parameters;
  std::vector<std::string> aliases;  ///< effects that this log cannot tell from this one
};

struct Candidate {
  std::string id;
  double heldout_Pa = 0.0;
  double confidence = 0.0;  ///< probability that it is the cause, if one alone is
  std::vector<Estimate> parameters;
};

struct Blame {
  std::string equation;  ///< command, valve_area, mass_flow, supply, energy, sensor
  double confidence = 0.0;
};

/// What an equation would have to err by, if it alone erred, for the readings to follow: found before any cause is named.
struct Disturbance {
  std::string equation;
  double probability = 0.0;  ///< that this equation errs, from the readings alone
  double size = 0.0;         ///< RMS [unit]
  std::string unit;          ///< V, kg/s, Pa, 1/s; empty for a share of the areas
  std::string depends_on;    ///< "the command before"; "time" where it depends on nothing that was tried
  double dependence = 0.0;   ///< share of its mean square that does
  std::vector<std::vector<double>> smoothed{};  ///< a fitted log, a tick [unit]
};

struct RegimeShare {
  std::string regime;  ///< "command moving, supply port open"
  double share = 0.0;  ///< of the squared error of the recalibrated model
};

struct NextExperiment {
  std::string excitation;              ///< id in the library of safe inputs
  std::string why;                     ///< one sentence for a person
  std::vector<std::string> separates;  ///< the effects it parts
  double power = 0.0;  ///< probability that the true one of two is then named alone, in the mean of all pairs
  std::string instruction;  ///< what to do, with the range of the command
};

/// One log as the page shows it: held-out rows are those from `heldout_from` on.
struct Trace {
  std::string name;
  std::size_t heldout_from = 0;
  std::vector<double> time_s;
  std::vector<double> command_V;
  std::vector<double> measured_Pa;
  std::vector<double> as_configured_Pa;
  std::vector<double> recalibrated_Pa;
  std::vector<double> with_effects_Pa;
  /// The flow that, added to the chamber, would make the recalibrated model follow the measurement, smoothed
  /// [kg/s].
  std::vector<double> disturbance_kg_s;
};

/// RMS error of the recalibrated model by cell; a cell without rows is NaN.
struct ErrorMap {
  std::vector<double> pressure_ratio;          ///< centres of the rows: (p - ambient)/(supply - ambient)
  std::vector<double> command_V;               ///< centres of the columns
  std::vector<std::vector<double>> rms_Pa;     ///< [pressure_ratio][command], before
  std::vector<std::vector<double>> closed_Pa;  ///< the same with the effects named
};

/// The least size of an effect that this log could have shown beside the set that fits best (5 % false alarms, 95 % power).
struct Detectable {
  std::string id;
  std::string parameter;
  double smallest = 0.0;  ///< not a number: no size that the effect can have
};

/// What was found on the logs from before, where there were any: the machine as it was.
struct Baseline {
  Verdict verdict = Verdict::none;
  double as_configured_Pa = 0.0;
  double with_effects_Pa = 0.0;
  std::vector<NamedEffect> effects;  ///< in the model of what came after, with the valve as fitted
};

struct GapReport {
  double as_configured_Pa = 0.0;
  double recalibrated_Pa = 0.0;
  double with_effects_Pa = 0.0;
  double noise_floor_Pa = 0.0;  ///< with a baseline at least what the model leaves of it
  double closed_fraction =
      0.0;  ///< (recalibrated - with_effects) / (recalibrated - noise_floor), 0 if nothing
  Verdict verdict = Verdict::none;
  std::vector<NamedEffect> effects;   ///< in order of their share
  std::vector<Candidate> candidates;  ///< every effect tried alone, best first
  std::optional<Blame> equation;      ///< none where there is no gap
  std::vector<Disturbance>
      disturbances;  ///< of each equation alone, most probable first; none where there is no gap
  std::vector<RegimeShare> where;      ///< largest first
  std::optional<NextExperiment> next;  ///< where rivals are listed, or nothing is named
  std::vector<CalibratedFigure> calibration;
  double gap_p_value = 1.0;  ///< of the recalibrated model's error, were it noise alone; 0.001 at least
  std::vector<Trace> traces;
  ErrorMap map;
  /// The pressures of a row are those of so much later than it says, as far as that shows; part of the calibration.
  double stamped_early_s = 0.0;
  std::vector<Detectable> detectable;
  std::vector<std::vector<std::string>> alias_classes;  ///< of two and more, from the excitation alone
  std::optional<Baseline> baseline;
  trace::RigDescription
      found;  ///< the rig with the valve as fitted and every effect found, the baseline's among them
};

}  // namespace plenum::host::diagnose
