// A disturbance of the command: areas at u + d. Terms: the command up to 0.1 s before, and plays (hysteresis).
#include "host-sim/diagnose/latent_terms.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace plenum::host::diagnose {
namespace {

constexpr std::array kLagParts{1, 2, 3, 4, 6, 9, 14, 22};  // of the command, in parts of a tick
constexpr std::array kPlays_V{0.02, 0.06, 0.2, 0.6};       // full widths

class CommandTerms : public LatentTerms {
 public:
  explicit CommandTerms(const LatentScene& rig) : LatentTerms(rig) { weigh_lags(); }

  std::vector<Term> terms() const override {
    std::vector<Term> terms;
    add(terms, "the command before", 0.5, kLagParts.size());
    add(terms, "the command's reversals", 0.5, kPlays_V.size());
    return terms;
  }
  DisturbanceScale disturbance() const override {
    return {.start_size = 0.05, .unit = "V", .may_drift = true};
  }
  double command_V(double logged_V, double d) const override { return logged_V + d; }
  void begin(const Background& b) override {
    played_.clear();
    at_played_.clear();
    for (const double width : kPlays_V) play(width, b);
  }
  void act(const Background& b, std::size_t k, const TickActions& tick) const override {
    Action* const a = tick.terms;
    Action& w = tick.disturbance;
    std::size_t i = 0;
    w.open(kInlet, b.at[k].inlet.slope);
    w.open(kExhaust, -b.at[k].exhaust.slope);
    w.own = 1.0;
    for (std::size_t j = 0; j < kLagParts.size(); ++j, ++i) {
      for (std::size_t part = 0; part < kParts; ++part) {
        for (const auto& [ticks_ago, weight] : lagging_[j][part]) {
          const std::size_t then = k - std::min(k, ticks_ago);
          a[i].input[kInlet + part] += weight * (b.at[then].inlet.area - b.at[k].inlet.area);
          a[i].input[kExhaust + part] += weight * (b.at[then].exhaust.area - b.at[k].exhaust.area);
          a[i].own += weight * (b.u[then] - b.u[k]) / kParts;
          if (std::abs(tick.size[i]) < 0.02) continue;
          for (std::size_t f = 0; f < 4; ++f) {
            tick.inlet_by[part][f] += tick.size[i] * weight * (b.at[then].inlet.by[f] - b.at[k].inlet.by[f]);
            tick.exhaust_by[part][f] +=
                tick.size[i] * weight * (b.at[then].exhaust.by[f] - b.at[k].exhaust.by[f]);
          }
        }
      }
    }
    for (std::size_t j = 0; j < kPlays_V.size(); ++j, ++i) {
      const Ports& x = at_played_[j][k];
      a[i].open(kInlet, x.inlet.area - b.at[k].inlet.area);
      a[i].open(kExhaust, x.exhaust.area - b.at[k].exhaust.area);
      for (std::size_t part = 0; part < kParts; ++part) {
        for (std::size_t f = 0; f < 4; ++f) {
          tick.inlet_by[part][f] += tick.size[i] * (x.inlet.by[f] - b.at[k].inlet.by[f]);
          tick.exhaust_by[part][f] += tick.size[i] * (x.exhaust.by[f] - b.at[k].exhaust.by[f]);
        }
      }
      a[i].own = played_[j][k] - b.u[k];
    }
  }

 private:
  void weigh_lags() {
    for (std::size_t j = 0; j < kLagParts.size(); ++j) {
      const int from = j > 0 ? kLagParts[j - 1] : 0;
      const int middle = kLagParts[j];
      const int to = j + 1 < kLagParts.size() ? kLagParts[j + 1] : middle + 1;
      const double sum = 0.5 * (to - from);
      lagging_.emplace_back();
      for (int part = 0; part < kParts; ++part) {
        auto& weights = lagging_.back()[static_cast<std::size_t>(part)];
        for (int lag = from + 1; lag < to; ++lag) {
          const double weight = lag <= middle ? static_cast<double>(lag - from) / (middle - from)
                                              : static_cast<double>(to - lag) / (to - middle);
          const auto ago = static_cast<std::size_t>((lag - part + kParts - 1) / kParts);
          if (ago == 0) continue;
          if (weights.empty() || weights.back().first != ago) weights.emplace_back(ago, 0.0);
          weights.back().second += weight / sum;
        }
      }
    }
  }

  /// The command through a play of this width.
  void play(double width, const Background& b) {
    std::vector<double> x(b.u.size());
    std::vector<Ports> at(b.u.size());
    double last = b.u[0];
    for (std::size_t k = 0; k < x.size(); ++k) {
      last = std::clamp(last, b.u[k] - 0.5 * width, b.u[k] + 0.5 * width);
      x[k] = last;
      at[k] = ports_of(*b.figures, last);
    }
    played_.push_back(std::move(x));
    at_played_.push_back(std::move(at));
  }

  /// [lag][part of a tick]: ticks ago and weights, of a triangle over the parts around the lag.
  std::vector<std::array<std::vector<std::pair<std::size_t, double>>, kParts>> lagging_;
  std::vector<std::vector<double>> played_;  ///< [width][tick]
  std::vector<std::vector<Ports>> at_played_;
};

}  // namespace

std::unique_ptr<LatentTerms> command_terms(const LatentScene& rig) {
  return std::make_unique<CommandTerms>(rig);
}

}  // namespace plenum::host::diagnose
