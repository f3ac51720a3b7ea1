#include "host-sim/client/acceptance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace plenum::host::client {
namespace {

constexpr std::size_t kLongestLag = 12;  // ticks: dead time, spool and tube of a slow valve

constexpr std::size_t kNoiseWindow = 100;   // ticks
constexpr std::size_t kAnswerWindow = 100;  // ticks

constexpr std::array kCriteria{
    Criterion{"latency_p999_us", "Tick latency, 99.9th percentile", "us", 500.0},
    Criterion{"latency_max_us", "Tick latency, the worst", "us", 2000.0},
    Criterion{"jitter_us", "Jitter: 99.9th percentile minus median", "us", 500.0},
    Criterion{"overruns", "Ticks that the board counts as overrun", "ticks", 0.0},
    Criterion{"tick_rate_error_percent", "Tick rate, deviation from 100 Hz", "%", 1.0},
    Criterion{"rows_lost", "Rows of the stream that did not come whole", "rows", 0.0},
    Criterion{"sdo_p99_ms", "SDO round trip, 99th percentile", "ms", 10.0},
    Criterion{"can_load_percent", "Load of the bus while streaming", "%", 60.0},
    Criterion{"stuck_channels", "Inputs that never change, not by a bit", "", 0.0},
    Criterion{"noise_Pa", "Noise of a pressure at rest, worst chamber", "Pa", 300.0},
    Criterion{"volume_noise_mL", "Noise of a volume at rest, worst chamber", "mL", 0.5},
    Criterion{"supply_noise_Pa", "Noise of the supply pressure at rest", "Pa", 1000.0},
    Criterion{"moving_latency_p999_us", "While the valves move: latency, 99.9th percentile", "us", 500.0},
    Criterion{"moving_jitter_us", "While the valves move: jitter, 99.9th minus median", "us", 500.0},
    Criterion{"moving_overruns", "While the valves move: overruns", "ticks", 0.0},
    Criterion{"chambers_amiss", "Chambers that do not answer their valve", "", 0.0}};

/// Where `share` of the ticks is reached.
std::size_t bin_at(std::span<const LatencyBin> bins, std::uint64_t ticks, double share) {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(ticks)));
  std::uint64_t so_far = 0;
  for (std::size_t b = 0; b < bins.size(); ++b) {
    so_far += bins[b].ticks;
    if (so_far >= wanted) return b;
  }
  return bins.size() - 1;
}

/// The greatest that a tick of this bin can have had.
double upper_us(std::span<const LatencyBin> bins, std::size_t bin, double max_us) {
  if (bin + 1 == bins.size()) return max_us;
  return std::min(static_cast<double>(bins[bin + 1].lowest_us) - 1.0, max_us);
}

/// Of neighbours: one fewer than there are values.
std::vector<double> differences_of(std::span<const double> values) {
  std::vector<double> differences;
  differences.reserve(values.size());
  for (std::size_t k = 1; k < values.size(); ++k) differences.push_back(values[k] - values[k - 1]);
  return differences;
}

/// The least difference of two samples, if every difference is a whole multiple of it. Samples that are all different
/// tell nothing: then there are too few of them, or the noise is averaged below the step.
std::optional<double> step_of(std::vector<double> samples) {
  const std::size_t all = samples.size();
  std::sort(samples.begin(), samples.end());
  samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
  if (samples.size() < 3 || samples.size() > all / 2) return std::nullopt;
  const std::vector<double> differences = differences_of(samples);
  const double step = *std::min_element(differences.begin(), differences.end());
  constexpr double kFar = 0.1;  // of a step
  const bool whole = std::all_of(differences.begin(), differences.end(), [&](double difference) {
    return std::abs(difference / step - std::round(difference / step)) < kFar;
  });
  return whole ? std::optional(step) : std::nullopt;
}

