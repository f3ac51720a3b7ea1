// plenumd: the program of the board. Reads board.toml, opens the devices, and runs the loop until it is asked to stop.
#include <fmt/format.h>
#include <plenum_version.hpp>  // written by the build

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <exception>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>

#include "board/bit_rate.hpp"
#include "board/check.hpp"
#include "board/config/board_file.hpp"
#include "board/config/last_accepted.hpp"
#include "board/linux_hardware.hpp"
#include "board/plenumd.hpp"
#include "board/resting_volts.hpp"
#include "board/rt/only_one.hpp"
#include "board/rt/real_time.hpp"
#include "board/rt/watchdog.hpp"
#include "board/say.hpp"
#include "firmware/board.hpp"

namespace {

using namespace plenum::board;

enum ExitCode { kDone = 0, kFailed = 1, kBadInput = 2 };

/// How long devices are waited for that the kernel is still finding. With all that comes before and after, less than a
/// hardware watchdog waits that an end without a farewell has left armed: fed up to 1.7 s before, 0.5 s to the new start.
constexpr std::chrono::seconds kPatience{2};
static_assert(kPatience + std::chrono::seconds(2) < std::chrono::seconds(rt::HardwareWatchdog::kTimeout_s));

void warn(const std::string& message) {
  say(fmt::format("<4>plenumd: {}\n", message));  // sd-daemon(3): the journal takes it for the level
}

void sum_up(const plenum::canopen::ProcessImage& image) {
  say(fmt::format(
      "<6>plenumd: stopped after {} ticks, {} overruns, latency {} us at most, {} us in 999 of 1000\n",
      image.tick_count, image.overrun_count, image.latency.max_us(), image.latency.p999_us()));
}

/// A line each.
void tell(std::string_view lines) {
  while (!lines.empty()) {
    const std::size_t end = std::min(lines.find('\n'), lines.size());
    say(fmt::format("plenumd: {}\n", lines.substr(0, end)));
    lines.remove_prefix(std::min(end + 1, lines.size()));
  }
}

int refuse(ExitCode code, const char* why) {
  tell(why);
  return code;
}

/// LSS may have been told a rate or a node id before the installer stated another.
void compare_with_lss(const config::BoardFile& file, const plenum::config::LssSettings& stored) {
  if (file.bit_rate_kbit && stored.bit_rate_kbit != 0 && stored.bit_rate_kbit != *file.bit_rate_kbit)
    warn(fmt::format("LSS has stored {} kbit/s, expected the {} of can.bit_rate_kbit, which counts",
                     stored.bit_rate_kbit, *file.bit_rate_kbit));
  const unsigned stated = file.settings.node.node_id;
  if (stated != plenum::canopen::kUnconfiguredNodeId && stored.node_id != 0 && stored.node_id != stated)
    warn(fmt::format(
        "LSS has stored node id {}, which counts, expected the {} of can.node_id: LSS gives it (plenum lss)",
        stored.node_id, stated));
}

/// A disk may take long: no tick waits for it.
std::jthread keep_in_background(const std::string& text) {
  return std::jthread([&text] {
    const std::string trouble = config::keep_accepted(text, config::state_folder());
    if (!trouble.empty()) warn(trouble);
  });
}

/// The outputs of the loop that has ended: while it ran the installer's file may have become another.
bool make_outputs_safe(const std::string& path) {
  if (const auto ran = config::kept_in(RestingVolts::runtime_folder())) return make_safe(*ran);
  const config::ChosenBoard chosen = config::choose_board(path, config::state_folder());
  const bool safe = make_safe(chosen.board);
  tell(chosen.refusal);  // last: who reads it may let it wait
  return safe;
}

/// Empty, too, where the kernel does not answer: it is no reason not to regulate.
std::optional<drivers::CanInterface> interface_now(const std::string& name) {
  try {
    return drivers::can_interface(name);
  } catch (const std::runtime_error& error) {
    warn(error.what());
    return std::nullopt;
  }
}

/// Of a board whose file is refused the loop says so.
void prepare_bus(const std::string& path) {
  const std::string done = set_bit_rate(config::choose_board(path, config::state_folder()).board);
  if (!done.empty()) tell(done);
}

int run(const config::BoardFile& file) {
  rt::block_stop_signals();
  const auto latest = std::chrono::steady_clock::now() + kPatience;
  const rt::OnlyOne only_one(file.interface, latest);
  if (const std::string trouble = config::keep_accepted(file.text, RestingVolts::runtime_folder());
      !trouble.empty())
    warn(trouble);
  LinuxHardware hardware(file, latest);
  for (const std::string& trouble : hardware.troubles()) warn(trouble);
  plenum::Settings settings = file.settings;
  settings.node.identity.software_version = kVersion;
  settings.node.identity.model_url = file.model_url.c_str();
  settings.node.bit_rates = rates_for_lss(file, interface_now(file.interface));
  const auto board = std::make_unique<plenum::Board>(settings, hardware.drivers());
  board->start();
  compare_with_lss(file, board->lss());
  std::jthread keeper;
  if (!file.settings.configuration_refused) keeper = keep_in_background(file.text);
  for (const std::string& refusal : rt::enter_real_time(file.real_time.priority, file.real_time.cpu))
    warn(refusal);
  Plenumd loop(file.real_time, *board, hardware.events(), hardware);
  loop.run();
  sum_up(board->controller().image());
  if (hardware.guarded()) return kDone;
  warn("the guard of the outputs has ended, or was stopped: expected it to stand as long as the loop runs");
  return kFailed;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);  // nobody who reads what is said here may end it
  CLI::App program{"Plenum's board: regulates up to eight pressure chambers and answers on CAN."};
  program.name("plenumd");
  program.set_version_flag("--version", fmt::format("{}, computing in {}", kVersion, kScalar));
  std::string path = "/etc/plenum/board.toml";
  bool only_check = false;
  bool only_safe = false;
  bool only_bus = false;
  program.add_option("--config", path, "What the board is made of")->capture_default_str();
  auto* check_flag = program.add_flag(
      "--check", only_check,
      "Read the configuration, open and read each device; no output changes, valve power and vent included");
  auto* safe_flag =
      program
          .add_flag("--safe", only_safe,
                    "Set the outputs to their safe values and switch the valve power off, then end")
          ->excludes(check_flag);
  program
      .add_flag("--set-bit-rate", only_bus,
                "Set the CAN interface to the bit rate of the configuration, or that LSS stored, then end")
      ->excludes(check_flag)
      ->excludes(safe_flag);
  program.footer(
      "Exit codes: 0 done, or stopped by SIGTERM; 1 a device failed, or the guard; 2 bad usage, or a "
      "configuration that is refused while none accepted before stands in for it.\n"
      "The valves lose their power when the program ends.\n"
      "\nExample:\n  plenumd --config board.toml --check");
  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& asked) {
    return program.exit(asked);
  } catch (const CLI::ParseError& error) {
    return refuse(kBadInput, error.what());
  }
  try {
    if (only_check) return check(config::read_board(path)) ? kDone : kFailed;
    if (only_bus) {
      prepare_bus(path);
      return kDone;
    }
    if (only_safe) return make_outputs_safe(path) ? kDone : kFailed;
    const config::ChosenBoard chosen = config::choose_board(path, config::state_folder());
    tell(chosen.refusal);
    return run(chosen.board);
  } catch (const config::ConfigError& error) {
    return refuse(kBadInput, error.what());
  } catch (const std::exception& error) {
    return refuse(kFailed, error.what());
  }
}
