// The second half of the demonstration: machines, each with an effect missing from its data sheet.
//
// Each machine is a chamber behind a thin-plate valve with the figures of one data sheet, and one effect of the catalogue. The
// board excites it; `diagnose` gets the recording and the data sheet, not the effect; what it finds goes to the board as a
// grey-box model. The board follows one reference twice, with the data sheet's model and with the one found, each time on the machine
// switched on anew: its volume then moves alike.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "host-sim/diagnose/gap_report.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::tools {

/// How the chamber followed: true pressure less reference.
struct GapTracked {
  std::vector<double> error_Pa;  ///< at each tick
  double rms_Pa = 0.0;           ///< without the onset
};

struct DemoGap {
  std::string effect;                     ///< what the machine has, an id of the catalogue
  std::map<std::string, double> figures;  ///< of the effect, by the names of its parameters
  diagnose::GapReport report;
  bool uploaded = false;  ///< the board took the model found
  std::string refusal;    ///< why not
  GapTracked before;      ///< with the data sheet's model
  GapTracked after;       ///< with the model found, or with the one that stayed
};

/// What the diagnosis names first, "nothing" where it names none.
std::string named_by(const DemoGap& gap);

/// All machines, one for each effect that a board answers by its model, or by the calibration of its sensors; `seed` of their sensors and excitation.
std::vector<DemoGap> close_gaps(const trace::RigDescription& sheet, std::uint32_t seed,
                                const std::function<void(double done)>& progress);

}  // namespace plenum::host::tools
