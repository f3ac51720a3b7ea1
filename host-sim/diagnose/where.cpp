#include "host-sim/diagnose/where.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

#include "host-sim/diagnose/linear_chamber.hpp"

namespace plenum::host::diagnose {
namespace {

using effects::Figures;

constexpr double kMovingFor_s = 0.06;     // after a move, the longest that a lag or a delay of a valve takes
constexpr double kMove = 0.002;           // of the command's range: below it is a converter's step
constexpr double kVolumeWindow_s = 0.25;  // to either side
constexpr double kVolumeMove = 0.02;
constexpr double kVolumesApart = 0.1;  // of the smallest
constexpr std::size_t kMostRegimes = 8;
constexpr double kLeastShare = 0.01;
constexpr double kWorthACut = 0.02;  // [nat] of information on where the error is
constexpr std::size_t kRatioRows = 8, kCommandColumns = 10;
constexpr double kLeastRowsOfCell = 5.0;
constexpr double kSmoothing_s = 0.1;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double command_range_V(const std::vector<double>& command_V) {
  const auto [low, high] = std::minmax_element(command_V.begin(), command_V.end());
  return *high - *low;
}

std::size_t ticks_in(double seconds, const effects::Timing& timing) {
  return static_cast<std::size_t>(std::lround(seconds / timing.tick_s));
}

// ---- regimes: a tree of cuts ----

enum class Answer { any, no, yes };

/// What a cut may ask, in the order in which a regime's name tells it.
struct Asked {
  bool Regime::*of;
  const char *yes, *no;
};
constexpr std::array<Asked, 8> kQuestions{{{&Regime::moving, "command moving", "command held"},
                                           {&Regime::reversed, "command just reversed", "command moving on"},
                                           {&Regime::opening, "valve opening", "valve closing"},
                                           {&Regime::choked, "flow choked", "flow subsonic"},
                                           {&Regime::high, "pressure high", "pressure low"},
                                           {&Regime::small, "volume small", "volume large"},
                                           {&Regime::volume_moving, "volume moving", "volume at rest"},
                                           {&Regime::late, "second half", "first half"}}};
/// Where in the order: those before the flow are told before the port.
constexpr std::size_t kMoving = 0, kReversed = 1, kOpening = 2, kChoked = 3;
static_assert(kQuestions[kMoving].of == &Regime::moving && kQuestions[kReversed].of == &Regime::reversed &&
              kQuestions[kOpening].of == &Regime::opening && kQuestions[kChoked].of == &Regime::choked);

struct Row {
  Regime regime;
  double squared = 0.0;
};

/// A set of regimes; what is `any` is not told apart.
struct Kind {
  std::optional<Port> port;
  std::array<Answer, kQuestions.size()> answers{};
};

/// "command moving, supply port open, flow choked, volume moving"
std::string words(const Kind& kind) {
  std::string text;
  const auto add = [&](const char* word) { text += (text.empty() ? "" : ", ") + std::string(word); };
  const auto tell = [&](std::size_t first, std::size_t end) {
    for (std::size_t question = first; question < end; ++question) {
      const Answer answer = kind.answers[question];
      // how it moves says that it does
      const bool said = question == kMoving && kind.answers[kReversed] != Answer::any;
      if (answer != Answer::any && !said)
        add(answer == Answer::yes ? kQuestions[question].yes : kQuestions[question].no);
    }
  };
  tell(kMoving, kChoked);
  if (kind.port == Port::supply) add("supply port open");
  if (kind.port == Port::exhaust) add("exhaust port open");
  if (kind.port == Port::shut) add("valve shut");
  tell(kChoked, kQuestions.size());
  return text.empty() ? "throughout" : text;
}

struct Leaf {
  Kind kind;
  std::vector<Row> rows;
  double squares = 0.0;

