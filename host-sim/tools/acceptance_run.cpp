#include "host-sim/tools/acceptance_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "host-sim/client/borrowed_stream.hpp"

namespace plenum::host::tools {
namespace {

namespace object = canopen::object;

constexpr double kTickRate_Hz = 100.0;
constexpr unsigned kRoundTrips = 300;
constexpr double kSilence_s = 0.5;       ///< without a row of the stream: the board or the bus is gone
constexpr std::size_t kSupplyRows = 10;  ///< from one reading of the supply to the next
constexpr std::uint8_t kVolumeGain = 5;  ///< of kChamberSettings
constexpr std::uint32_t kCutTicks = 2;   ///< whose rows were on their way when the ticks were read

/// Ticks and overruns, and the time of the link when they were so.
struct Counted {
  std::uint32_t ticks;
  double time_s;
  std::uint32_t overruns;
  std::vector<client::LatencyBin> latency;
};

std::uint32_t ticks_of(client::Session& session) {
  return session.read<std::uint32_t>(object::kHealth, 1);
}

Counted count(client::Session& session) {
  const std::uint32_t ticks = ticks_of(session);
  const double time_s = session.link().now_s();
  const auto overruns = session.read<std::uint32_t>(object::kHealth, 2);
  return {ticks, time_s, overruns, client::read_latency(session)};
}

client::LoopLatency loop_between(client::Session& session, const Counted& before, const Counted& after) {
  return client::latency_between(before.latency, after.latency,
                                 session.read<std::uint32_t>(object::kHealth, 3));
}

void require_not_stopped(const AcceptancePlan& plan) {
  if (plan.stopped && plan.stopped())
    throw std::runtime_error(
        "stopped by hand before all was measured: nothing is judged, expected a run to its end");
}

/// What is at the inputs, from here to the end of the rest.
struct Inputs {
  std::vector<std::vector<double>> position_V;  ///< per chamber
  std::vector<double> supply_Pa;
};

void read_inputs(client::Session& session, const Inputs& inputs, AcceptanceRun& run) {
  const auto judge = [&](const std::string& name, std::span<const double> samples, bool in_use) {
    const client::Reading reading = client::reading_of(samples);
    if (in_use && !reading.changed) run.stuck.push_back(name);
    return reading;
  };
  for (std::size_t c = 0; c < run.rest_Pa.size(); ++c) {
    const bool in_use = client::is_in_use(session, c);
    run.reading.push_back(judge(fmt::format("pressure {}", c + 1), run.rest_Pa[c], in_use));
    run.pressure_stuck = run.pressure_stuck || (in_use && !run.reading.back().changed);
    run.position.push_back(judge(fmt::format("position {}", c + 1), inputs.position_V[c], in_use));
    run.volume_gain_mL_per_V.push_back(
        static_cast<double>(session.read<float>(object::nth(object::kChamberSettings, c), kVolumeGain)));
  }
  if (!inputs.supply_Pa.empty()) run.supply = judge("supply", inputs.supply_Pa, true);
}

/// Takes the stream's rows for a while. A tick that is lost whole leaves no trace in the stream: the board's count tells.
void listen_at_rest(MeteredLink& link, client::Session& session, const client::Stream& streamed,
                    const AcceptancePlan& plan, AcceptanceRun& run, const client::Progress& progress) {
  client::Stream stream = streamed;
  const auto whole = static_cast<std::uint8_t>((1U << plan.chambers) - 1U);
  run.rest_Pa.resize(plan.chambers);
  Inputs inputs{.position_V = std::vector<std::vector<double>>(plan.chambers), .supply_Pa = {}};
  const bool supply_watched = client::watches_supply(session);
  std::size_t seen = 0;
  const client::Subscription subscription(session, [&](const client::Arrival& arrival) {
    stream.accept(arrival.time_s, arrival.frame, [&](const client::StreamRow& row) {
      ++seen;
      if (row.chambers != whole) {
        ++run.rows_lost;
        return;
      }
      ++run.rows;
      for (std::size_t c = 0; c < plan.chambers; ++c) {
        run.rest_Pa[c].push_back(row.sample[c].actual_Pa);
        inputs.position_V[c].push_back(row.sample[c].position_V);
      }
    });
  });
  const std::uint32_t ticks_before = ticks_of(session);
  const std::size_t rows_before = run.rows;
  const double begin_s = link.now_s();
  const std::uint64_t busy_before = link.busy_bits();
  double told_s = begin_s;
  std::size_t supply_due = 0;
  while (link.now_s() < begin_s + plan.seconds) {
    require_not_stopped(plan);
    const std::size_t before = seen;
    if (!session.listen_until([&] { return seen != before; }, kSilence_s)) {
      throw client::Timeout(fmt::format("node {}: no row of the stream came for {} s, expected one each {} s",
                                        session.node_id(), kSilence_s, 1.0 / kTickRate_Hz));
    }
    if (supply_watched && seen >= supply_due) {
      supply_due = seen + kSupplyRows;
      inputs.supply_Pa.push_back(static_cast<double>(session.read<float>(object::kSupply, 0)));
    }
    if (link.now_s() < told_s) continue;
    told_s = link.now_s() + 1.0;
    progress((link.now_s() - begin_s) / plan.seconds);
  }
  run.can_load =
      static_cast<double>(link.busy_bits() - busy_before) / (plan.bit_rate * (link.now_s() - begin_s));
  const std::uint32_t ticks = ticks_of(session) - ticks_before;
  const std::size_t accounted = run.rows - rows_before + run.rows_lost;
  if (ticks > accounted + kCutTicks) run.rows_lost += ticks - accounted;
  read_inputs(session, inputs, run);
}

/// Asks for one object again and again, while the stream goes on.
void time_round_trips(client::Session& session, AcceptanceRun& run) {
  std::vector<double> took_ms;
  while (took_ms.size() < kRoundTrips) {
    const double begin_s = session.link().now_s();
    session.read<std::uint32_t>(object::kDeviceTypeIndex, 0);
    took_ms.push_back(1e3 * (session.link().now_s() - begin_s));
  }
  std::sort(took_ms.begin(), took_ms.end());
  run.sdo_median_ms = took_ms[kRoundTrips / 2];
  run.sdo_p99_ms = took_ms[kRoundTrips * 99 / 100];
}

void move(client::Session& session, const AcceptancePlan& plan, AcceptanceRun& run,
          const client::Progress& progress) {
  client::CaptureOptions motion = *plan.motion;
  motion.stopped = plan.stopped;
  const Counted before = count(session);
  try {
    run.moved = client::capture(session, motion, progress);
  } catch (const client::Refused& fault) {
    run.moving_fault = fault.what();
  }
  require_not_stopped(plan);
  const Counted after = count(session);
  run.moving = loop_between(session, before, after);
  run.moving_overruns = after.overruns - before.overruns;
  if (run.moved.empty()) return;
  std::vector<std::vector<double>> pressure_Pa(plan.chambers);
  std::vector<std::vector<double>> command_V(plan.chambers);
  for (const client::CapturedRow& row : run.moved) {
    for (std::size_t c = 0; c < plan.chambers; ++c) {
      pressure_Pa[c].push_back(row.sample[c].actual_Pa);
      command_V[c].push_back(row.sample[c].command_V);
    }
  }
  run.answer = client::answers_of(
      pressure_Pa, command_V,
      {.pressure_low_Pa = motion.pressure_low_Pa,
       .pressure_high_Pa = motion.pressure_high_Pa,
       .command_mean_V = 0.5 * static_cast<double>(motion.command_low_V + motion.command_high_V)});
}

/// The largest of a figure a chamber, and whose it is. What is not a number is the largest.
client::Measured worst(const char* id, std::span<const double> figures) {
  std::size_t worst = 0;
  for (std::size_t c = 0; c < figures.size(); ++c) {
    if (!(figures[c] <= figures[worst])) worst = c;
    if (std::isnan(figures[worst])) break;
  }
  return {id, figures[worst], fmt::format("chamber {}", worst + 1)};
}

client::Measured noise_measured(const AcceptanceRun& run) {
  std::vector<double> noise_Pa;
  for (const client::Reading& reading : run.reading) noise_Pa.push_back(reading.noise);
  return worst("noise_Pa", noise_Pa);
}

client::Measured volume_noise_measured(const AcceptanceRun& run) {
  std::vector<double> noise_mL;
  for (std::size_t c = 0; c < run.position.size(); ++c) noise_mL.push_back(volume_noise_mL(run, c));
  return worst("volume_noise_mL", noise_mL);
}

client::Measured supply_noise_measured(const AcceptanceRun& run) {
  if (!run.supply) return {"supply_noise_Pa", std::nullopt, "the board watches none: supply_low_kPa is 0"};
  return {"supply_noise_Pa", run.supply->noise, fmt::format("mean {:.1f} kPa", 1e-3 * run.supply->mean)};
}

client::Measured stuck_measured(const AcceptanceRun& run) {
  return {"stuck_channels", static_cast<double>(run.stuck.size()),
          run.stuck.empty()
              ? ""
              : fmt::format("{}: look at sensor, wire and converter", fmt::join(run.stuck, ", "))};
}

client::Measured answer_measured(const AcceptanceRun& run) {
  if (!run.not_moved.empty()) return {"chambers_amiss", std::nullopt, run.not_moved};
  if (!run.moving_fault.empty())
    return {"chambers_amiss", static_cast<double>(run.reading.size()), run.moving_fault};
  std::vector<std::string> troubles;
  for (std::size_t c = 0; c < run.answer.size(); ++c) {
    const std::string trouble = client::trouble_of(run.answer[c], c);
    if (!trouble.empty()) troubles.push_back(fmt::format("chamber {} {}", c + 1, trouble));
  }
  return {"chambers_amiss", static_cast<double>(troubles.size()),
          fmt::format("{}", fmt::join(troubles, "; "))};
}

}  // namespace

AcceptanceRun run_acceptance(MeteredLink& link, client::Session& session, const AcceptancePlan& plan,
                             const client::Progress& progress) {
  client::require_at_rest(session, "noise is told from motion only while no valve moves");
  client::require_no_stream(session);
  if (plan.motion) client::require_none_left_out(session, plan.chambers);
  AcceptanceRun run;
  session.nmt(canopen::NmtCommand::enter_pre_operational);
  {
    client::BorrowedStream borrowed(
        session, {.chambers = static_cast<std::uint8_t>((1U << plan.chambers) - 1U), .position = true});
    session.nmt(canopen::NmtCommand::start);
    const Counted before = count(session);
    listen_at_rest(link, session, borrowed.stream(), plan, run, progress);
    time_round_trips(session, run);
    const Counted after = count(session);
    run.loop = loop_between(session, before, after);
    run.overruns = after.overruns - before.overruns;
    run.tick_rate_Hz = (after.ticks - before.ticks) / (after.time_s - before.time_s);
    borrowed.give_back();
  }
  if (!plan.motion) {
    run.not_moved = "no valve was moved: --move";
  } else if (run.pressure_stuck) {
    run.not_moved = "no valve was moved: a pressure is stuck, and would guard no chamber";
  } else {
    move(session, plan, run, progress);
  }
  return run;
}

double volume_noise_mL(const AcceptanceRun& run, std::size_t chamber) {
  return std::abs(run.volume_gain_mL_per_V[chamber]) * run.position[chamber].noise;
}

std::vector<client::Measured> measured_by(const AcceptanceRun& run) {
  const auto moving = [&run](const char* id, double value) {
    return client::Measured{id, run.moving ? std::optional(value) : std::nullopt, run.not_moved};
  };
  const client::LoopLatency loop = run.moving.value_or(client::LoopLatency{});
  return {{"latency_p999_us", run.loop.p999_us, fmt::format("{} ticks", run.loop.ticks)},
          {"latency_max_us", run.loop.max_us, ""},
          {"jitter_us", run.loop.jitter_us, ""},
          {"overruns", run.overruns, ""},
          {"tick_rate_error_percent", 100.0 * std::abs(run.tick_rate_Hz / kTickRate_Hz - 1.0),
           fmt::format("{:.3f} Hz by the clock of this PC", run.tick_rate_Hz)},
          {"rows_lost", static_cast<double>(run.rows_lost), fmt::format("{} came whole", run.rows)},
          {"sdo_p99_ms", run.sdo_p99_ms,
           fmt::format("half of {} within {:.2f} ms", kRoundTrips, run.sdo_median_ms)},
          {"can_load_percent", 100.0 * run.can_load, ""},
          stuck_measured(run),
          noise_measured(run),
          volume_noise_measured(run),
          supply_noise_measured(run),
          moving("moving_latency_p999_us", loop.p999_us),
          moving("moving_jitter_us", loop.jitter_us),
          moving("moving_overruns", run.moving_overruns),
          answer_measured(run)};
}

}  // namespace plenum::host::tools
