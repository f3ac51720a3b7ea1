#include "tests/safety/upset.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <system_error>

#include "host-sim/plant/random.hpp"
#include "tests/safety/machine.hpp"

namespace plenum::safety_case {
namespace {

using host::plant::Random;
using safety::State;

constexpr std::uint64_t kOfAMachine = 64;  ///< upsets that share one, up to the flip
constexpr int kTicks = 200;                ///< from the flip to the end
constexpr int kLate = 150;                 ///< from the flip to where the two runs must agree again
constexpr unsigned kPatience_s = 20;       ///< for a run of milliseconds

struct Member {
  const char* name;
  std::size_t offset, bytes;
  bool of_each_chamber;
};

/// Where the members of a class lie, in the order of their declaration; the sizes must add up.
class Layout {
 public:
  template <class T>
  void add(const char* name, bool of_each_chamber = false) {
    at_ = (at_ + alignof(T) - 1) / alignof(T) * alignof(T);
    members_.push_back({name, at_, sizeof(T), of_each_chamber});
    at_ += sizeof(T);
  }
  template <class Whole>
  std::vector<Member> of() const {
    const std::size_t whole = (at_ + alignof(Whole) - 1) / alignof(Whole) * alignof(Whole);
    if (whole != sizeof(Whole)) throw std::logic_error("tests/safety/upset.cpp: the layout is another one");
    return members_;
  }

 private:
  std::size_t at_ = 0;
  std::vector<Member> members_;
};

std::vector<Member> loop_members() {
  Layout loop;
  loop.add<config::ChamberSettings>("settings of a chamber", true);
  loop.add<config::ChamberSettings>("settings at rest", true);
  loop.add<safety::ChamberMonitor>("monitor", true);
  loop.add<control::VolumeObserver>("volume observer", true);
  loop.add<control::ReferenceShaper>("reference", true);
  loop.add<control::Regulator>("regulator", true);
  loop.add<control::Excitation>("excitation", true);
  loop.add<control::AnyModel>("model", true);
  loop.add<config::LongSeal>("seal of the model", true);
  loop.add<std::array<std::uint64_t, 5>>("seals of settings and state", true);
  loop.add<std::array<numeric::Scalar, 4>>("delay, commands and stroke", true);
  loop.add<numeric::Scalar>("last pressure", true);
  loop.add<control::ChamberMotion>("motion", true);
  loop.add<std::array<numeric::Scalar, 6>>("last of the model, what is held", true);
  loop.add<std::array<bool, 11>>("flags", true);
  return loop.of<ChamberLoop>();
}

std::vector<Member> members() {
  Layout controller;
  controller.add<control::Regulator::Config>("regulator's configuration");
  controller.add<std::uint64_t>("seal of the regulator's configuration");
  controller.add<config::SettingsDesk>("settings desk");
  controller.add<canopen::ProcessImage>("process image");
  controller.add<telemetry::Recorder>("recorder");
  controller.add<InverseRun>("inverse run");
  controller.add<ShadowRun>("shadow run");
  controller.add<config::ParameterSlots>("parameter slots");
  controller.add<canopen::Node>("node");
  controller.add<std::array<ChamberLoop, kChambers>>("chambers");
  controller.add<safety::BoardMonitor>("board monitor");
  controller.add<safety::FaultRegister>("fault register");
  controller.add<safety::Supervisor>("supervisor");
  controller.add<std::array<safety::SetpointNews, kChambers>>("news of set points");
  controller.add<safety::Drive>("last drive");
  controller.add<std::array<std::uint8_t, 2>>("masks of chambers");
  std::vector<Member> all;
  for (const Member& member : controller.of<Controller>()) {
    if (std::strcmp(member.name, "chambers") != 0) {
      all.push_back(member);
      continue;
    }
    for (Member of_loop : loop_members()) {
      of_loop.offset += member.offset;
      all.push_back(of_loop);
    }
  }
  return all;
}

/// What a run did: compared with that of a machine of which no bit flipped, and whose noise is the same.
struct Course {
  std::array<std::array<float, kChambers>, kTicks> command_V;
  std::array<std::array<double, kChambers>, kTicks> pressure_kPa;
};

/// What a run's process leaves behind.
struct Verdict {
  bool reached;
  End end;
  Apart apart;
  std::array<char, 160> why;
  Course undisturbed;  ///< of the stage
};

enum class Scene : std::uint8_t { closed_loop, open_loop, excitation, hold, rest, faulty };
constexpr std::array kSceneNames = {"regulates", "runs in open loop", "excites", "holds",
                                    "rests",     "waits for a reset"};

/// A machine that is brought to its scene, to be copied.
class Stage {
 public:
  explicit Stage(std::uint64_t seed)
      : random_(seed),
        scene_(static_cast<Scene>(static_cast<int>(random_.uniform(0.0, kSceneNames.size())))),
        kind_(draw_kind()),
        machine_(models(kind_), random_.uniform() < 0.5 ? config::SafeOutput::null : config::SafeOutput::vent,
                 seed) {
    machine_.start(scene_ == Scene::excitation  ? canopen::ControlMode::excitation
                   : scene_ == Scene::open_loop ? canopen::ControlMode::pressure_open_loop
                                                : canopen::ControlMode::pressure_closed_loop);
    word_ = scene_ == Scene::rest ? 0x1 : scene_ == Scene::hold ? 0x3 : 0x7;
    for (const std::uint16_t word : Words{0x1, 0x3, 0x7}) {
      if (word <= word_) machine_.climb({word});
    }
    machine_.run(60);
    if (scene_ == Scene::faulty) {
      machine_.digital.inputs.emergency_stop = true;
      machine_.run(2);
      machine_.digital.inputs.emergency_stop = false;
      word_ = 0x1;
      machine_.climb({word_});
    }
    machine_.run(2);
    state_ = machine_.state();
    code_ = machine_.image().error_code;
    register_ = machine_.image().error_register;
    const State wanted = scene_ == Scene::faulty ? State::fault_disabled
                         : scene_ == Scene::rest ? State::disabled
                         : scene_ == Scene::hold ? State::hold
                                                 : State::active;
    if (state_ != wanted || (code_ != 0) != (scene_ == Scene::faulty))
      throw std::logic_error(fmt::format("seed {}: a machine that {} is {}", seed,
                                         kSceneNames[static_cast<std::size_t>(scene_)],
                                         safety::describe(state_)));
  }

