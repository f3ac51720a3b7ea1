#include "host-sim/identify/chamber/area_table.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host-sim/identify/box_solver.hpp"
#include "host-sim/plant/orifice.hpp"

namespace plenum::host::identify::chamber {
namespace {

using effects::EffectSet;
using effects::Figures;
using Vector = BoxVector<Eigen::Dynamic>;
using Gram = BoxGram<Eigen::Dynamic>;

constexpr double kUnit_m2 = 1e-6;
/// Of the bending, against the rows: it decides only where there are none.
constexpr double kPriceOfBending = 1e-4;
/// Of a node: so that one without any command has a value.
constexpr double kPriceOfArea = 1e-9;
constexpr double kMost_m2 = 1.0;

/// Half of them even over the range, half as the commands lie.
std::vector<double> nodes_of(const std::vector<Record>& records) {
  std::vector<double> commands;
  for (const Record& record : records) {
    const auto begin = record.drive.command_V.begin();
    commands.insert(commands.end(), begin, begin + static_cast<std::ptrdiff_t>(record.fitted_rows));
  }
  std::sort(commands.begin(), commands.end());
  const auto quantile = [&](double share) {
    return commands[static_cast<std::size_t>(share * static_cast<double>(commands.size() - 1))];
  };
  std::vector<double> nodes;
  for (Eigen::Index i = 0; i < kMostNodes; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(kMostNodes - 1);
    nodes.push_back(0.5 *
                    (quantile(share) + commands.front() + share * (commands.back() - commands.front())));
  }
  return nodes;
}

/// Node below a command, and how far the command is towards the next one.
struct Along {
  Eigen::Index node = 0;
  double share = 0.0;
};
Along along(const std::vector<double>& nodes, double command_V) {
  const auto above = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, command_V);
  const auto node = above - nodes.begin() - 1;
  const double from_V = nodes[static_cast<std::size_t>(node)];
  return {node, std::clamp((command_V - from_V) / (*above - from_V), 0.0, 1.0)};
}

/// The normal equations of (T1), areas in kUnit_m2.
struct Normal {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
};

void add_rows(const Scene& scene, const Record& record, const std::vector<double>& nodes, Normal& normal) {
  const plant::ThinPlate plate(
      plant::thin_plate_constants(scene.around.gas, scene.around.discharge_coefficient));
  const double R_T = scene.around.gas.specific_gas_constant_J_kg_K() * scene.around.gas.temperature_K;
  const double h = record.drive.timing.tick_s;
  const double before = std::clamp(0.5 * record.drive.timing.average_s / h, 0.0, 0.5);
  const auto steps = static_cast<std::size_t>(record.drive.timing.steps);
  const std::vector<double>& y = record.measured_Pa;
  Eigen::VectorXd row(2 * kMostNodes);
  for (std::size_t k = std::max<std::size_t>(1, record.settled_rows); k + 1 < record.fitted_rows; ++k) {
    row.setZero();
    double known_Pa = y[k + 1] - y[k];
    // A tick and its share of the row.
    const auto add_tick = [&](std::size_t tick, double share) {
      const double p = y[tick] + (0.5 + before) * (y[tick + 1] - y[tick]);
      const double* const volume = record.drive.volume_m3.data() + tick * steps;
      const double v = 0.5 * (volume[0] + volume[steps]);
      const double per_kg = share * h * scene.around.gas.kappa / v;
      known_Pa += per_kg * (volume[steps] - volume[0]) / h * p;
      const Along at = along(nodes, record.drive.command_V[tick]);
      const double inlet = per_kg * R_T * kUnit_m2 * plate.phi(scene.around.supply_Pa, p);
      const double exhaust = -per_kg * R_T * kUnit_m2 * plate.phi(p, scene.around.ambient_Pa);
      row[at.node] += (1.0 - at.share) * inlet;
      row[at.node + 1] += at.share * inlet;
      row[kMostNodes + at.node] += (1.0 - at.share) * exhaust;
      row[kMostNodes + at.node + 1] += at.share * exhaust;
    };
    add_tick(k - 1, before);
    add_tick(k, 1.0 - before);
    normal.H.selfadjointView<Eigen::Upper>().rankUpdate(row);
    normal.g -= known_Pa * row;
  }
}

void add_prices(const std::vector<double>& nodes, Eigen::MatrixXd& H) {
  const double scale = H.diagonal().maxCoeff();
  const double span_V = nodes.back() - nodes.front();
  H.diagonal().array() += kPriceOfArea * scale;
  for (Eigen::Index port = 0; port < 2; ++port) {
    for (Eigen::Index i = 1; i + 1 < kMostNodes; ++i) {
      const auto node = static_cast<std::size_t>(i);
      const double left = span_V / (nodes[node] - nodes[node - 1]) / static_cast<double>(kMostNodes);
      const double right = span_V / (nodes[node + 1] - nodes[node]) / static_cast<double>(kMostNodes);
      Eigen::VectorXd bend = Eigen::VectorXd::Zero(2 * kMostNodes);
      bend[port * kMostNodes + i - 1] = left;
      bend[port * kMostNodes + i] = -left - right;
      bend[port * kMostNodes + i + 1] = right;
      H += kPriceOfBending * scale / bend.squaredNorm() * bend * bend.transpose();
    }
  }
}

/// (3), with a gain a port, bent as area_shape bends it.
double area_m2(double opening_V, double gain, double leak, double transition, const double* shape) {
  const double o = std::max(opening_V, 0.0);
  const double g = o / (o + 2.0);
  const double ratio =
      shape == nullptr ? 1.0 : std::max(1.0 + g * (shape[0] + g * (shape[1] + g * shape[2])), 0.05);
  const double over = gain * opening_V * ratio - leak;
  return leak + 0.5 * (std::sqrt(over * over + transition * transition) + over);
}

Eigen::VectorXd areas(const std::vector<double>& nodes, const Figures& figures, EffectSet on) {
  const double* const shape = figures.data() + effects::kFirstFigure[effects::kIdAreaShape];
  const bool shaped = (on >> effects::kIdAreaShape & 1U) != 0;
  const std::array<double, 3> inlet{shape[0], shape[1], shape[4]};
  const std::array<double, 3> exhaust{shape[2], shape[3], shape[5]};
  Eigen::VectorXd x(2 * kMostNodes);
  for (Eigen::Index i = 0; i < kMostNodes; ++i) {
    const double u = nodes[static_cast<std::size_t>(i)];
    x[i] =
        area_m2(u - figures[effects::kOpenAbove], figures[effects::kInletGain], figures[effects::kInletLeak],
                figures[effects::kTransition], shaped ? inlet.data() : nullptr);
    x[kMostNodes + i] = area_m2(figures[effects::kExhaustBelow] - u, figures[effects::kExhaustGain],
                                figures[effects::kExhaustLeak], figures[effects::kTransition],
                                shaped ? exhaust.data() : nullptr);
  }
  return x;
}

/// The figures that are sought: z are in units of `scale` from `base`.
struct Sought {
  std::size_t figure;
  double low, high, scale;
};

std::vector<Sought> sought(const AreaTable& table, double gain, EffectSet on) {
  const double first_V = table.command_V.front();
  const double last_V = table.command_V.back();
  std::vector<Sought> all{{effects::kOpenAbove, first_V - 1.0, last_V + 1.0, 0.1},
                          {effects::kExhaustBelow, first_V - 1.0, last_V + 1.0, 0.1},
                          {effects::kInletGain, 1e-3 * gain, 1e3 * gain, 0.2 * gain},
                          {effects::kExhaustGain, 1e-3 * gain, 1e3 * gain, 0.2 * gain},
                          {effects::kInletLeak, 0.0, gain, 0.05 * gain},
                          {effects::kExhaustLeak, 0.0, gain, 0.05 * gain},
                          {effects::kTransition, 1e-3 * gain, gain, 0.1 * gain}};
  if ((on >> effects::kIdAreaShape & 1U) != 0) {
    for (std::size_t i = 0; i < effects::kAreaShapeParameters.size(); ++i) {
      const effects::Parameter& p = effects::kAreaShapeParameters[i];
      if (!p.refines) {
        all.push_back({effects::kFirstFigure[effects::kIdAreaShape] + i, p.low, p.high, p.typical_change});
      }
    }
  }
  return all;
}

struct Nearest {
  Figures figures{};
  double squares = std::numeric_limits<double>::infinity();
};

Nearest descend(const AreaTable& table, const Figures& base, double gain, EffectSet on) {
  constexpr double kDifference = 1e-4;
  constexpr int kMostIterations = 60;
  constexpr double kTolerance = 1e-6;
  const std::vector<Sought> variables = sought(table, gain, on);
  const auto n = static_cast<Eigen::Index>(variables.size());
  const auto figures_at = [&](const Vector& z) {
    Figures figures = base;
    for (Eigen::Index i = 0; i < n; ++i) {
      const Sought& v = variables[static_cast<std::size_t>(i)];
      figures[v.figure] = std::clamp(base[v.figure] + v.scale * z[i], v.low, v.high);
    }
    return figures;
  };
  BoxProblem<Eigen::Dynamic> problem;
  problem.squares = [&](const Vector& z) { return table.squares(figures_at(z), on); };
  problem.gram = [&](const Vector& z) -> Gram {
    const Figures here = figures_at(z);
    const Eigen::VectorXd x = areas(table.command_V, here, on);
    Eigen::MatrixXd columns(2 * kMostNodes, n + 1);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Sought& v = variables[static_cast<std::size_t>(i)];
      Figures changed = here;
      const double step = here[v.figure] + kDifference * v.scale > v.high ? -kDifference : kDifference;
      changed[v.figure] += step * v.scale;
      columns.col(i) = (areas(table.command_V, changed, on) - x) / step;
    }
    columns.col(n) = x - table.area_m2;
    return columns.transpose() * table.weight * columns;
  };
  problem.low.resize(n);
  problem.high.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Sought& v = variables[static_cast<std::size_t>(i)];
    problem.low[i] = (v.low - base[v.figure]) / v.scale;
    problem.high[i] = (v.high - base[v.figure]) / v.scale;
  }
  const auto solution =
      minimise_in_box<Eigen::Dynamic>(problem, Vector::Zero(n), kMostIterations, kTolerance);
  return {figures_at(solution.z), solution.squares};
}

}  // namespace

