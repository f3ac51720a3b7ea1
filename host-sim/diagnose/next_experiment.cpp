#include "host-sim/diagnose/next_experiment.hpp"

#include <fmt/core.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <stdexcept>
#include <utility>

#include "host-sim/diagnose/trial.hpp"
#include "host-sim/diagnose/trust.hpp"
#include "host-sim/diagnose/where.hpp"

namespace plenum::host::diagnose {
namespace {

using effects::kLanes;
using identify::chamber::Record;
using identify::chamber::Variable;

constexpr double kSwing = 0.3;
constexpr double kSwing_Hz = 0.7;
constexpr double kSecondVolume = 1.6;
constexpr double kSecondSupply = 0.55;  // of the gauge pressure
constexpr double kFill_s = 0.8;         // that a full stroke would take, if the log's strokes allow it
constexpr double kDifference = 1e-4;    // of a scaled variable, as in the fits
constexpr double kStartStep_Pa = 100.0;
constexpr double kWeakPrior = 50.0;  // of scaled variables: holds only what the readings do not feel
constexpr double kParted = 0.95;

/// Commands by name of what they do to the valve, one a tick.
class Script {
 public:
  explicit Script(const Scene& scene)
      : tick_s_(scene.records.front().drive.timing.tick_s),
        open_V_(scene.nominal[effects::kOpenAbove]),
        exhaust_V_(scene.nominal[effects::kExhaustBelow]) {
    const Record& log = scene.records.front();
    const double null_V = shut();
    double seen_V = 0.05;
    for (const double u : log.drive.command_V) seen_V = std::max(seen_V, std::abs(u - null_V));
    // the stroke whose choked flow fills the chamber in kFill_s
    const plant::ThinPlateConstants plate =
        plant::thin_plate_constants(scene.around.gas, scene.around.discharge_coefficient);
    const double gas_J_kg = scene.around.gas.specific_gas_constant_J_kg_K() * scene.around.gas.temperature_K *
                            scene.around.gas.kappa;
    const double rise_Pa_s_V = scene.nominal[effects::kInletGain] * plate.beta_s_m * scene.around.supply_Pa *
                               gas_J_kg / log.drive.volume_m3.front();
    const double gauge_Pa = scene.around.supply_Pa - scene.around.ambient_Pa;
    const double needed_V = gauge_Pa / (rise_Pa_s_V * kFill_s);
    stroke_V_ = std::max(seen_V, std::min(needed_V, 2.0 * seen_V));
    if (null_V > 1.0) stroke_V_ = std::min(stroke_V_, null_V);
    fill_s_ = std::clamp(gauge_Pa / (rise_Pa_s_V * stroke_V_), 0.05, 4.0);
  }

  double up(double share) const { return std::max(open_V_, exhaust_V_) + share * reach(); }
  double down(double share) const { return std::min(open_V_, exhaust_V_) - share * reach(); }
  double shut() const { return 0.5 * (open_V_ + exhaust_V_); }
  /// A full stroke fills the chamber in about this time.
  double fill_s() const { return fill_s_; }
  /// The share of a stroke that fills the chamber in about `seconds`.
  double filling_in(double seconds) const { return std::min(fill_s_ / seconds, 1.0); }
  double tick_s() const { return tick_s_; }
  double seconds() const { return static_cast<double>(command_V_.size()) * tick_s_; }

  Script& hold(double command_V, double seconds) {
    return follow(seconds, [=](double) { return command_V; });
  }
  Script& follow(double seconds, const std::function<double(double)>& command_V) {
    const long ticks = std::max(std::lround(seconds / tick_s_), 1L);
    for (long i = 0; i < ticks; ++i) command_V_.push_back(command_V(static_cast<double>(i) * tick_s_));
    return *this;
  }
  const std::vector<double>& command_V() const { return command_V_; }

 private:
  double reach() const { return std::max(stroke_V_ - 0.5 * std::abs(open_V_ - exhaust_V_), 0.02); }

