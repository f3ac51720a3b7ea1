// What a bus of 1 Mbit/s carries when every chamber gets a set point and gives its actual value at 100 Hz, every frame
// taking the most bits that stuffing can make of it, and how soon a set point is in a command.
//
// The boards keep their default PDOs: four set points or four actual values a frame. One more board is added until a set
// point is missed, an actual value does not come in its own cycle, or the bus is full by count. The wire's own limit is
// the number of such frames that fit into 10 ms beside the SYNC.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <deque>
#include <vector>

#include "firmware/config/model_image.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/ports/can_frame_bits.hpp"
#include "host-sim/rig/standard_rigs.hpp"
#include "host-sim/tools/rig_link.hpp"
#include "tests/bench/row.hpp"

namespace {

using namespace plenum::host;

constexpr int kCycles = 100;
constexpr unsigned kChambers = 8;
constexpr unsigned kFrames = 4;  ///< of a board and cycle
constexpr double kCycleBits = 10'000.0;

rig::RigConfig rig_of(unsigned boards) {
  rig::RigConfig config = rig::mpye_rig({.boards = boards, .chambers = kChambers});
  config.bus.worst_case_stuffing = true;
  return config;
}

std::array<double, kChambers> setpoints(int cycle) {
  std::array<double, kChambers> setpoint_Pa{};
  for (std::size_t c = 0; c < setpoint_Pa.size(); ++c) {
    setpoint_Pa[c] = 2e5 + 1e3 * cycle + 1e4 * static_cast<double>(c);
  }
  return setpoint_Pa;
}

struct Load {
  bool nothing_lost = true;
  double bits_a_cycle = 0.0;
  double worst_latency_us =
      0.0;  ///< of a set point or an actual value, from its queue to the end of its frame
};

/// A model like those fitted to the rig's valves: what the set point makes of the command is not judged here.
std::vector<client::ModelUpload> some_models() {
  plenum::config::ModelParameters model;
  model.kind = plenum::config::ModelKind::tassa9;
  model.count = 12;
  model.value = {5.02F, 2.5F, 4.0F, -0.05F, 0.003F, 0.02F, 40.0F, 0.1F, 0.08F, 0.1F, 620.0F, 101.325F};
  std::vector<std::uint8_t> image(plenum::config::kMaxImageBytes);
  image.resize(plenum::config::encode(model, image));
  std::vector<client::ModelUpload> uploads;
  for (std::uint8_t c = 0; c < kChambers; ++c) uploads.push_back({c, image});
  return uploads;
}

/// Every board regulates its chambers: what it sends besides (a warning, say) takes its place on the bus, too.
Load loaded(unsigned boards) {
  rig::Rig rig(rig_of(boards));
  tools::RigLink link(rig);
  std::deque<client::Session> sessions;
  for (unsigned id = 1; id <= boards; ++id) {
    sessions.emplace_back(link, static_cast<std::uint8_t>(id));
    sessions.back().upload_models(some_models());
    sessions.back().nmt(plenum::canopen::NmtCommand::start);
  }
  const auto cycle = [&](int k, double end_s) {
    for (client::Session& session : sessions) session.send_setpoints(setpoints(k));
    sessions[0].send_sync();
    sessions[0].listen(end_s - rig.now_s());
  };
  for (client::Session& session : sessions) {
    cycle(0, rig.now_s() + 0.01);
    session.enable();
  }
  std::vector<unsigned> actual(boards + 1);
  sessions[0].subscribe([&](const client::Arrival& arrival) {
    const std::uint32_t function = arrival.frame.id & 0x780U;
    if (function == 0x180 || function == 0x280) ++actual.at(arrival.frame.id & 0x7FU);
  });
  sessions[0].listen(0.02);  // what is still on its way
  std::fill(actual.begin(), actual.end(), 0U);
  std::vector<std::uint32_t> counts;
  for (std::size_t b = 0; b < boards; ++b) counts.push_back(rig.board(b).controller().image().setpoint_count);
  const ports::SimulatedBus::Counters before = rig.bus().counters();
  const double start_s = rig.now_s();
  Load load;
  for (int k = 0; k < kCycles; ++k) {
    cycle(k, start_s + 0.01 * (k + 1));
    for (std::size_t b = 0; b < boards; ++b) {
      const auto& image = rig.board(b).controller().image();
      load.nothing_lost =
          load.nothing_lost && image.error_code == 0 &&
          (image.status_word & plenum::canopen::word::kActive) == plenum::canopen::word::kActive &&
          image.setpoint_count == counts[b] + static_cast<unsigned>(k + 1);
    }
  }
  load.bits_a_cycle = static_cast<double>(rig.bus().counters().bits - before.bits) / kCycles;
  sessions[0].listen(0.01);
  for (unsigned id = 1; id <= boards; ++id) {
    load.nothing_lost = load.nothing_lost && actual[id] == 2U * kCycles;
    for (const std::uint32_t function : {0x180U, 0x280U, 0x200U, 0x300U}) {
      load.worst_latency_us =
          std::max(load.worst_latency_us,
                   1e-3 * static_cast<double>(rig.bus().identifier_counters(function + id).worst_latency_ns));
    }
  }
  return load;
}

struct Commanded {
  std::vector<std::array<float, kChambers>> at_tick;
  std::size_t in_force = 0;  ///< ticks that were over when the last set points came into force
};

/// Commands of a board in ACTIVE whose set points come `phase_s` after each tick; the last ones differ by `step_Pa`.
Commanded commanded(double phase_s, double step_Pa) {
  Commanded result;
  rig::Rig rig(rig::mpye_rig({.boards = 1, .chambers = kChambers}));
  const auto& image = rig.board(0).controller().image();
  tools::RigLink link(rig, "master", [&] {
    std::array<float, kChambers> now{};
    for (std::size_t c = 0; c < now.size(); ++c) now[c] = image.chamber[c].command_V;
    result.at_tick.push_back(now);
  });
  client::Session session(link, 1);
  session.upload_models(some_models());
  session.nmt(plenum::canopen::NmtCommand::start);
  session.listen(0.01 - std::fmod(rig.now_s(), 0.01) + phase_s);
  std::array<double, kChambers> setpoint_Pa{};
  setpoint_Pa.fill(3e5);
  const auto cycle = [&] {
    const double begin_s = rig.now_s();
    session.send_setpoints(setpoint_Pa);
    session.send_sync();
    const std::uint32_t before = image.setpoint_count;
    while (image.setpoint_count == before) session.listen(1e-5);
    result.in_force = result.at_tick.size();
    session.listen(begin_s + 0.01 - rig.now_s());
  };
  for (const std::uint16_t word :
       {plenum::canopen::word::kDisabled, plenum::canopen::word::kHold, plenum::canopen::word::kActive}) {
    session.write<std::uint16_t>(plenum::canopen::object::kControlWord, 0, word);
    session.listen(0.01 - std::fmod(rig.now_s() - phase_s, 0.01));
    cycle();
  }
  for (int k = 0; k < 20; ++k) cycle();
  for (double& p : setpoint_Pa) p += step_Pa;
  cycle();
  session.listen(0.05);
  return result;
}

/// Ticks from a set point's coming into force to the first command that knows of it, counting the tick of that command:
/// of two boards alike in all but their last set point. The worst of all chambers and of several phases of the tick.
std::size_t setpoint_to_command_ticks() {
  std::size_t worst = 0;
  for (const double phase_s : {0.0005, 0.003, 0.005, 0.007, 0.009}) {
    const Commanded one = commanded(phase_s, 0.0), other = commanded(phase_s, 5e4);
    for (std::size_t c = 0; c < kChambers; ++c) {
      std::size_t tick = other.in_force;
      while (tick < other.at_tick.size() && other.at_tick[tick][c] == one.at_tick[tick][c]) ++tick;
      worst = std::max(worst, tick - other.in_force + 1);
    }
  }
  return worst;
}

}  // namespace

