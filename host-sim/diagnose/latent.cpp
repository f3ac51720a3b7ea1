#include "host-sim/diagnose/latent.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <numeric>

#include "host-sim/diagnose/latent_filter.hpp"
#include "host-sim/diagnose/latent_terms.hpp"
#include "host-sim/identify/in_parallel.hpp"

namespace plenum::host::diagnose {
namespace {

using effects::Equation;
using effects::Figures;
using effects::kValveFigures;

constexpr std::size_t kLeastRows = 50;
/// Columns of the normal equations: the valve's figures, by how much the pressures are stamped early, and the terms.
constexpr std::size_t kStamp = kValveFigures;
constexpr std::size_t kFirstTerm = kStamp + 1;
/// A form that no term holds leaves hundreds of nats at the wrong equation's advantage: with this, of 191 blind cases, the
/// answers given with 0.37, 0.66, 0.86, 0.95 and 0.99 were right in 0.79, 0.74, 0.92, 0.92 and 0.97 (fifths of them).
constexpr double kTemper = 9.0;

/// What an error of an equation could depend on: of two kinds of terms the one that does better speaks for it.
struct Kind {
  Equation equation;
  std::unique_ptr<LatentTerms> (*terms)(const LatentScene& rig);
};
constexpr std::array kKinds{
    Kind{Equation::command, late_command_terms},  Kind{Equation::command, spool_terms},
    Kind{Equation::valve_area, valve_area_terms}, Kind{Equation::mass_flow, mass_flow_terms},
    Kind{Equation::mass_flow, leak_terms},        Kind{Equation::supply, supply_terms},
    Kind{Equation::energy, energy_terms},         Kind{Equation::sensor, sensor_terms}};

/// One equation under suspicion.
class Suspect {
 public:
  Suspect(const Scene& scene, const std::vector<const Record*>& records, const Figures& recalibrated,
          const Kind& kind)
      : scene_(scene),
        rig_(scene, records),
        equation_(kind.equation),
        of_equation_(kind.terms(rig_)),
        disturbance_(of_equation_->disturbance()),
        terms_(of_equation_->terms()),
        figures_(recalibrated),
        term_(terms_.size(), 0.0),
        spread_{scene.noise_Pa, kStartSpread * scene.around.supply_Pa} {
    figures_[effects::kStampedEarly] = scene.nominal[effects::kStampedEarly];  // what errs may look so, too
    for (const Record* record : records) {
      tracks_.emplace_back(*record);
      tracks_.back().columns = columns();
    }
    actions_.resize(records.size());
  }

  LatentEquation examine() {
    noise_ = {disturbance_.start_size, 0.3};
    double at = sweep();
    double damping = 0.0;
    for (int pass = 0; pass < kPasses; ++pass) {
      const double begun = at;
      // what ticks taken as linear promise is believed when a sweep has shown it
      for (const bool near : {false, true}) {
        const Point before = present();
        choose_noise(near);
        renew();
        const double l = sweep();
        if (l > at) {
          at = l;
          break;
        }
        go_back(before);
        sweep();
      }
      const System system = evaluate();
      const Point before = present();
      for (int attempt = 0; attempt < kAttempts; ++attempt) {
        take(system.change(damping));
        const double l = sweep();
        if (l > at) {
          at = l;
          damping = damping > 0.02 ? 0.1 * damping : 0.0;
          break;
        }
        damping = std::max(10.0 * damping, 0.01);
        go_back(before);
        if (attempt + 1 == kAttempts) sweep();
      }
      if (at < begun + kWorthAPass) break;
    }
    log_likelihood_ = at - evaluate().occam;
    return answer();
  }

 private:
  static constexpr int kPasses = 8;
  static constexpr int kAttempts = 3;
  static constexpr double kWorthAPass = 5.0;  // [nat]

  /// What acts in the ticks of a record.
  struct Actions {
    std::vector<Inputs> inputs;
    std::vector<Action> terms;  // [tick][term]
    std::vector<Action> disturbance;
    std::vector<std::array<double, 4>> figure_inlet,
        figure_exhaust;  // [part of a tick]: of an area by a figure
  };

