// Makes the recording that plenum_same_bits shows to the controller: what a board sees of eight simulated chambers on moving volumes,
// and all that a PC sends it.
//
// Each kind of model is uploaded to some of the chambers, then another kind to each; the board follows in closed and in open loop,
// excites the chambers, and each of several faults strikes while it regulates. The digest printed is the one of this very
// run: what plenum_same_bits finds where the scalar is the same. A recording differs from the last one at least in the numbers
// of its upload sessions, which are random.
//
// usage: plenum_same_bits_record FILE
#include <array>
#include <cmath>
#include <deque>
#include <fstream>
#include <functional>
#include <iomanip>
#include <iostream>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "host-sim/client/capture.hpp"
#include "host-sim/client/model_bytes.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/identify/greybox.hpp"
#include "host-sim/plant/chamber.hpp"
#include "tests/bits/replay.hpp"

namespace {

using namespace plenum;
using namespace plenum::host;

constexpr double kTick_s = 0.01;
constexpr double kSupply_Pa = 700e3;
constexpr double kShut_V = 5.0;

/// The board, its chambers and the way of the PC to it.
class World : public client::Link {
 public:
  explicit World(std::ostream& out) : out_(out) {
    for (unsigned c = 0; c < config::kChambers; ++c) {
      const double mean_m3 = 150e-6 * (1.0 + 0.1 * c);
      const plant::VolumeSine swing{
          .amplitude_m3 = 0.25 * mean_m3, .frequency_Hz = 0.4 + 0.15 * c, .phase_rad = 0.7 * c};
      chamber_.emplace_back(plant::ThinPlateValve({}, plant::Gas{}), plant::ChamberConfig{},
                            plant::VolumeMotion(mean_m3, {swing}));
    }
  }

  void send(const client::CanFrame& frame) override {
    out_ << "F " << std::hex << frame.id;
    for (std::size_t i = 0; i < frame.length; ++i) out_ << ' ' << unsigned{frame.data[i]};
    out_ << '\n';
    board_.receive(frame);
    take_sent();
  }
  std::optional<client::CanFrame> receive(double timeout_s) override {
    for (const double end_s = now_s() + timeout_s; arrived_.empty(); tick()) {
      if (now_s() >= end_s) return std::nullopt;
    }
    const client::CanFrame frame = arrived_.front();
    arrived_.pop_front();
    return frame;
  }
  double now_s() const override { return kTick_s * ticks_; }

  const bits::Replay& board() const { return board_; }
  int ticks() const { return ticks_; }

  /// Changes what the board is shown; empty: nothing.
  std::function<void(bits::Tick&)> fault;
  /// Done before each tick.
  std::function<void()> before_tick;

 private:
  void tick() {
    if (before_tick) before_tick();
    bits::Tick tick;
    for (std::size_t c = 0; c < config::kChambers; ++c) {
      const double held_V =
          outputs_.digital.valve_power ? static_cast<double>(outputs_.command_V[c]) : kShut_V;
      tick.reading[c] = reading(1e-5 * chamber_[c].advance(held_V, kTick_s).mean_Pa);
      tick.reading[config::kChambers + c] = reading(1e6 / 40.0 * chamber_[c].volume_m3());
    }
    tick.reading.back() = reading(1e-5 * kSupply_Pa);
    if (fault) fault(tick);
    out_ << "T " << std::hex << tick.flags << ' ' << tick.stale;
    for (const std::uint16_t value : tick.reading) out_ << ' ' << value;
    out_ << '\n';
    outputs_ = board_.step(tick);
    ++ticks_;
    take_sent();
  }

  /// With noise of 2 bits, which is 60 Pa.
  std::uint16_t reading(double volts) {
    const double noise = static_cast<double>(random_() % 5U) - 2.0;
    return static_cast<std::uint16_t>(std::lround(volts / static_cast<double>(bits::kReadingLsb_V) + noise));
  }

  void take_sent() {
    for (const client::CanFrame& frame : board_.sent()) arrived_.push_back(frame);
  }

