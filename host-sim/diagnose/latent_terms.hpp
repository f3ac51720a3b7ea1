// What an error of an equation could depend on: a file an equation (latent_command.cpp, ...), which gives its terms, the unit and
// size of its disturbance, and what both do to the inputs of a tick. latent.cpp filters and judges; it knows no equation.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host-sim/diagnose/linear_chamber.hpp"

namespace plenum::host::diagnose {

using identify::chamber::Record;

/// What a term, or the disturbance, of size one does to a tick's inputs, and to its reading directly.
struct Action {
  Inputs input{};
  double reading = 0.0;
  double own = 0.0;  // the same in the unit of the equation's disturbance

  /// The same area in every part of the tick. `port`: kInlet or kExhaust.
  void open(std::size_t port, double area) {
    for (std::size_t part = 0; part < kParts; ++part) input[port + part] = area;
  }
};

struct Term {
  std::string group;    // "the command before"
  double spread = 1.0;  // standard deviation expected
};
/// Of a term that a log does not show: at rest a volume error is a gain of both ports.
inline constexpr double kNever = 1e-9;

struct DisturbanceScale {
  double start_size = 0.0;  // from which its size is sought
  double per_unit = 1.0;    // of the disturbance as reported, in that of the filter
  std::string unit;         // as reported
  bool may_drift =
      false;  // slowly, by more than the areas' slopes can follow: the inputs are taken where it is
};

/// The rig, as all equations see it.
struct LatentScene {
  LatentScene(const Scene& scene, const std::vector<const Record*>& records);

  const Scene& scene;
  LinearChamber chamber;
  double gain = 0.0;        // [m2/V] mean of the ports, as configured
  double flow_scale = 0.0;  // [kg/s] a port open by a volt, choked
  bool volume_moves = false;
};

/// What the filter expected of each tick before its reading, which the terms are taken at (a pressure that knows the
/// reading would explain it), and the disturbance that the inputs are taken at.
struct About {
  std::vector<double> pressure, middle_Pa, d;
};

/// What terms are made of, of one record, a tick.
struct Background {
  const Record* record = nullptr;
  const About* about = nullptr;
  const effects::Figures* figures = nullptr;
  std::vector<double> u;
  std::vector<Ports> at;
  std::vector<double> in_flow, ex_flow;  // at the pressure expected
  double mean_volume = 0.0;
};

/// To be filled for one tick; zero before.
struct TickActions {
  Action* terms;
  Action& disturbance;
  const std::vector<double>& size;  ///< of the terms, at present
  /// [part of the tick]: an area by its threshold, gain, leak and width, which a term can change, too.
  std::array<double, 4>*inlet_by, *exhaust_by;
};

class LatentTerms {
 public:
  /// `rig` must outlive this.
  explicit LatentTerms(const LatentScene& rig) : rig_(rig) {}
  LatentTerms(const LatentTerms&) = delete;
  LatentTerms& operator=(const LatentTerms&) = delete;
  virtual ~LatentTerms() = default;

  virtual std::vector<Term> terms() const = 0;
  virtual DisturbanceScale disturbance() const = 0;
  /// The command that acts, under this disturbance.
  virtual double command_V(double logged_V, double /*d*/) const { return logged_V; }
  /// Called before the first tick of each pass over a record.
  virtual void begin(const Background& /*b*/) {}
  /// What terms and disturbance of size one do in tick k.
  virtual void act(const Background& b, std::size_t k, const TickActions& tick) const = 0;
  /// What the terms do that need the filter's own readings, tick by tick as it goes: it begins at `begin_Pa` and finds `at`.
  virtual double derive(std::size_t /*k*/, double /*begin_Pa*/, const Outcome& /*at*/, Action* /*terms*/,
                        const std::vector<double>& /*size*/) {
    return 1.0;
  }
  /// Whether the whole disturbance of the records, as it came out, can be.
  virtual bool is_possible(const std::vector<std::vector<double>>& /*whole*/) const { return true; }

 protected:
  static void add(std::vector<Term>& terms, const char* group, double spread, std::size_t count) {
    terms.insert(terms.end(), count, {group, spread});
  }

  const LatentScene& rig_;
};

std::unique_ptr<LatentTerms> late_command_terms(const LatentScene& rig);
std::unique_ptr<LatentTerms> spool_terms(const LatentScene& rig);
std::unique_ptr<LatentTerms> valve_area_terms(const LatentScene& rig);
std::unique_ptr<LatentTerms> mass_flow_terms(const LatentScene& rig);
std::unique_ptr<LatentTerms> leak_terms(const LatentScene& rig);
std::unique_ptr<LatentTerms> supply_terms(const LatentScene& rig);
std::unique_ptr<LatentTerms> energy_terms(const LatentScene& rig);
std::unique_ptr<LatentTerms> sensor_terms(const LatentScene& rig);

/// One at a centre, falling to zero at its neighbours; flat beyond the ends.
double hat(std::span<const double> centres, std::size_t i, double x);
/// First order, a tick's value held.
std::vector<double> smoothed(std::vector<double> x, double tau, double tick_s);

}  // namespace plenum::host::diagnose