  struct Point {
    Figures figures{};
    std::vector<double> term;
    MarkovNoise noise;
    std::vector<About> about;  // a record
  };

  /// The normal equations of figures and terms, whitened.
  struct System {
    double occam = 0.0;  // [nat] what the terms' freedom costs
    Eigen::MatrixXd H;
    Eigen::VectorXd g;
    Eigen::VectorXd least, most;  // what each may change by

    /// What would leave its bounds stays at them, and the others are chosen for that.
    Eigen::VectorXd change(double damping) const {
      Eigen::MatrixXd damped = H;
      damped.diagonal() *= 1.0 + damping;
      Eigen::VectorXd towards = g;
      for (Eigen::Index round = 0;; ++round) {
        const Eigen::VectorXd scale = damped.diagonal().cwiseSqrt().cwiseInverse();
        const Eigen::MatrixXd scaled = scale.asDiagonal() * damped * scale.asDiagonal();
        const Eigen::VectorXd free = scale.cwiseProduct(scaled.ldlt().solve(scale.cwiseProduct(towards)));
        Eigen::VectorXd held = free.cwiseMax(least).cwiseMin(most);
        Eigen::Index farthest = 0;
        const double beyond = ((free - held).cwiseAbs().cwiseQuotient(scale)).maxCoeff(&farthest);
        if (!(beyond > 1e-9) || round == free.size()) return held;
        const double at = held[farthest];
        towards -= damped.col(farthest) * at;
        damped.row(farthest).setZero();
        damped.col(farthest).setZero();
        damped(farthest, farthest) = H(farthest, farthest);
        towards[farthest] = H(farthest, farthest) * at;
      }
    }
  };

  std::size_t columns() const { return kFirstTerm + terms_.size(); }

  Background background(const Track& t) const {
    const Record& record = *t.record;
    const std::size_t ticks = t.ticks();
    Background b;
    b.record = &record;
    b.about = &t.about;
    b.figures = &figures_;
    b.u.resize(ticks);
    b.at.resize(ticks);
    b.in_flow.resize(ticks);
    b.ex_flow.resize(ticks);
    for (std::size_t k = 0; k < ticks; ++k) {
      const double middle = t.about.middle_Pa[k];
      b.u[k] = of_equation_->command_V(record.drive.command_V[k], t.about.d[k]);
      b.at[k] = ports_of(figures_, b.u[k]);
      b.in_flow[k] = b.at[k].inlet.area * rig_.chamber.plate().phi(scene_.around.supply_Pa, middle);
      b.ex_flow[k] = b.at[k].exhaust.area * rig_.chamber.plate().phi(middle, scene_.around.ambient_Pa);
    }
    const std::vector<double>& v = record.drive.volume_m3;
    b.mean_volume = std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
    return b;
  }

  void act(const Track& t, Actions& acts) const {
    const std::size_t ticks = t.ticks();
    const double Pa = scene_.around.ambient_Pa;
    const std::size_t n = terms_.size();
    acts.terms.assign(ticks * n, {});
    acts.disturbance.assign(ticks, {});
    acts.inputs.assign(ticks, {});
    acts.figure_inlet.assign(ticks * kParts, {});
    acts.figure_exhaust.assign(ticks * kParts, {});
    const Background b = background(t);
    of_equation_->begin(b);
    for (std::size_t k = 0; k < ticks; ++k) {
      Inputs& base = acts.inputs[k];
      base[kSupply] = scene_.around.supply_Pa;
      base[kBehind] = Pa;
      for (std::size_t part = 0; part < kParts; ++part) {
        base[kInlet + part] = b.at[k].inlet.area;
        base[kExhaust + part] = b.at[k].exhaust.area;
        acts.figure_inlet[k * kParts + part] = b.at[k].inlet.by;
        acts.figure_exhaust[k * kParts + part] = b.at[k].exhaust.by;
      }
      Action* const a = acts.terms.data() + k * n;
      of_equation_->act(b, k,
                        {a, acts.disturbance[k], term_, acts.figure_inlet.data() + k * kParts,
                         acts.figure_exhaust.data() + k * kParts});
      for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t c = 0; c < kInputs; ++c) base[c] += term_[j] * a[j].input[c];
      }
      for (std::size_t c = kInlet; c < kSupply; ++c) base[c] = std::max(base[c], 0.0);
      base[kSupply] = std::max(base[kSupply], 1.05 * Pa);
      base[kBehind] = std::clamp(base[kBehind], 0.9 * Pa, scene_.around.supply_Pa);
    }
  }

