// A disturbance of the command: areas at u + d. Terms: plays (hysteresis), and either the areas of the commands up to 11 ticks before, by
// which one that is late and one that is met bit by bit are told, or the areas that a spool has on its way, which passes the null.
#include "host-sim/diagnose/latent_terms.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace plenum::host::diagnose {
namespace {

/// Of the command, in parts of a tick; the ends have no term.
constexpr std::array kLagParts{0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 18.0, 28.0, 44.0, 45.0};
constexpr std::array kSpools{0.15, 0.4, 1.0, 2.5, 6.0};  // time constants [ticks], of two stages each
constexpr std::array kPlays_V{0.02, 0.06, 0.2, 0.6};     // full widths

/// Of a tick's parts.
using PartAreas = std::array<Ports, kParts>;

class CommandTerms : public LatentTerms {
 public:
  using LatentTerms::LatentTerms;

  std::vector<Term> terms() const override {
    std::vector<Term> terms;
    add(terms, "the command before", 0.5, lag_terms());
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
    Action& w = tick.disturbance;
    w.open(kInlet, b.at[k].inlet.slope);
    w.open(kExhaust, -b.at[k].exhaust.slope);
    w.own = 1.0;
    act_before(b, k, tick);
    for (std::size_t j = 0; j < kPlays_V.size(); ++j) {
      PartAreas at;
      at.fill(at_played_[j][k]);
      move(b, k, tick, lag_terms() + j, at, played_[j][k]);
    }
  }

 protected:
  /// Terms of the command before, which come first.
  virtual std::size_t lag_terms() const = 0;
  virtual void act_before(const Background& b, std::size_t k, const TickActions& tick) const = 0;

  /// Term i: the ports of another command, the mean of `command_V`, in the place of those that are open.
  static void move(const Background& b, std::size_t k, const TickActions& tick, std::size_t i,
                   const PartAreas& to, double command_V) {
    Action& a = tick.terms[i];
    for (std::size_t part = 0; part < kParts; ++part) {
      const Opening& in = to[part].inlet;
      const Opening& ex = to[part].exhaust;
      a.input[kInlet + part] = in.area - b.at[k].inlet.area;
      a.input[kExhaust + part] = ex.area - b.at[k].exhaust.area;
      for (std::size_t f = 0; f < 4; ++f) {
        tick.inlet_by[part][f] += tick.size[i] * (in.by[f] - b.at[k].inlet.by[f]);
        tick.exhaust_by[part][f] += tick.size[i] * (ex.by[f] - b.at[k].exhaust.by[f]);
      }
    }
    a.own = command_V - b.u[k];
  }

 private:
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

  std::vector<std::vector<double>> played_;  ///< [width][tick]
  std::vector<std::vector<Ports>> at_played_;
};

class LateCommandTerms : public CommandTerms {
 public:
  explicit LateCommandTerms(const LatentScene& rig) : CommandTerms(rig) {
    for (std::size_t j = 1; j + 1 < kLagParts.size(); ++j) lagging_.push_back(around(j));
  }

 private:
  /// Ticks ago and weights, of a part of a tick.
  using Weights = std::vector<std::pair<std::size_t, double>>;

  std::size_t lag_terms() const override { return lagging_.size(); }
  void act_before(const Background& b, std::size_t k, const TickActions& tick) const override {
    for (std::size_t j = 0; j < lagging_.size(); ++j) {
      PartAreas at;
      double command_V = b.u[k];
      for (std::size_t part = 0; part < kParts; ++part) {
        at[part] = b.at[k];
        for (const auto& [ticks_ago, weight] : lagging_[j][part]) {
          const std::size_t then = k - std::min(k, ticks_ago);
          add(at[part].inlet, weight, b.at[then].inlet, b.at[k].inlet);
          add(at[part].exhaust, weight, b.at[then].exhaust, b.at[k].exhaust);
          command_V += weight * (b.u[then] - b.u[k]) / kParts;
        }
      }
      move(b, k, tick, j, at, command_V);
    }
  }
  static void add(Opening& sum, double weight, const Opening& then, const Opening& now) {
    sum.area += weight * (then.area - now.area);
    for (std::size_t f = 0; f < sum.by.size(); ++f) sum.by[f] += weight * (then.by[f] - now.by[f]);
  }
  /// Of the parts of a tick: a triangle over the parts around lag j.
  static std::array<Weights, kParts> around(std::size_t j) {
    std::array<Weights, kParts> of;
    const auto from = static_cast<int>(kLagParts[j - 1]);
    const auto to = static_cast<int>(kLagParts[j + 1]);
    const double sum = 0.5 * (to - from);
    for (int part = 0; part < kParts; ++part) {
      Weights& weights = of[static_cast<std::size_t>(part)];
      for (int lag = from + 1; lag < to; ++lag) {
        const double weight = hat(kLagParts, j, lag);
        const auto ago = static_cast<std::size_t>((lag - part + kParts - 1) / kParts);
        if (ago == 0) continue;
        if (weights.empty() || weights.back().first != ago) weights.emplace_back(ago, 0.0);
        weights.back().second += weight / sum;
      }
    }
    return of;
  }

  std::vector<std::array<Weights, kParts>> lagging_;  ///< [lag]
};

class SpoolTerms : public CommandTerms {
 public:
  using CommandTerms::CommandTerms;

  void begin(const Background& b) override {
    CommandTerms::begin(b);
    spooled_.clear();
    at_spooled_.clear();
    for (const double ticks : kSpools) spool(ticks, b);
  }

 private:
  std::size_t lag_terms() const override { return kSpools.size(); }
  void act_before(const Background& b, std::size_t k, const TickActions& tick) const override {
    for (std::size_t j = 0; j < kSpools.size(); ++j) move(b, k, tick, j, at_spooled_[j][k], spooled_[j][k]);
  }
  /// The command behind two equal lags of first order; its areas in the middle of each part of a tick.
  void spool(double ticks, const Background& b) {
    std::vector<double> mean(b.u.size());
    std::vector<PartAreas> at(b.u.size());
    const double half_part_per_tau = 0.5 / (ticks * kParts);
    const double keep = std::exp(-half_part_per_tau);
    double first = b.u[0];
    double second = b.u[0];
    const auto half_a_part = [&](double u) {
      second = u + keep * (second - u + half_part_per_tau * (first - u));
      first = u + keep * (first - u);
    };
    for (std::size_t k = 0; k < b.u.size(); ++k) {
      for (Ports& of_part : at[k]) {
        half_a_part(b.u[k]);
        of_part = ports_of(*b.figures, second);
        mean[k] += second / kParts;
        half_a_part(b.u[k]);
      }
    }
    spooled_.push_back(std::move(mean));
    at_spooled_.push_back(std::move(at));
  }

  std::vector<std::vector<double>> spooled_;  ///< [time constant][tick]
  std::vector<std::vector<PartAreas>> at_spooled_;
};

}  // namespace

std::unique_ptr<LatentTerms> late_command_terms(const LatentScene& rig) {
  return std::make_unique<LateCommandTerms>(rig);
}

std::unique_ptr<LatentTerms> spool_terms(const LatentScene& rig) {
  return std::make_unique<SpoolTerms>(rig);
}

}  // namespace plenum::host::diagnose
