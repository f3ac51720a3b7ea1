#include "board/linux_hardware.hpp"

#include <memory>
#include <stdexcept>
#include <thread>

namespace plenum::board {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPause{100};

Guard::Config guard_config(const config::RealTime& real_time) {
  constexpr std::uint64_t kTick_ns = plenum::config::kTick_us * std::uint64_t{1000};
  return {.silence_ns = static_cast<std::uint64_t>(real_time.guard_ticks) * kTick_ns,
          .priority = real_time.priority == 0 ? 0 : real_time.priority + 1};
}

}  // namespace

// The lines come first: while the others are waited for, the valves are without power.
LinuxHardware::LinuxHardware(const config::BoardFile& board, steady_clock::time_point latest)
    : stop_(open_lines(board.gpio, latest)),
      valves_(stop_, open(output_, board.analog_out, latest)),
      guard_(guard_config(board.real_time), valves_),
      bus_([interface = board.interface] { return std::make_unique<drivers::SocketCan>(interface); }),
      watchdog_(board.watchdog) {
  open(input_, board.analog_in, latest);
  open(store_, board.store, latest);
  if (!bus_.trouble().empty()) troubles_.push_back(bus_.trouble());
  events_.emplace(lines_ ? lines_->descriptor() : -1,
                  input_ ? input_->descriptors() : std::span<const int>{});
  events_->watch_frames(bus_.descriptor());
}

template <class Driver, class Config>
std::optional<Driver>& LinuxHardware::open(std::optional<Driver>& driver, const Config& config,
                                           steady_clock::time_point latest) {
  for (;;) {
    try {
      driver.emplace(config);
      return driver;
    } catch (const std::runtime_error& error) {
      if (steady_clock::now() >= latest) {
        troubles_.emplace_back(error.what());
        return driver;
      }
    }
    std::this_thread::sleep_for(kPause);
  }
}

ports::DigitalIo& LinuxHardware::open_lines(const drivers::GpioConfig& config,
                                            steady_clock::time_point latest) {
  open(lines_, config, latest);
  if (lines_) return *lines_;
  return no_lines_;
}

Drivers LinuxHardware::drivers() noexcept {
  const auto either = []<class Port>(auto& driver, Port& absent) -> Port& {
    if (driver) return *driver;
    return absent;
  };
  ports::AnalogInput& no_input = no_input_;
  ports::AnalogOutput& no_output = no_output_;
  ports::ParameterStore& no_store = no_store_;
  return {.analog_in = either(input_, no_input),
          .analog_out = either(output_, no_output),
          .digital = stop_,
          .can = bus_,
          .store = either(store_, no_store)};
}

bool LinuxHardware::gather() noexcept {
  if (!input_) return false;
  const unsigned before = input_->gathered();
  input_->gather();
  return input_->gathered() > before;
}

bool LinuxHardware::scans_ready() const noexcept {
  return input_ && input_->gathered() >= input_->scans_per_tick();
}

void LinuxHardware::ticked(std::uint64_t now_ns, std::uint32_t tick_count) noexcept {
  bus_.tend();
  events_->watch_frames(bus_.descriptor());
  manager_.ticked(now_ns, tick_count);
  watchdog_.ticked(now_ns, tick_count);
  guard_.beat();
}

void LinuxHardware::make_safe() noexcept {
  valves_.make_safe();
  guard_.rest();
}

}  // namespace plenum::board
