#include "board/check.hpp"

#include <fmt/format.h>
#include <linux/major.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "board/bit_rate.hpp"
#include "board/bus_check.hpp"
#include "board/config/last_accepted.hpp"
#include "board/drivers/can_bit_rate.hpp"
#include "board/drivers/file_store.hpp"
#include "board/drivers/gpio_lines.hpp"
#include "board/drivers/iio_input.hpp"
#include "board/drivers/iio_output.hpp"
#include "board/drivers/socketcan.hpp"
#include "board/range_check.hpp"
#include "board/resting_volts.hpp"
#include "board/rt/events.hpp"
#include "board/rt/real_time.hpp"
#include "board/say.hpp"
#include "firmware/board.hpp"

namespace plenum::board {
namespace {

using plenum::config::kChambers;

const std::filesystem::path kStateFolder = "/var/lib/plenum";  ///< StateDirectory= of service/plenumd.service

/// The lines of the page.
class Page {
 public:
  void line(bool good, const char* what, const std::string& found) {
    fmt::print("{:<4}  {:<13}  {}\n", good ? "ok" : "FAIL", what, found);
    all_good_ = all_good_ && good;
  }

  /// One thing, which throws when it fails and else says what it found.
  template <class Try>
  void attempt(const char* what, Try&& found) {
    try {
      line(true, what, found());
    } catch (const std::runtime_error& error) {
      line(false, what, error.what());
    }
  }

  /// What could not be opened, a line each. False: there is some.
  bool none_missing(const char* what, const std::vector<std::string>& missing) {
    for (const std::string& one : missing) line(false, what, one);
    return missing.empty();
  }

  bool all_good() const { return all_good_; }