  double tick_s_, open_V_, exhaust_V_;
  double stroke_V_ = 0.0, fill_s_ = 0.0;
  std::vector<double> command_V_;
};

// ---- the commands of the library ----

std::vector<double> fill_and_dump(Script script) {
  const double fill = script.fill_s();
  for (const double size : {1.0, 0.3, 0.6}) {
    script.hold(script.up(size), 1.5 * fill / size).hold(script.shut(), 2.0);
    script.hold(script.down(size), 0.5 * fill / size).hold(script.shut(), 2.0);
    script.hold(script.down(size), 2.0 * fill / size).hold(script.up(size), 0.3 * fill / size);
    script.hold(script.shut(), 1.0).hold(script.down(size), 1.5 * fill / size);
  }
  return script.command_V();
}

std::vector<double> mixed_steps(Script script, double seconds) {
  std::mt19937 bits(7);
  const auto random = [&] { return static_cast<double>(bits()) / 4294967296.0; };
  while (script.seconds() < seconds) {
    const double size = std::exp(std::log(0.04) * random());
    const double length_s =
        0.06 + 0.4 * random() * random() * std::min(1.0, script.fill_s() / kFill_s / size + 0.2);
    const double choice = random();
    // the exhaust flow falls with the pressure, so that it needs more time for as much air
    if (choice < 0.38) {
      script.hold(script.up(size), length_s);
    } else if (choice < 0.85) {
      script.hold(script.down(size), 1.3 * length_s);
    } else {
      script.hold(script.shut(), 0.5 * length_s);
    }
  }
  return script.command_V();
}

/// Small stairs with a step back at every other one, on one side of the null for as long as the pressure bears it.
std::vector<double> staircase(Script script) {
  constexpr double kStairs[] = {0.2, 0.5, 0.35, 0.8, 0.6, 1.0, 0.7, 0.85, 0.4, 0.55, 0.15, 0.3};
  while (script.seconds() < 30.0) {
    const double top = script.filling_in(2.0);
    for (const double stair : kStairs) script.hold(script.up(stair * top), 0.2);
    script.hold(script.shut(), 0.3);
    for (const double stair : kStairs) script.hold(script.down(stair * top), 0.3);
    script.hold(script.shut(), 0.3);
  }
  return script.command_V();
}

std::vector<double> chirp(Script script) {
  constexpr double kEach_s = 15.0, kFrom_Hz = 0.2, kTo_Hz = 6.0;
  for (const double size : {0.25, 1.0}) {
    script.follow(kEach_s, [&](double t) {
      const double growth = std::log(kTo_Hz / kFrom_Hz) / kEach_s;
      const double phase = 2.0 * std::numbers::pi * kFrom_Hz * (std::exp(growth * t) - 1.0) / growth;
      return script.shut() + size * std::sin(phase) * (script.up(1.0) - script.shut());
    });
  }
  return script.command_V();
}

std::vector<double> slow_equalisation(Script script) {
  for (const double seconds : {2.0, 4.0}) {
    const double size = script.filling_in(seconds);
    script.hold(script.up(size), 2.0 * seconds).hold(script.shut(), 0.5);
    script.hold(script.down(size), 3.0 * seconds).hold(script.shut(), 0.5);
  }
  return script.command_V();
}

/// Pulses that bring the chamber to about twice ambient, vented by openings of many sizes.
std::vector<double> low_venting(Script script) {
  while (script.seconds() < 24.0) {
    for (const double seconds : {0.8, 1.6, 3.0}) {
      script.hold(script.up(script.filling_in(0.8)), 0.3).hold(script.shut(), 0.2);
      script.hold(script.down(script.filling_in(seconds)), 0.5 + 0.4 * seconds);
    }
  }
  return script.command_V();
}

// ---- volumes ----

/// The log's own volume, there and back again for as long as it takes.
std::vector<double> as_logged_m3(const Record& log, std::size_t rows, double factor) {
  const auto steps = static_cast<std::size_t>(log.drive.timing.steps);
  const std::size_t last = log.rows() - 1;
  std::vector<double> volume_m3(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const std::size_t at = last == 0 ? 0 : row % (2 * last);
    volume_m3[row] = factor * log.drive.volume_m3[std::min(at, 2 * last - at) * steps];
  }
  return volume_m3;
}

double mean_m3(const Record& log) {
  double sum = 0.0;
  for (const double v : log.drive.volume_m3) sum += v;
  return sum / static_cast<double>(log.drive.volume_m3.size());
}

std::vector<double> swinging_m3(const Record& log, std::size_t rows) {
  const double mean = mean_m3(log);
  std::vector<double> volume_m3(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const double t = static_cast<double>(row) * log.drive.timing.tick_s;
    volume_m3[row] = mean * (1.0 + kSwing * std::sin(2.0 * std::numbers::pi * kSwing_Hz * t));
  }
  return volume_m3;
}

// ---- how far rivals are apart ----

/// What a rival reads under an input, and how that changes with the valve's figures and the starts.
struct Answer {
  Eigen::VectorXd reading_Pa;
  Eigen::MatrixXd slopes;  ///< for each scaled variable
};

Answer answer_of(const Scene& scene, const Excitation& excitation, const Rival& rival) {
  const std::vector<Variable> valve = valve_variables(scene);
  Eigen::Index rows = 0;
  for (const Stretch& s : excitation.stretches)
    rows += static_cast<Eigen::Index>(s.drive.command_V.size()) - 1;
  const auto figures = static_cast<Eigen::Index>(valve.size());
  const auto starts = static_cast<Eigen::Index>(excitation.stretches.size());
  Answer answer{Eigen::VectorXd(rows), Eigen::MatrixXd::Zero(rows, figures + starts)};
  Eigen::Index done = 0;
  for (Eigen::Index k = 0; k < starts; ++k) {
    const Stretch& stretch = excitation.stretches[static_cast<std::size_t>(k)];
    effects::Surroundings around = scene.around;
    around.supply_Pa = stretch.supply_Pa;
    const effects::Run base{rival.figures, {around.ambient_Pa}};
    const auto count = static_cast<Eigen::Index>(stretch.drive.command_V.size()) - 1;
    for (Eigen::Index first = 0; first <= figures; first += kLanes - 1) {
      std::vector<effects::Run> runs{base};
      std::vector<double> steps;
      for (Eigen::Index i = first; i <= figures && i < first + kLanes - 1; ++i) {
        effects::Run changed = base;
        if (i < figures) {
          const Variable& v = valve[static_cast<std::size_t>(i)];
          const double step =
              base.figures[v.figure] + kDifference * v.scale > v.high ? -kDifference : kDifference;
          changed.figures[v.figure] += step * v.scale;
          steps.push_back(step);
        } else {
          changed.start.pressure_Pa += kStartStep_Pa;
          steps.push_back(1.0);
        }
        runs.push_back(changed);
      }
      std::vector<double> lanes(stretch.drive.command_V.size() * static_cast<std::size_t>(kLanes));
      effects::free_run(around, stretch.drive, rival.on, runs, lanes);
      for (Eigen::Index row = 0; row < count; ++row) {
        const double* at = lanes.data() + (row + 1) * kLanes;
        answer.reading_Pa[done + row] = at[0];
        for (std::size_t i = 0; i < steps.size(); ++i) {
          const Eigen::Index variable = first + static_cast<Eigen::Index>(i);
          answer.slopes(done + row, variable < figures ? variable : figures + k) =
              (at[i + 1] - at[0]) / steps[i];
        }
      }
    }
    done += count;
  }
  return answer;
}

/// RMS of what is left when `second` is fitted to `first`.
double apart_Pa(const Answer& first, const Answer& second, double noise_Pa) {
  const Eigen::VectorXd off = first.reading_Pa - second.reading_Pa;
  Eigen::MatrixXd normal = second.slopes.transpose() * second.slopes;
  normal.diagonal().array() += noise_Pa * noise_Pa / (kWeakPrior * kWeakPrior);
  const Eigen::VectorXd change = normal.ldlt().solve(second.slopes.transpose() * off);
  return (off - second.slopes * change).norm() / std::sqrt(static_cast<double>(off.size()));
}

/// What to do, and how far the valve is opened for it.
std::string instruction_of(const Excitation& input) {
  double low_V = std::numeric_limits<double>::infinity(), high_V = -low_V;
  for (const Stretch& stretch : input.stretches) {
    const auto [low, high] = std::ranges::minmax(stretch.drive.command_V);
    low_V = std::min(low_V, low);
    high_V = std::max(high_V, high);
  }
  return fmt::format("{} Commands from {:.3g} to {:.3g} V.", input.sentence, low_V, high_V);
}

/// Entropy of the time that the chamber spends in each regime, at each fifth of its mean volume [nat].
double variety(const Scene& scene, const Excitation& excitation, const Rival& rival) {
  const double fifth_m3 = 0.2 * mean_m3(scene.records.front());
  std::map<std::pair<int, long>, double> rows;
  double all = 0.0;
  for (const Stretch& stretch : excitation.stretches) {
    Scene there = scene;
    there.around.supply_Pa = stretch.supply_Pa;
    Record record;
    record.drive = stretch.drive;
    record.measured_Pa.resize(stretch.drive.command_V.size());
    const std::vector<double> reading =
        run(there, record, rival.on, rival.figures, {there.around.ambient_Pa});
    const std::vector<Regime> regimes = regimes_of(there, rival.figures, stretch.drive, reading);
    for (std::size_t row = 1; row < regimes.size(); ++row) {
      const Regime& r = regimes[row];
      const double volume_m3 =
          stretch.drive.volume_m3[row * static_cast<std::size_t>(stretch.drive.timing.steps)];
      const int kind =
          static_cast<int>(r.port) * 16 + r.moving * 8 + r.reversed * 4 + r.choked * 2 + r.volume_moving;
      rows[{kind, std::lround(volume_m3 / fifth_m3)}] += 1.0;
      all += 1.0;
    }
  }
  double entropy = 0.0;
  for (const auto& [place, count] : rows) entropy -= count / all * std::log(count / all);
  return entropy;
}

/// What an input does to the rivals, two by two.
struct Parting {
  double mean_power = 0.0, least_power = 1.0;
  /// Of the two that are told apart worst.
  double nearest_Pa = std::numeric_limits<double>::infinity();
  std::pair<std::size_t, std::size_t> nearest{0, 1};
  std::vector<bool> parted;  ///< told from another with kParted, a rival