  Point present() const {
    Point point{figures_, term_, noise_, {}};
    point.about.reserve(tracks_.size());
    for (const Track& t : tracks_) point.about.push_back(t.about);
    return point;
  }
  void go_back(const Point& point) {
    figures_ = point.figures;
    term_ = point.term;
    noise_ = point.noise;
    for (std::size_t r = 0; r < tracks_.size(); ++r) tracks_[r].about = point.about[r];
  }

  /// Of the innovations, `cost` being the sum of theirs, and of what figures and terms are beyond what was expected of them.
  double likelihood(double cost) const {
    const double l = -0.5 * (cost + beyond_expected().cwiseQuotient(spreads()).squaredNorm());
    return std::isfinite(l) ? l : -std::numeric_limits<double>::infinity();
  }
  /// With another noise, each tick linear as it is.
  double likelihood(const MarkovNoise& noise) const {
    double cost = 0.0;
    for (const Track& t : tracks_) cost += cost_of(t, noise, spread_);
    return likelihood(cost);
  }
  /// Runs the filter at the present figures and terms and takes each tick linear about it.
  double sweep() {
    double cost = 0.0;
    for (std::size_t r = 0; r < tracks_.size(); ++r) cost += sweep(tracks_[r], actions_[r]);
    return likelihood(cost);
  }
  double sweep(Track& t, Actions& acts) const {
    act(t, acts);
    const std::size_t ticks = t.ticks();
    const Record& record = *t.record;
    const auto steps = static_cast<std::size_t>(record.drive.timing.steps);
    const std::size_t m = terms_.size();
    t.linear.resize(ticks);
    t.sensor.assign(ticks, 0.0);
    t.at_Pa.resize(ticks);
    t.tangent.assign(ticks * columns() * 2, 0.0);
    t.rough.resize(ticks);
    t.by_d.resize(ticks);
    LatentFilter filter(t, noise_, spread_);
    // a piston that moves in compresses to more than the supply
    const double most_Pa =
        2.0 * std::max(scene_.around.supply_Pa,
                       *std::max_element(record.measured_Pa.begin(), record.measured_Pa.end()));
    double cost = 0.0;
    for (std::size_t k = 0; k < ticks; ++k) {
      Linear& l = t.linear[k];
      filter.hold_pressure(5e3, most_Pa);
      const double begin_Pa = filter.state().x;
      t.at_Pa[k] = begin_Pa;
      l = rig_.chamber.tick(begin_Pa, acts.inputs[k], record.drive.volume_m3.data() + k * steps,
                            record.drive.timing, figures_[effects::kStampedEarly]);
      Action* const a = acts.terms.data() + k * m;
      const double own = of_equation_->derive(k, begin_Pa, l.at, a, term_);
      for (std::size_t j = 0; j < m; ++j) t.sensor[k] += term_[j] * a[j].reading;
      l.by_pressure.reading *= own;
      l.reading_by_early *= own;
      for (Outcome& o : l.by_input) o.reading *= own;
      fill_tangents(t, acts, k);
      const LatentFilter::Update u = filter.update(k);
      if (k + 1 >= record.settled_rows) cost += u.cost();
      filter.advance(k);
    }
    return cost;
  }

