// A disturbance of the sensor: its reading plus d of the supply's pressure. Terms: the readings before, and the pressure.
#include "host-sim/diagnose/latent_terms.hpp"

#include <array>

namespace plenum::host::diagnose {
namespace {

constexpr std::array<std::size_t, 6> kSensorLags{1, 2, 3, 5, 8, 13};  // ticks

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
  void begin(const Background& b) override { read_.assign(b.u.size(), 0.0); }
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
  double derive(std::size_t k, double begin_Pa, const Outcome& at, Action* a,
                const std::vector<double>& size) override {
    const double P = rig_.scene.around.supply_Pa;
    double own = 1.0;
    for (std::size_t j = 0; j < kSensorLags.size(); ++j) {
      const double then = k >= kSensorLags[j] ? read_[k - kSensorLags[j]] : at.reading;
      a[j].reading = then - at.reading;
      a[j].own = a[j].reading / P;
      own -= size[j];
    }
    a[kSensorLags.size()].reading = begin_Pa - at.end;
    a[kSensorLags.size()].own = a[kSensorLags.size()].reading / P;
    read_[k] = at.reading;
    return own;
  }

 private:
  std::vector<double> read_;  ///< [tick] what the filter takes the chamber's own reading to have been
};

}  // namespace

std::unique_ptr<LatentTerms> sensor_terms(const LatentScene& rig) {
  return std::make_unique<SensorTerms>(rig);
}

}  // namespace plenum::host::diagnose