/// Second differences, a window at a time; the median of the windows. Not a number when a sample is none.
double noise_of(std::span<const double> samples) {
  std::vector<double> variances;
  for (std::size_t begin = 0; begin < samples.size(); begin += kNoiseWindow) {
    const std::span window = samples.subspan(begin, std::min(kNoiseWindow, samples.size() - begin));
    if (window.size() < std::min(kNoiseWindow, samples.size())) break;
    double squares = 0.0;
    for (std::size_t k = 2; k < window.size(); ++k)
      squares += std::pow(window[k] - 2.0 * window[k - 1] + window[k - 2], 2);
    if (std::isnan(squares)) return squares;
    variances.push_back(squares / (6.0 * static_cast<double>(window.size() - 2)));
  }
  const auto middle = variances.begin() + static_cast<std::ptrdiff_t>(variances.size() / 2);
  std::nth_element(variances.begin(), middle, variances.end());
  return std::sqrt(*middle);
}

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Of two sequences of one length, from the means of each window: moments in which nothing moves, as of chambers that ran to a
/// pressure's end, take nothing from the others. 0 when one of them is constant.
double correlation(std::span<const double> x, std::span<const double> y) {
  double xx = 0.0;
  double yy = 0.0;
  double xy = 0.0;
  for (std::size_t begin = 0; begin < x.size(); begin += kAnswerWindow) {
    const std::span in_x = x.subspan(begin, std::min(kAnswerWindow, x.size() - begin));
    const std::span in_y = y.subspan(begin, in_x.size());
    const double mean_x = mean_of(in_x);
    const double mean_y = mean_of(in_y);
    for (std::size_t k = 0; k < in_x.size(); ++k) {
      xx += (in_x[k] - mean_x) * (in_x[k] - mean_x);
      yy += (in_y[k] - mean_y) * (in_y[k] - mean_y);
      xy += (in_x[k] - mean_x) * (in_y[k] - mean_y);
    }
  }
  return xx > 0.0 && yy > 0.0 ? xy / std::sqrt(xx * yy) : 0.0;
}

double answer_to(std::span<const double> change_Pa, std::span<const double> command_V) {
  double strongest = 0.0;
  for (std::size_t lag = 0; lag < kLongestLag; ++lag) {
    const double found = correlation(change_Pa.subspan(lag), command_V.first(change_Pa.size() - lag));
    if (std::abs(found) > std::abs(strongest)) strongest = found;
  }
  return strongest;
}

/// Distance beyond the limits while the valve is turned against it; 0: within, or turned otherwise.
double beyond_Pa(double pressure_Pa, double command_V, const MotionLimits& limits) {
  if (pressure_Pa > limits.pressure_high_Pa && command_V < limits.command_mean_V)
    return pressure_Pa - limits.pressure_high_Pa;
  if (pressure_Pa < limits.pressure_low_Pa && command_V > limits.command_mean_V)
    return limits.pressure_low_Pa - pressure_Pa;
  return 0.0;
}

bool escapes(std::span<const double> pressure_Pa, std::span<const double> command_V,
             const MotionLimits& limits) {
  constexpr std::size_t kSecond = 100;  // ticks
  constexpr double kNoNearer = 0.99;    // what is left of the distance; noise is less than a hundredth of it
  const auto distance_Pa = [&](std::size_t k) { return beyond_Pa(pressure_Pa[k], command_V[k], limits); };
  std::size_t run = 0;  // ticks beyond so far
  for (std::size_t k = 0; k < pressure_Pa.size(); ++k) {
    run = distance_Pa(k) == 0.0 ? 0 : run + 1;
    if (run > kSecond && distance_Pa(k) >= kNoNearer * distance_Pa(k - kSecond)) return true;
  }
  return false;
}

/// The criteria with the limits that were asked for.
std::vector<Criterion> limited(std::span<const std::string> limits) {
  std::vector<Criterion> criteria(kCriteria.begin(), kCriteria.end());
  for (const std::string& limit : limits) {
    const std::size_t equals = limit.find('=');
    const std::string_view id = std::string_view(limit).substr(0, equals);
    const auto criterion =
        std::find_if(criteria.begin(), criteria.end(), [&](const Criterion& one) { return one.id == id; });
    if (equals == std::string::npos || criterion == criteria.end()) {
      std::vector<std::string_view> ids;
      ids.reserve(kCriteria.size());
      for (const Criterion& one : kCriteria) ids.push_back(one.id);
      throw std::invalid_argument(
          fmt::format("limit '{}': expected NAME=VALUE with one of {}", limit, fmt::join(ids, ", ")));
    }
    const char* const end = limit.data() + limit.size();
    const auto [read_to, error] = std::from_chars(limit.data() + equals + 1, end, criterion->limit);
    if (error != std::errc() || read_to != end || !std::isfinite(criterion->limit)) {
      throw std::invalid_argument(fmt::format("limit '{}': expected a number behind {}=", limit, id));
    }
  }
  return criteria;
}

Verdict verdict_on(const Criterion& criterion, std::optional<double> value) {
  if (!value) return Verdict::not_run;
  return std::isfinite(*value) && *value <= criterion.limit ? Verdict::pass : Verdict::fail;
}

}  // namespace

