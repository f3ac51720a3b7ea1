// The candidate fits of one blind case, timed, for gap_speed.py: says what the peer needs to do the same fits, then
// does them.
//
// usage: gap_speed CASE SECONDS    prints one JSON object
//
// The first SECONDS of CASE/log.csv are fitted: recalibration from the rig's figures, then each effect of kCandidates
// with the valve's figures, from the recalibrated valve and one typical step of the effect's first parameter. Each
// time is the least of kRepeats calls of fit(), which runs on one thread: the processor's, so that what else the
// machine does counts for neither.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "host-sim/identify/chamber/fit.hpp"
#include "host-sim/plant/gas.hpp"
#include "host-sim/trace/log_csv.hpp"

namespace {

using namespace plenum::host;
namespace chamber = plenum::host::identify::chamber;
using Json = nlohmann::ordered_json;

constexpr std::string_view kCandidates[] = {"spool_lag", "supply_droop", "volume_error", "sensor_lag"};
constexpr int kRepeats = 3;

struct Timed {
  chamber::Fit fit;
  double seconds = std::numeric_limits<double>::infinity();
};

Timed timed_fit(const chamber::Scene& scene, effects::EffectSet on, const effects::Figures& start,
                const std::vector<effects::Start>& begin) {
  Timed timed;
  for (int k = 0; k < kRepeats; ++k) {
    const std::clock_t from = std::clock();
    timed.fit = chamber::fit(scene, on, start, begin);
    timed.seconds = std::min(timed.seconds, static_cast<double>(std::clock() - from) / CLOCKS_PER_SEC);
  }
  return timed;
}

Json json_of(std::string_view effect, const effects::Figures& start, const Timed& timed) {
  Json variables = Json::array();
  for (const chamber::Variable& v : timed.fit.variables) {
    variables.push_back({{"figure", v.figure}, {"low", v.low}, {"high", v.high}, {"scale", v.scale}});
  }
  return {{"effect", effect},
          {"start", start},
          {"variables", variables},
          {"seconds", timed.seconds},
          {"squares_Pa2", timed.fit.squares},
          {"iterations", timed.fit.iterations},
          {"converged", timed.fit.converged},
          {"figures", timed.fit.figures},
          {"start_Pa", timed.fit.start.front().pressure_Pa}};
}

Json fits_of(const std::filesystem::path& folder, double seconds) {
  const auto rig = trace::read_rig(folder / "rig.toml");
  const auto log = trace::read_log(folder / "log.csv", rig);
  chamber::Scene scene = chamber::make_scene(rig);
  chamber::add_record(scene, chamber::make_record(
                                 "log.csv", log, seconds / (log.period_s * static_cast<double>(log.size()))));
  scene.records.front().settled_rows = 1;  // every row
  const chamber::Record& record = scene.records.front();
  const std::vector<effects::Start> begin{{record.measured_Pa.front()}};

  const auto plate = plant::thin_plate_constants(scene.around.gas, scene.around.discharge_coefficient);
  Json first_figures;
  Json fits = Json::array();
  const Timed valve = timed_fit(scene, 0, scene.nominal, begin);
  fits.push_back(json_of("", scene.nominal, valve));
  for (const std::string_view id : kCandidates) {
    const std::size_t at = effects::find(id).value();
    const effects::Parameter& first = effects::kCatalogue[at]->parameters.front();
    effects::Figures start = valve.fit.figures;
    start[effects::kFirstFigure[at]] = first.neutral() + first.typical_change;
    first_figures[std::string(id)] = effects::kFirstFigure[at];
    fits.push_back(json_of(id, start, timed_fit(scene, 1U << at, start, valve.fit.start)));
  }
  return {{"rows", record.fitted_rows},
          {"tick_s", record.drive.timing.tick_s},
          {"average_s", record.drive.timing.average_s},
          {"steps", record.drive.timing.steps},
          {"gas_J_kg", scene.around.gas.specific_gas_constant_J_kg_K() * scene.around.gas.temperature_K},
          {"kappa", scene.around.gas.kappa},
          {"supply_Pa", scene.around.supply_Pa},
          {"ambient_Pa", scene.around.ambient_Pa},
          {"alpha_s_m", plate.alpha_s_m},
          {"theta", plate.theta},
          {"command_V", record.drive.command_V},
          {"volume_m3", record.drive.volume_m3},
          {"measured_Pa", record.measured_Pa},
          {"begin_Pa", begin.front().pressure_Pa},
          {"recalibrated_start_Pa", valve.fit.start.front().pressure_Pa},
          {"first_figures", first_figures},
          {"fits", fits}};
}

}  // namespace

int main(int count, char** words) {
  const double seconds = count == 3 ? std::strtod(words[2], nullptr) : 0.0;
  if (!(seconds > 0.0)) {
    std::fprintf(stderr, "usage: gap_speed CASE SECONDS\n");
    return 2;
  }
  try {
    std::printf("%s\n", fits_of(words[1], seconds).dump().c_str());
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "gap_speed: %s\n", fault.what());
    return 2;
  }
}
