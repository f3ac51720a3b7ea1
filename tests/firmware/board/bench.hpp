// A board on the bench: its drivers are lines of memory, its chambers obey the 9-parameter model exactly.
//
// The model is written here a second time, in double and from the paper's equations (7) to (10), at a volume
// that stands still: what the board regulates is known in closed form.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <initializer_list>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "firmware/board.hpp"
#include "firmware/config/model_image.hpp"
#include "host-sim/client/link.hpp"
#include "host-sim/client/session.hpp"
#include "tests/firmware/config/power_cut_medium.hpp"

namespace plenum {

using config::kChambers;

/// Control words, one after the other.
using Words = std::initializer_list<std::uint16_t>;

class FakeAnalogInput final : public ports::AnalogInput {
 public:
  void read(std::span<ports::AnalogReading> readings) noexcept override {
    for (std::size_t i = 0; i < readings.size(); ++i) readings[i] = reading.at(i);
  }
  std::array<ports::AnalogReading, kAnalogInputs> reading{};
};

class FakeAnalogOutput final : public ports::AnalogOutput {
 public:
  bool write(std::span<const float> command_V) noexcept override {
    asked_V.assign(command_V.begin(), command_V.end());
    if (!refuses) held_V = asked_V;
    return !refuses;
  }
  std::vector<float> asked_V, held_V;
  bool refuses = false;
};

class FakeDigitalIo final : public ports::DigitalIo {
 public:
  ports::DigitalInputs read() noexcept override { return inputs; }
  void write(const ports::DigitalOutputs& written) noexcept override { outputs = written; }
  ports::DigitalInputs inputs;
  ports::DigitalOutputs outputs;
};

class FakeCan final : public ports::CanBus {
 public:
  bool send(const ports::CanFrame& frame) noexcept override {
    if (state_now == ports::CanState::bus_off || from_board.size() >= room) return false;
    from_board.push_back(frame);
    return true;
  }
  bool receive(ports::CanFrame& frame) noexcept override {
    if (to_board.empty()) return false;
    frame = to_board.front();
    to_board.pop_front();
    return true;
  }
  ports::CanState state() const noexcept override { return state_now; }
  std::uint32_t lost() const noexcept override { return lost_frames; }

  std::deque<ports::CanFrame> to_board, from_board;
  std::size_t room = SIZE_MAX;  ///< frames that the transmit queue holds
  ports::CanState state_now = ports::CanState::error_active;
  std::uint32_t lost_frames = 0;
};

/// c1..c9, c_gamma, P_c, P_r of a valve like the paper's.
inline constexpr std::array<float, 12> kValve = {5.02F, 2.5F, 4.0F,  -0.05F, 0.003F, 0.02F,
                                                 40.0F, 0.1F, 0.08F, 0.1F,   620.0F, 101.325F};

inline std::vector<std::uint8_t> image_of(const std::array<float, 12>& values, std::uint32_t serial = 0) {
  config::ModelParameters parameters;
  parameters.kind = config::ModelKind::tassa9;
  parameters.count = 12;
  parameters.valve_serial = serial;
  std::copy(values.begin(), values.end(), parameters.value.begin());
  std::vector<std::uint8_t> bytes(config::kMaxImageBytes);
  bytes.resize(config::encode(parameters, bytes));
  return bytes;
}

/// A chamber at a constant volume [kPa, V, mL], (7) to (10) with v' = 0.
struct Chamber {
  double pressure_kPa = 101.325;
  double volume_mL = 150.0;