LoopLatency latency_between(std::span<const LatencyBin> before, std::span<const LatencyBin> after,
                            std::uint32_t max_us) {
  LoopLatency latency;
  for (std::size_t b = 0; b < after.size(); ++b) {
    if (before.size() != after.size() || after[b].ticks < before[b].ticks) {
      throw ProtocolError("2201h: holds fewer ticks than it did, expected more: the board has started anew");
    }
    latency.bin.push_back({after[b].lowest_us, after[b].ticks - before[b].ticks});
    latency.ticks += latency.bin.back().ticks;
  }
  if (latency.ticks == 0)
    throw ProtocolError("2201h: no tick began meanwhile, expected one each 0.01 s: the loop stands still");
  const std::size_t slow = bin_at(latency.bin, latency.ticks, 0.999);
  latency.p999_us = upper_us(latency.bin, slow, max_us);
  latency.max_us = upper_us(latency.bin, bin_at(latency.bin, latency.ticks, 1.0), max_us);
  latency.jitter_us = latency.p999_us - latency.bin[bin_at(latency.bin, latency.ticks, 0.5)].lowest_us;
  return latency;
}

Reading reading_of(std::span<const double> samples) {
  if (samples.size() < 3)
    throw std::invalid_argument(
        fmt::format("a reading of {} samples, expected three at least", samples.size()));
  Reading reading;
  reading.mean = mean_of(samples);
  double squares = 0.0;
  for (const double sample : samples) squares += std::pow(sample - reading.mean, 2);
  reading.std = std::sqrt(squares / static_cast<double>(samples.size() - 1));
  reading.noise = noise_of(samples);
  reading.changed =
      std::any_of(samples.begin(), samples.end(), [&](double sample) { return sample != samples.front(); });
  if (std::isfinite(squares)) reading.step = step_of({samples.begin(), samples.end()});
  return reading;
}

std::vector<Answer> answers_of(std::span<const std::vector<double>> pressure_Pa,
                               std::span<const std::vector<double>> command_V, const MotionLimits& limits) {
  std::vector<Answer> answers(pressure_Pa.size());
  for (std::size_t c = 0; c < answers.size(); ++c) {
    // change[k] = pressure[k + 1] - pressure[k], while command[k] was held
    const std::vector<double> change = differences_of(pressure_Pa[c]);
    if (change.size() <= kLongestLag)
      throw std::invalid_argument(
          fmt::format("{} rows, expected more than {}", pressure_Pa[c].size(), kLongestLag + 1));
    answers[c].escapes = escapes(pressure_Pa[c], command_V[c], limits);
    for (std::size_t valve = 0; valve < command_V.size(); ++valve) {
      const double found = answer_to(change, command_V[valve]);
      if (valve == c) answers[c].own = found;
      if (std::abs(found) > std::abs(answers[c].best_correlation)) {
        answers[c].best = valve;
        answers[c].best_correlation = found;
      }
    }
  }
  return answers;
}

std::string trouble_of(const Answer& answer, std::size_t chamber) {
  if (answer.best != chamber && answer.best_correlation >= kFollows)
    return fmt::format("follows valve {}: tubes or wires are swapped", answer.best + 1);
  if (answer.own <= -kAnswers) return "goes the wrong way";
  if (answer.escapes)
    return "stays beyond its limits though its valve is turned against it: tubes or wires are swapped, or it "
           "is dead";
  return answer.own >= kAnswers ? "" : "does not answer";
}

std::span<const Criterion> acceptance_criteria() {
  return kCriteria;
}

const char* verdict_name(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "pass";
    case Verdict::fail:
      return "fail";
    case Verdict::not_run:
      break;
  }
  return "not run";
}

std::vector<Judged> judge(std::span<const Measured> measured, std::span<const std::string> limits) {
  std::vector<Judged> judged;
  for (const Criterion& criterion : limited(limits)) {
    Judged& one = judged.emplace_back(Judged{criterion, {}, "", Verdict::not_run});
    const auto found = std::find_if(measured.begin(), measured.end(),
                                    [&](const Measured& of) { return of.id == criterion.id; });
    if (found == measured.end()) continue;
    one.value = found->value;
    one.remark = found->remark;
    one.verdict = verdict_on(criterion, found->value);
  }
  return judged;
}

bool accepted(std::span<const Judged> judged) {
  return std::none_of(judged.begin(), judged.end(),
                      [](const Judged& one) { return one.verdict == Verdict::fail; });
}

}  // namespace plenum::host::client