 private:
  bool all_good_ = true;
};

/// One a channel that is fitted, without the others.
std::vector<drivers::IioInputConfig> each_channel(const drivers::IioInputConfig& whole) {
  std::vector<drivers::IioInputConfig> each;
  for (std::size_t c = 0; c < whole.channels.size(); ++c) {
    if (!whole.channels[c].fitted()) continue;
    drivers::IioInputConfig one = whole;
    one.channels.assign(whole.channels.size(), {});
    one.channels[c] = whole.channels[c];
    each.push_back(one);
  }
  return each;
}

/// Waits for the scans of a few ticks; whatever has come by then is read.
void wait_for_scans(drivers::IioInput& input) {
  constexpr int kPatience_ms = 500;
  constexpr std::uint64_t kMillisecond_ns = 1'000'000;
  const std::uint64_t latest_ns = rt::monotonic_ns() + kPatience_ms * kMillisecond_ns;
  std::vector<pollfd> polled;
  for (const int descriptor : input.descriptors())
    polled.push_back({.fd = descriptor, .events = POLLIN, .revents = 0});
  const unsigned enough = std::max(1U, input.scans_per_tick());
  while (input.gathered() < enough && !input.gone()) {
    const std::uint64_t now_ns = rt::monotonic_ns();
    if (now_ns >= latest_ns) return;
    ::poll(polled.data(), polled.size(), static_cast<int>((latest_ns - now_ns) / kMillisecond_ns) + 1);
    input.gather();
  }
}

struct Sensor {
  std::string name;
  drivers::IioChannel channel;
  float quantity;  ///< of the reading
  const char* unit;
  float low_V;
  float high_V;
  bool is_pressure = false;
};

void check_reading(const Sensor& sensor, const ports::AnalogReading& reading, Page& page) {
  if (!sensor.channel.fitted()) return;
  const std::string where =
      fmt::format("{} ({} {})", sensor.name, sensor.channel.device, sensor.channel.channel);
  if (!reading.fresh) {
    page.line(false, "analog input", fmt::format("{}: no scan came, expected a tick's worth", where));
    return;
  }
  if (sensor.is_pressure && reading.at_end) {
    page.line(
        false, "analog input",
        fmt::format("{}: stands at the end of its range, {:.3f} V, expected less", where, reading.mean_V));
    return;
  }
  const bool valid = reading.mean_V >= sensor.low_V && reading.mean_V <= sensor.high_V;
  page.line(valid, "analog input",
            fmt::format("{}: {:.1f} {} ({:.3f} V{})", where, sensor.quantity, sensor.unit, reading.mean_V,
                        valid ? "" : fmt::format(", expected {} to {} V", sensor.low_V, sensor.high_V)));
}

/// The readings of the channels of `analog_in`. Throws when it cannot be opened.
void check_readings(const config::BoardFile& board, const drivers::IioInputConfig& analog_in, Page& page) {
  std::array<ports::AnalogReading, kAnalogInputs> readings{};
  drivers::IioInput input(analog_in);
  for (const std::string& one : short_ranges(board, analog_in, input)) page.line(false, "analog input", one);
  wait_for_scans(input);
  input.read(readings);
  const auto& channels = analog_in.channels;
  for (std::size_t c = 0; c < kChambers; ++c) {
    const plenum::config::ChamberSettings& settings = board.settings.chamber[c];
    if (!settings.in_use) continue;
    const ports::AnalogReading& pressure = readings[c];
    const ports::AnalogReading& position = readings[kChambers + c];
    check_reading({fmt::format("pressure {}", c + 1), channels[c], pressure_kPa(settings, pressure.mean_V),
                   "kPa", settings.pressure_valid_low_V, settings.pressure_valid_high_V, true},
                  pressure, page);
    check_reading(
        {fmt::format("volume {}", c + 1), channels[kChambers + c], volume_mL(settings, position.mean_V), "mL",
         settings.position_valid_low_V, settings.position_valid_high_V},
        position, page);
  }
  constexpr float kAnyVoltage_V = 1000.0F;
  const ports::AnalogReading& supply = readings[2 * kChambers];
  check_reading({"supply", channels[2 * kChambers], supply_kPa(board.settings.board, supply.mean_V), "kPa",
                 -kAnyVoltage_V, kAnyVoltage_V},
                supply, page);
}

/// The board opens its inputs as a whole. Where that fails each is opened alone, and each failure named once; where none
/// fails alone, that of the whole is, as of a trigger that serves two devices at most.
void check_input(const config::BoardFile& board, Page& page) {
  std::string of_whole;
  try {
    check_readings(board, board.analog_in, page);
    return;
  } catch (const std::runtime_error& error) {
    of_whole = error.what();
  }
  std::vector<std::string> missing;
  for (const drivers::IioInputConfig& one : each_channel(board.analog_in)) {
    try {
      check_readings(board, one, page);
    } catch (const std::runtime_error& error) {
      if (std::find(missing.begin(), missing.end(), error.what()) == missing.end())
        missing.emplace_back(error.what());
    }
  }
  if (missing.empty()) missing.push_back(of_whole);
  page.none_missing("analog input", missing);
}

/// Throws.
void require_free(const drivers::GpioLine& line, const drivers::GpioInfo& info) {
  if (!info.holder.empty())
    drivers::refuse_gpio(line, "held by " + info.holder, "a line that nobody holds (stop plenumd first)");
}

/// Read as it stands, and only where it is an input: nothing of it changes, nor when it is let go.
bool circuit_open(const drivers::GpioLine& stop, const drivers::GpioInfo& info) {
  if (info.output)
    drivers::refuse_gpio(stop, "drives its pin", "an input, as a line is that nobody has set up");
  drivers::GpioRequest line(stop, drivers::GpioUse::as_is);
  const std::optional<bool> active = line.value();
  if (!active) drivers::refuse_gpio(stop, "cannot be read", "its value");
  return *active;
}

/// Takes no output: whoever takes one sets its level, and some chips make an input of one that is let go.
void check_lines(const drivers::GpioConfig& gpio, Page& page) {
  std::vector<std::string> wrong;
  std::set<std::string> places;
  // looks at a line and takes it not
  const auto look = [&](const drivers::GpioLine& line, auto&& found) -> std::string {
    if (!line.fitted()) return "not fitted";
    try {
      const drivers::GpioInfo info = drivers::gpio_info(line);
      if (!places.insert(info.place).second)
        drivers::refuse_gpio(line, info.place + " is another line of [gpio], too", "a line of its own");
      require_free(line, info);
      return found(line, info);
    } catch (const std::runtime_error& error) {
      wrong.emplace_back(error.what());
      return {};
    }
  };
  const auto output = [](const drivers::GpioLine&, const drivers::GpioInfo&) { return "fitted"; };
  const auto stop = [](const drivers::GpioLine& line, const drivers::GpioInfo& info) {
    return circuit_open(line, info) ? "open" : "closed";
  };
  // one after the other: arguments have no order
  const std::string power = look(gpio.valve_power, output);
  const std::string vent = look(gpio.vent, output);
  const std::string lamp = look(gpio.fault_lamp, output);
  const std::string circuit = look(gpio.emergency_stop, stop);
  if (!page.none_missing("digital lines", wrong)) return;
  page.line(true, "digital lines",
            fmt::format("valve power {}, vent {}, lamp {}, emergency stop {}", power, vent, lamp, circuit));
}

/// What a regulated chamber may ask of its output, and does not get: a line each.
std::vector<std::string> beyond_range(const config::BoardFile& board, const drivers::IioOutput& output) {
  std::vector<std::string> beyond;
  for (std::size_t c = 0; c < kChambers; ++c) {
    const plenum::config::ChamberSettings& settings = board.settings.chamber[c];
    if (!settings.in_use) continue;
    const std::pair<const char*, float> asked[] = {{"command_low_V", settings.command_low_V},
                                                   {"command_high_V", settings.command_high_V},
                                                   {"vent_V", settings.vent_V}};
    for (const auto& [name, volts] : asked) {
      if (!output.reaches(c, volts))
        beyond.push_back(fmt::format(
            "iio:{}: {} = {} of chamber {} lies beyond its range, expected a value that it can hold",
            board.analog_out.channels[c].where(), name, volts, c + 1));
    }
  }
  return beyond;
}

void check_output(const config::BoardFile& board, Page& page) {
  const drivers::IioOutputConfig& analog_out = board.analog_out;
  std::vector<std::string> missing;
  const drivers::IioOutput output(analog_out, &missing);
  for (std::string& one : beyond_range(board, output)) missing.push_back(std::move(one));
  const auto fitted = std::count_if(analog_out.channels.begin(), analog_out.channels.end(),
                                    [](const auto& channel) { return channel.fitted(); });
  if (page.none_missing("analog output", missing))
    page.line(true, "analog output", fmt::format("{} opened, none written", fitted));
}

/// What the kernel counts a device among, as "watchdog"; empty: it is none, or the kernel does not say.
std::string subsystem_of(const struct stat& device) {
  if (!S_ISCHR(device.st_mode)) return {};
  std::error_code unknown;
  const std::filesystem::path link =
      fmt::format("/sys/dev/char/{}:{}/subsystem", major(device.st_rdev), minor(device.st_rdev));
  return std::filesystem::read_symlink(link, unknown).filename().string();
}

/// Looks without touching: a watchdog that is opened is armed.
std::string check_watchdog(const std::filesystem::path& path) {
  const auto refuse = [&](const std::string& found) {
    throw std::runtime_error(
        fmt::format("{}: {}, expected a watchdog that can be written", path.string(), found));
  };
  struct stat device {};
  if (::stat(path.c_str(), &device) != 0 || ::access(path.c_str(), W_OK) != 0) refuse(std::strerror(errno));
  const std::string subsystem = subsystem_of(device);
  // of /dev/watchdog, the first one's older name: admin-guide/devices.txt of the kernel
  constexpr unsigned kWatchdogMinor = 130;
  if (subsystem != "watchdog" && device.st_rdev != makedev(MISC_MAJOR, kWatchdogMinor))
    refuse(subsystem.empty() ? "is no device that the kernel lists"
                             : "is one of its " + subsystem + " devices");
  return path.string();
}

/// By going there: what is checked does no more on it than this.
std::string check_processor(int cpu) {
  const std::string refusal = rt::run_on(cpu);
  if (!refusal.empty()) throw std::runtime_error(refusal);
  return fmt::format("{}", cpu);
}

bool lies_in(const std::filesystem::path& path, const std::filesystem::path& folder) {
  const std::filesystem::path whole = path.lexically_normal();
  const std::filesystem::path part = folder.lexically_normal();
  return std::mismatch(part.begin(), part.end(), whole.begin(), whole.end()).first == part.end();
}

/// The folder, and what the service needs for it: to whoever looks from outside of its sandbox any folder may be writable.
std::string check_store(const std::filesystem::path& folder) {
  drivers::FileStore::look(folder);
  const std::filesystem::path state = config::state_folder();
  const std::filesystem::path services = state.empty() ? kStateFolder : state;
  if (lies_in(folder, services)) return folder.string();
  return fmt::format(
      "{0}, outside of {1}: the service needs a line ReadWritePaths={0} (systemctl edit plenumd)",
      folder.string(), services.string());
}

}  // namespace

bool check(const config::BoardFile& board) {
  Page page;
  const auto in_use = std::count_if(board.settings.chamber.begin(), board.settings.chamber.end(),
                                    [](const auto& chamber) { return chamber.in_use; });
  page.line(true, "configuration", fmt::format("{} chambers in use", in_use));
  page.attempt("bus", [&] {
    drivers::SocketCan can(board.interface);
    const drivers::CanInterface interface =
        drivers::can_interface(board.interface).value_or(drivers::CanInterface{});
    const BitRate wanted =
        wanted_bit_rate(board, stored_lss(board.store).value_or(plenum::config::LssSettings{}), interface);
    for (const std::string& trouble :
         {trouble_of(can, board.interface), bit_rate_trouble(interface, wanted, board.interface)})
      if (!trouble.empty()) throw std::runtime_error(trouble);
    return interface.bit_rate ? fmt::format("{}, {} kbit/s", board.interface, *interface.bit_rate / 1000)
                              : fmt::format("{}, which has no bit rate", board.interface);
  });
  check_lines(board.gpio, page);
  check_input(board, page);
  check_output(board, page);
  page.attempt("store", [&] { return check_store(board.store); });
  if (!board.watchdog.empty()) page.attempt("watchdog", [&] { return check_watchdog(board.watchdog); });
  if (const auto cpu = board.real_time.cpu) page.attempt("processor", [&] { return check_processor(*cpu); });
  return page.all_good();
}

bool make_safe(const config::BoardFile& board) {
  std::vector<std::string> troubles;
  {
    const drivers::GpioLines off(board.gpio, &troubles);
    const std::size_t of_lines = troubles.size();
    drivers::IioOutputConfig outputs = board.analog_out;
    std::array<std::atomic<float>, kChambers> now_V;  // as the loop and its guard have them
    if (const auto left_V = RestingVolts::left_in(RestingVolts::runtime_folder())) {
      std::copy(left_V->begin(), left_V->end(), now_V.begin());
      outputs.safe_now_V = now_V;
    }
    drivers::IioOutput output(outputs, &troubles);
    if (!output.make_safe() && troubles.size() == of_lines)
      troubles.emplace_back("an analog output was refused, expected all to be set");
  }
  // last: who reads it may let it wait
  for (const std::string& trouble : troubles) say(fmt::format("plenumd --safe: {}\n", trouble));
  return troubles.empty();
}

}  // namespace plenum::board
