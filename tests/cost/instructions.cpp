// Instructions that the dearest call of a function of the core takes, as far as a search finds it, counted by callgrind.
//
// Each row below draws a case from a Tape: admissible parameters, a state, and what is asked. tape.hpp searches for the dearest. What
// is counted lies between two client requests, the call itself included; callgrind's dump is read back at once.
//
// usage: valgrind --tool=callgrind --collect-atstart=no --callgrind-out-file=FILE plenum_cost_instructions FILE SEED [ROW...]
//        plenum_cost_instructions --list      the rows
//
// SEED is that of the search. Standard input: cases that it begins with, a line each: the row, a tabulator, a tape. Prints one JSON
// object a line; "kept": what the dearest of the cases given takes, 0 if there is none:
//   {"row": "Tassa9::inverse", "instructions": 1234, "kept": 1230, "case": "7e8 3 ffff"}
#include <valgrind/callgrind.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware/config/crc32.hpp"
#include "firmware/control/any_model.hpp"
#include "firmware/control/excitation.hpp"
#include "firmware/control/model_paths.hpp"
#include "firmware/control/regulator.hpp"
#include "firmware/control/volume_observer.hpp"
#include "tests/cost/chambers_alike.hpp"
#include "tests/cost/master.hpp"
#include "tests/cost/tape.hpp"

namespace {

using namespace plenum;
using config::ModelKind;
using control::ChamberMotion;
using cost::Tape;
using numeric::Scalar;

constexpr cost::Effort kOfFunction{.drawn = 150, .varied = 150};
constexpr cost::Effort kOfEpisode{.drawn = 30, .varied = 90};
constexpr cost::Effort kOfSession{.drawn = 10, .varied = 6};

/// What is computed is wanted, so that the compiler computes it.
template <class Value>
void wanted(const Value& value) {
  asm volatile("" : : "r"(&value) : "memory");
}

/// Callgrind's count of what is between two of its client requests.
class Instructions {
 public:
  /// `file`: where callgrind writes; its n-th dump goes to file.n.
  explicit Instructions(std::string file) : file_(std::move(file)) {}

  template <class Calls>
  std::uint64_t of(Calls&& calls) {
    CALLGRIND_TOGGLE_COLLECT;
    calls();
    CALLGRIND_TOGGLE_COLLECT;
    CALLGRIND_DUMP_STATS;
    return take_dump();
  }

 private:
  std::uint64_t take_dump() {
    const std::string name = file_ + "." + std::to_string(++dumps_);
    std::ifstream dump(name);
    constexpr std::string_view kKey = "totals: ";
    for (std::string line; std::getline(dump, line);) {
      if (!line.starts_with(kKey)) continue;
      dump.close();
      std::filesystem::remove(name);
      return std::stoull(line.substr(kKey.size()));
    }
    throw std::runtime_error(name + ": a dump of callgrind with a line of totals is expected");
  }

  std::string file_;
  int dumps_ = 0;
};

Scalar between(Tape& tape, double low, double high) {
  return static_cast<Scalar>(std::uniform_real_distribution<double>(low, high)(tape));
}

bool one_in_two(Tape& tape) {
  return tape() % 2 == 0;
}

/// With the delays that a grey-box model may state.
cost::Subject draw_with_delays(Tape& tape, ModelKind kind) {
  cost::Subject subject = cost::draw_subject(tape, kind);
  if (kind != ModelKind::greybox) return subject;
  const auto put = [&](config::GreyboxParameter which, double most) {
    const float value = std::uniform_real_distribution<float>(0.0F, static_cast<float>(most))(tape);
    if (one_in_two(tape)) subject.model.value[which] = value;
  };
  put(config::kDeadTime, 0.08);
  put(config::kSpoolPeriod, 0.1);
  put(config::kHysteresis, 0.5);
  put(config::kSensorLag, 0.05);
  return subject;
}

/// A model in force, and one question to it.
struct Question {
  Question(Tape& tape, ModelKind kind) : subject(draw_with_delays(tape, kind)) {
    model = known->take_over(subject.model, Scalar(3), Scalar(7));
    motion = {.volume_mL = static_cast<Scalar>(subject.volume_mL),
              .volume_rate_mL_s = static_cast<Scalar>(subject.volume_rate_mL_s)};
    pressure_kPa = static_cast<Scalar>(subject.pressure_kPa);
    const double span_kPa = static_cast<double>(subject.supply_kPa - subject.ambient_kPa);
    const double reach = std::array{0.002, 0.03, 0.3, 1.0}[tape() % 4];
    target_kPa = pressure_kPa + static_cast<Scalar>(span_kPa * reach) * between(tape, -1.0, 1.0);
    command_V = between(tape, 3.0, 7.0);
  }

