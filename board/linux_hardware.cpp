#include "board/linux_hardware.hpp"

#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "board/range_check.hpp"

namespace plenum::board {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPause{100};

Guard::Config guard_config(const config::RealTime& real_time) {
  constexpr std::uint64_t kTick_ns = plenum::config::kTick_us * std::uint64_t{1000};
  return {.silence_ns = static_cast<std::uint64_t>(real_time.guard_ticks) * kTick_ns,
          .priority = real_time.priority == 0 ? 0 : real_time.priority + 1};
}

drivers::IioOutputConfig resting_at(drivers::IioOutputConfig output,
                                    std::span<const std::atomic<float>> now_V) {
  output.safe_now_V = now_V;
  return output;
}

}  // namespace

// The lines come first: while the others are waited for, the valves are without power. The watchdog comes last: nothing that
// is waited for feeds it.
LinuxHardware::LinuxHardware(const config::BoardFile& board, steady_clock::time_point latest)
    : rest_stated_(board.safe_V_stated),
      resting_(board.analog_out.safe_V, RestingVolts::runtime_folder()),
      lines_(opened<drivers::GpioLines>(board.gpio, latest)),
      output_(opened<drivers::IioOutput>(resting_at(board.analog_out, resting_.now()), latest)),
      stop_(lines_),
      valves_(stop_, output_),
      guard_(guard_config(board.real_time), valves_),
      bus_([interface = board.interface] {
        return std::make_unique<drivers::SocketCan>(interface, std::span(&drivers::kBaseDataFrames, 1));
      }) {
  open(input_, board.analog_in, latest);
  if (input_) {
    for (std::string& one : short_ranges(board, board.analog_in, *input_))
      troubles_.push_back(std::move(one));
  }
  open(store_, board.store, latest);
  if (!bus_.trouble().empty()) troubles_.push_back(bus_.trouble());
  events_.emplace(lines_.descriptor(), input_ ? input_->descriptors() : std::span<const int>{});
  events_->watch_frames(bus_.descriptor());
  open(watchdog_, board.watchdog, latest);
  if (watchdog_ && !watchdog_->trouble().empty()) troubles_.push_back(watchdog_->trouble());
}

template <class Driver, class Config>
Driver LinuxHardware::opened(const Config& config, steady_clock::time_point latest) {
  while (steady_clock::now() < latest) {
    try {
      return Driver(config);
    } catch (const std::runtime_error&) {
      std::this_thread::sleep_for(kPause);
    }
  }
  return Driver(config, &troubles_);
}

template <class Driver, class Config>
void LinuxHardware::open(std::optional<Driver>& driver, const Config& config,
                         steady_clock::time_point latest) {
  for (;;) {
    try {
      driver.emplace(config);
      return;
    } catch (const std::runtime_error& error) {
      if (steady_clock::now() >= latest) {
        troubles_.emplace_back(error.what());
        return;
      }
    }
    std::this_thread::sleep_for(kPause);
  }
}

Drivers LinuxHardware::drivers() noexcept {
  const auto either = []<class Port>(auto& driver, Port& absent) -> Port& {
    if (driver) return *driver;
    return absent;
  };
  ports::AnalogInput& no_input = no_input_;
  ports::ParameterStore& no_store = no_store_;
  return {.analog_in = either(input_, no_input),
          .analog_out = output_,
          .digital = stop_,
          .can = bus_,
          .store = either(store_, no_store)};
}

void LinuxHardware::begin() noexcept {
  if (input_) input_->forget();
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
  if (bus_.tend()) opener_.wake();
  events_->watch_frames(bus_.descriptor());
  manager_.ticked(now_ns, tick_count);
  if (watchdog_) watchdog_->ticked(now_ns, tick_count);
  guard_.beat();
}

void LinuxHardware::rest_at(std::size_t chamber, float command_V) noexcept {
  if (!rest_stated_[chamber]) resting_.set(chamber, command_V);
}

void LinuxHardware::make_safe() noexcept {
  valves_.make_safe();
  guard_.rest();
}

}  // namespace plenum::board