  double mean() const { return squares / static_cast<double>(rows.size()); }
  void take(const Row& row) {
    rows.push_back(row);
    squares += row.squared;
  }
};

struct Cut {
  double worth = 0.0;  // sum of share * log(mean squared error / that of the whole)
  Leaf yes, no;
};

/// Whether the rows of such a regime can be asked that.
bool can_be_asked(const Kind& kind, std::size_t question) {
  if (kind.answers[question] != Answer::any) return false;
  switch (question) {
    case kReversed:
    case kOpening:
      return kind.answers[kMoving] == Answer::yes;
    case kChoked:
      return kind.port && kind.port != Port::shut;
    default:
      return true;
  }
}

Cut best_cut(const Leaf& leaf, double all_squares) {
  Cut best;
  for (std::size_t question = 0; question < kQuestions.size(); ++question) {
    if (!can_be_asked(leaf.kind, question)) continue;
    Cut cut;
    cut.yes.kind = cut.no.kind = leaf.kind;
    cut.yes.kind.answers[question] = Answer::yes;
    cut.no.kind.answers[question] = Answer::no;
    for (const Row& row : leaf.rows) (row.regime.*kQuestions[question].of ? cut.yes : cut.no).take(row);
    if (cut.yes.rows.empty() || cut.no.rows.empty()) continue;
    for (const Leaf* part : {&cut.yes, &cut.no}) {
      if (part->squares > 0.0)
        cut.worth += part->squares / all_squares * std::log(part->mean() / leaf.mean());
    }
    if (cut.worth > best.worth) best = std::move(cut);
  }
  return best;
}

// ---- the flow through the valve ----

/// Net flow into the chamber [kg/s].
double valve_flow_kg_s(const Scene& scene, const plant::ThinPlate& plate, const Figures& valve,
                       double command_V, double pressure_Pa) {
  const Ports ports = ports_of(valve, command_V);
  return ports.inlet.area * plate.phi(scene.around.supply_Pa, pressure_Pa) -
         ports.exhaust.area * plate.phi(pressure_Pa, scene.around.ambient_Pa);
}

}  // namespace

std::vector<Regime> regimes_of(const Scene& scene, const Figures& valve, const effects::Drive& drive,
                               const std::vector<double>& pressure_Pa) {
  const std::size_t rows = pressure_Pa.size();
  const auto steps = static_cast<std::size_t>(drive.timing.steps);
  const double theta = plant::thin_plate_constants(scene.around.gas).theta;
  const double least_move_V = std::max(kMove * command_range_V(drive.command_V), 1e-9);
  const std::size_t moving_for = std::max<std::size_t>(ticks_in(kMovingFor_s, drive.timing), 1);
  const std::size_t reach = std::max<std::size_t>(ticks_in(kVolumeWindow_s, drive.timing), 1) * steps;
  const double middle_Pa = 0.5 * (scene.around.supply_Pa + scene.around.ambient_Pa);
  const auto [least_m3, most_m3] = std::ranges::minmax(drive.volume_m3);
  const bool volumes_apart = most_m3 - least_m3 > kVolumesApart * least_m3;
  const auto inlet_of = [&](double command_V) {
    return valve[effects::kInletGain] * (command_V - valve[effects::kOpenAbove]);
  };
  const auto exhaust_of = [&](double command_V) {
    return valve[effects::kExhaustGain] * (valve[effects::kExhaustBelow] - command_V);
  };
  const auto opening_of = [&](double command_V) {
    return std::max(inlet_of(command_V), exhaust_of(command_V));
  };

  std::vector<Regime> regimes(rows);
  double last_V = drive.command_V.front();  // where the command was when it last moved
  int direction = 0;
  bool opening = false;
  std::size_t since_move = moving_for + 1, since_reversal = moving_for + 1;  // [ticks]
  for (std::size_t row = 1; row < rows; ++row) {
    Regime& r = regimes[row];
    const double command_V = drive.command_V[row - 1];
    ++since_move;
    ++since_reversal;
    if (std::abs(command_V - last_V) > least_move_V) {
      const int now = command_V > last_V ? 1 : -1;
      if (now == -direction) since_reversal = 0;
      since_move = 0;
      direction = now;
      opening = opening_of(command_V) > opening_of(last_V);
      last_V = command_V;
    }
    r.moving = since_move < moving_for;
    r.reversed = r.moving && since_reversal < moving_for;
    r.opening = r.moving && opening;
    r.high = pressure_Pa[row] > middle_Pa;

    if (opening_of(command_V) > 0.0)
      r.port = inlet_of(command_V) > exhaust_of(command_V) ? Port::supply : Port::exhaust;
    r.choked = (r.port == Port::supply && scene.around.supply_Pa > theta * pressure_Pa[row]) ||
               (r.port == Port::exhaust && pressure_Pa[row] > theta * scene.around.ambient_Pa);

    const std::size_t at = row * steps;
    r.small = volumes_apart && drive.volume_m3[at] < 0.5 * (least_m3 + most_m3);
    const auto from = drive.volume_m3.begin() + static_cast<std::ptrdiff_t>(at - std::min(at, reach));
    const auto to = drive.volume_m3.begin() +
                    static_cast<std::ptrdiff_t>(std::min(at + reach + 1, drive.volume_m3.size()));
    const auto [low, high] = std::minmax_element(from, to);
    r.volume_moving = *high - *low > kVolumeMove * *low;
  }
  return regimes;
}

std::vector<RegimeShare> regimes(const Scene& scene, const Figures& recalibrated,
                                 const std::vector<Scored>& scored) {
  std::vector<Row> rows;
  double all = 0.0;
  for (const Scored& s : scored) {
    std::vector<Regime> of_row = regimes_of(scene, recalibrated, s.record->drive, s.record->measured_Pa);
    const std::size_t first = std::max<std::size_t>(s.first, 1);
    const std::size_t middle = first + (s.record->rows() - std::min(first, s.record->rows())) / 2;
    for (std::size_t row = first; row < s.record->rows(); ++row) {
      const double error = s.before_Pa[row] - s.record->measured_Pa[row];
      of_row[row].late = row >= middle;
      rows.push_back({of_row[row], error * error});
      all += error * error;
    }
  }
  if (!(all > 0.0)) return {};

  // the port is always told; what else is told is what the error asks for
  std::vector<Leaf> leaves;
  for (const Port port : {Port::shut, Port::supply, Port::exhaust}) {
    Leaf leaf;
    leaf.kind.port = port;
    for (const Row& row : rows) {
      if (row.regime.port == port) leaf.take(row);
    }
    if (!leaf.rows.empty()) leaves.push_back(std::move(leaf));
  }
  while (leaves.size() < kMostRegimes) {
    Cut best;
    std::size_t where = 0;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      if (leaves[i].squares < kLeastShare * all) continue;
      Cut cut = best_cut(leaves[i], all);
      if (cut.worth > best.worth) {
        best = std::move(cut);
        where = i;
      }
    }
    if (best.worth < kWorthACut) break;
    leaves[where] = std::move(best.yes);
    leaves.push_back(std::move(best.no));
  }