  void fill_tangents(Track& t, const Actions& acts, std::size_t k) const {
    const Linear& l = t.linear[k];
    double* const end = t.end_by(k);
    double* const reading = t.reading_by(k);
    const auto add = [&](std::size_t column, std::size_t input, double by) {
      end[column] += by * l.by_input[input].end;
      reading[column] += by * l.by_input[input].reading;
    };
    for (std::size_t part = 0; part < kParts; ++part) {
      const std::array<double, 4>& in = acts.figure_inlet[k * kParts + part];
      const std::array<double, 4>& ex = acts.figure_exhaust[k * kParts + part];
      add(effects::kOpenAbove, kInlet + part, in[0]);
      add(effects::kInletGain, kInlet + part, in[1]);
      add(effects::kInletLeak, kInlet + part, in[2]);
      add(effects::kTransition, kInlet + part, in[3]);
      add(effects::kExhaustBelow, kExhaust + part, ex[0]);
      add(effects::kExhaustGain, kExhaust + part, ex[1]);
      add(effects::kExhaustLeak, kExhaust + part, ex[2]);
      add(effects::kTransition, kExhaust + part, ex[3]);
    }
    reading[kStamp] = l.reading_by_early;
    for (std::size_t j = 0; j < terms_.size(); ++j) {
      const Action& a = acts.terms[k * terms_.size() + j];
      for (std::size_t c = 0; c < kInputs; ++c) {
        if (a.input[c] != 0.0) add(kFirstTerm + j, c, a.input[c]);
      }
      reading[kFirstTerm + j] += a.reading;
    }
    const Action& disturbed = acts.disturbance[k];
    Outcome& d = t.by_d[k];
    d = {0.0, disturbed.reading};
    for (std::size_t c = 0; c < kInputs; ++c) {
      d.end += disturbed.input[c] * l.by_input[c].end;
      d.reading += disturbed.input[c] * l.by_input[c].reading;
    }
    t.rough[k] = kRough_Pa + kRoughShare * std::abs(l.at.end - t.at_Pa[k]);
  }

  Eigen::VectorXd spreads() const {
    Eigen::VectorXd s(static_cast<Eigen::Index>(columns()));
    s << 0.2, 0.2, 0.5 * rig_.gain, 0.5 * rig_.gain, 0.1 * rig_.gain, 0.1 * rig_.gain, 0.1 * rig_.gain,
        std::max(kStampSpread * scene_.most_early_s, kGivenStamp_s),
        Eigen::VectorXd::Zero(static_cast<Eigen::Index>(terms_.size()));
    for (std::size_t j = 0; j < terms_.size(); ++j)
      s[static_cast<Eigen::Index>(kFirstTerm + j)] = terms_[j].spread;
    return s;
  }
  Eigen::VectorXd beyond_expected() const {
    Eigen::VectorXd s(static_cast<Eigen::Index>(columns()));
    for (std::size_t j = 0; j < kValveFigures; ++j)
      s[static_cast<Eigen::Index>(j)] = figures_[j] - scene_.nominal[j];
    s[static_cast<Eigen::Index>(kStamp)] =
        figures_[effects::kStampedEarly] - scene_.nominal[effects::kStampedEarly];
    for (std::size_t j = 0; j < terms_.size(); ++j) s[static_cast<Eigen::Index>(kFirstTerm + j)] = term_[j];
    return s;
  }

  void bound(System& system) const {
    system.most.setConstant(static_cast<Eigen::Index>(columns()), std::numeric_limits<double>::infinity());
    system.least = -system.most;
    for (const std::size_t j : {effects::kInletGain, effects::kExhaustGain})
      system.least[static_cast<Eigen::Index>(j)] = 0.05 * rig_.gain - figures_[j];
    for (const std::size_t j : {effects::kInletLeak, effects::kExhaustLeak})
      system.least[static_cast<Eigen::Index>(j)] = -figures_[j];
    system.least[effects::kTransition] = 1e-3 * rig_.gain - figures_[effects::kTransition];
    const double early_s = figures_[effects::kStampedEarly];
    system.least[kStamp] = -early_s;
    system.most[kStamp] = std::max(scene_.most_early_s - early_s, 0.0);
  }