  std::string name() const {
    return fmt::format("{}, model {}", kSceneNames[static_cast<std::size_t>(scene_)],
                       static_cast<int>(kind_));
  }

  /// Of no flip.
  Course course() {
    Course course;
    for (std::size_t i = 0; i < kTicks; ++i) {
      machine_.tick();
      for (std::size_t c = 0; c < kChambers; ++c) {
        course.command_V[i][c] = machine_.analog_out.asked_V[c];
        course.pressure_kPa[i][c] = machine_.pressure_kPa(c);
      }
    }
    return course;
  }

  /// Flips, runs, and judges: in a process of its own. `why` takes what is wrong with an unsafe end.
  End judge(std::size_t byte, unsigned bit, Verdict& verdict, std::string& why) {
    const Controller& controller = machine_.board.controller();
    auto* bytes = reinterpret_cast<unsigned char*>(const_cast<Controller*>(&controller));
    bytes[byte] = static_cast<unsigned char>(bytes[byte] ^ 1U << bit);
    for (int i = 0; i < kTicks; ++i) {
      machine_.tick();
      for (std::size_t c = 0; c < kChambers; ++c) {
        const float command_V = machine_.analog_out.asked_V[c];
        if (!(command_V >= 0.0F && command_V <= 10.0F)) {
          why = fmt::format("tick {}: {} V at chamber {}", i, command_V, c + 1);
          return End::unsafe;
        }
        const auto at = static_cast<std::size_t>(i);
        Apart& apart = verdict.apart;
        const double apart_kPa = std::abs(machine_.pressure_kPa(c) - verdict.undisturbed.pressure_kPa[at][c]);
        const double apart_V =
            std::abs(static_cast<double>(command_V - verdict.undisturbed.command_V[at][c]));
        apart.most_kPa = std::max(apart.most_kPa, apart_kPa);
        if (i < kLate) continue;
        apart.late_kPa = std::max(apart.late_kPa, apart_kPa);
        apart.late_V = std::max(apart.late_V, apart_V);
      }
      const bool moves = machine_.state() == State::active || machine_.state() == State::hold;
      if (moves && (word_ & 0x2) == 0) {
        why = fmt::format("tick {}: moves without an order", i);
        return End::unsafe;
      }
    }
    if (!machine_.over_pressure().empty()) {
      why = machine_.over_pressure();
      return End::unsafe;
    }
    const std::uint16_t code = machine_.image().error_code;
    if (!outputs_follow(why)) return End::unsafe;
    if (code_ != 0 && code == 0) {
      why = "the fault is forgotten";
      return End::unsafe;
    }
    // a more urgent fault that stood before hides the code of a second one, but not its bit of 1001h
    if (code != code_ || machine_.image().error_register != register_) return End::detected;
    // a fault that stands may hide a second one, which leads to another of its states
    if (code_ == 0 && machine_.state() != state_) {
      why = fmt::format("is {} without a fault", safety::describe(machine_.state()));
      return End::unsafe;
    }
    machine_.control(0x0);
    machine_.run(2);
    const bool obeys = machine_.state() == State::init || machine_.state() == State::fault_init;
    if (!obeys) return End::deaf;
    return verdict.apart.late_kPa <= kAlike_kPa && verdict.apart.late_V <= kAlike_V ? End::harmless
                                                                                    : End::strayed;
  }