int main() {
  const double sync_bits = ports::most_frame_bits({}) + ports::kIntermissionBits;
  const double frame_bits = ports::most_frame_bits({.length = 8}) + ports::kIntermissionBits;
  const auto limit = static_cast<unsigned>((kCycleBits - sync_bits) / (kFrames * frame_bits));
  Load ten, most;
  unsigned boards = 0;
  for (unsigned tried = 10; tried <= limit + 1; ++tried) {
    const Load load = loaded(tried);
    if (tried == 10) ten = load;
    if (!load.nothing_lost) break;
    most = load;
    boards = tried;
  }
  std::fprintf(
      stderr,
      "the wire's own limit: %u boards (%u chambers); %u boards carried, %.0f of 10000 bits a cycle\n", limit,
      kChambers * limit, boards, most.bits_a_cycle);
  plenum::bench::print({"bus.chambers_at_1mbit_100hz", 1.0 * kChambers * boards, "chambers", "higher", 80.0});
  plenum::bench::print({"bus.wire_limit_chambers", 1.0 * kChambers * limit, "chambers", "higher"});
  plenum::bench::print({"bus.load_of_80_chambers_percent", 100.0 * ten.bits_a_cycle / kCycleBits, "%"});
  plenum::bench::print({"bus.worst_latency_of_80_chambers_us", ten.worst_latency_us, "us"});
  const auto ticks = static_cast<double>(setpoint_to_command_ticks());
  plenum::bench::print({"bus.setpoint_to_command_ticks", ticks, "ticks", "lower", 1.0});
}
