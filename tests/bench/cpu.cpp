// board.cpu_percent_of_tick: processor time of a tick of the board's own loop with 8 chambers regulating, over its 10 ms.
//
// The very Plenumd and Board of plenumd, on a clock that the bench moves. Each tick the master's SYNC and two PDOs of set points
// come in, the loop is woken for them and again for the tick, and the board sends its default TPDOs and the capture stream of
// eight chambers. Frames cross the kernel by a pair of datagram sockets, a system call each way a frame, as SocketCAN's do;
// machines without the kernel's CAN have no nearer thing. Converters are memory: reading them is the price of a device's driver
// and not of the tick. The chambers obey the model of the tests' board.
//
// Counted is the processor time of this thread from each wait's end to the next wait's begin, all wakings of a tick together:
// other programs on the machine delay the loop, but are not its work. The world moves while the loop waits, uncounted.
#include <fcntl.h>
#include <fmt/core.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "board/plenumd.hpp"
#include "tests/bench/row.hpp"
#include "tests/firmware/board/bench.hpp"

namespace {

using namespace plenum;

constexpr std::size_t kWarmUp = 200;
constexpr std::size_t kTicks = 50'000;
constexpr std::uint64_t kTick_ns = 10'000'000;
constexpr double kTarget_percent = 2.0;
constexpr std::uint32_t kNode = 5;

std::uint64_t processor_time_ns() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000 + static_cast<std::uint64_t>(time.tv_nsec);
}

/// One end of a pair of datagram sockets; a datagram is a frame.
class SocketCan final : public ports::CanBus {
 public:
  explicit SocketCan(int socket) : socket_(socket) {}
  ~SocketCan() { ::close(socket_); }
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;

  bool send(const ports::CanFrame& frame) noexcept override {
    return ::send(socket_, &frame, sizeof frame, MSG_DONTWAIT) == sizeof frame;
  }
  bool receive(ports::CanFrame& frame) noexcept override {
    return ::recv(socket_, &frame, sizeof frame, MSG_DONTWAIT) == sizeof frame;
  }
  ports::CanState state() const noexcept override { return ports::CanState::error_active; }
  std::uint32_t lost() const noexcept override { return 0; }

 private:
  int socket_;
};

/// Chambers, master and clock; what the loop waits for.
class World final : public board::rt::Events, public board::Hardware {
 public:
  World(SocketCan& master, FakeAnalogInput& input, FakeAnalogOutput& output, FakeDigitalIo& digital)
      : master_(master), input_(input), output_(output), digital_(digital) {
    tick_time_ns.reserve(kTicks);
    for (std::size_t c = 0; c < kChambers; ++c) sense(c, chamber_[c].pressure_kPa);
    input_.reading[2 * kChambers] = {6.2F, true};
    begin_ns_ = processor_time_ns();
  }

  void put(std::uint32_t id, std::initializer_list<std::uint8_t> data) {
    ports::CanFrame frame;
    frame.id = id;
    frame.length = static_cast<std::uint8_t>(data.size());
    std::copy(data.begin(), data.end(), frame.data.begin());
    if (!master_.send(frame)) throw std::runtime_error("the master's socket took no frame");
  }

  std::uint64_t now_ns() noexcept override { return now_ns_; }

  board::rt::Happened wait(std::uint64_t until_ns, board::rt::WaitFor) noexcept override {
    spent_ns_ += processor_time_ns() - begin_ns_;
    if (ticked_) {
      if (++ticks_ > kWarmUp) tick_time_ns.push_back(spent_ns_);
      spent_ns_ = 0;
      ticked_ = false;
      told_ = false;
      move_on();
    }
    board::rt::Happened happened{.stop = tick_time_ns.size() == kTicks, .frames = !told_};
    if (told_) now_ns_ = until_ns;  // first the frames, in the middle of the tick, then its end
    if (!told_) now_ns_ = until_ns - kTick_ns / 2;
    told_ = true;
    begin_ns_ = processor_time_ns();
    return happened;
  }

  void begin() noexcept override {}
  bool gather() noexcept override { return false; }
  bool scans_ready() const noexcept override { return false; }
  void look_at_stop() noexcept override {}
  bool guarded() const noexcept override { return true; }
  void ticked(std::uint64_t, std::uint32_t) noexcept override { ticked_ = true; }
  void make_safe() noexcept override {}
  void rest_at(std::size_t, float) noexcept override {}
  void stopping() noexcept override {}

  std::vector<std::uint64_t> tick_time_ns;
  std::uint64_t frames = 0;  ///< that the board has sent since the warm-up

 private:
  void sense(std::size_t c, double mean_kPa) {
    input_.reading[c] = {static_cast<float>(mean_kPa / 100.0), true};
    input_.reading[kChambers + c] = {static_cast<float>((chamber_[c].volume_mL - 20.0) / 30.0), true};
  }

