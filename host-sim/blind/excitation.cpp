#include "host-sim/blind/excitation.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

namespace plenum::host::blind {
namespace {

constexpr double kTau = 2.0 * std::numbers::pi;

class Script {
 public:
  Script(const ExcitationSetting& setting, std::uint64_t seed) : s_(setting), random_(seed, 77) {
    chirp_V_ = random_.uniform(0.5, 1.6);
    fastest_Hz_ = random_.uniform(5.0, 10.0);
    for (double& opening : pattern_V_) opening = random_.log_uniform(0.15, 2.0);
  }

  double command(std::size_t row, double pressure_Pa) {
    const double level = (pressure_Pa - s_.ambient_Pa) / (s_.supply_Pa - s_.ambient_Pa);
    const double u = raw(row, level);
    return std::clamp(u, 0.0, 10.0);
  }

 private:
  double raw(std::size_t row, double level) {
    const double time_s = static_cast<double>(row) * s_.period_s;
    const double total_s = static_cast<double>(s_.rows) * s_.period_s;
    if (s_.kind == Excitation::kChirp) return chirp(time_s, time_s / total_s, chirp_V_, level);

    struct Segment {
      double share;
      double (Script::*run)(double time_s, double share, double duration_s, double level);
    };
    static constexpr Segment kSegments[] = {{0.26, &Script::fill_and_dump}, {0.22, &Script::steps},
                                            {0.16, &Script::targets},       {0.14, &Script::chirps},
                                            {0.12, &Script::staircase},     {0.10, &Script::repeat}};
    double begin = 0.0;
    for (const Segment& segment : kSegments) {
      const double end = begin + segment.share;
      const double share = time_s / total_s;
      if (share < end - 1e-9 || &segment == std::end(kSegments) - 1) {
        if (&segment != current_) {
          current_ = &segment;
          phase_ = 0;
          since_s_ = time_s;
        }
        return (this->*segment.run)(time_s - begin * total_s, (share - begin) / segment.share,
                                    segment.share * total_s, level);
      }
      begin = end;
    }
    return s_.null_V;
  }

  double open(double side_volts) const {
    return s_.null_V + (side_volts > 0.0 ? s_.half_gap_V : -s_.half_gap_V) + side_volts;
  }

  /// Rest, fill fully, hold, dump to a third, hold, dump fully, fill again at half stroke, dump.
  double fill_and_dump(double time_s, double, double duration_s, double level) {
    const double hold_s = std::min(2.0, 0.19 * duration_s);
    const double most_s = 0.1 * duration_s;
    const double now_s = time_s;
    const auto next = [&] {
      ++phase_;
      since_in_s_ = now_s;
    };
    if (time_s < 0.5 * s_.period_s) since_in_s_ = 0.0;
    const double in_s = time_s - since_in_s_;
    switch (phase_) {
      case 0:
        if (in_s >= 0.03 * duration_s) next();
        return s_.null_V;
      case 1:
        if (level > 0.93 || in_s > most_s) next();
        return 10.0;
      case 2:
        if (in_s >= hold_s) next();
        return s_.null_V;
      case 3:
        if (level < 0.4 || in_s > most_s) next();
        return open(-1.0);
      case 4:
        if (in_s >= hold_s) next();
        return s_.null_V;
      case 5:
        if (level < 0.01 || in_s > most_s) next();
        return 0.0;
      case 6:
        if (level > 0.9 || in_s > most_s) next();
        return open(2.0);
      case 7:
        if (in_s > 0.02 * duration_s) next();
        return s_.null_V;
      default:
        if (level < 0.05 && in_s > 0.05 * duration_s) phase_ = 6, since_in_s_ = now_s;
        return open(-0.6);
    }
  }