  std::vector<RegimeShare> shares;
  double named = 0.0;
  for (const Leaf& leaf : leaves) {
    const double share = leaf.squares / all;
    if (share < kLeastShare) continue;
    shares.push_back({words(leaf.kind), share});
    named += share;
  }
  if (1.0 - named >= kLeastShare) {
    shares.push_back({"elsewhere", 1.0 - named});
  } else {
    for (RegimeShare& s : shares) s.share /= named;
  }
  std::stable_sort(shares.begin(), shares.end(),
                   [](const RegimeShare& a, const RegimeShare& b) { return a.share > b.share; });
  return shares;
}

ErrorMap error_map(const Scene& scene, const std::vector<Scored>& scored) {
  double low_V = std::numeric_limits<double>::infinity();
  double high_V = -low_V;
  const auto each_row = [&](auto&& visit) {
    for (const Scored& s : scored) {
      for (std::size_t row = std::max<std::size_t>(s.first, 1); row < s.record->rows(); ++row) {
        visit(s, row, s.record->drive.command_V[row - 1]);
      }
    }
  };
  each_row([&](const Scored&, std::size_t, double command_V) {
    low_V = std::min(low_V, command_V);
    high_V = std::max(high_V, command_V);
  });
  ErrorMap map;
  if (low_V > high_V) return map;
  if (high_V - low_V < 1e-6) {
    low_V -= 0.5;
    high_V += 0.5;
  }
  struct Cell {
    double rows = 0.0, before = 0.0, after = 0.0;
  };
  std::array<std::array<Cell, kCommandColumns>, kRatioRows> cells{};
  const auto place = [](double share, std::size_t places) {
    const auto count = static_cast<double>(places);
    return static_cast<std::size_t>(std::clamp(std::floor(share * count), 0.0, count - 1.0));
  };
  each_row([&](const Scored& s, std::size_t row, double command_V) {
    const double measured = s.record->measured_Pa[row];
    const double ratio =
        (measured - scene.around.ambient_Pa) / (scene.around.supply_Pa - scene.around.ambient_Pa);
    Cell& cell =
        cells[place(ratio, kRatioRows)][place((command_V - low_V) / (high_V - low_V), kCommandColumns)];
    const double before = s.before_Pa[row] - measured;
    const double after = s.after_Pa.empty() ? kNaN : s.after_Pa[row] - measured;
    cell.rows += 1.0;
    cell.before += before * before;
    cell.after += after * after;
  });
  for (std::size_t i = 0; i < kRatioRows; ++i) {
    map.pressure_ratio.push_back((static_cast<double>(i) + 0.5) / kRatioRows);
    map.rms_Pa.emplace_back();
    map.closed_Pa.emplace_back();
    for (const Cell& cell : cells[i]) {
      const bool seen = cell.rows >= kLeastRowsOfCell;
      map.rms_Pa.back().push_back(seen ? std::sqrt(cell.before / cell.rows) : kNaN);
      map.closed_Pa.back().push_back(seen ? std::sqrt(cell.after / cell.rows) : kNaN);
    }
  }
  for (std::size_t k = 0; k < kCommandColumns; ++k) {
    map.command_V.push_back(low_V + (static_cast<double>(k) + 0.5) / kCommandColumns * (high_V - low_V));
  }
  return map;
}

