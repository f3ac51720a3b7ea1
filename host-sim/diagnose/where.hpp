// Where the recalibrated model errs, before any cause is named: in which regime, at which pressure and command, and
// which mass flow it lacks.
#pragma once

#include <cstddef>
#include <vector>

#include "host-sim/diagnose/gap_report.hpp"
#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::diagnose {

using identify::chamber::Record;
using identify::chamber::Scene;
using identify::chamber::Score;

/// Rows [first, rows) of one log are judged; row 0, where a run begins, never is.
struct Scored {
  const Record* record = nullptr;
  std::size_t first = 0;
  std::vector<double> before_Pa;  ///< free run of the recalibrated model, as long as the record
  std::vector<double> after_Pa;   ///< the same with the effects named; may be empty
};

/// Whether the openings of the valve's two ports differ, and which is the wider.
enum class Port { shut, supply, exhaust };

/// What a chamber goes through at one row.
struct Regime {
  Port port = Port::shut;
  bool moving = false;         ///< the command moved within the last 60 ms
  bool reversed = false;       ///< ... and against its previous move
  bool opening = false;        ///< ... so that the open port is wider than before
  bool choked = false;         ///< flow through the open port
  bool high = false;           ///< pressure above the middle from ambient to supply
  bool volume_moving = false;  ///< by more than 2 % within half a second
  bool late = false;           ///< in the second half of the rows that are judged: of regimes() alone
  bool small = false;  ///< volume below the middle of those that the log has, where they are a tenth apart
};

/// Row by row. A row belongs to the tick that ends there: it sees the command of the row before it.
std::vector<Regime> regimes_of(const Scene& scene, const effects::Figures& valve, const effects::Drive& drive,
                               const std::vector<double>& pressure_Pa);

/// Shares of the squared error of before_Pa, largest first: regimes are disjoint and their shares sum to 1. They are
/// at most eight, and none below 1 %: a cut is made where the error departs most from the time spent, and be it by time, between the
/// first half of the rows of each log and the second. Regimes below
/// 1 % are gathered as "elsewhere", or left out where even that stays below. Empty where there is no error.
std::vector<RegimeShare> regimes(const Scene& scene, const effects::Figures& recalibrated,
                                 const std::vector<Scored>& scored);

/// RMS errors over eight pressure ratios and ten commands. Cells of fewer than five rows are NaN; so is closed_Pa
/// where after_Pa is missing.
ErrorMap error_map(const Scene& scene, const std::vector<Scored>& scored);

/// The mass flow that, added to the chamber of the recalibrated model, would make it follow the measured pressure,
///   d = (p v)'/(kappa R T) + (1 - 1/kappa) p v'/(R T) - a_c phi(P, p) + a_r phi(p, Q),          from (4)
/// smoothed over +-0.1 s [kg/s]; as long as the record, positive into the chamber. It is what is missing whatever the
/// equation: a sensor that lags shows as a flow, too.
std::vector<double> disturbance_kg_s(const Scene& scene, const Record& record,
                                     const effects::Figures& recalibrated);

}  // namespace plenum::host::diagnose
