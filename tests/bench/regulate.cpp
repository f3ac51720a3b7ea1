// regulate.*: the whole line on the MPYE-table plant with spool lag, noise and moving volumes (the rig of the
// demo).
//
//   capture (excitation on the board) -> identify -> upload over CAN -> capture in closed loop -> identify ->
//   upload (what the board refuses, because it predicts worse than the model in force, stays out)
//   -> follow references over CAN, judged on the plant's own pressure at the tick's edges
//
// regulate.rmse_vs_tuned_pi: RMS error over sines of 0.5 to 4 Hz, a trapezoid and a filtered random
// reference, each within what that chamber's valve can follow, over that of a PI regulator on the same
// plants, converters, volumes and references. The PI's gains and bias are optimised on that very set, for
// each chamber on its own (Nelder and Mead from the best of a grid), and it is given the reference 0, 1 or 2
// ticks ahead, whichever suits it best.
//
// regulate.settle_vs_time_optimal: time from a step of the set point (sent without preview) until the
// pressure stays within 1 % of span, over the bang-bang time of the true plant in its state at the step plus
// two ticks. regulate.overshoot_percent: the farthest beyond the target after such a step, of span.
//
// All with the model that the board regulates best with, the grey-box model, and once more with the 9-parameter model
// (regulate.*_tassa9); with its repaired form what needs no PI (regulate.*_tassa9r). With the word `models`:
// model.regulate_rmse_vs_tassa9, both without the PI.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "host-sim/client/capture.hpp"
#include "host-sim/client/model_bytes.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/identify/chamber/fit_greybox.hpp"
#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/identify/profile.hpp"
#include "host-sim/plant/reach.hpp"
#include "host-sim/rig/standard_rigs.hpp"
#include "host-sim/tools/recorded_log.hpp"
#include "host-sim/tools/rig_link.hpp"
#include "tests/bench/row.hpp"

namespace {

using namespace plenum::host;

constexpr unsigned kChambers = 8;
constexpr double kTick_s = 0.01;
constexpr double kSpan_Pa = 600'000.0;
constexpr double kLow_V = 3.0;
constexpr double kHigh_V = 7.0;
constexpr std::size_t kRows = 800;
constexpr std::size_t kSkip = 50;  // the first half second is the way onto the reference

using Series = std::vector<double>;
using Plants = std::array<plant::ChamberPlant, kChambers>;

/// The simulated rig as seen by the client, keeping the plants' true state at every tick.
class WatchedLink : public tools::RigLink {
 public:
  explicit WatchedLink(rig::Rig& rig)
      : tools::RigLink(rig, "master", [this, &rig] {
          for (unsigned c = 0; keep && c < kChambers; ++c) truth[c].push_back(rig.board(0).plant(c));
        }) {}

