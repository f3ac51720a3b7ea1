// What the demonstration finds out, from the rig to the tracked references; demo_report.hpp shows it.
#pragma once

#include <string>
#include <vector>

#include "host-sim/client/capture.hpp"
#include "host-sim/client/references.hpp"
#include "host-sim/identify/fit.hpp"
#include "host-sim/identify/free_run.hpp"
#include "host-sim/tools/demo_gap.hpp"
#include "host-sim/trace/log.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::tools {

struct DemoTracked {
  std::string name;  ///< of the reference
  client::ReferenceShape shape;
  std::vector<client::CapturedRow> rows;
  std::vector<client::Tracking> chamber;
};

struct DemoChamber {
  identify::Tassa9Fit excited;  ///< fitted to the excitation, used for the second recording
  identify::Tassa9Fit fit;      ///< fitted to the second recording, used for the rest
  trace::Log excitation;
  trace::Log held_out;            ///< in closed loop, another seed: no fit has seen it
  identify::Drift drift;          ///< on the held-out log
  double free_run_rms_kPa = 0.0;  ///< on the held-out log, over 2 s
};

struct Demo {
  trace::RigDescription rig;
  bool measured_valves =
      true;  ///< the plant's valves follow measured tables, which the model does not contain
  double span_Pa = 0.0;
  double record_s = 0.0;
  double volume_swing = 0.0;
  std::uint64_t seed = 0;
  std::vector<DemoChamber> chamber;
  std::vector<DemoTracked> tracked;
  double bus_load = 0.0;
  std::uint64_t bus_frames = 0;
  double simulated_s = 0.0;
  std::vector<DemoGap> gaps;  ///< the second half
};

}  // namespace plenum::host::tools
