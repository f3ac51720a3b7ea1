#include "host-sim/identify/chamber/next_tick.hpp"

#include <cmath>
#include <vector>

namespace plenum::host::identify::chamber {

double next_tick_rms_Pa(const Scene& scene, effects::EffectSet on, const effects::Figures& figures,
                        const std::vector<effects::Start>& start) {
  double squares = 0.0;
  double rows = 0.0;
  for (std::size_t r = 0; r < scene.records.size(); ++r) {
    const Record& record = scene.records[r];
    const std::vector<double> reading_Pa = run(
        scene, record, on, figures, start.empty() ? estimate_start(scene, record, on, figures) : start[r]);
    for (std::size_t k = record.settled_rows; k < record.fitted_rows; ++k) {
      const double change_Pa =
          reading_Pa[k] - record.measured_Pa[k] - (reading_Pa[k - 1] - record.measured_Pa[k - 1]);
      squares += change_Pa * change_Pa;
      rows += 1.0;
    }
  }
  return std::sqrt(squares / rows);
}

}  // namespace plenum::host::identify::chamber
