#include "board/config/board_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>

#include "firmware/board.hpp"
#include "firmware/canopen/lss.hpp"
#include "firmware/config/setting_fields.hpp"

namespace plenum::board::config {
namespace {

using drivers::kTicks_Hz;
using plenum::config::BoardSettings;
using plenum::config::ChamberSettings;
using plenum::config::kChambers;
using plenum::config::SafeOutput;

constexpr std::int64_t kAny32 = 0xFFFF'FFFF;
constexpr unsigned kHighestRate_Hz = 100'000;
constexpr double kHighestOutput_V = 10.0;
constexpr std::size_t kLongestUrl = 255;

/// Gathers what is wrong in one part after the other, so that it can be mended at one go.
class Mistakes {
 public:
  template <class Read>
  void of(Read&& read) {
    try {
      read();
    } catch (const ConfigError& error) {
      if (!all_.empty()) all_ += '\n';
      all_ += error.what();
    }
  }
  /// Throws where there is any.
  void end() const {
    if (!all_.empty()) throw ConfigError(all_);
  }

 private:
  std::string all_;
};

/// Every place that is named may be named once.
class Places {
 public:
  void take(const TomlTable& table, std::string_view key, const std::string& place) {
    if (!taken_.insert(place).second)
      table.refuse(key, fmt::format("= {} is named twice", place), "a place of its own");
  }

