#include "host-sim/diagnose/latent_filter.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace plenum::host::diagnose {

Track::Track(const Record& of) : record(&of), begin_Pa(of.measured_Pa.front()) {
  about.pressure.assign(of.measured_Pa.begin(), of.measured_Pa.end() - 1);
  about.middle_Pa = about.pressure;
  about.d.assign(ticks(), 0.0);
}

double LatentFilter::Update::cost() const {
  return std::log(S) + innovation * innovation / S;
}

LatentFilter::LatentFilter(const Track& track, const MarkovNoise& noise, const Spread& spread)
    : track_(track),
      noise_(noise),
      reading_Pa_(spread.reading_Pa),
      keep_(std::exp(-track.record->drive.timing.tick_s / noise.memory_s)),
      s_{track.begin_Pa, 0.0, spread.begin_Pa * spread.begin_Pa, 0.0, noise.size * noise.size} {}

void LatentFilter::hold_pressure(double low_Pa, double high_Pa) {
  s_.x = std::clamp(s_.x, low_Pa, high_Pa);
}

LatentFilter::Update LatentFilter::update(std::size_t k) {
  const Linear& l = track_.linear[k];
  Update u;
  u.C = l.by_pressure.reading;
  u.E = track_.by_d[k].reading;
  const double rough = 0.5 * track_.rough[k];
  u.S = u.C * u.C * s_.xx + 2.0 * u.C * u.E * s_.xd + u.E * u.E * s_.dd + reading_Pa_ * reading_Pa_ +
        rough * rough;
  u.Kx = (u.C * s_.xx + u.E * s_.xd) / u.S;
  u.Kd = (u.C * s_.xd + u.E * s_.dd) / u.S;
  u.innovation =
      track_.record->measured_Pa[k + 1] -
      (l.at.reading + track_.sensor[k] + u.C * (s_.x - track_.at_Pa[k]) + u.E * (s_.d - track_.about.d[k]));
  s_.x += u.Kx * u.innovation;
  s_.d += u.Kd * u.innovation;
  s_.xx -= u.Kx * u.Kx * u.S;
  s_.xd -= u.Kx * u.Kd * u.S;
  s_.dd -= u.Kd * u.Kd * u.S;
  return u;
}

void LatentFilter::advance(std::size_t k) {
  const Linear& l = track_.linear[k];
  const double A = l.by_pressure.end;
  const double G = track_.by_d[k].end;
  const double x = l.at.end + A * (s_.x - track_.at_Pa[k]) + G * (s_.d - track_.about.d[k]);
  const double xx = A * A * s_.xx + 2.0 * A * G * s_.xd + G * G * s_.dd + track_.rough[k] * track_.rough[k];
  const double xd = keep_ * (A * s_.xd + G * s_.dd);
  s_ = {x, keep_ * s_.d, xx, xd, keep_ * keep_ * s_.dd + (1.0 - keep_ * keep_) * noise_.size * noise_.size};
}

double cost_of(const Track& track, const MarkovNoise& noise, const LatentFilter::Spread& spread) {
  LatentFilter filter(track, noise, spread);
  double sum = 0.0;
  for (std::size_t k = 0; k < track.ticks(); ++k) {
    const LatentFilter::Update u = filter.update(k);
    if (k + 1 >= track.record->settled_rows) sum += u.cost();
    filter.advance(k);
  }
  return sum;
}

std::vector<double> smoothed_disturbance(const Track& track, const MarkovNoise& noise,
                                         const LatentFilter::Spread& spread) {
  const std::size_t ticks = track.ticks();
  std::vector<LatentFilter::State> filtered(ticks), predicted(ticks);
  LatentFilter filter(track, noise, spread);
  for (std::size_t k = 0; k < ticks; ++k) {
    predicted[k] = filter.state();
    filter.update(k);
    filtered[k] = filter.state();
    filter.advance(k);
  }
  std::vector<double> smooth(ticks);
  double x = filtered.back().x;
  double d = filtered.back().d;
  for (std::size_t k = ticks; k-- > 0;) {
    const LatentFilter::State& f = filtered[k];
    if (k + 1 < ticks) {
      const LatentFilter::State& p = predicted[k + 1];
      Eigen::Matrix2d before, next, move;
      before << f.xx, f.xd, f.xd, f.dd;
      next << p.xx, p.xd, p.xd, p.dd;
      move << track.linear[k].by_pressure.end, track.by_d[k].end, 0.0, filter.keep();
      next.diagonal().array() *= 1.0 + 1e-9;
      const Eigen::Matrix2d gain = before * move.transpose() * next.inverse();
      const Eigen::Vector2d jump(x - p.x, d - p.d);
      const Eigen::Vector2d back = gain * jump;
      x = f.x + back[0];
      d = f.d + back[1];
    }
    smooth[k] = d;
  }
  return smooth;
}

void add_gram(const Track& track, const MarkovNoise& noise, const LatentFilter::Spread& spread,
              Eigen::MatrixXd& gram) {
  const auto n = static_cast<Eigen::Index>(track.columns);
  constexpr Eigen::Index kBatch = 64;
  Eigen::MatrixXd batch = Eigen::MatrixXd::Zero(n + 1, kBatch);
  Eigen::VectorXd xs = Eigen::VectorXd::Zero(n), ds = Eigen::VectorXd::Zero(n), c(n), x_new(n);
  LatentFilter filter(track, noise, spread);
  Eigen::Index at = 0;
  for (std::size_t k = 0; k < track.ticks(); ++k) {
    const Eigen::Map<const Eigen::VectorXd> end(track.end_by(k), n), reading(track.reading_by(k), n);
    const LatentFilter::Update u = filter.update(k);
    c.noalias() = u.C * xs + u.E * ds + reading;
    if (k + 1 >= track.record->settled_rows) {
      const double w = 1.0 / std::sqrt(u.S);
      batch.col(at).head(n) = w * c;
      batch(n, at) = w * u.innovation;
      if (++at == kBatch) {
        gram.selfadjointView<Eigen::Upper>().rankUpdate(batch);
        at = 0;
      }
    }
    xs.noalias() -= u.Kx * c;
    ds.noalias() -= u.Kd * c;
    filter.advance(k);
    x_new.noalias() = track.linear[k].by_pressure.end * xs + track.by_d[k].end * ds + end;
    xs.swap(x_new);
    ds *= filter.keep();
  }
  if (at > 0) gram.selfadjointView<Eigen::Upper>().rankUpdate(batch.leftCols(at));
}

}  // namespace plenum::host::diagnose