std::vector<double> disturbance_kg_s(const Scene& scene, const Record& record, const Figures& recalibrated) {
  const std::size_t rows = record.rows();
  const std::size_t ticks = rows - 1;
  if (ticks < 3) return std::vector<double>(rows, 0.0);
  const effects::Timing& timing = record.drive.timing;
  const auto steps = static_cast<std::size_t>(timing.steps);
  const double tick_s = timing.tick_s;
  const double kappa = scene.around.gas.kappa;
  const double RT = scene.around.gas.specific_gas_constant_J_kg_K() * scene.around.gas.temperature_K;
  const plant::ThinPlate plate(
      plant::thin_plate_constants(scene.around.gas, scene.around.discharge_coefficient));

  // At the middle of each tick; a reading is the pressure half its averaging time before its row, or as much later as it is early.
  const double back = (0.5 * (tick_s - timing.average_s) + recalibrated[effects::kStampedEarly]) / tick_s;
  std::vector<double> pressure(ticks), volume(ticks), squeeze(ticks), flow(ticks);
  for (std::size_t k = 0; k < ticks; ++k) {
    pressure[k] = record.measured_Pa[k + 1] + back * (record.measured_Pa[k] - record.measured_Pa[k + 1]);
    const double begin = record.drive.volume_m3[k * steps];
    const double end = record.drive.volume_m3[(k + 1) * steps];
    volume[k] = steps % 2 == 0 ? record.drive.volume_m3[k * steps + steps / 2] : 0.5 * (begin + end);
    squeeze[k] = (1.0 - 1.0 / kappa) / RT * pressure[k] * (end - begin) / tick_s;
    flow[k] = valve_flow_kg_s(scene, plate, recalibrated, record.drive.command_V[k], pressure[k]);
  }
  // (p v)' between the middles of the neighbours covers half of each neighbour: so must the flows.
  std::vector<double> missing(ticks);
  for (std::size_t k = 1; k + 1 < ticks; ++k) {
    const double storing =
        (pressure[k + 1] * volume[k + 1] - pressure[k - 1] * volume[k - 1]) / (kappa * RT * 2.0 * tick_s);
    const auto over_both = [&](const std::vector<double>& x) {
      return 0.25 * x[k - 1] + 0.5 * x[k] + 0.25 * x[k + 1];
    };
    missing[k] = storing + over_both(squeeze) - over_both(flow);
  }

  // raised cosine; the first and the last tick have no neighbour on one side
  const auto reach = static_cast<std::size_t>(std::max(std::ceil(kSmoothing_s / tick_s), 1.0));
  std::vector<double> smooth(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    double sum = 0.0, weights = 0.0;
    const std::size_t from = std::clamp<std::size_t>(row - std::min(row, reach), 1, ticks - 2);
    const std::size_t to = std::clamp<std::size_t>(row + reach, 1, ticks - 2);
    for (std::size_t k = from; k <= to; ++k) {
      const double away =
          (static_cast<double>(k) + 0.5 - static_cast<double>(row)) / static_cast<double>(reach + 1);
      const double weight = std::max(1.0 + std::cos(std::numbers::pi * std::clamp(away, -1.0, 1.0)), 1e-9);
      sum += weight * missing[k];
      weights += weight;
    }
    smooth[row] = sum / weights;
  }
  return smooth;
}

}  // namespace plenum::host::diagnose