  System evaluate() const {
    const auto n = static_cast<Eigen::Index>(columns());
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(n + 1, n + 1);
    for (const Track& t : tracks_) add_gram(t, noise_, spread_, gram);
    gram = Eigen::MatrixXd(gram.selfadjointView<Eigen::Upper>());
    const Eigen::VectorXd precision = spreads().array().square().inverse();
    const Eigen::VectorXd beyond = beyond_expected();
    Eigen::MatrixXd H = gram.topLeftCorner(n, n);
    H.diagonal() += precision;
    System system;
    bound(system);
    system.g = gram.col(n).head(n) - precision.cwiseProduct(beyond);
    system.H = H;
    const Eigen::VectorXd scale = H.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::LDLT<Eigen::MatrixXd> solver(scale.asDiagonal() * H * scale.asDiagonal());
    // a term that is not seen costs nothing: it could have been left out
    const Eigen::VectorXd variance =
        solver.solve(Eigen::MatrixXd::Identity(n, n)).diagonal().cwiseProduct(scale.cwiseAbs2());
    for (std::size_t j = 0; j < terms_.size(); ++j) {
      const double error = std::sqrt(variance[static_cast<Eigen::Index>(kFirstTerm + j)]);
      if (std::abs(term_[j]) > kSeen * error)
        system.occam += std::max(0.0, std::log(terms_[j].spread / error));
    }
    return system;
  }

  /// Size and memory of the disturbance, or its size alone `near` the present one.
  void choose_noise(bool near) {
    double best = -std::numeric_limits<double>::infinity();
    const MarkovNoise present = noise_;
    MarkovNoise chosen = present;
    for (const double memory : kMemories_s) {
      for (int i = -8; i <= 3; ++i) {
        const MarkovNoise noise{disturbance_.start_size * std::pow(10.0, 0.5 * i), memory};
        const double ratio = noise.size / present.size;
        if (near && (memory != present.memory_s || ratio > 3.5 || ratio < 0.28)) continue;
        const double l = likelihood(noise);
        if (l > best) {
          best = l;
          chosen = noise;
        }
      }
    }
    noise_ = chosen;
  }

  void take(const Eigen::VectorXd& change) {
    for (std::size_t j = 0; j < kValveFigures; ++j) figures_[j] += change[static_cast<Eigen::Index>(j)];
    figures_[effects::kStampedEarly] += change[static_cast<Eigen::Index>(kStamp)];
    for (std::size_t j = 0; j < terms_.size(); ++j)
      term_[j] += change[static_cast<Eigen::Index>(kFirstTerm + j)];
  }

  /// The terms are taken at what the filter expects now, and a slow drift of the command, which is more than the
  /// areas' slopes can follow, where it is now.
  void renew() {
    const bool drifts = disturbance_.may_drift && noise_.memory_s >= 1.0;
    for (Track& t : tracks_) {
      for (std::size_t k = 0; k < t.ticks(); ++k) {
        t.about.pressure[k] = t.at_Pa[k];
        t.about.middle_Pa[k] = 0.5 * (t.at_Pa[k] + std::max(t.linear[k].at.end, 5e3));
      }
      if (drifts) {
        t.about.d = smoothed_disturbance(t, noise_, spread_);
      } else {
        t.about.d.assign(t.ticks(), 0.0);
      }
    }
  }