  /// Moves on by a tick; returns the mean pressure over it.
  double advance(double command_V) {
    const auto c = [](std::size_t i) { return static_cast<double>(kValve[i - 1]); };
    const double u = command_V - c(1);
    const double x = c(2) * u + c(3) * u * u * u;
    const double s = 0.5 * (c(11) + c(12)) + 0.5 * (c(11) - c(12)) * x / std::sqrt(x * x + 1.0);
    const double k = std::sqrt(u * u + c(10) * c(10)) - c(10) + c(9) + c(8) * u;
    const double rh = c(7) * k / (1.0 + c(6) * volume_mL) * 0.01;
    const double mean = s + (pressure_kPa - s) * -std::expm1(-rh) / rh;
    pressure_kPa = s + (pressure_kPa - s) * std::exp(-rh);
    return mean;
  }
};

/// One image a chamber; an empty one is none.
using Images = std::array<std::vector<std::uint8_t>, kChambers>;

/// Puts these models and values into the store, as a board would have left them.
inline void keep_set(config::PowerCutMedium& store, const Images& images,
                     const std::vector<config::RecordRow>& values = {}) {
  std::vector<std::uint8_t> body(config::kMaxBodyBytes);
  config::RowWriter rows(body);
  for (const config::RecordRow& row : values) rows.add(row);
  for (std::size_t c = 0; c < kChambers; ++c) {
    const auto index = static_cast<std::uint16_t>(canopen::object::kActiveModel + c);
    if (!images[c].empty()) rows.add({.index = index, .sub = 0, .value = images[c]});
  }
  config::RecordStore writer(store);
  std::vector<std::uint8_t> old(config::kMaxBodyBytes);
  writer.load(old);
  config::store_all(writer, std::span(body).first(rows.size()));
  store.operations = 0;
}

inline Settings bench_settings() {
  Settings settings;
  settings.node.node_id = 5;
  settings.regulator.valve_delay_ticks = 0.0F;
  settings.board.supply_low_kPa = 500.0F;
  for (config::ChamberSettings& chamber : settings.chamber) {
    chamber.vent_V = 2.5F;  // outside of the regulator's range, to be told from its commands
    chamber.pressure_high_kPa = 600.0F;
    chamber.over_pressure_kPa = 700.0F;
  }
  return settings;
}

/// The board, its drivers and chambers, and the bus as a link for a client::Session.
class Bench : public host::client::Link {
 public:
  static constexpr std::uint32_t kNode = 5;

  explicit Bench(const Settings& settings = bench_settings())
      : board(settings, {analog_in, analog_out, digital, can, store}), session(*this, kNode) {
    for (std::size_t c = 0; c < kChambers; ++c) sense(c, chamber[c].pressure_kPa);
    analog_in.reading[2 * kChambers] = {6.2F, true};
  }

  // Link: an SDO request is answered between ticks, everything else takes ticks
  void send(const ports::CanFrame& frame) override {
    can.to_board.push_back(frame);
    board.handle_frames();
  }
  std::optional<ports::CanFrame> receive(double timeout_s) override {
    for (const double end_s = now_s() + timeout_s; can.from_board.empty(); tick()) {
      if (now_s() >= end_s) return std::nullopt;
    }
    const ports::CanFrame frame = can.from_board.front();
    can.from_board.pop_front();
    return frame;
  }
  double now_s() const override { return 0.01 * ticks; }

  void put(std::uint32_t id, const std::vector<std::uint8_t>& data) {
    ports::CanFrame frame;
    frame.id = id;
    frame.length = static_cast<std::uint8_t>(data.size());
    std::copy(data.begin(), data.end(), frame.data.begin());
    if (can.state_now != ports::CanState::bus_off) can.to_board.push_back(frame);
  }
  void control(std::uint16_t word) {
    put(0x400 + kNode, {static_cast<std::uint8_t>(word), static_cast<std::uint8_t>(word >> 8)});
  }
  /// One set point for all chambers, and the SYNC that makes it valid.
  void setpoints(double value_kPa) {
    const auto mbar = static_cast<std::uint16_t>(std::lround(10.0 * value_kPa));
    std::vector<std::uint8_t> data;
    for (int i = 0; i < 4; ++i) {
      data.push_back(static_cast<std::uint8_t>(mbar));
      data.push_back(static_cast<std::uint8_t>(mbar >> 8));
    }
    put(0x200 + kNode, data);
    put(0x300 + kNode, data);
    put(0x80, {});
  }

