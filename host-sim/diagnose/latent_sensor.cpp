// A disturbance of the sensor: its reading plus d of the supply's pressure. Terms: what the chamber alone would have been
// read to be, behind lags of first order, its rise over a tick, and the pressure.
#include "host-sim/diagnose/latent_terms.hpp"

#include <array>
#include <cmath>

namespace plenum::host::diagnose {
namespace {

constexpr std::array<double, 4> kSensorLags{0.5, 1.5, 4.0, 12.0};  // time constants [ticks]

class SensorTerms : public LatentTerms {
 public:
  using LatentTerms::LatentTerms;

  std::vector<Term> terms() const override {
    std::vector<Term> terms;
    add(terms, "the pressure's rate", 0.5, kSensorLags.size() + 1);
    add(terms, "the pressure", 0.05, 3);
    return terms;
  }
  DisturbanceScale disturbance() const override {
    return {.start_size = 0.01, .per_unit = rig_.scene.around.supply_Pa, .unit = "Pa"};
  }
  void begin(const Background& /*b*/) override { followed_.clear(); }
  void act(const Background& b, std::size_t k, const TickActions& tick) const override {
    Action* const a = tick.terms;
    Action& w = tick.disturbance;
    std::size_t i = 0;
    const double P = rig_.scene.around.supply_Pa;
    const double Pa = rig_.scene.around.ambient_Pa;
    const double middle = b.about->middle_Pa[k];
    w.reading = P;
    w.own = 1.0;
    i += kSensorLags.size() + 1;  // they need the readings: derive()
    const double x = (middle - Pa) / P;
    for (const double s : {1.0, x, x * x}) {
      a[i].reading = P * s;
      a[i++].own = s;
    }
  }
  double derive(std::size_t /*k*/, double begin_Pa, const Outcome& at, Action* a,
                const std::vector<double>& size) override {
    const double P = rig_.scene.around.supply_Pa;
    double own = 1.0;
    if (followed_.empty()) followed_.assign(kSensorLags.size(), at.reading);
    for (std::size_t j = 0; j < kSensorLags.size(); ++j) {
      const double keep = std::exp(-1.0 / kSensorLags[j]);
      followed_[j] = keep * followed_[j] + (1.0 - keep) * at.reading;
      a[j].reading = followed_[j] - at.reading;
      a[j].own = a[j].reading / P;
      own -= size[j] * keep;
    }
    a[kSensorLags.size()].reading = begin_Pa - at.end;
    a[kSensorLags.size()].own = a[kSensorLags.size()].reading / P;
    return own;
  }

 private:
  std::vector<double>
      followed_;  ///< [lag] the chamber's own reading, as the filter expects it, behind a lag of first order
};

}  // namespace

std::unique_ptr<LatentTerms> sensor_terms(const LatentScene& rig) {
  return std::make_unique<SensorTerms>(rig);
}

}  // namespace plenum::host::diagnose