  bool keep = false;
  std::array<std::vector<plant::ChamberPlant>, kChambers> truth;  ///< before the command of that tick
};

enum class Kind { tassa9, tassa9r, greybox };

client::ModelUpload identified(const std::vector<client::CapturedRow>& rows, unsigned chamber, Kind kind) {
  trace::RigDescription description;
  description.supply.pressure_Pa = 700'000.0;
  description.ambient.pressure_Pa = 100'000.0;
  const std::vector<trace::Log> logs{tools::log_of(rows, chamber)};
  const auto number = static_cast<std::uint8_t>(chamber);
  if (kind == Kind::greybox) {
    const auto fit = identify::chamber::fit_greybox(logs, description);
    fmt::print(stderr, "chamber {}: held out {:.2f} kPa, next tick {:.2f} kPa, free run {:.2f} kPa\n",
               chamber + 1, fit.rms_heldout_kPa, fit.rms_next_tick_kPa, fit.rms_free_run_kPa);
    const trace::ModelFile file = identify::chamber::to_model_file(fit, chamber);
    return {number, client::encode_model(file.kind, file.parameters, {})};
  }
  identify::FitOptions options;
  options.stretch_s = 0.2;
  if (kind == Kind::tassa9r) options.form = identify::Form::repaired;
  const identify::Tassa9Fit fit = identify::fit_tassa9_profiled(logs, description, options);
  fmt::print(stderr, "chamber {}: c_gamma {} V, one-step {:.2f} kPa, free run {:.2f} kPa\n", chamber + 1,
             fit.model.c_gamma_V, fit.rms_one_step_kPa, fit.rms_free_run_kPa);
  return {number, client::encode_model(identify::kind_of(options.form), fit.model.image(), {})};
}

void identify_and_upload(client::Session& session, const std::vector<client::CapturedRow>& rows, Kind kind) {
  std::vector<client::ModelUpload> uploads(kChambers);
  identify::in_parallel(kChambers, std::thread::hardware_concurrency(), [&](std::size_t c) {
    uploads[c] = identified(rows, static_cast<unsigned>(c), kind);
  });
  for (const client::ModelUpload& upload : uploads) {
    try {
      session.upload_model(upload.chamber, upload.image);
    } catch (const client::Refused& refused) {  // it predicts worse than the one in force, which stays
      fmt::print(stderr, "{}\n", refused.what());
    }
  }
}

/// The slowest that full opening moves a chamber's pressure, either way, between the two pressures [Pa/s].
double least_rate_Pa_s(const plant::ChamberPlant& chamber, double low_Pa, double high_Pa) {
  const auto rate = [&](double pressure_Pa, double command_V) {
    const double flow = plant::mass_flow_kg_s(chamber.valve(), pressure_Pa, command_V, chamber.supply_Pa(),
                                              chamber.ambient_Pa());
    // 287 J/(kg K) at 293 K; an exponent of 1: what both directions reach at least. Volume at its largest.
    return std::fabs(flow) * 287.0 * 293.0 / (1.2 * chamber.volume_m3());
  };
  return std::min(rate(high_Pa, kHigh_V), rate(low_Pa, kLow_V));
}

/// Reference `kind` of a chamber, at half of what its valve can do at most.
Series reference(int kind, unsigned chamber, const plant::ChamberPlant& plant) {
  constexpr double kMiddle_Pa = 350'000.0;
  const double fastest_Pa_s = 0.5 * least_rate_Pa_s(plant, 200'000.0, 500'000.0);
  Series series(kRows);
  constexpr std::array<double, 4> kSine_Hz = {0.5, 1.0, 2.0, 4.0};
  for (std::size_t k = 0; k < kRows; ++k) {
    const double t = kTick_s * static_cast<double>(k);
    double value_Pa = kMiddle_Pa;
    if (kind < 4) {
      const double omega = 2.0 * std::numbers::pi * kSine_Hz[static_cast<std::size_t>(kind)];
      value_Pa += std::min(150'000.0, fastest_Pa_s / omega) * std::sin(omega * t);
    } else if (kind == 4) {
      const double ramp_s = std::max(0.5, 300'000.0 / fastest_Pa_s);
      const double period_s = 2.0 * ramp_s + 1.0;
      const double phase = std::fmod(t, period_s);
      const double up = std::clamp((phase - 0.25) / ramp_s, 0.0, 1.0);
      const double down = std::clamp((phase - 0.75 - ramp_s) / ramp_s, 0.0, 1.0);
      value_Pa += 300'000.0 * (up - down - 0.5);
    } else {
      double steepest_Pa_s = 0;
      double sum_Pa = 0;
      for (int i = 0; i < 12; ++i) {
        const double omega = 2.0 * std::numbers::pi * (0.2 + 0.23 * i);
        sum_Pa += 15'000.0 * std::sin(omega * t + 1.7 * i * i + chamber);
        steepest_Pa_s += 15'000.0 * omega / std::numbers::sqrt2;
      }
      value_Pa += sum_Pa * std::min(1.0, 2.0 * fastest_Pa_s / steepest_Pa_s);
    }
    series[k] = value_Pa;
  }
  return series;
}
constexpr int kKinds = 6;

double mean_square(const Series& truth_Pa, const Series& reference_Pa) {
  double sum = 0;
  for (std::size_t k = kSkip; k < kRows; ++k) sum += std::pow(truth_Pa[k] - reference_Pa[k], 2);
  return sum / static_cast<double>(kRows - kSkip);
}

struct Pi {
  double gain_V_kPa = 0.02;
  double integral_V_kPa_s = 0.1;
  double bias_V = 5.0;
};

/// The PI on a chamber from where it stood when that reference began: same plant, converters and noise.
double pi_mean_square(plant::ChamberPlant plant, const Series& reference_Pa, const Pi& pi, std::size_t ahead,
                      std::uint64_t seed) {
  plant::AveragingAdc adc(
      {.low_V = -10.0, .high_V = 10.0, .bits = 16, .sample_noise_V = 0.005, .samples_per_tick = 200},
      plant::Random(seed));
  plant::Dac dac;
  Series truth_Pa(kRows);
  double measured_kPa = plant.pressure_Pa() / 1e3;
  double integral_V = pi.bias_V;
  for (std::size_t k = 0; k < kRows; ++k) {
    truth_Pa[k] = plant.pressure_Pa();
    const double error_kPa = reference_Pa[std::min(k + ahead, kRows - 1)] / 1e3 - measured_kPa;
    const double wanted_V = integral_V + pi.gain_V_kPa * error_kPa;
    const double command_V = std::clamp(wanted_V, kLow_V, kHigh_V);
    if (command_V == wanted_V) integral_V += pi.integral_V_kPa_s * error_kPa * kTick_s;
    measured_kPa = 100.0 * adc.read_V(plant.advance(dac.write_V(command_V), kTick_s).mean_Pa / 100'000.0);
  }
  const double square = mean_square(truth_Pa, reference_Pa);
  return std::isfinite(square) ? square : std::numeric_limits<double>::max();
}

/// The least mean square that a PI reaches on all references of a chamber.
double tuned_pi_mean_square(const std::vector<plant::ChamberPlant>& start,
                            const std::vector<Series>& references, unsigned chamber, std::size_t ahead) {
  const auto cost = [&](const std::array<double, 3>& x) {
    const Pi pi{std::exp(x[0]), std::exp(x[1]), x[2]};
    double sum = 0;
    for (std::size_t i = 0; i < references.size(); ++i) {
      sum += pi_mean_square(start[i], references[i], pi, ahead, 100 * chamber + i) /
             static_cast<double>(references.size());
    }
    return sum;
  };
  struct Corner {
    std::array<double, 3> x{};
    double cost = std::numeric_limits<double>::max();
  };
  Corner best;
  for (const double gain : {0.01, 0.02, 0.04, 0.08, 0.16}) {
    for (const double integral : {0.05, 0.2, 0.8, 3.2}) {
      const std::array<double, 3> x{std::log(gain), std::log(integral), 5.0};
      const double at = cost(x);
      if (at < best.cost) best = {x, at};
    }
  }
  // Nelder and Mead, Computer Journal 7 (1965), from there.
  std::array<Corner, 4> simplex{best, best, best, best};
  for (std::size_t i = 0; i < 3; ++i) {
    simplex[i + 1].x[i] += i == 2 ? 0.2 : 0.4;
    simplex[i + 1].cost = cost(simplex[i + 1].x);
  }
  const auto along = [&](double t) {
    Corner corner;
    for (std::size_t i = 0; i < 3; ++i) {
      const double centre = (simplex[0].x[i] + simplex[1].x[i] + simplex[2].x[i]) / 3.0;
      corner.x[i] = centre + t * (simplex[3].x[i] - centre);
    }
    corner.cost = cost(corner.x);
    return corner;
  };
  for (int i = 0; i < 40; ++i) {
    std::sort(simplex.begin(), simplex.end(),
              [](const Corner& a, const Corner& b) { return a.cost < b.cost; });
    const Corner mirrored = along(-1.0);
    if (mirrored.cost < simplex[0].cost) {
      const Corner farther = along(-2.0);
      simplex[3] = farther.cost < mirrored.cost ? farther : mirrored;
    } else if (mirrored.cost < simplex[2].cost) {
      simplex[3] = mirrored;
    } else {
      const Corner nearer = along(mirrored.cost < simplex[3].cost ? -0.5 : 0.5);
      if (nearer.cost < std::min(mirrored.cost, simplex[3].cost)) {
        simplex[3] = nearer;
      } else {
        for (std::size_t j = 1; j < 4; ++j) {
          for (std::size_t d = 0; d < 3; ++d) simplex[j].x[d] = 0.5 * (simplex[j].x[d] + simplex[0].x[d]);
          simplex[j].cost = cost(simplex[j].x);
        }
      }
    }
  }
  return std::min_element(simplex.begin(), simplex.end(),
                          [](const Corner& a, const Corner& b) { return a.cost < b.cost; })
      ->cost;
}

/// Follows one reference a chamber. Returns the true pressures at the ticks of the rows; `start` gets the
/// plants there.
std::array<Series, kChambers> followed(
    client::Session& session, WatchedLink& link, const std::vector<Series>& references, std::uint8_t preview,
    std::vector<std::vector<plant::ChamberPlant>>* start,
    std::array<std::vector<plant::ChamberPlant>, kChambers>* states = nullptr) {
  for (auto& truth : link.truth) truth.clear();
  link.keep = true;
  const auto rows = client::follow(session, references, {.preview_ticks = preview, .chambers = kChambers});
  link.keep = false;
  // The ticks kept hold the way there and back too: the rows are found in them by their time.
  std::array<Series, kChambers> truth_Pa;
  for (unsigned c = 0; c < kChambers; ++c) {
    const double from_s = rows.front().bus_time_s - link.truth[c].front().time_s();
    const auto first = static_cast<std::size_t>(from_s / kTick_s);  // a row's frames follow its tick at once
    for (std::size_t k = 0; k < rows.size(); ++k)
      truth_Pa[c].push_back(link.truth[c][first + k].pressure_Pa());
    if (start != nullptr) (*start)[c].push_back(link.truth[c][first]);
    if (states != nullptr) {
      (*states)[c].assign(link.truth[c].begin() + static_cast<std::ptrdiff_t>(first),
                          link.truth[c].begin() + static_cast<std::ptrdiff_t>(first + rows.size()));
    }
  }
  return truth_Pa;
}

/// Sums over rigs.
struct Result {
  double ours_Pa2 = 0;  ///< mean squares, one term a chamber
  double pi_Pa2 = 0;
  double pi_blind_Pa2 = 0;
  unsigned chambers = 0;
  double ratio_sum = 0;
  double worst_ratio = 0;
  double overshoot_Pa = 0;
  int steps = 0;
};

void measure(std::uint64_t seed, Kind kind_of_model, bool beside_pi, Result& result) {
  rig::Rig rig(rig::mpye_rig({.seed = seed}));
  WatchedLink link(rig);
  client::Session session(link, 1);

  identify_and_upload(session, client::capture(session, {.seconds = 60.0}), kind_of_model);
  identify_and_upload(
      session,
      client::follow(session, client::random_references(kChambers, 60.0, 130'000.0, 600'000.0, 1), {}),
      kind_of_model);

  std::vector<std::vector<Series>> reference_of(kChambers);  // by chamber, then kind
  std::vector<std::vector<plant::ChamberPlant>> start(kChambers);
  std::vector<double> square(kChambers, 0.0);
  for (int kind = 0; kind < kKinds; ++kind) {
    std::vector<Series> references;
    for (unsigned c = 0; c < kChambers; ++c) {
      references.push_back(reference(kind, c, rig.board(0).plant(c)));
      reference_of[c].push_back(references.back());
    }
    const auto truth_Pa = followed(session, link, references, 2, &start);
    double of_kind = 0;
    for (unsigned c = 0; c < kChambers; ++c) {
      const double at = mean_square(truth_Pa[c], references[c]);
      square[c] += at / kKinds;
      of_kind += at / kChambers;
    }
    fmt::print(stderr, "reference {}: RMSE {:.2f} kPa\n", kind, std::sqrt(of_kind) / 1e3);
  }

  std::array<double, kChambers> pi_square{};
  std::array<double, kChambers> pi_blind_square{};
  if (beside_pi) {
    identify::in_parallel(kChambers, std::thread::hardware_concurrency(), [&](std::size_t i) {
      const auto c = static_cast<unsigned>(i);
      pi_blind_square[c] = tuned_pi_mean_square(start[c], reference_of[c], c, 0);
      pi_square[c] = pi_blind_square[c];
      for (const std::size_t ahead : {1UL, 2UL}) {
        pi_square[c] = std::min(pi_square[c], tuned_pi_mean_square(start[c], reference_of[c], c, ahead));
      }
    });
  }
  for (unsigned c = 0; c < kChambers; ++c) {
    fmt::print(stderr, "chamber {}: RMSE {:.2f} kPa", c + 1, std::sqrt(square[c]) / 1e3);
    if (beside_pi) {
      fmt::print(stderr, ", PI {:.2f} kPa, PI without preview {:.2f} kPa", std::sqrt(pi_square[c]) / 1e3,
                 std::sqrt(pi_blind_square[c]) / 1e3);
    }
    fmt::print(stderr, "\n");
    result.ours_Pa2 += square[c];
    result.pi_Pa2 += pi_square[c];
    result.pi_blind_Pa2 += pi_blind_square[c];
    ++result.chambers;
  }

  // Steps: small and large, up and down, between pressures where both ports have air to move.
  const std::vector<double> levels_kPa = {250, 450, 250, 300, 200, 550, 150, 400, 380, 250};
  constexpr std::size_t kHoldRows = 80;
  std::vector<Series> references(kChambers);
  for (Series& series : references) {
    for (const double level : levels_kPa) series.insert(series.end(), kHoldRows, 1e3 * level);
  }
  std::array<std::vector<plant::ChamberPlant>, kChambers> states;
  followed(session, link, references, 0, nullptr, &states);
  for (unsigned c = 0; c < kChambers; ++c) {
    for (std::size_t i = 1; i < levels_kPa.size(); ++i) {
      const std::size_t at = i * kHoldRows;
      // Without preview, the set point of row `at` is latched one tick before it and acts from there on.
      const std::size_t given = at - 1;
      const double target_Pa = 1e3 * levels_kPa[i];
      const double direction = target_Pa > 1e3 * levels_kPa[i - 1] ? 1.0 : -1.0;
      const double band_Pa = 0.01 * kSpan_Pa;
      const double bound_s =
          plant::bang_bang_time_s(states[c][given], target_Pa - direction * band_Pa, kLow_V, kHigh_V) +
          2.0 * kTick_s;
      std::size_t settled = given;
      for (std::size_t k = given; k < at + kHoldRows - 1; ++k) {
        const double error_Pa = states[c][k].pressure_Pa() - target_Pa;
        if (std::fabs(error_Pa) > band_Pa) settled = k + 1;
        result.overshoot_Pa = std::max(result.overshoot_Pa, k > given ? direction * error_Pa : 0.0);
      }
      const double settle_s = kTick_s * static_cast<double>(settled - given);
      const double ratio = settle_s / bound_s;
      fmt::print(stderr, "chamber {} step to {} kPa: {:.0f} ms, bound + 2 ticks {:.0f} ms\n", c + 1,
                 levels_kPa[i], settle_s * 1e3, bound_s * 1e3);
      result.ratio_sum += ratio;
      result.worst_ratio = std::max(result.worst_ratio, ratio);
      ++result.steps;
    }
  }
}

/// Rigs on which no constant of the regulator was chosen.
Result measured(Kind kind, bool beside_pi) {
  Result result;
  for (const std::uint64_t seed : {101U, 102U, 103U}) measure(seed, kind, beside_pi, result);
  return result;
}

double rmse_kPa(const Result& result) {
  return std::sqrt(result.ours_Pa2 / result.chambers) / 1e3;
}

/// `suffix`: of the rows' names.
void print_rows(const char* suffix, const Result& result) {
  const auto name = [&](const char* row) { return fmt::format("regulate.{}{}", row, suffix); };
  plenum::bench::print({name("rmse_kPa"), rmse_kPa(result), "kPa"});
  plenum::bench::print({name("settle_vs_time_optimal"), result.ratio_sum / result.steps, "1", "lower", 1.2});
  plenum::bench::print({name("settle_vs_time_optimal_worst"), result.worst_ratio, "1"});
  plenum::bench::print(
      {name("overshoot_percent"), 100.0 * result.overshoot_Pa / kSpan_Pa, "% of span", "lower", 2.0});
}

/// Of a result that was measured beside the PI.
void print_beside_pi(const char* suffix, const Result& result) {
  const auto name = [&](const char* row) { return fmt::format("regulate.{}{}", row, suffix); };
  const double pi_kPa = std::sqrt(result.pi_Pa2 / result.chambers) / 1e3;
  const double pi_blind_kPa = std::sqrt(result.pi_blind_Pa2 / result.chambers) / 1e3;
  print_rows(suffix, result);
  plenum::bench::print({name("rmse_vs_tuned_pi"), rmse_kPa(result) / pi_kPa, "1", "lower", 0.25,
                        "PI tuned on each chamber's set, kPa", pi_kPa});
  plenum::bench::print({name("rmse_vs_tuned_pi_without_preview"),
                        rmse_kPa(result) / pi_blind_kPa,
                        "1",
                        "lower",
                        {},
                        "the same PI without preview, kPa",
                        pi_blind_kPa});
}

}  // namespace

int main(int count, char** words) {
  if (count == 2 && std::string_view(words[1]) == "models") {
    const double nine_kPa = rmse_kPa(measured(Kind::tassa9, false));
    const double greybox_kPa = rmse_kPa(measured(Kind::greybox, false));
    plenum::bench::print({"model.regulate_rmse_vs_tassa9", greybox_kPa / nine_kPa, "1", "lower", 0.5,
                          "the 9-parameter model, kPa", nine_kPa});
    return 0;
  }
  print_beside_pi("", measured(Kind::greybox, true));
  print_beside_pi("_tassa9", measured(Kind::tassa9, true));
  print_rows("_tassa9r", measured(Kind::tassa9r, false));
}
