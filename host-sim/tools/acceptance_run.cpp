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
constexpr double kSilence_s = 0.5;  ///< without a row of the stream: the board or the bus is gone
constexpr double kLargestVolume_m3 = 3e-3;
constexpr std::uint32_t kCutTicks = 2;  ///< whose rows were on their way when the ticks were read

void require_at_rest(client::Session& session) {
  const std::uint16_t status = session.status_word();
  if (!client::is_regulating(status)) return;
  const auto fault = client::read_fault(session);
  throw client::Refused(fmt::format(
      "node {}: is in {}, expected a board at rest: noise is told from motion only while no valve moves",
      session.node_id(), client::state_name(status, fault ? fault->code : std::uint16_t{0})));
}

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

void require_not_stopped(const AcceptancePlan& plan) {
  if (plan.stopped && plan.stopped())
    throw std::runtime_error(
        "stopped by hand before all was measured: nothing is judged, expected a run to its end");
}

/// Takes the stream's rows for a while. A tick that is lost whole leaves no trace in the stream: the board's count tells.
void listen_at_rest(MeteredLink& link, client::Session& session, const client::Stream& streamed,
                    const AcceptancePlan& plan, AcceptanceRun& run, const client::Progress& progress) {
  client::Stream stream = streamed;
  const auto whole = static_cast<std::uint8_t>((1U << plan.chambers) - 1U);
  run.rest_Pa.resize(plan.chambers);
  std::size_t seen = 0;
  const client::Subscription subscription(session, [&](const client::Arrival& arrival) {
    stream.accept(arrival.time_s, arrival.frame, [&](const client::StreamRow& row) {
      ++seen;
      if (row.chambers != whole) {
        ++run.rows_lost;
        return;
      }
      ++run.rows;
      for (std::size_t c = 0; c < plan.chambers; ++c) run.rest_Pa[c].push_back(row.sample[c].actual_Pa);
    });
  });
  const std::uint32_t ticks_before = ticks_of(session);
  const std::size_t rows_before = run.rows;
  const double begin_s = link.now_s();
  const std::uint64_t busy_before = link.busy_bits();
  double told_s = begin_s;
  while (link.now_s() < begin_s + plan.seconds) {
    require_not_stopped(plan);
    const std::size_t before = seen;
    if (!session.listen_until([&] { return seen != before; }, kSilence_s)) {
      throw client::Timeout(fmt::format("node {}: no row of the stream came for {} s, expected one each {} s",
                                        session.node_id(), kSilence_s, 1.0 / kTickRate_Hz));
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
  for (const std::vector<double>& pressure_Pa : run.rest_Pa)
    run.reading.push_back(client::reading_of(pressure_Pa));
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
  run.moved = client::capture(session, motion, progress);
  require_not_stopped(plan);
  std::vector<std::vector<double>> pressure_Pa(plan.chambers);
  std::vector<std::vector<double>> command_V(plan.chambers);
  for (const client::CapturedRow& row : run.moved) {
    for (std::size_t c = 0; c < plan.chambers; ++c) {
      pressure_Pa[c].push_back(row.sample[c].actual_Pa);
      command_V[c].push_back(row.sample[c].command_V);
    }
  }
  run.answer = client::answers_of(pressure_Pa, command_V);
}

std::string noise_remark(const AcceptanceRun& run, std::size_t worst) {
  std::string remark = fmt::format("chamber {}", worst + 1);
  for (std::size_t c = 0; c < run.reading.size(); ++c) {
    if (!run.reading[c].changed)
      remark += fmt::format("; chamber {} never changed: stuck, or noise below its step", c + 1);
  }
  return remark;
}

client::Measured noise_measured(const AcceptanceRun& run) {
  std::size_t worst = 0;
  for (std::size_t c = 0; c < run.reading.size(); ++c) {
    // Written so that what is not a number is the worst.
    if (!(run.reading[c].noise_Pa <= run.reading[worst].noise_Pa)) worst = c;
    if (std::isnan(run.reading[worst].noise_Pa)) break;
  }
  return {"noise_Pa", run.reading[worst].noise_Pa, noise_remark(run, worst)};
}

client::Measured answer_measured(const AcceptanceRun& run) {
  if (run.answer.empty()) return {"chambers_amiss", std::nullopt, "no valve was moved: --move"};
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
  require_at_rest(session);
  AcceptanceRun run;
  session.nmt(canopen::NmtCommand::enter_pre_operational);
  {
    client::BorrowedStream borrowed(session,
                                    {.chambers = static_cast<std::uint8_t>((1U << plan.chambers) - 1U),
                                     .largest_volume_m3 = kLargestVolume_m3});
    session.nmt(canopen::NmtCommand::start);
    const Counted before = count(session);
    listen_at_rest(link, session, borrowed.stream(), plan, run, progress);
    time_round_trips(session, run);
    const Counted after = count(session);
    run.loop = client::latency_between(before.latency, after.latency,
                                       session.read<std::uint32_t>(object::kHealth, 9));
    run.overruns = after.overruns - before.overruns;
    run.tick_rate_Hz = (after.ticks - before.ticks) / (after.time_s - before.time_s);
    borrowed.give_back();
  }
  if (plan.motion) move(session, plan, run, progress);
  return run;
}

std::vector<client::Measured> measured_by(const AcceptanceRun& run) {
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
          noise_measured(run),
          answer_measured(run)};
}

}  // namespace plenum::host::tools
