// One command of the program: its arguments are declared by add_NAME(), its work is done by `run`.
#pragma once

#include <functional>

#include "host-sim/tools/command_line.hpp"

namespace plenum::host::tools {

/// Exit codes of every command.
inline constexpr int kDone = 0;
inline constexpr int kFailure = 1;     ///< it ran, and the answer is a failure
inline constexpr int kBadInput = 2;    ///< bad usage or bad input
inline constexpr int kImpossible = 3;  ///< the computation could not be done

struct Command {
  Arguments arguments;
  std::function<int()> run;  ///< returns the exit code; throws as main.cpp maps it
};

Command add_sim(Program& program);
Command add_capture(Program& program);
Command add_identify(Program& program);
Command add_orifice(Program& program);
Command add_regulator(Program& program);
Command add_relief(Program& program);
Command add_friction(Program& program);
Command add_cylinder(Program& program);
Command add_flow(Program& program);
Command add_narx(Program& program);
Command add_diagnose(Program& program);
Command add_effects(Program& program);
Command add_upload(Program& program);
Command add_download(Program& program);
Command add_regulate(Program& program);
Command add_scan(Program& program);
Command add_info(Program& program);
Command add_lss(Program& program);
Command add_describe(Program& program);
Command add_faults(Program& program);
Command add_nmt(Program& program);
Command add_reset(Program& program);
Command add_diff(Program& program);
Command add_backup(Program& program);
Command add_restore(Program& program);
Command add_monitor(Program& program);
Command add_record(Program& program);
Command add_decode(Program& program);
Command add_demo(Program& program);
Command add_blind(Program& program);
Command add_reproduce(Program& program);
Command add_acceptance(Program& program);
Command add_calibrate(Program& program);

}  // namespace plenum::host::tools