  /// Several openings on one side, up and down, until the pressure nears that side's end.
  double steps(double time_s, double, double, double level) {
    if (phase_ == 0) {
      phase_ = 1;
      next_s_ = time_s;
      side_ = level < 0.5 ? 1.0 : -1.0;
    }
    if (side_ > 0.0 ? level > 0.85 : level < 0.12) {
      side_ = -side_;
      next_s_ = time_s;
    }
    if (time_s >= next_s_ - 1e-9) {
      size_V_ = side_ * random_.log_uniform(0.05, random_.chance(0.15) ? 4.5 : 1.5);
      if (random_.chance(0.12)) size_V_ = 0.0;
      const double speed = std::clamp(std::abs(size_V_), 0.05, 4.5) / s_.fill_s;
      next_s_ = time_s + std::clamp(random_.uniform(0.1, 0.5) / speed, 0.02, 0.4);
    }
    return size_V_ == 0.0 ? s_.null_V : open(size_V_);
  }

  double targets(double time_s, double, double, double level) {
    if (phase_ == 0 || time_s >= next_s_ - 1e-9) {
      phase_ = 1;
      target_ = random_.uniform(0.08, 0.92);
      next_s_ = time_s + random_.uniform(0.25, 1.2);
      sum_ = 0.0;
    }
    const double error = target_ - level;
    sum_ = std::clamp(sum_ + error * s_.period_s, -0.3, 0.3);
    return std::clamp(s_.null_V + gain() * (error + 2.0 * sum_), 3.0, 7.0);
  }

  double chirps(double time_s, double share, double duration_s, double level) {
    const bool second = share >= 0.5;
    const double begin_s = second ? 0.5 * duration_s : 0.0;
    return chirp(time_s - begin_s, 2.0 * (second ? share - 0.5 : share), second ? 1.8 : 0.45, level);
  }

  /// 0.3 Hz to the fastest, rising in ratio; the pull keeps the mean near the middle.
  double chirp(double time_s, double share, double amplitude_V, double level) const {
    const double ratio = fastest_Hz_ / 0.3;
    const double length_s = share > 0.0 ? time_s / share : 1.0;
    const double turns = 0.3 * length_s * (std::pow(ratio, share) - 1.0) / std::log(ratio);
    return s_.null_V + amplitude_V * std::sin(kTau * turns) + 0.5 * (0.5 - level);
  }

  double staircase(double, double share, double, double) {
    constexpr double kUp[] = {0.05, 0.15, 0.3, 0.2, 0.1, 0.4, 0.25, 0.6};
    const double side = share < 0.5 ? 1.0 : -1.0;
    const double at = share < 0.5 ? 2.0 * share : 2.0 * share - 1.0;
    const auto i = std::min<std::size_t>(static_cast<std::size_t>(8.0 * at), 7);
    // Slow chambers get larger openings: about four time constants a side.
    return open(side * kUp[i] * std::clamp(10.0 * s_.fill_s, 0.5, 3.0));
  }

  double repeat(double, double share, double, double) {
    const double at = 2.0 * share - std::floor(2.0 * share);
    if (at < 0.35) return 1.0;
    const auto i = std::min<std::size_t>(static_cast<std::size_t>((at - 0.35) / 0.65 * 6.0), 5);
    constexpr double kSides[] = {1.0, 0.0, 1.0, -1.0, 1.0, -1.0};
    return kSides[i] == 0.0 ? s_.null_V : open(kSides[i] * pattern_V_[i]);
  }

  double gain() const { return std::clamp(s_.fill_s * 40.0, 2.0, 20.0); }

  ExcitationSetting s_;
  Random random_;
  double chirp_V_;
  double fastest_Hz_;
  std::array<double, 6> pattern_V_{};
  const void* current_ = nullptr;
  int phase_ = 0;
  double since_s_ = 0.0, since_in_s_ = 0.0, next_s_ = 0.0;
  double side_ = 1.0, size_V_ = 0.0, target_ = 0.5, sum_ = 0.0;
};

}  // namespace

Driver excite(const ExcitationSetting& setting, std::uint64_t seed) {
  const auto script = std::make_shared<Script>(setting, seed);
  return [script](std::size_t row, double pressure_Pa) { return script->command(row, pressure_Pa); };
}

}  // namespace plenum::host::blind
