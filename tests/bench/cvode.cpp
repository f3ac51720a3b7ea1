// How much faster the plant integrates a chamber than SUNDIALS CVODE does, at the same accuracy.
//
// Thin-plate valve, volume swinging by 30 % at 0.7 Hz, a new random command of 3..7 V every 10 ms, 5 s. Both
// integrate the same right side (the plant's own flow functions) and are restarted at every command. Accuracy:
// the largest error of a tick's end over the whole run, 1e-4 of supply - ambient, against CVODE at a relative
// tolerance of 1e-12. Each side is run at every setting of a list; of those that reach the accuracy the
// fastest counts. CVODE: BDF and Adams, Newton with the analytic Jacobian or fixed point, relative tolerances
// of 1e-2.5 to 1e-7, its own first step or one of five given ones. The plant: tolerances of 0.5 Pa to 8 kPa.
// CVODE is not asked for the mean of a tick, which the plant computes as well.
//
// The row with the target is that of 100 mL, in the middle of the volumes of the population
// (host-sim/reproduce/actuators); beside it those of its ends, 40 and 300 mL: the smaller the volume, the more
// the plant too has to cut its ticks.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host-sim/plant/chamber.hpp"
#include "host-sim/plant/random.hpp"
#include "tests/bench/row.hpp"
#include "tests/plant/cvode/cvode_chamber.hpp"

namespace {

using namespace plenum::host::plant;
using oracle::CvodeChamber;
using oracle::CvodeMethod;
using oracle::CvodeSettings;

constexpr double kTick_s = 0.01;
constexpr std::size_t kTicks = 500;
constexpr double kAccuracy = 1e-4;  // of supply - ambient
constexpr int kRepeats = 15;        // of the fastest settings, in turns

struct Scene {
  ThinPlateValve valve{ThinPlateValveConfig{}};
  ChamberConfig config;
  VolumeMotion volume;
  std::vector<double> command_V;
  std::vector<double> reference_Pa{};  // of the ends of the ticks

