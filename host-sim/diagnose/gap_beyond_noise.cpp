#include "host-sim/diagnose/gap_beyond_noise.hpp"

#include <algorithm>
#include <utility>

#include "host-sim/diagnose/verdict.hpp"
#include "host-sim/identify/chamber/noise.hpp"

namespace plenum::host::diagnose {

CalibratedToAll calibrated_to_all(const Scene& fitted, const std::vector<HeldOut>& heldout, const Fit& base) {
  CalibratedToAll all{.scene = fitted, .fit = {}, .place = {}};
  std::vector<effects::Start> start = base.start;
  for (const HeldOut& held : heldout) {
    if (held.continues >= 0) {
      all.place.push_back(static_cast<std::size_t>(held.continues));
      all.scene.records[all.place.back()].fitted_rows = held.record.rows();
    } else {
      all.place.push_back(all.scene.records.size());
      all.scene.records.push_back(held.record);
      start.push_back(heldout_start(fitted, held, base));
    }
  }
  all.fit = fit(all.scene, 0, base.figures, start);
  if (all.fit.rms_Pa() > kAtFloor * fitted.noise_Pa) {
    Fit from_data_sheet = fit(all.scene, 0, fitted.nominal, start);
    if (from_data_sheet.squares < all.fit.squares) all.fit = std::move(from_data_sheet);
  }
  return all;
}

void append_error(std::vector<double>& error, const Record& record, const std::vector<double>& reading_Pa,
                  std::size_t first, std::size_t last) {
  for (std::size_t row = std::max(first, record.settled_rows); row < last; ++row) {
    error.push_back(reading_Pa[row] - record.measured_Pa[row]);
  }
}

double gap_p_value(const CalibratedToAll& all, const std::vector<HeldOut>& heldout, const Scene& scene,
                   const Fit& best, double noise_Pa) {
  std::vector<double> noise;
  for (std::size_t i = 0; i < scene.records.size(); ++i) {
    const Record& record = scene.records[i];
    append_error(noise, record, run(scene, record, best.on, best.figures, best.start[i]), 0,
                 record.fitted_rows);
  }
  std::vector<double> error;
  for (std::size_t i = 0; i < heldout.size(); ++i) {
    const std::size_t place = all.place[i];
    const Record& record = all.scene.records[place];
    append_error(error, record, run(all.scene, record, 0, all.fit.figures, all.fit.start[place]),
                 heldout[i].first, record.rows());
  }
  return identify::chamber::probability_of_noise(error, noise, best.variables.size() + best.start.size(),
                                                 noise_Pa, kAtFloor * noise_Pa);
}

}  // namespace plenum::host::diagnose
