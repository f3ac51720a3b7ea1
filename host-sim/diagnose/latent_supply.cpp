// A disturbance of the supply: its pressure times 1 + d. Terms: the flow drawn, now and up to a second before.
#include "host-sim/diagnose/latent_terms.hpp"

#include <array>
#include <cmath>

namespace plenum::host::diagnose {
namespace {

constexpr std::array kSupply_s{0.0, 0.03, 0.1, 0.3, 1.0};

class SupplyTerms : public LatentTerms {
 public:
  using LatentTerms::LatentTerms;

  std::vector<Term> terms() const override {
    std::vector<Term> terms;
    add(terms, "the flow drawn", 0.1, kSupply_s.size() + 1);
    return terms;
  }
  DisturbanceScale disturbance() const override {
    return {.start_size = 0.02, .per_unit = rig_.scene.around.supply_Pa, .unit = "Pa"};
  }
  void begin(const Background& b) override {
    followed_.clear();
    for (const double tau : kSupply_s)
      followed_.push_back(smoothed(b.in_flow, tau, b.record->drive.timing.tick_s));
  }
  void act(const Background& b, std::size_t k, const TickActions& tick) const override {
    Action* const a = tick.terms;
    Action& w = tick.disturbance;
    std::size_t i = 0;
    const double P = rig_.scene.around.supply_Pa;
    const double scale = rig_.flow_scale;
    w.input[kSupply] = P;
    w.own = 1.0;
    for (const std::vector<double>& x : followed_) {
      a[i].input[kSupply] = -P * x[k] / scale;
      a[i].own = -x[k] / scale;
      ++i;
    }
    a[i].own = -b.in_flow[k] * std::abs(b.in_flow[k]) / (scale * scale);
    a[i].input[kSupply] = P * a[i].own;
  }

 private:
  std::vector<std::vector<double>> followed_;  ///< [time constant][tick]
};

}  // namespace

std::unique_ptr<LatentTerms> supply_terms(const LatentScene& rig) {
  return std::make_unique<SupplyTerms>(rig);
}

}  // namespace plenum::host::diagnose