 private:
  std::set<std::string> taken_;
};

drivers::IioChannel read_channel(TomlTable& parent, std::string_view key, Places& places) {
  std::optional<TomlTable> table = parent.table(key);
  if (!table) return {};
  drivers::IioChannel channel;
  channel.device = table->need("device", table->text("device"), "an IIO device by name, label or id");
  channel.channel = table->need("channel", table->text("channel"), "a channel of it, as voltage0");
  table->end();
  places.take(parent, key, fmt::format("{}/{}", channel.device, channel.channel));
  return channel;
}

drivers::IioChannel need_channel(TomlTable& parent, std::string_view key, Places& places) {
  drivers::IioChannel channel = read_channel(parent, key, places);
  if (channel.device.empty()) parent.refuse(key, "is missing", "{ device = ..., channel = ... }");
  return channel;
}

drivers::GpioLine read_line(TomlTable& parent, std::string_view key, Places& places) {
  std::optional<TomlTable> table = parent.table(key);
  if (!table) return {};
  drivers::GpioLine line;
  line.chip = table->need("chip", table->text("chip"), "a chip as gpiodetect lists it");
  line.line = table->need("line", table->text("line"), "a line of it by name or offset, in quotes");
  line.active_low = table->flag("active_low").value_or(false);
  table->end();
  places.take(parent, key, fmt::format("{}/{}", line.chip, line.line));
  return line;
}

/// Each under its own name, as 2400h.. of the object dictionary has them.
template <typename Settings, typename Number, std::size_t count>
void read_fields(TomlTable& table, const plenum::config::SettingField<Settings, Number> (&fields)[count],
                 Settings& settings) {
  Mistakes mistakes;
  for (const auto& field : fields) {
    const auto low = static_cast<double>(field.low);
    const auto high = static_cast<double>(field.high);
    mistakes.of([&] {
      if constexpr (std::is_same_v<Number, float>) {
        if (const auto value = table.number(field.name, low, high))
          settings.*field.member = static_cast<float>(*value);
      } else {
        if (const auto value =
                table.whole(field.name, static_cast<std::int64_t>(low), static_cast<std::int64_t>(high)))
          settings.*field.member = static_cast<Number>(*value);
      }
    });
  }
  mistakes.end();
}

void require(const TomlTable& table, const plenum::config::SettingVerdict& verdict) {
  if (verdict) return;
  table.refuse(verdict.field, fmt::format("= {}", verdict.value),
               fmt::format("{} to {}", verdict.low, verdict.high));
}

std::uint32_t read_number32(TomlTable& table, std::string_view key) {
  return static_cast<std::uint32_t>(table.whole(key, 0, kAny32).value_or(0));
}

/// Of a rate that is stated LSS offers no other.
void read_bit_rate(TomlTable& can, BoardFile& board) {
  const auto kbit = can.whole("bit_rate_kbit", 10, 1000);
  if (!kbit) return;
  const auto row = canopen::row_of_bit_rate(1000U * static_cast<std::uint32_t>(*kbit));
  if (!row) can.refuse("bit_rate_kbit", fmt::format("= {}", *kbit), "1000, 800, 500, 250, 125, 50, 20 or 10");
  board.bit_rate_kbit = static_cast<std::uint16_t>(*kbit);
  board.settings.node.bit_rates = static_cast<std::uint16_t>(1U << *row);
}

void read_can(TomlTable& document, BoardFile& board) {
  TomlTable can = document.need("can", document.table("can"), "a table [can]");
  board.interface = can.need("interface", can.text("interface"), "a CAN interface, as can0");
  canopen::Config& node = board.settings.node;
  node.node_id =
      static_cast<std::uint8_t>(can.whole("node_id", 1, 127).value_or(canopen::kUnconfiguredNodeId));
  read_bit_rate(can, board);
  node.identity.hardware_version = "Linux board";
  node.identity.vendor_id = read_number32(can, "vendor_id");
  node.identity.product_code = read_number32(can, "product_code");
  node.identity.revision = read_number32(can, "revision");
  node.identity.serial = read_number32(can, "serial");
  board.model_url = can.text("model_url").value_or("");
  if (board.model_url.size() > kLongestUrl)
    can.refuse("model_url", fmt::format("has {} characters", board.model_url.size()),
               fmt::format("at most {}", kLongestUrl));
  can.end();
}

void read_analog_input(TomlTable& document, BoardFile& board) {
  TomlTable input = document.need("analog_input", document.table("analog_input"), "a table [analog_input]");
  const auto rate = input.need("rate_Hz", input.whole("rate_Hz", 0, kHighestRate_Hz),
                               "scans a second, or 0 for devices that run freely");
  if (rate % kTicks_Hz != 0)
    input.refuse("rate_Hz", fmt::format("= {}", rate), fmt::format("a multiple of {}", kTicks_Hz));
  board.analog_in.rate_Hz = static_cast<unsigned>(rate);
  board.analog_in.trigger = input.text("trigger").value_or("");
  constexpr int kHighestOversampling = 65536;
  if (const auto ratio = input.whole("oversampling", 1, kHighestOversampling))
    board.analog_in.oversampling = static_cast<unsigned>(*ratio);
  constexpr double kFinest_mV = 1e-6;
  constexpr double kCoarsest_mV = 1000.0;
  board.analog_in.scale_mV = input.number("scale_mV", kFinest_mV, kCoarsest_mV);
  input.end();
}

void read_board_settings(TomlTable& document, BoardFile& board, Places& inputs) {
  std::optional<TomlTable> table = document.table("board");
  if (!table) return;
  BoardSettings& settings = board.settings.board;
  board.analog_in.channels[2 * kChambers] = read_channel(*table, "supply", inputs);
  read_fields(*table, plenum::config::kBoardFloats, settings);
  read_fields(*table, plenum::config::kBoardTicks, settings);
  table->end();
  require(*table, plenum::config::validate(settings));
  // A sensor that is not there never has a fresh reading: the supply would be low for ever.
  if (settings.supply_low_kPa > 0.0F && board.analog_in.channels[2 * kChambers].device.empty())
    table->refuse("supply_low_kPa", fmt::format("= {}", settings.supply_low_kPa),
                  "0, or a channel board.supply");
}

void read_chamber_settings(TomlTable& table, ChamberSettings& settings) {
  settings.valve_serial = read_number32(table, "valve_serial");
  settings.sensor_serial = read_number32(table, "sensor_serial");
  read_fields(table, plenum::config::kChamberFloats, settings);
  read_fields(table, plenum::config::kChamberTicks, settings);
  const std::optional<std::size_t> safe = table.choice("safe_output", {"null", "vent"});
  if (safe) settings.safe_output = *safe == 0 ? SafeOutput::null : SafeOutput::vent;
  if (const auto ramp = table.choice("ramp_type", {"none", "one_rate", "two_rates"}))
    settings.ramp_type = static_cast<plenum::config::RampType>(*ramp);
  settings.deviation_watched = table.flag("deviation_watched").value_or(settings.deviation_watched);
  settings.target_watched = table.flag("target_watched").value_or(settings.target_watched);
}

void read_chamber(TomlTable& table, std::size_t c, BoardFile& board, Places& inputs, Places& outputs) {
  ChamberSettings& settings = board.settings.chamber[c];
  settings.in_use = table.flag("in_use").value_or(true);
  const auto channel = [&](std::string_view key, Places& places) {
    return settings.in_use ? need_channel(table, key, places) : read_channel(table, key, places);
  };
  board.analog_in.channels[c] = channel("pressure", inputs);
  board.analog_in.channels[kChambers + c] = channel("position", inputs);
  board.analog_out.channels[c] = channel("command", outputs);
  read_chamber_settings(table, settings);
  const auto safe_V = table.number("safe_V", 0.0, kHighestOutput_V);
  board.safe_V_stated[c] = safe_V.has_value();
  // above its null a valve fills, for as long as nobody regulates
  if (safe_V && static_cast<float>(*safe_V) > settings.null_V)
    table.refuse("safe_V", fmt::format("= {}", *safe_V), fmt::format("0 to null_V = {}", settings.null_V));
  if (safe_V)
    board.analog_out.safe_V[c] = static_cast<float>(*safe_V);
  else
    board.analog_out.safe_V[c] =
        settings.in_use && settings.safe_output == SafeOutput::vent ? settings.vent_V : settings.null_V;
  table.end();
  require(table, plenum::config::validate(settings));
}

void read_chambers(TomlTable& document, BoardFile& board, Places& inputs) {
  Places outputs;
  std::vector<TomlTable> tables = document.tables("chamber", kChambers);
  if (tables.empty())
    document.refuse("chamber", "is missing", fmt::format("1 to {} tables [[chamber]]", kChambers));
  Mistakes mistakes;
  for (std::size_t c = 0; c < kChambers; ++c) {
    if (c < tables.size()) {
      mistakes.of([&] { read_chamber(tables[c], c, board, inputs, outputs); });
    } else {
      board.settings.chamber[c].in_use = false;
      board.analog_out.safe_V[c] = board.settings.chamber[c].null_V;
    }
  }
  mistakes.end();
}

void read_gpio(TomlTable& document, BoardFile& board) {
  std::optional<TomlTable> gpio = document.table("gpio");
  if (!gpio) return;
  Places lines;
  board.gpio.valve_power = read_line(*gpio, "valve_power", lines);
  board.gpio.emergency_stop = read_line(*gpio, "emergency_stop", lines);
  board.gpio.fault_lamp = read_line(*gpio, "fault_lamp", lines);
  board.gpio.vent = read_line(*gpio, "vent", lines);
  gpio->end();
}

std::filesystem::path read_absolute_path(TomlTable& table, std::string_view key) {
  std::filesystem::path path = table.text(key).value_or("");
  if (!path.empty() && !path.is_absolute())
    table.refuse(key, fmt::format("= '{}'", path.string()), "a path that begins with /");
  return path;
}

void read_store(TomlTable& document, BoardFile& board) {
  TomlTable store = document.need("store", document.table("store"), "a table [store]");
  board.store = read_absolute_path(store, "folder");
  if (board.store.empty()) store.refuse("folder", "is missing", "a folder, as /var/lib/plenum");
  store.end();
}

void read_real_time(TomlTable& document, BoardFile& board) {
  // of devices that run freely nobody knows how many scans make a tick
  const bool runs_freely = board.analog_in.rate_Hz == 0;
  if (runs_freely) board.real_time.pacing = Pacing::timer;
  std::optional<TomlTable> table = document.table("real_time");
  if (!table) return;
  constexpr int kCpus = 1024;  // as many as a cpu_set_t holds
  RealTime& real_time = board.real_time;
  if (const auto pacing = table->choice("pacing", {"adc", "timer"}))
    real_time.pacing = Pacing{static_cast<std::uint8_t>(*pacing)};
  if (runs_freely && real_time.pacing == Pacing::adc)
    table->refuse("pacing", "= 'adc'", "timer, as analog_input.rate_Hz is 0");
  constexpr int kHighest = 98;  // one is left for the guard
  if (const auto priority = table->whole("priority", 0, kHighest))
    real_time.priority = static_cast<int>(*priority);
  if (const auto cpu = table->whole("cpu", 0, kCpus - 1)) real_time.cpu = static_cast<int>(*cpu);
  if (const auto overrun = table->choice("overrun", {"skip", "count", "fault"}))
    real_time.overrun = Overrun{static_cast<std::uint8_t>(*overrun)};
  if (const auto ticks = table->whole("guard_ticks", 5, 1000))
    real_time.guard_ticks = static_cast<int>(*ticks);
  board.watchdog = read_absolute_path(*table, "watchdog");
  table->end();
}

}  // namespace

BoardFile parse_board(std::string_view text, const std::string& file) {
  const toml::table parsed = parse_toml(text, file);
  TomlTable document(parsed, file);
  BoardFile board;
  board.text = text;
  board.analog_in.channels.resize(kAnalogInputs);
  board.analog_out.channels.resize(kChambers);
  board.analog_out.safe_V.resize(kChambers);
  Places inputs;
  Mistakes mistakes;
  mistakes.of([&] { read_can(document, board); });
  mistakes.of([&] { read_analog_input(document, board); });
  mistakes.of([&] { read_board_settings(document, board, inputs); });
  mistakes.of([&] { read_chambers(document, board, inputs); });
  mistakes.of([&] { read_gpio(document, board); });
  mistakes.of([&] { read_store(document, board); });
  mistakes.of([&] { read_real_time(document, board); });
  mistakes.of([&] { document.end(); });
  mistakes.end();
  return board;
}

BoardFile read_board(const std::filesystem::path& path) {
  std::error_code unknown;
  if (const auto type = std::filesystem::status(path, unknown).type();
      type == std::filesystem::file_type::fifo || type == std::filesystem::file_type::character)
    throw ConfigError(fmt::format("{}: is a pipe or a device, expected a board.toml", path.string()));
  std::ifstream file(path, std::ios::binary);
  file.peek();
  if (file.rdstate() == std::ios::eofbit)
    throw ConfigError(fmt::format("{}: is empty, expected a board.toml", path.string()));
  std::ostringstream text;
  text << file.rdbuf();
  // a folder can be opened, and not read
  if (!file || !text)
    throw ConfigError(fmt::format("{}: {}, expected a board.toml", path.string(), std::strerror(errno)));
  return parse_board(text.str(), path.string());
}

}  // namespace plenum::board::config