  cost::Subject subject;
  std::unique_ptr<control::AnyModel> known = std::make_unique<control::AnyModel>();
  const control::PressureModel* model = nullptr;
  ChamberMotion motion;
  Scalar pressure_kPa{}, target_kPa{}, command_V{};
};

/// A regulator that has run for some ticks on readings that its model does not give.
struct Regulation {
  Regulation(Tape& tape, ModelKind kind) : question(tape, kind) {
    const Scalar delay_ticks = one_in_two(tape) ? between(tape, 0.0, 12.0) : Scalar(0);
    regulator.configure({.valve_delay_ticks = delay_ticks});
    control::ModelPaths paths = control::paths_of(question.subject.model, delay_ticks);
    if (paths.valve.dead_ticks == Scalar(0)) paths.valve.dead_ticks = delay_ticks;
    regulator.take_over(paths.valve, paths.sensor_lag_ticks);
    regulator.reset(question.pressure_kPa, Scalar(5));
    for (std::uint64_t left = 1 + tape() % 8; left > 0; --left) {
      next(tape);
      regulator.observe(*question.model, measured_kPa, question.motion);
      regulator.sent(regulator.regulate(*question.model, reference, question.motion).command_V);
    }
    next(tape);
  }
  void next(Tape& tape) {
    const cost::Subject& subject = question.subject;
    const auto anywhere = [&] {
      return between(tape, static_cast<double>(subject.ambient_kPa), static_cast<double>(subject.supply_kPa));
    };
    measured_kPa = one_in_two(tape) ? anywhere() : regulator.pressure_kPa() + between(tape, -5.0, 5.0);
    const Scalar base_kPa = one_in_two(tape) ? anywhere() : measured_kPa;
    for (Scalar& reference_kPa : reference.kPa) reference_kPa = base_kPa + between(tape, -30.0, 30.0);
  }