  LatentEquation answer() const {
    LatentEquation a;
    a.equation = equation_;
    a.log_likelihood = log_likelihood_;
    a.memory_s = noise_.memory_s;
    a.unit = disturbance_.unit;
    const double unit = disturbance_.per_unit;
    std::vector<std::string> groups{"time"};  // the disturbance itself, which depends on no term
    std::vector<std::size_t> group_of;
    for (const Term& term : terms_) {
      const auto at = std::find(groups.begin(), groups.end(), term.group);
      group_of.push_back(static_cast<std::size_t>(at - groups.begin()));
      if (at == groups.end()) groups.push_back(term.group);
    }
    std::vector<double> part(groups.size()), without(groups.size(), 0.0);
    double all = 0.0, rest = 0.0, count = 0.0;
    for (std::size_t r = 0; r < tracks_.size(); ++r) {
      const std::vector<double> smooth = smoothed_disturbance(tracks_[r], noise_, spread_);
      const Actions& acts = actions_[r];
      std::vector<double> whole(smooth.size());
      for (std::size_t k = 0; k < whole.size(); ++k) {
        std::fill(part.begin(), part.end(), 0.0);
        part[0] = smooth[k] * acts.disturbance[k].own;
        rest += part[0] * part[0];
        for (std::size_t j = 0; j < terms_.size(); ++j)
          part[group_of[j]] += term_[j] * acts.terms[k * terms_.size() + j].own;
        const double sum = std::accumulate(part.begin(), part.end(), 0.0);
        whole[k] = unit * sum;
        all += sum * sum;
        for (std::size_t g = 0; g < part.size(); ++g) without[g] += (sum - part[g]) * (sum - part[g]);
        count += 1.0;
      }
      a.disturbance.push_back(std::move(whole));
    }
    if (!of_equation_->is_possible(a.disturbance))
      a.log_likelihood = -std::numeric_limits<double>::infinity();
    a.early_s = figures_[effects::kStampedEarly];
    a.size = unit * std::sqrt(all / count);
    a.rest = unit * std::sqrt(rest / count);
    for (std::size_t g = 0; g < groups.size(); ++g)
      a.terms.push_back({groups[g], all > 0.0 ? std::max(0.0, 1.0 - without[g] / all) : 0.0});
    std::stable_sort(a.terms.begin(), a.terms.end(),
                     [](const auto& x, const auto& y) { return x.share > y.share; });
    return a;
  }
  static constexpr std::array<double, 5> kMemories_s{0.002, 0.05, 0.3, 2.0, 20.0};
  static constexpr double kGivenStamp_s = 1e-9;  // of one that is not looked for
  static constexpr double kStampSpread = 0.3;    // of the most that is looked for
  static constexpr double kSeen = 3.0;           // standard errors
  static constexpr double kRough_Pa = 20.0;
  static constexpr double kRoughShare = 0.003;
  static constexpr double kStartSpread = 0.03;

  const Scene& scene_;
  LatentScene rig_;
  Equation equation_;
  std::unique_ptr<LatentTerms> of_equation_;
  DisturbanceScale disturbance_;
  std::vector<Term> terms_;
  Figures figures_;
  std::vector<double> term_;
  MarkovNoise noise_;
  LatentFilter::Spread spread_;
  std::vector<Track> tracks_;
  std::vector<Actions> actions_;  ///< a track
  double log_likelihood_ = 0.0;
};

}  // namespace

std::vector<LatentEquation> latent(const Scene& scene, const std::vector<const Record*>& records,
                                   const Figures& recalibrated, unsigned threads) {
  std::vector<const Record*> long_enough;
  std::copy_if(records.begin(), records.end(), std::back_inserter(long_enough),
               [](const Record* record) { return record->rows() >= kLeastRows; });
  if (long_enough.empty()) return {};
  std::vector<LatentEquation> found(kKinds.size());
  identify::in_parallel(kKinds.size(), threads, [&](std::size_t i) {
    found[i] = Suspect(scene, long_enough, recalibrated, kKinds[i]).examine();
  });
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.log_likelihood > b.log_likelihood; });
  std::vector<Equation> seen;  // of an equation's kinds the best speaks
  std::erase_if(found, [&](const LatentEquation& of) {
    const bool again = std::find(seen.begin(), seen.end(), of.equation) != seen.end();
    seen.push_back(of.equation);
    return again;
  });
  const double best = found.front().log_likelihood;
  double sum = 0.0;
  for (LatentEquation& e : found) {
    e.probability = std::isfinite(best) ? std::exp(-std::sqrt(best - e.log_likelihood) / kTemper) : 1.0;
    sum += e.probability;
  }
  for (LatentEquation& e : found) e.probability /= sum;
  return found;
}

}  // namespace plenum::host::diagnose