double AreaTable::squares(const Figures& figures, EffectSet on) const {
  const Eigen::VectorXd off = areas(command_V, figures, on) - area_m2;
  return off.dot(weight * off);
}

AreaTable area_table(const Scene& scene) {
  AreaTable table;
  table.command_V = nodes_of(scene.records);
  Normal normal{Eigen::MatrixXd::Zero(2 * kMostNodes, 2 * kMostNodes), Eigen::VectorXd::Zero(2 * kMostNodes)};
  for (const Record& record : scene.records) add_rows(scene, record, table.command_V, normal);
  normal.H = Eigen::MatrixXd(normal.H.selfadjointView<Eigen::Upper>());
  add_prices(table.command_V, normal.H);
  const Vector low = Vector::Zero(2 * kMostNodes);
  const Vector high = Vector::Constant(2 * kMostNodes, kMost_m2 / kUnit_m2);
  table.area_m2 = kUnit_m2 * quadratic_in_box<Eigen::Dynamic>(normal.H, normal.g, low, high);
  table.weight = normal.H / (kUnit_m2 * kUnit_m2);
  return table;
}

Figures nearest_valve(const AreaTable& table, const Figures& base, EffectSet on) {
  constexpr int kOpenings = 7;  // over the commands, of each port
  const double first_V = table.command_V.front();
  const double span_V = table.command_V.back() - first_V;
  const double most_m2 = table.area_m2.maxCoeff();
  Nearest best;
  for (int inlet = 0; inlet < kOpenings; ++inlet) {
    for (int exhaust = 0; exhaust <= inlet;
         ++exhaust) {  // a port that opens before the other shuts wastes air
      Figures start = base;
      const double gain = 2.0 * most_m2 / span_V;
      start[effects::kOpenAbove] = first_V + span_V * (inlet + 0.5) / kOpenings;
      start[effects::kExhaustBelow] = first_V + span_V * (exhaust + 0.5) / kOpenings;
      start[effects::kInletGain] = start[effects::kExhaustGain] = gain;
      start[effects::kInletLeak] = start[effects::kExhaustLeak] = 0.01 * gain;
      start[effects::kTransition] = 0.05 * gain;
      const Nearest found = descend(table, start, gain, on);
      if (found.squares < best.squares) best = found;
    }
  }
  return best.figures;
}

}  // namespace plenum::host::identify::chamber