  Question question;
  control::Regulator regulator;
  control::ReferenceShaper::Reference reference;
  Scalar measured_kPa{};
};

std::vector<std::uint8_t> image_of(const config::ModelParameters& model) {
  std::vector<std::uint8_t> bytes(config::kMaxImageBytes);
  bytes.resize(config::encode(model, bytes));
  return bytes;
}

struct Row {
  std::string name;
  cost::Effort effort;
  std::function<std::uint64_t(Instructions&, Tape&)> cost;
};

std::vector<Row> rows_of_models() {
  std::vector<Row> rows;
  constexpr std::array<std::pair<ModelKind, const char*>, 3> kKinds = {
      {{ModelKind::tassa9, "Tassa9"}, {ModelKind::tassa9r, "Tassa9r"}, {ModelKind::greybox, "Greybox"}}};
  for (const auto& of_kind : kKinds) {
    const ModelKind kind = of_kind.first;
    const std::string name = of_kind.second;
    rows.push_back({name + "::configure", kOfFunction, [kind](Instructions& count, Tape& tape) {
                      const Question asked(tape, kind);
                      return count.of(
                          [&] { wanted(asked.known->take_over(asked.subject.model, Scalar(3), Scalar(7))); });
                    }});
    rows.push_back({name + "::step", kOfFunction, [kind](Instructions& count, Tape& tape) {
                      const Question asked(tape, kind);
                      return count.of([&] {
                        wanted(
                            asked.model->step(asked.pressure_kPa, asked.command_V, asked.motion, Scalar(1)));
                      });
                    }});
    rows.push_back({name + "::inverse", kOfFunction, [kind](Instructions& count, Tape& tape) {
                      const Question asked(tape, kind);
                      return count.of([&] {
                        wanted(asked.model->inverse(asked.pressure_kPa, asked.target_kPa, asked.motion,
                                                    asked.command_V));
                      });
                    }});
    rows.push_back(
        {"Regulator::observe, " + name, kOfFunction, [kind](Instructions& count, Tape& tape) {
           Regulation run(tape, kind);
           return count.of([&] {
             wanted(run.regulator.observe(*run.question.model, run.measured_kPa, run.question.motion));
           });
         }});
    rows.push_back({"Regulator::regulate, " + name, kOfFunction, [kind](Instructions& count, Tape& tape) {
                      Regulation run(tape, kind);
                      run.regulator.observe(*run.question.model, run.measured_kPa, run.question.motion);
                      return count.of([&] {
                        wanted(
                            run.regulator.regulate(*run.question.model, run.reference, run.question.motion));
                      });
                    }});
    rows.push_back({"config::decode, " + name, kOfFunction, [kind](Instructions& count, Tape& tape) {
                      const auto image = image_of(draw_with_delays(tape, kind).model);
                      config::ModelParameters decoded;
                      return count.of([&] { wanted(config::decode(image, decoded)); });
                    }});
    rows.push_back(
        {"Controller::step, regulating by " + name, kOfEpisode, [kind](Instructions& count, Tape& tape) {
           constexpr int kTicks = 8;
           const auto chambers =
               std::make_unique<cost::ChambersAlike<Tape>>(tape, draw_with_delays(tape, kind));
           chambers->go_active();
           std::uint64_t most = 0;
           for (int k = 0; k < kTicks; ++k) {
             chambers->next_scene();
             for (const ports::CanFrame& frame : chambers->setpoints()) chambers->controller().receive(frame);
             const Inputs inputs = chambers->inputs();
             most = std::max(most, count.of([&] { wanted(chambers->controller().step(inputs)); }));
             ports::CanFrame frame;
             while (chambers->controller().next_frame(frame)) {
             }
           }
           return most;
         }});
  }
  return rows;
}

std::vector<Row> rows_of_blocks() {
  std::vector<Row> rows;
  rows.push_back({"VolumeObserver::step", kOfFunction, [](Instructions& count, Tape& tape) {
                    control::VolumeObserver observer;
                    observer.configure({});
                    observer.reset(between(tape, 1.0, 1000.0));
                    const Scalar measured_mL = between(tape, 1.0, 1000.0);
                    return count.of([&] { wanted(observer.step(measured_mL)); });
                  }});
  rows.push_back({"CommandTrim::move", kOfFunction, [](Instructions& count, Tape& tape) {
                    control::CommandTrim trim;
                    trim.configure({});
                    const auto move = [&] {
                      trim.move(trim.place(between(tape, 2.0, 8.0)), between(tape, -2.0, 2.0));
                    };
                    for (std::uint64_t left = tape() % 20; left > 0; --left) move();
                    const Scalar command_V = between(tape, 2.0, 8.0);
                    const Scalar step_V = between(tape, -2.0, 2.0);
                    return count.of([&] { trim.move(trim.place(command_V), step_V); });
                  }});
  rows.push_back({"ReferenceShaper::step", kOfFunction, [](Instructions& count, Tape& tape) {
                    control::ReferenceShaper shaper;
                    const numeric::Scalar ramp_kPa_s = between(tape, 1.0, 100000.0);
                    shaper.configure({.rise_kPa_s = ramp_kPa_s, .fall_kPa_s = ramp_kPa_s});
                    shaper.reset(between(tape, 0.0, 1000.0));
                    const auto preview = static_cast<std::uint8_t>(tape() % 12);
                    const std::size_t ahead = 1 + tape() % control::ReferenceShaper::kMostAhead;
                    for (int i = 0; i < 4; ++i) shaper.step(between(tape, 0.0, 1000.0), preview, ahead);
                    const Scalar setpoint_kPa = between(tape, 0.0, 1000.0);
                    return count.of([&] { wanted(shaper.step(setpoint_kPa, preview, ahead)); });
                  }});
  rows.push_back({"SensorLag::observe", kOfFunction, [](Instructions& count, Tape& tape) {
                    control::SensorLag sensor;
                    sensor.configure(between(tape, 0.0, 30.0), Scalar(2));
                    const Scalar from_kPa = between(tape, 100.0, 700.0);
                    sensor.reset(from_kPa);
                    const control::Prediction predicted{.end_kPa = between(tape, 100.0, 700.0),
                                                        .mean_kPa = between(tape, 100.0, 700.0)};
                    const Scalar reading_kPa = between(tape, 100.0, 700.0);
                    return count.of([&] { wanted(sensor.observe(from_kPa, predicted, reading_kPa)); });
                  }});
  rows.push_back({"Excitation::step", kOfFunction, [](Instructions& count, Tape& tape) {
                    control::Excitation excitation;
                    excitation.configure({.seed = static_cast<std::uint32_t>(tape())});
                    for (std::uint64_t left = tape() % 20; left > 0; --left)
                      excitation.step(between(tape, 50.0, 700.0));
                    const Scalar pressure_kPa = between(tape, 50.0, 700.0);
                    return count.of([&] { wanted(excitation.step(pressure_kPa)); });
                  }});
  rows.push_back({"config::crc32, the longest image", {.drawn = 1}, [](Instructions& count, Tape& tape) {
                    std::array<std::uint8_t, config::kMaxImageBytes> bytes{};
                    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(tape());
                    return count.of([&] { wanted(config::crc32(bytes)); });
                  }});
  rows.push_back({"Controller::prepare", {.drawn = 1}, [](Instructions& count, Tape&) {
                    const auto controller = std::make_unique<Controller>(cost::settings_alike());
                    return count.of([&] { controller->prepare(); });
                  }});
  return rows;
}

/// The dearest call of one sort in a session.
struct OneSort {
  template <class Calls>
  void operator()(cost::Call call, Calls&& calls) {
    if (call != sort) return calls();
    most = std::max(most, count.of(calls));
  }
  Instructions& count;
  cost::Call sort;
  std::uint64_t most = 0;
};

std::vector<Row> rows_of_sessions() {
  std::vector<Row> rows;
  const auto add = [&](const char* name, cost::Call sort) {
    rows.push_back({name, kOfSession, [sort](Instructions& count, Tape& tape) {
                      constexpr int kActs = 3;
                      const auto chambers = std::make_unique<cost::ChambersAlike<Tape>>(
                          tape, draw_with_delays(tape, ModelKind::tassa9));
                      chambers->go_active();
                      OneSort watch{count, sort};
                      cost::Master<Tape, OneSort> master(tape, *chambers, watch);
                      for (int i = 0; i < kActs; ++i) master.act();
                      return watch.most;
                    }});
  };
  add("Controller::receive, any frame", cost::Call::receive);
  add("Controller::step, whatever a master does", cost::Call::step);
  add("Controller::next_frame, all of a tick", cost::Call::send);
  return rows;
}

std::vector<Row> all_rows() {
  std::vector<Row> rows = rows_of_models();
  for (auto& more : {rows_of_blocks(), rows_of_sessions()}) rows.insert(rows.end(), more.begin(), more.end());
  return rows;
}

}  // namespace

