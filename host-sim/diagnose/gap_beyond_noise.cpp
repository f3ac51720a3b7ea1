#include "host-sim/diagnose/gap_beyond_noise.hpp"

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

double gap_p_value(const CalibratedToAll& all, const std::vector<HeldOut>& heldout, const Scene& scene,
                   const Fit& best, double noise_Pa) {
  std::vector<double> error;
  for (std::size_t i = 0; i < heldout.size(); ++i) {
    const std::size_t place = all.place[i];
    const Record& record = all.scene.records[place];
    const std::vector<double> of = errors_Pa(run(all.scene, record, 0, all.fit.figures, all.fit.start[place]),
                                             record, heldout[i].first, record.rows());
    error.insert(error.end(), of.begin(), of.end());
  }
  return identify::chamber::probability_of_noise(error, fitted_errors_Pa(scene, best),
                                                 best.variables.size() + best.start.size(), noise_Pa,
                                                 kAtFloor * noise_Pa);
}

}  // namespace plenum::host::diagnose
