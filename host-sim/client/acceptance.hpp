// Is this board, on its user's own hardware, fit for its task? Statistics of what was measured over the bus, and the verdict
// on each of them. Measuring is the caller's part.
//
//   loop       2201h before and after a while: how late the ticks between them began
//   readings   the stream while no valve moves: how much a channel scatters, whether it ever changes, and the step of its
//              converter if that shows
//   answers    the stream while the board excites its valves: which valve does a pressure follow, and which way
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/client/board_facts.hpp"

namespace plenum::host::client {

// ---- statistics ----

/// Bounds, as the bins of 2201h have them: each is at most a quarter above the true figure.
struct LoopLatency {
  std::uint64_t ticks = 0;
  double p999_us = 0.0;         ///< 999 of 1000 ticks began no later
  double max_us = 0.0;          ///< none began later
  double jitter_us = 0.0;       ///< from the median to p999_us
  std::vector<LatencyBin> bin;  ///< those ticks, bin by bin
};

/// Of the ticks between two readings of 2201h. `max_us`: 2200h:3 as it was after them. Throws ProtocolError when there is no
/// tick between them, or less than none: the board has started anew.
LoopLatency latency_between(std::span<const LatencyBin> before, std::span<const LatencyBin> after,
                            std::uint32_t max_us);

/// Of a channel; in the unit of its samples.
struct Reading {
  double mean = 0.0;
  double std = 0.0;  ///< of the samples, drift included
  /// White noise of a sample, blind to drift: a sixth of the mean square of second differences (Gasser, Sroka and
  /// Jennen-Steinmetz, Biometrika 73 (1986), 625-633), the median over windows of a second, so that a moment of motion
  /// does not count; its root.
  double noise = 0.0;
  /// Of which all differences are whole multiples; empty when the samples do not show it.
  std::optional<double> step;
  bool changed = true;  ///< false: every sample is the same to the last bit
};

/// Of at least three samples, otherwise std::invalid_argument; NaN in, NaN out.
Reading reading_of(std::span<const double> samples);

/// How a pressure follows the valves: the correlation of its change in a tick with a valve's command some ticks before, where
/// that is largest in magnitude. 1: a rising command feeds it, -1: empties it, 0: no answer.
struct Answer {
  double own = 0.0;               ///< to its own valve
  std::size_t best = 0;           ///< the valve, from 0, that it follows most
  double best_correlation = 0.0;  ///< to that one
  /// It stayed beyond its limits for a second and came no nearer to them, its own valve turned against it all the while.
  bool escapes = false;
};

/// Within which the board keeps the pressures while it excites the valves; the commands' mean tells which way one is turned.
struct MotionLimits {
  double pressure_low_Pa;
  double pressure_high_Pa;
  double command_mean_V;
};

/// One a chamber. `pressure_Pa[c]` and `command_V[c]`: chamber c, tick by tick, all of one length; pressures are means over the
/// tick before, commands are held from then on.
std::vector<Answer> answers_of(std::span<const std::vector<double>> pressure_Pa,
                               std::span<const std::vector<double>> command_V, const MotionLimits& limits);

/// Below this a correlation counts as none: noise alone stays below a quarter over thirty seconds.
inline constexpr double kAnswers = 0.25;
/// From here on it names another valve: of seven others one may come near a quarter by chance.
inline constexpr double kFollows = 0.4;

/// "follows valve 3: tubes or wires are swapped", "goes the wrong way", "stays beyond its limits ...", "does not answer"; empty for one that
/// does right. Where two are swapped, each guard turns the other's valve: within a second both chambers are at a pressure's end, and what
/// correlation was left may be chance.
std::string trouble_of(const Answer& answer, std::size_t chamber);

// ---- verdict ----

/// What was measured; empty where nothing was. Per cent, microseconds and so on as the names of the criteria say.
struct Measured {
  std::string id;  ///< of a criterion
  std::optional<double> value;
  std::string remark;
};

struct Criterion {
  std::string_view id;
  std::string_view text;
  std::string_view unit;
  double limit;  ///< the value shall be at most this
};

/// In the order in which they are told; README.md of host-sim/tools explains them.
std::span<const Criterion> acceptance_criteria();

enum class Verdict { pass, fail, not_run };
const char* verdict_name(Verdict verdict);

struct Judged {
  Criterion criterion;
  std::optional<double> value;
  std::string remark;
  Verdict verdict = Verdict::not_run;
};

/// One a criterion, in their order; `limits`: "id=value", in the place of the criteria's own. What is not finite fails. Throws
/// std::invalid_argument for a limit that is none.
std::vector<Judged> judge(std::span<const Measured> measured, std::span<const std::string> limits);

/// Nothing has failed.
bool accepted(std::span<const Judged> judged);

}  // namespace plenum::host::client
