// A disturbance of the energy: heat d. Terms: the gas's temperature; the volume, its motion and its delay.
#include "host-sim/diagnose/latent_terms.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace plenum::host::diagnose {
namespace {

constexpr std::array kHeat_s{0.03, 0.1, 0.3, 1.0, 3.0};
constexpr std::array<std::size_t, 3> kVolumeLags{2, 6, 15};  // ticks

class EnergyTerms : public LatentTerms {
 public:
  using LatentTerms::LatentTerms;

  std::vector<Term> terms() const override {
    std::vector<Term> terms;
    add(terms, "the gas's temperature", 0.5, 2 * kHeat_s.size());
    add(terms, "the volume", rig_.volume_moves ? 0.2 : kNever, 2);
    add(terms, "the volume's motion", rig_.volume_moves ? 0.5 : kNever, kVolumeLags.size() + 1);
    return terms;
  }
  DisturbanceScale disturbance() const override { return {.start_size = 0.5, .unit = "1/s"}; }
  void begin(const Background& b) override {
    followed_.clear();
    for (const double power : {0.0, 1.0}) {
      for (const double tau : kHeat_s) followed_.push_back(cooling(tau, power, b));
    }
  }
  void act(const Background& b, std::size_t k, const TickActions& tick) const override {
    Action* const a = tick.terms;
    Action& w = tick.disturbance;
    std::size_t i = 0;
    const double middle = b.about->middle_Pa[k];
    const effects::Timing& timing = b.record->drive.timing;
    const auto steps = static_cast<std::size_t>(timing.steps);
    const std::vector<double>& volume = b.record->drive.volume_m3;
    const double v = volume[k * steps];
    const double v_next = volume[(k + 1) * steps];
    const double per_rate = 0.5 * (v + v_next) * middle / (rig_.chamber.kappa() * rig_.chamber.RT());
    w.input[kFlow] = per_rate;
    w.own = 1.0;
    for (std::size_t j = 0; j < followed_.size(); ++j, ++i) {
      a[i].own = followed_[j][k];
      a[i].input[kFlow] = per_rate * a[i].own;
    }
    const double flow_rate =
        (b.in_flow[k] - b.ex_flow[k]) * rig_.chamber.kappa() * rig_.chamber.RT() / (middle * v);
    const double compression = -rig_.chamber.kappa() * (v_next - v) / (timing.tick_s * v);
    a[i].input[kVolume] = b.mean_volume;
    a[i++].own = -(flow_rate + compression) * b.mean_volume / v;
    const double bend = (v - b.mean_volume);
    a[i].input[kVolume] = bend;
    a[i].input[kFlow] = per_rate * compression;
    a[i].own = -(flow_rate + compression) * bend / v + compression;
    ++i;
    for (const std::size_t lag : kVolumeLags) {
      const std::size_t then = (k - std::min(k, lag)) * steps;
      const double D = volume[then] - v;
      const double change = volume[then + steps] - v_next - D;
      a[i].input[kVolume] = D;
      const double moved = -rig_.chamber.kappa() * change / (timing.tick_s * v);
      a[i].input[kFlow] = per_rate * moved;
      a[i].own = moved - (flow_rate + compression) * D / v;
      ++i;
    }
    a[i].own = compression;
    a[i].input[kFlow] = per_rate * compression;
  }

 private:
  /// Rate of the pressure's logarithm [1/s] as gas that flow and volume have warmed, by (4), comes back to the wall's temperature: in tau
  /// at half the supply and the mean volume, which grows as its mass to this power.
  std::vector<double> cooling(double tau, double power, const Background& b) const {
    constexpr double kHottest = 4.0;  // over the wall's temperature, and its reciprocal
    const effects::Timing& timing = b.record->drive.timing;
    const auto steps = static_cast<std::size_t>(timing.steps);
    const double kappa = rig_.chamber.kappa();
    std::vector<double> fall(b.about->pressure.size());
    double warmth = 1.0;  // the gas's temperature over the wall's
    for (std::size_t k = 0; k < fall.size(); ++k) {
      const double v = b.record->drive.volume_m3[k * steps];
      const double squeezed = b.record->drive.volume_m3[(k + 1) * steps] / v - 1.0;
      const double pv = b.about->middle_Pa[k] * v;
      const double flown = (b.in_flow[k] - b.ex_flow[k]) * rig_.chamber.RT() * timing.tick_s / pv;
      const double moved = warmth * std::exp(flown * (kappa - warmth) - (kappa - 1.0) * squeezed);
      const double density = pv / (0.5 * rig_.scene.around.supply_Pa * b.mean_volume * warmth);
      const double rate = std::pow(std::max(density, 0.05), -power) / tau;
      const double before = std::clamp(moved, 1.0 / kHottest, kHottest);
      warmth = 1.0 + (before - 1.0) * std::exp(-timing.tick_s * rate);
      fall[k] = std::log(warmth / before) / timing.tick_s;
    }
    return fall;
  }

  std::vector<std::vector<double>> followed_;  ///< [power, time constant][tick]
};

}  // namespace

std::unique_ptr<LatentTerms> energy_terms(const LatentScene& rig) {
  return std::make_unique<EnergyTerms>(rig);
}

}  // namespace plenum::host::diagnose