  explicit Scene(double mean_m3) : volume(mean_m3, {VolumeSine{0.3 * mean_m3, 0.7, 0.3}}) {
    Random random(1);
    for (std::size_t k = 0; k < kTicks; ++k) command_V.push_back(random.uniform(3.0, 7.0));
  }
};

/// The ends of all ticks [Pa] and the time it took, construction included.
struct Run {
  std::vector<double> end_Pa;
  double seconds = 0.0;
};

template <class Make>
Run run(const Scene& scene, const Make& make) {
  Run done;
  done.end_Pa.reserve(kTicks);
  const auto begin = std::chrono::steady_clock::now();
  auto chamber = make();
  for (const double u : scene.command_V) done.end_Pa.push_back(chamber.advance(u, kTick_s).end_Pa);
  done.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return done;
}

Run run_plant(const Scene& scene, double tolerance_Pa) {
  ChamberConfig config = scene.config;
  config.tolerance_Pa = tolerance_Pa;
  return run(scene, [&] { return ChamberPlant(scene.valve, config, scene.volume); });
}

Run run_cvode(const Scene& scene, const CvodeSettings& settings) {
  return run(scene,
             [&] { return CvodeChamber<ThinPlateValve>(scene.valve, scene.config, scene.volume, settings); });
}

double error_of_span(const Scene& scene, const std::vector<double>& end_Pa) {
  double most_Pa = 0.0;
  for (std::size_t k = 0; k < kTicks; ++k) {
    most_Pa = std::max(most_Pa, std::abs(end_Pa[k] - scene.reference_Pa[k]));
  }
  return most_Pa / (scene.config.supply_Pa - scene.config.ambient_Pa);
}

struct Setting {
  std::string name;
  std::function<Run()> run;
  double error = 0.0;
  double seconds = std::numeric_limits<double>::infinity();
};

/// The fastest of those that are accurate enough.
Setting fastest(const Scene& scene, std::vector<Setting> settings) {
  Setting best;
  for (Setting& one : settings) {
    for (int k = 0; k < 3; ++k) {
      const Run done = one.run();
      one.error = error_of_span(scene, done.end_Pa);
      one.seconds = std::min(one.seconds, done.seconds);
    }
    if (one.error <= kAccuracy && one.seconds < best.seconds) best = one;
  }
  return best;
}

std::vector<Setting> plant_settings(const Scene& scene) {
  std::vector<Setting> all;
  for (double tolerance_Pa = 0.5; tolerance_Pa < 9000.0; tolerance_Pa *= std::sqrt(2.0)) {
    all.push_back({"tolerance " + std::to_string(tolerance_Pa) + " Pa",
                   [&scene, tolerance_Pa] { return run_plant(scene, tolerance_Pa); }});
  }
  return all;
}

std::vector<Setting> cvode_settings(const Scene& scene) {
  struct Named {
    CvodeMethod method;
    const char* name;
  };
  std::vector<Setting> all;
  for (const Named method :
       {Named{CvodeMethod::kBdfNewton, "BDF, Newton"}, Named{CvodeMethod::kAdamsNewton, "Adams, Newton"},
        Named{CvodeMethod::kAdamsFixedPoint, "Adams, fixed point"}}) {
    for (const double first_step_s : {0.0, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2}) {
      for (double digits = 2.5; digits <= 7.0; digits += 0.25) {
        CvodeSettings settings;
        settings.method = method.method;
        settings.first_step_s = first_step_s;
        settings.relative_tolerance = std::pow(10.0, -digits);
        settings.absolute_tolerance_Pa = 1e-3;
        settings.with_mean = false;
        all.push_back({std::string(method.name) + ", relative tolerance 1e-" + std::to_string(digits) +
                           ", first step " +
                           (first_step_s > 0.0 ? std::to_string(first_step_s) + " s" : "its own"),
                       [&scene, settings] { return run_cvode(scene, settings); }});
      }
    }
  }
  return all;
}

double ratio_on(double mean_m3) {
  Scene scene(mean_m3);
  CvodeSettings tight;
  tight.relative_tolerance = 1e-12;
  tight.with_mean = false;
  scene.reference_Pa = run_cvode(scene, tight).end_Pa;
  Setting plant = fastest(scene, plant_settings(scene));
  Setting cvode = fastest(scene, cvode_settings(scene));
  if (!plant.run || !cvode.run) {
    std::fprintf(stderr, "%.0f mL: no setting reaches %g of span\n", 1e6 * mean_m3, kAccuracy);
    return std::numeric_limits<double>::quiet_NaN();
  }
  for (int k = 0; k < kRepeats; ++k) {
    plant.seconds = std::min(plant.seconds, plant.run().seconds);
    cvode.seconds = std::min(cvode.seconds, cvode.run().seconds);
  }
  const double to_ns = 1e9 / static_cast<double>(kTicks);
  std::fprintf(stderr,
               "%.0f mL: plant %.0f ns a tick (%s, error %.1e of span; at its default of 2 Pa %.1e), "
               "CVODE %.0f ns (%s, error %.1e)\n",
               1e6 * mean_m3, to_ns * plant.seconds, plant.name.c_str(), plant.error,
               error_of_span(scene, run_plant(scene, 2.0).end_Pa), to_ns * cvode.seconds, cvode.name.c_str(),
               cvode.error);
  return cvode.seconds / plant.seconds;
}

void print_ratio(const std::string& suffix, double ratio, std::optional<double> target = {}) {
  plenum::bench::print(
      {"plant.speed_vs_cvode" + suffix, ratio, "x", "higher", target, "SUNDIALS CVODE 6.4", 1.0});
}

}  // namespace

int main() {
  const double small = ratio_on(40e-6);
  const double middle = ratio_on(100e-6);
  const double large = ratio_on(300e-6);
  if (!std::isfinite(small + middle + large)) return 1;
  print_ratio("", middle, 10.0);
  print_ratio("_40mL", small);
  print_ratio("_300mL", large);
}