  /// One tick of the world and the board: chambers move with what the outputs held, then the board steps.
  void tick() {
    if (streaming) setpoints(setpoint_kPa);
    for (std::size_t c = 0; c < kChambers && !analog_out.held_V.empty(); ++c) {
      const bool powered = digital.outputs.valve_power;
      sense(c, chamber[c].advance(powered ? static_cast<double>(analog_out.held_V[c]) : 5.0));
    }
    for (std::size_t i = 0; i < forced.size(); ++i) {
      if (forced[i]) analog_in.reading[i] = *forced[i];
    }
    board.handle_frames();
    board.tick({.overrun = late ? Overrun::fault : Overrun::none});
    if (storing) board.store_changed();
    ++ticks;
  }
  void run(int count) {
    for (int i = 0; i < count; ++i) tick();
  }

  /// A reset, until its boot-up message has come.
  void reset(canopen::NmtCommand command) {
    session.nmt(command);
    tick();
    for (int i = 0; board.controller().node().is_resetting(); ++i) {
      if (i == 1000) throw std::runtime_error("a reset takes no 10 s");
      tick();
    }
    tick();
  }

  using Images = plenum::Images;

  void store_models(const Images& images = images_of(100),
                    const std::vector<config::RecordRow>& values = {}) {
    keep_set(store, images, values);
  }
  static Images images_of(std::uint32_t serial) {
    Images images;
    images.fill(image_of(kValve, serial));
    return images;
  }
  /// Lets the board store until it has nothing left to do, or fails.
  void finish_storing() {
    for (int i = 0; i < 100; ++i) {
      board.store_changed();
      if (image().store.phase != canopen::StorePhase::writing) return;
    }
    throw std::runtime_error("a set of eight models takes no 100 pieces");
  }
  /// From power-on to ACTIVE at `target_kPa`, settled.
  void go_active(double target_kPa) {
    setpoint_kPa = target_kPa;
    store_models();
    board.start();
    put(0, {1, 0});
    tick();
    climb();
    run(100);
    can.from_board.clear();
  }
  /// DISABLED, HOLD, ACTIVE.
  void climb() {
    streaming = true;
    for (const std::uint16_t word : Words{0x1, 0x3, 0x7}) {
      control(word);
      run(2);
    }
  }

  const canopen::ProcessImage& image() const { return board.controller().image(); }
  safety::State state() const { return board.controller().state(); }
  std::vector<ports::CanFrame> take() {
    std::vector<ports::CanFrame> frames(can.from_board.begin(), can.from_board.end());
    can.from_board.clear();
    return frames;
  }
  std::vector<host::client::Emergency> take_emergencies() {
    std::vector<host::client::Emergency> found;
    for (const ports::CanFrame& frame : take()) {
      if (const auto emergency = host::client::decode_emergency(frame)) found.push_back(*emergency);
    }
    return found;
  }

  FakeAnalogInput analog_in;
  FakeAnalogOutput analog_out;
  FakeDigitalIo digital;
  FakeCan can;
  config::PowerCutMedium store;
  Board board;
  std::array<Chamber, kChambers> chamber{};
  /// Readings that stand in place of the true ones: pressures, positions, supply.
  std::array<std::optional<ports::AnalogReading>, kAnalogInputs> forced{};
  bool streaming = false;
  bool storing = false;  ///< the board has time to store after each tick
  double setpoint_kPa = 300.0;
  bool late = false;
  int ticks = 0;
  host::client::Session session;

 private:
  void sense(std::size_t c, double mean_kPa) {
    analog_in.reading[c] = {static_cast<float>(mean_kPa / 100.0), true};
    analog_in.reading[kChambers + c] = {static_cast<float>((chamber[c].volume_mL - 20.0) / 30.0), true};
  }
};

/// From now on this reading stands in place of the true one.
inline void force(Bench& bench, std::size_t input, float mean_V, bool fresh = true) {
  bench.forced[input] = ports::AnalogReading{mean_V, fresh};
}
inline void free_inputs(Bench& bench) {
  bench.forced.fill(std::nullopt);
  bench.analog_in.reading[2 * kChambers] = {6.2F, true};
}

}  // namespace plenum