  std::ostream& out_;
  bits::Replay board_;
  Outputs outputs_;
  std::vector<plant::ChamberPlant> chamber_;
  std::deque<client::CanFrame> arrived_;
  std::mt19937 random_{1};
  int ticks_ = 0;
};

/// Near what a fit to these chambers gives: how well they predict is not judged here.
std::vector<std::uint8_t> model_of(unsigned kind) {
  if (kind == 0) {
    const std::vector<double> tassa9 = {5.0,  0.9, 1.5,  -0.02, 0.003, 0.02,
                                        12.0, 0.1, 0.05, 0.1,   700.0, 101.3};
    return client::encode_model("tassa9", tassa9, {});
  }
  if (kind == 1) {
    const std::vector<double> tassa9r = {5.0, 0.9, 1.5, 0.02, 0.02, 12.0, -0.1, 0.05, 0.1, 700.0, 101.3};
    return client::encode_model("tassa9r", tassa9r, {});
  }
  trace::RigDescription rig;
  if (kind == 3) {
    rig.effects["area_shape"] = {{"inlet_slope", 1.0}, {"inlet_curve", -0.5}, {"exhaust_slope", 0.6}};
    rig.effects["flow_function"] = {
        {"critical_ratio", 0.35}, {"subsonic_index", 0.6}, {"discharge_slope", 0.1}};
    rig.effects["volume_error"] = {{"offset_mL", 15.0}};
    rig.effects["chamber_leak"] = {{"conductance_g_s_MPa", 0.3}};
    rig.effects["dead_time"] = {{"delay_s", 0.0234}};
    rig.effects["spool_lag"] = {{"natural_frequency_Hz", 12.0}, {"damping", 0.8}};
    rig.effects["valve_hysteresis"] = {{"width_V", 0.2}};
    rig.effects["sensor_lag"] = {{"time_constant_s", 0.03}};
  }
  const trace::ModelFile file = identify::greybox_of(rig).file;
  return client::encode_model(file.kind, file.parameters, {});
}

/// Chamber c has the model (c + shift) mod 4.
void upload(client::Session& session, unsigned shift) {
  std::vector<client::ModelUpload> uploads;
  for (unsigned c = 0; c < config::kChambers; ++c)
    uploads.push_back({static_cast<std::uint8_t>(c), model_of((c + shift) % 4)});
  session.upload_models(uploads, client::Doubted::force);
}

/// Sines for the even chambers, steps for the odd ones.
std::vector<std::vector<double>> references(std::size_t rows) {
  std::vector<std::vector<double>> all(config::kChambers);
  for (unsigned c = 0; c < config::kChambers; ++c) {
    for (std::size_t k = 0; k < rows; ++k) {
      const double t_s = kTick_s * static_cast<double>(k);
      all[c].push_back(c % 2 == 0 ? 350e3 + 90e3 * std::sin(2.0 * std::numbers::pi * (1.0 + 0.4 * c) * t_s)
                       : (k / 25 + c / 2) % 2 == 0 ? 250e3
                                                   : 450e3);
    }
  }
  return all;
}

/// Regulates at a set point that drifts, is struck by the fault for 0.25 s, and goes on when it is reset.
void strike(World& world, client::Session& session, const std::function<void(bits::Tick&)>& fault) {
  world.before_tick = [&world, &session] {
    std::array<double, config::kChambers> setpoint_Pa{};
    for (std::size_t c = 0; c < setpoint_Pa.size(); ++c)
      setpoint_Pa[c] = 300e3 + 1e4 * static_cast<double>(c) + 100.0 * (world.ticks() % 500);
    session.send_setpoints(setpoint_Pa);
    session.send_sync();
  };
  session.reset_fault();
  session.enable();
  session.listen(0.3);
  world.fault = fault;
  session.listen(0.25);
  if (world.board().controller().image().error_code == 0) throw std::runtime_error("a fault did not strike");
  world.fault = {};
  session.listen(0.05);
  world.before_tick = {};
}

void set(bits::Tick& tick, bits::Flag flag) {
  tick.flags |= flag;
}

int run(const char* path) {
  std::ofstream out(path);
  World world(out);
  client::Session session(world, bits::kNode);
  session.listen(0.05);
  session.nmt(canopen::NmtCommand::start);
  upload(session, 0);
  client::follow(session, references(150), {.preview_ticks = 2});
  upload(session, 1);
  client::follow(session, references(100), {.preview_ticks = 0, .open_loop = true});
  client::capture(session, {.seconds = 1.0});
  upload(session, 2);
  const std::vector<std::function<void(bits::Tick&)>> faults = {
      [](bits::Tick& tick) { set(tick, bits::kEmergencyStop); },
      [](bits::Tick& tick) { tick.stale |= 1U << 2U; },
      [](bits::Tick& tick) { tick.reading[5] = 0x10; },
      [](bits::Tick& tick) { tick.reading[3] = 28000; },
      [](bits::Tick& tick) { tick.reading.back() = 10000; },
      [](bits::Tick& tick) { set(tick, bits::kLate); },
      [](bits::Tick& tick) { set(tick, bits::kBusOff); },
      [](bits::Tick& tick) { set(tick, bits::kFramesLost), set(tick, bits::kCanPassive); },
      [](bits::Tick& tick) { set(tick, bits::kOutputsRefused); }};
  for (const auto& fault : faults) strike(world, session, fault);
  if (!out.flush()) throw std::runtime_error(std::string("cannot write ") + path);
  std::cout << std::dec << world.ticks() << " ticks, digest" << std::hex << std::uppercase
            << std::setfill('0');
  for (const std::uint32_t crc : world.board().digest()) std::cout << ' ' << std::setw(8) << crc;
  std::cout << '\n';
  return 0;
}

}  // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::cerr << "usage: plenum_same_bits_record FILE\n";
    return 2;
  }
  try {
    return run(words[1]);
  } catch (const std::exception& error) {
    std::cerr << "plenum_same_bits_record: " << error.what() << '\n';
    return 1;
  }
}
