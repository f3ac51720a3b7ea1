// One command of the program: its arguments are declared by add_NAME(), its work is done by `run`.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

namespace plenum::host::tools {

/// Exit codes of every command.
inline constexpr int kDone = 0;
inline constexpr int kFailure = 1;     ///< it ran, and the answer is a failure
inline constexpr int kBadInput = 2;    ///< bad usage or bad input
inline constexpr int kImpossible = 3;  ///< the computation could not be done

struct Command {
  CLI::App* app;
  std::function<int()> run;  ///< returns the exit code; throws as main.cpp maps it
};

/// A command `name` of `of`, which `about` tells. Commands call this and not add_subcommand(): that brings the whole of
/// CLI11, its help and configuration files too, into each source that calls it.
CLI::App* subcommand(CLI::App& of, const std::string& name, const std::string& about);

Command add_sim(CLI::App& program);
Command add_capture(CLI::App& program);
Command add_identify(CLI::App& program);
Command add_orifice(CLI::App& program);
Command add_diagnose(CLI::App& program);
Command add_effects(CLI::App& program);
Command add_upload(CLI::App& program);
Command add_download(CLI::App& program);
Command add_regulate(CLI::App& program);
Command add_scan(CLI::App& program);
Command add_info(CLI::App& program);
Command add_faults(CLI::App& program);
Command add_reset(CLI::App& program);
Command add_diff(CLI::App& program);
Command add_backup(CLI::App& program);
Command add_restore(CLI::App& program);
Command add_monitor(CLI::App& program);
Command add_record(CLI::App& program);
Command add_decode(CLI::App& program);
Command add_demo(CLI::App& program);
Command add_blind(CLI::App& program);
Command add_reproduce(CLI::App& program);
Command add_acceptance(CLI::App& program);
Command add_calibrate(CLI::App& program);

}  // namespace plenum::host::tools
