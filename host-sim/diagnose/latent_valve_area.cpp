// A disturbance of the valve's areas: both times 1 + d. Terms: the opening of each port.
#include "host-sim/diagnose/latent_terms.hpp"

#include <array>

namespace plenum::host::diagnose {
namespace {

constexpr std::array kOpenings{0.02, 0.06, 0.12, 0.2, 0.3, 0.4, 0.5, 0.62};  // o/(o + 2 V)

class ValveAreaTerms : public LatentTerms {
 public:
  using LatentTerms::LatentTerms;

  std::vector<Term> terms() const override {
    std::vector<Term> terms;
    add(terms, "the supply port's opening", 0.3, kOpenings.size() - 1);
    add(terms, "the exhaust port's opening", 0.3, kOpenings.size() - 1);
    return terms;
  }
  DisturbanceScale disturbance() const override { return {.start_size = 0.05, .unit = ""}; }
  void act(const Background& b, std::size_t k, const TickActions& tick) const override {
    Action* const a = tick.terms;
    Action& w = tick.disturbance;
    std::size_t i = 0;
    w.open(kInlet, b.at[k].inlet.area);
    w.open(kExhaust, b.at[k].exhaust.area);
    w.own = 1.0;
    const double in_V = b.u[k] - (*b.figures)[effects::kOpenAbove];
    const double ex_V = (*b.figures)[effects::kExhaustBelow] - b.u[k];
    for (const bool inlet : {true, false}) {
      const double o = inlet ? in_V : ex_V;
      for (std::size_t j = 1; j < kOpenings.size(); ++j, ++i) {
        if (o <= 0.0) continue;
        const double h = hat(kOpenings, j, o / (o + 2.0));
        const double area = (*b.figures)[inlet ? effects::kInletGain : effects::kExhaustGain] * o * h;
        a[i].open(inlet ? kInlet : kExhaust, area);
        a[i].own = h;
      }
    }
  }
};

}  // namespace

std::unique_ptr<LatentTerms> valve_area_terms(const LatentScene& rig) {
  return std::make_unique<ValveAreaTerms>(rig);
}

}  // namespace plenum::host::diagnose
