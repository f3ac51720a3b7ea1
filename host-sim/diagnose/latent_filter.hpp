// The filter under latent.hpp: pressure p and disturbance d of one record, each tick linear about (p', d').
//
//   y_(k+1) = reading_k + sensor_k + C (p_k - p') + E (d_k - d') + e,    e of variance noise^2 + (rough_k/2)^2
//   p_(k+1) = end_k + A (p_k - p') + G (d_k - d') + w,                   w of variance rough_k^2
//   d_(k+1) = a d_k + sqrt(1 - a^2) size v,    a = e^(-h/memory)         a first-order Markov process
//
// p [Pa]; d in the unit of its equation; A and C are linear.by_pressure, G and E by_d; rough is what a tick does that no equation is
// to blame for. Source: Kalman's filter, and the smoother of Rauch, Tung and Striebel, AIAA Journal 3 (1965).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "host-sim/diagnose/latent_terms.hpp"

namespace plenum::host::diagnose {

/// Of the disturbance: its standard deviation, and the time in which it forgets.
struct MarkovNoise {
  double size = 0.0, memory_s = 0.0;
};

/// A record as the filter sees it; all but the first three have an entry a tick.
struct Track {
  explicit Track(const Record& of);

  const Record* record;
  double begin_Pa;
  std::size_t columns = 0;  ///< of the normal equations: figures, stamp, terms
  About about;
  std::vector<double> at_Pa;  ///< p', where the filter was when the tick was linearised
  std::vector<Linear> linear;
  std::vector<Outcome> by_d;
  std::vector<double> sensor;   ///< what the sensor adds [Pa]
  std::vector<double> rough;    ///< [Pa]
  std::vector<double> tangent;  ///< [tick][end, reading][column]

  std::size_t ticks() const { return about.pressure.size(); }
  double* end_by(std::size_t k) { return tangent.data() + 2 * k * columns; }
  double* reading_by(std::size_t k) { return end_by(k) + columns; }
  const double* end_by(std::size_t k) const { return tangent.data() + 2 * k * columns; }
  const double* reading_by(std::size_t k) const { return end_by(k) + columns; }
};

class LatentFilter {
 public:
  struct State {
    double x = 0.0, d = 0.0;
    double xx = 0.0, xd = 0.0, dd = 0.0;  ///< covariance
  };
  struct Update {
    double C = 0.0, E = 0.0, S = 0.0, Kx = 0.0, Kd = 0.0, innovation = 0.0;

    /// Twice the negative logarithm of the innovation's density, but for a constant [nat].
    double cost() const;
  };
  /// Standard deviations of a reading and of the pressure at the first row.
  struct Spread {
    double reading_Pa = 0.0, begin_Pa = 0.0;
  };

  /// Stands at the begin of tick 0. `track` must outlive it.
  LatentFilter(const Track& track, const MarkovNoise& noise, const Spread& spread);

  const State& state() const { return s_; }
  void hold_pressure(double low_Pa, double high_Pa);
  /// Takes in the reading at the end of tick k, at whose begin it stands.
  Update update(std::size_t k);
  /// To the end of tick k.
  void advance(std::size_t k);
  /// Of the disturbance in a tick what is left after it: a.
  double keep() const { return keep_; }

 private:
  const Track& track_;
  MarkovNoise noise_;
  double reading_Pa_, keep_;
  State s_;
};

/// Sum of the updates' costs over the rows that count [nat].
double cost_of(const Track& track, const MarkovNoise& noise, const LatentFilter::Spread& spread);

/// The disturbance in each tick, given all readings.
std::vector<double> smoothed_disturbance(const Track& track, const MarkovNoise& noise,
                                         const LatentFilter::Spread& spread);

/// Adds to the upper triangle of `gram` (columns + 1 square) the normal equations of [tangents, innovation], whitened.
void add_gram(const Track& track, const MarkovNoise& noise, const LatentFilter::Spread& spread,
              Eigen::MatrixXd& gram);

}  // namespace plenum::host::diagnose