 private:
  config::ModelKind draw_kind() {
    if (scene_ == Scene::open_loop) return config::ModelKind::greybox;
    constexpr std::array kKinds = {config::ModelKind::greybox, config::ModelKind::tassa9r,
                                   config::ModelKind::tassa9};
    return kKinds[static_cast<std::size_t>(random_.uniform(0.0, kKinds.size()))];
  }

  /// By the settings that the test gave, not by those in the controller.
  bool outputs_follow(std::string& why) const {
    const State state = machine_.state();
    const bool regulates = state == State::active || state == State::hold || state == State::fault_hold;
    for (std::size_t c = 0; c < kChambers; ++c) {
      const config::ChamberSettings& its = machine_.settings.chamber[c];
      const float command_V = machine_.analog_out.asked_V[c];
      const bool in_range = command_V >= its.command_low_V && command_V <= its.command_high_V;
      const bool at_rest = command_V == machine_.safe_V(c) || command_V == its.vent_V;
      if (regulates ? in_range || at_rest : at_rest) continue;
      why = fmt::format("{} with {} V at chamber {}", safety::describe(state), command_V, c + 1);
      return false;
    }
    return true;
  }

  Random random_;
  Scene scene_;
  config::ModelKind kind_;
  Machine machine_;
  std::uint16_t word_ = 0;
  State state_ = State::not_ready;
  std::uint16_t code_ = 0;
  std::uint8_t register_ = 0;
};

/// Runs in a process of its own, which `judge` ends. Returns its status.
template <class Judge>
int in_a_process(const Judge& judge) {
  const pid_t child = fork();
  if (child < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (child == 0) {
    alarm(kPatience_s);
    judge();
    _exit(0);
  }
  int status = 0;
  if (waitpid(child, &status, 0) != child) throw std::system_error(errno, std::generic_category(), "waitpid");
  return status;
}

Upset run_apart(Stage& stage, std::uint64_t seed, Verdict& shared) {
  static const std::vector<Member> all = members();
  Random random(seed ^ 0x5EEDU);
  Upset upset{.seed = seed, .part = seed % all.size(), .apart = {}, .what = {}};
  const Member& member = all[upset.part];
  std::size_t byte =
      member.offset + static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(member.bytes)));
  if (member.of_each_chamber)
    byte += sizeof(ChamberLoop) * static_cast<std::size_t>(random.uniform(0.0, kChambers));
  const auto bit = static_cast<unsigned>(random.uniform(0.0, 8.0));
  shared.reached = false;
  shared.apart = {};
  shared.why.fill('\0');
  const int status = in_a_process([&] {
    std::string why;
    shared.end = stage.judge(byte, bit, shared, why);
    why.copy(shared.why.data(), shared.why.size() - 1);
    shared.reached = true;
  });
  upset.apart = shared.apart;
  upset.end = shared.reached ? shared.end : End::ended;
  upset.what =
      fmt::format("{}, byte {}, bit {}, {}: {}, at most {:.1f} kPa apart, late {:.2f} kPa and {:.3f} V {}",
                  member.name, byte - member.offset, bit, stage.name(), describe(upset.end),
                  upset.apart.most_kPa, upset.apart.late_kPa, upset.apart.late_V, shared.why.data());
  if (!shared.reached && WIFSIGNALED(status)) upset.what += strsignal(WTERMSIG(status));
  return upset;
}

}  // namespace

const char* describe(End end) {
  constexpr std::array kNames = {"harmless", "detected", "strayed", "ended", "deaf", "unsafe"};
  return kNames[static_cast<std::size_t>(end)];
}

std::vector<Part> parts() {
  std::vector<Part> found;
  for (const Member& member : members())
    found.push_back({member.name, member.bytes * (member.of_each_chamber ? kChambers : 1)});
  return found;
}

std::vector<Upset> upsets(std::uint64_t first, std::uint64_t last) {
  void* page = mmap(nullptr, sizeof(Verdict), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) throw std::system_error(errno, std::generic_category(), "mmap");
  Verdict& shared = *new (page) Verdict{};
  std::vector<Upset> found;
  std::unique_ptr<Stage> stage;
  for (std::uint64_t seed = first; seed < last; ++seed) {
    if (!stage || seed % kOfAMachine == 0) {
      stage = std::make_unique<Stage>(seed / kOfAMachine);
      in_a_process([&] { shared.undisturbed = stage->course(); });
    }
    found.push_back(run_apart(*stage, seed, shared));
  }
  munmap(page, sizeof(Verdict));
  return found;
}

}  // namespace plenum::safety_case
