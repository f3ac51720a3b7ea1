// What `plenum acceptance` measures of a board, over the bus.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host-sim/client/acceptance.hpp"
#include "host-sim/client/capture.hpp"
#include "host-sim/tools/metered_link.hpp"

namespace plenum::host::tools {

struct AcceptancePlan {
  double seconds = 30.0;  ///< of listening at rest
  unsigned chambers = 8;
  std::uint32_t bit_rate = 1'000'000;            ///< [bit/s] of the bus
  std::optional<client::CaptureOptions> motion;  ///< how the valves are excited; empty: they are not
  client::Stopped stopped = {};
};

struct AcceptanceRun {
  client::LoopLatency loop;
  std::uint32_t overruns = 0;
  double tick_rate_Hz = 0.0;
  std::size_t rows = 0;       ///< that came whole
  std::size_t rows_lost = 0;  ///< ticks of which some chambers came, or nothing
  double can_load = 0.0;      ///< share of the time that the bus was busy while streaming
  double sdo_median_ms = 0.0;
  double sdo_p99_ms = 0.0;
  std::vector<std::vector<double>> rest_Pa;   ///< per chamber, at rest
  std::vector<client::Reading> reading;       ///< per chamber, its pressure [Pa]
  std::vector<client::Reading> position;      ///< per chamber, its position sensor [V]
  std::vector<double> volume_gain_mL_per_V;   ///< per chamber
  std::optional<client::Reading> supply;      ///< [Pa]; empty: the board watches none
  std::vector<std::string> stuck;             ///< inputs of chambers in use of which not a bit has changed
  bool pressure_stuck = false;                ///< one of them is a pressure
  std::string not_moved;                      ///< why no valve was moved; empty: they were
  std::optional<client::LoopLatency> moving;  ///< the loop meanwhile
  std::uint32_t moving_overruns = 0;
  std::string moving_fault;                ///< what ended the motion early; empty: nothing
  std::vector<client::CapturedRow> moved;  ///< empty without motion
  std::vector<client::Answer> answer;      ///< per chamber; empty without motion
};

/// Listens to a board at rest, then moves its valves if the plan says so and no pressure is stuck, for nothing would guard a chamber
/// whose sensor stands still. Gives back the settings that it borrows, also when it
/// fails; leaves the node operational and the board as it was, or DISABLED after motion. Throws as Session and
/// client::capture() do; Refused for a board that regulates, std::runtime_error when stopped before its end.
AcceptanceRun run_acceptance(MeteredLink& link, client::Session& session, const AcceptancePlan& plan,
                             const client::Progress& progress);

/// Noise of a chamber's position sensor as that of its volume.
double volume_noise_mL(const AcceptanceRun& run, std::size_t chamber);

/// Each criterion's value.
std::vector<client::Measured> measured_by(const AcceptanceRun& run);

}  // namespace plenum::host::tools