namespace {

/// The cases of standard input, by their rows.
std::map<std::string, std::vector<Tape>> known_cases() {
  std::map<std::string, std::vector<Tape>> known;
  for (std::string line; std::getline(std::cin, line);) {
    const std::size_t tabulator = line.find('\t');
    if (tabulator == std::string::npos)
      throw std::invalid_argument("a row, a tabulator and a tape are expected, found '" + line.substr(0, 40) +
                                  "'");
    known[line.substr(0, tabulator)].push_back(Tape::from(line.substr(tabulator + 1)));
  }
  return known;
}

void print(const Row& row, std::uint64_t seed, const std::vector<Tape>& known, Instructions& instructions) {
  const auto cost_of = [&](Tape& tape) { return row.cost(instructions, tape); };
  const std::uint64_t kept = known.empty() ? 0 : cost::dearest(seed, known, {}, cost_of).cost;
  const cost::Dearest found = cost::dearest(seed, known, row.effort, cost_of);
  std::printf(R"({"row": "%s", "instructions": %llu, "kept": %llu, "case": "%s"})"
              "\n",
              row.name.c_str(), static_cast<unsigned long long>(found.cost),
              static_cast<unsigned long long>(kept), found.tape.text().c_str());
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** words) {
  const std::vector<std::string> arguments(words + 1, words + count);
  const std::vector<Row> rows = all_rows();
  if (arguments == std::vector<std::string>{"--list"}) {
    for (const Row& row : rows) std::printf("%s\n", row.name.c_str());
    return 0;
  }
  if (arguments.size() < 2 || RUNNING_ON_VALGRIND == 0) {
    std::fprintf(
        stderr,
        "plenum_cost_instructions: expected --list, or FILE SEED [ROW...] under callgrind, whose output "
        "FILE is\n");
    return 2;
  }
  try {
    Instructions instructions(arguments[0]);
    const std::uint64_t seed = std::stoull(arguments[1]);
    const std::map<std::string, std::vector<Tape>> known = known_cases();
    for (const Row& row : rows) {
      const auto asked = std::find(arguments.begin() + 2, arguments.end(), row.name);
      if (arguments.size() > 2 && asked == arguments.end()) continue;
      const auto of_row = known.find(row.name);
      print(row, seed, of_row == known.end() ? std::vector<Tape>{} : of_row->second, instructions);
    }
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "plenum_cost_instructions: %s\n", fault.what());
    return 2;
  }
}