  /// A tick of the chambers, and what the master sends in the next one.
  void move_on() noexcept {
    for (ports::CanFrame frame; master_.receive(frame);) frames += ticks_ > kWarmUp ? 1 : 0;
    for (std::size_t c = 0; c < kChambers; ++c) {
      const double command_V = digital_.outputs.valve_power ? static_cast<double>(output_.held_V[c]) : 5.0;
      sense(c, chamber_[c].advance(command_V));
    }
    // All states of the regulator are met: sines of 0.2 to 2 Hz, and a step now and then.
    const double time_s = 0.01 * static_cast<double>(ticks_);
    const auto mbar = [&](double frequency_Hz) {
      const double step = ticks_ / 300 % 2 == 0 ? 0.0 : 600.0;
      return static_cast<std::uint16_t>(
          std::lround(2700.0 + step + 900.0 * std::sin(6.283 * frequency_Hz * time_s)));
    };
    for (std::uint32_t pdo = 0; pdo < 2; ++pdo) {
      std::array<std::uint16_t, 4> value{};
      for (std::size_t i = 0; i < 4; ++i) value[i] = mbar(0.2 + 0.25 * static_cast<double>(4 * pdo + i));
      const auto low = [&](std::size_t i) { return static_cast<std::uint8_t>(value[i]); };
      const auto high = [&](std::size_t i) { return static_cast<std::uint8_t>(value[i] >> 8U); };
      put(0x200 + 0x100 * pdo + kNode, {low(0), high(0), low(1), high(1), low(2), high(2), low(3), high(3)});
    }
    put(0x80, {});
    switch (ticks_) {  // DISABLED, HOLD, ACTIVE
      case 5:
        return put(0x400 + kNode, {1, 0});
      case 10:
        return put(0x400 + kNode, {3, 0});
      case 15:
        return put(0x400 + kNode, {7, 0});
      default:
        return;
    }
  }

  SocketCan& master_;
  FakeAnalogInput& input_;
  FakeAnalogOutput& output_;
  FakeDigitalIo& digital_;
  std::array<Chamber, kChambers> chamber_{};
  std::uint64_t now_ns_ = 0;
  std::uint64_t begin_ns_ = 0;
  std::uint64_t spent_ns_ = 0;
  std::size_t ticks_ = 0;
  bool ticked_ = false;
  bool told_ = false;
};

double percent(std::uint64_t time_ns) {
  return 100.0 * static_cast<double>(time_ns) / static_cast<double>(kTick_ns);
}

int run() {
  std::array<int, 2> pair{};
  if (::socketpair(AF_UNIX, SOCK_DGRAM, 0, pair.data()) != 0)
    throw std::system_error(errno, std::generic_category(), "a pair of datagram sockets");
  SocketCan to_board(pair[0]);
  SocketCan master(pair[1]);
  Bench models;  // for what a board with eight models has in its store
  models.store_models();
  FakeAnalogInput input;
  FakeAnalogOutput output;
  FakeDigitalIo digital;
  World world(master, input, output, digital);
  Board board(bench_settings(), {input, output, digital, to_board, models.store});
  board.start();
  world.put(0, {1, 0});                           // NMT start
  for (std::uint8_t c = 0; c < kChambers; ++c) {  // TPDO5..12, each tick: the stream
    world.put(0x600 + kNode, {0x23, static_cast<std::uint8_t>(0x04 + c), 0x18, 1,
                              static_cast<std::uint8_t>(0x80 + c), 0x06, 0, 0x40});
    board.handle_frames();
    ports::CanFrame answer;
    while (master.receive(answer)) {
    }
  }
  board::Plenumd loop({.pacing = board::config::Pacing::timer}, board, world, world);
  loop.run();
  if (board.controller().state() != safety::State::active || board.controller().image().error_code != 0)
    throw std::runtime_error(fmt::format("the board does not regulate, error {:04X}h: the count is void",
                                         board.controller().image().error_code));
  std::vector<std::uint64_t>& times_ns = world.tick_time_ns;
  std::sort(times_ns.begin(), times_ns.end());
  const std::uint64_t p999_ns = times_ns[times_ns.size() * 999 / 1000];
  fmt::print(stderr,
             "{} ticks, {:.1f} frames sent in each; median {:.1f} us, 999 of 1000 within {:.1f} us, worst "
             "{:.1f} us\n",
             times_ns.size(), static_cast<double>(world.frames) / static_cast<double>(kTicks),
             1e-3 * static_cast<double>(times_ns[times_ns.size() / 2]), 1e-3 * static_cast<double>(p999_ns),
             1e-3 * static_cast<double>(times_ns.back()));
  bench::print({"board.cpu_percent_of_tick", percent(p999_ns), "%", "lower", kTarget_percent});
  return 0;
}

}  // namespace

int main() {
  try {
    return run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "cpu: {}\n", error.what());
    return 1;
  }
}