  bool parts_all() const { return least_power >= kParted; }
  bool better_than(const Parting& other) const {
    constexpr double kAlike = 1e-6;
    if (parts_all() != other.parts_all()) return parts_all();
    const double more = mean_power - other.mean_power;
    return std::abs(more) > kAlike ? more > 0.0 : nearest_Pa > other.nearest_Pa;
  }
};

Parting parted_by(const Scene& scene, const Excitation& excitation, const std::vector<Rival>& rivals,
                  double noise_Pa) {
  std::vector<Answer> answers;
  answers.reserve(rivals.size());
  for (const Rival& rival : rivals) answers.push_back(answer_of(scene, excitation, rival));
  const auto rows = static_cast<double>(answers.front().reading_Pa.size());
  Parting of;
  of.parted.assign(rivals.size(), false);
  double pairs = 0.0;
  for (std::size_t a = 0; a < rivals.size(); ++a) {
    for (std::size_t b = a + 1; b < rivals.size(); ++b) {
      const double b_of_a_Pa = apart_Pa(answers[a], answers[b], noise_Pa);
      const double a_of_b_Pa = apart_Pa(answers[b], answers[a], noise_Pa);
      const double price =
          static_cast<double>(rivals[b].variables) - static_cast<double>(rivals[a].variables);
      const double power = 0.5 * (named_alone(b_of_a_Pa / noise_Pa, rows, price) +
                                  named_alone(a_of_b_Pa / noise_Pa, rows, -price));
      of.mean_power += power;
      pairs += 1.0;
      if (power >= kParted) of.parted[a] = of.parted[b] = true;
      of.least_power = std::min(of.least_power, power);
      if (const double apart = std::min(b_of_a_Pa, a_of_b_Pa); apart < of.nearest_Pa) {
        of.nearest_Pa = apart;
        of.nearest = {a, b};
      }
    }
  }
  of.mean_power /= pairs;
  return of;
}

/// Of many rivals the nearest two are those that decide.
std::string why_text(const std::vector<Rival>& rivals, const Parting& of, const std::string& under) {
  const std::string pair =
      fmt::format("{} and {}", rivals[of.nearest.first].id, rivals[of.nearest.second].id);
  std::string all = rivals.front().id;
  for (std::size_t i = 1; i < rivals.size(); ++i)
    all += (i + 1 == rivals.size() ? " and " : ", ") + rivals[i].id;
  const bool many = rivals.size() > 2;
  const std::string they = many ? fmt::format("the nearest two, {},", pair) : "they";
  return of.parts_all() ? fmt::format("{} answer alike on this log; under {} {} differ by {:.2g} kPa RMS.",
                                      all, under, they, 1e-3 * of.nearest_Pa)
                        : fmt::format(
                              "{} answer alike on this log, and no input known here parts {} well: under {} "
                              "{} differ by {:.2g} kPa RMS, within the noise.",
                              all, many ? "all of them" : "them", under, they, 1e-3 * of.nearest_Pa);
}

NextExperiment most_varied(const Scene& scene, const std::vector<Excitation>& inputs, const Rival& rival) {
  std::vector<double> variety_of(inputs.size());
  std::transform(inputs.begin(), inputs.end(), variety_of.begin(),
                 [&](const Excitation& e) { return variety(scene, e, rival); });
  const auto most = std::max_element(variety_of.begin(), variety_of.end()) - variety_of.begin();
  const Excitation& best = inputs[static_cast<std::size_t>(most)];
  NextExperiment next;
  next.excitation = best.id;
  next.instruction = instruction_of(best);
  next.why = fmt::format(
      "No effect of the catalogue closes the gap; {} take the chamber through the widest variety of regimes, "
      "and show "
      "in which of them the model errs.",
      best.title);
  return next;
}

}  // namespace

std::vector<Excitation> library(const Scene& scene) {
  if (scene.records.empty()) throw std::invalid_argument("next experiment: expected a log, found none");
  const Record& log = scene.records.front();
  const double supply = scene.around.supply_Pa;
  const double second_supply = scene.around.ambient_Pa + kSecondSupply * (supply - scene.around.ambient_Pa);
  const Script script(scene);
  const auto stretch = [&](const std::vector<double>& command_V, const std::vector<double>& volume_m3,
                           double supply_Pa) {
    return Stretch{effects::make_drive(command_V, volume_m3, log.drive.timing), supply_Pa};
  };
  const auto plain = [&](const std::vector<double>& command_V) {
    return stretch(command_V, as_logged_m3(log, command_V.size(), 1.0), supply);
  };
  const auto moving = [&](const std::vector<double>& command_V) {
    return stretch(command_V, swinging_m3(log, command_V.size()), supply);
  };
  const std::vector<double> filling = fill_and_dump(script);
  const std::vector<double> steps = mixed_steps(script, 30.0);
  const std::vector<double> half = mixed_steps(script, 18.0);
  const double swing_percent = 100.0 * kSwing;

  std::vector<Excitation> inputs;
  inputs.push_back(
      {"fill_and_dump",
       "fills and dumps with sealed holds",
       "Fill and dump at three openings, with the valve shut for 2 s at a high and at a middle pressure.",
       {plain(filling)}});
  inputs.push_back(
      {"mixed_steps", "steps of mixed size", "Steps of random size, sign and length, 30 s.", {plain(steps)}});
  inputs.push_back({"staircase",
                    "a staircase with reversals on one side",
                    "Small stairs with steps back, first on the supply side, then on the exhaust side, 30 s.",
                    {plain(staircase(script))}});
  inputs.push_back({"chirp",
                    "chirps of two amplitudes",
                    "A sine from 0.2 to 6 Hz, at a quarter of the stroke and at the whole of it, 15 s each.",
                    {plain(chirp(script))}});
  inputs.push_back(
      {"slow_equalisation",
       "slow equalisation",
       "Fill up to the supply and vent down to ambient through small openings, waiting until the "
       "pressures are equal.",
       {plain(slow_equalisation(script))}});
  inputs.push_back({"low_venting",
                    "venting below twice ambient",
                    "Short fills to about twice ambient, vented through openings of several sizes.",
                    {plain(low_venting(script))}});
  inputs.push_back(
      {"mixed_steps_two_supplies",
       "steps of mixed size at two supply pressures",
       fmt::format("Steps of random size, 18 s at the supply of the rig and 18 s at {:.0f} kPa absolute.",
                   1e-3 * second_supply),
       {plain(half), stretch(half, as_logged_m3(log, half.size(), 1.0), second_supply)}});
  inputs.push_back(
      {"mixed_steps_second_volume",
       "steps of mixed size at two volumes",
       fmt::format("Steps of random size, 18 s at the volume of the log and 18 s at {:.1f} times that.",
                   kSecondVolume),
       {plain(half), stretch(half, as_logged_m3(log, half.size(), kSecondVolume), supply)}});
  inputs.push_back({"mixed_steps_moving_volume",
                    "steps of mixed size while the volume moves",
                    fmt::format("Steps of random size, 30 s, while the volume swings by {:.0f} % at {} Hz.",
                                swing_percent, kSwing_Hz),
                    {moving(steps)}});
  inputs.push_back(
      {"fill_and_dump_moving_volume",
       "fills and dumps with sealed holds while the volume moves",
       fmt::format("Fill and dump with the valve shut at two pressures, while the volume swings by "
                   "{:.0f} % at {} Hz.",
                   swing_percent, kSwing_Hz),
       {moving(filling)}});
  return inputs;
}

double named_alone(double apart, double rows, double price) {
  const double pieces = std::min(rows, kMostPieces);
  const double lead = 0.5 * (pieces * std::log1p(apart * apart) + price * std::log(pieces)) -
                      std::log(kNamedAlone / (1.0 - kNamedAlone));
  const double deviation = pieces * apart / ((1.0 + apart * apart) * std::sqrt(rows));
  return 0.5 * std::erfc(-lead / (deviation * std::numbers::sqrt2));
}

NextExperiment next_experiment(const Scene& scene, const std::vector<Rival>& rivals) {
  const std::vector<Excitation> inputs = library(scene);
  if (rivals.size() < 2) {
    return most_varied(scene, inputs, rivals.empty() ? Rival{"", 0, scene.nominal} : rivals.front());
  }
  const double noise_Pa = std::max(scene.noise_Pa, 1.0);
  std::vector<Parting> partings;
  partings.reserve(inputs.size());
  for (const Excitation& input : inputs) partings.push_back(parted_by(scene, input, rivals, noise_Pa));
  const auto most = std::max_element(partings.begin(), partings.end(),
                                     [](const Parting& a, const Parting& b) { return b.better_than(a); });
  const Excitation& best = inputs[static_cast<std::size_t>(most - partings.begin())];
  NextExperiment next;
  next.excitation = best.id;
  next.instruction = instruction_of(best);
  next.power = most->mean_power;
  for (std::size_t i = 0; i < rivals.size(); ++i) {
    if (most->parted[i]) next.separates.push_back(rivals[i].id);
  }
  next.why = why_text(rivals, *most, best.title);
  return next;
}

}  // namespace plenum::host::diagnose
