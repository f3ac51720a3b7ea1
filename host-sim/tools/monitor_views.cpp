#include "host-sim/tools/monitor_views.hpp"

#include <fmt/format.h>
#include <netdb.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

#include "host-sim/tools/board_json.hpp"

namespace plenum::host::tools {
namespace {

Json scaled(const std::optional<double>& value, double scale) {
  return value ? number(*value * scale) : Json(nullptr);
}

std::string shown(const std::optional<double>& value, double scale, int decimals) {
  return value ? fmt::format("{:.{}f}", *value * scale, decimals) : "-";
}

std::string state_of(const client::BoardView& view) {
  if (!view.status_word) return "-";
  const std::string name = client::state_name(*view.status_word, view.error_code.value_or(0));
  // both have a status word of 0
  return name == "NOT_READY" && !view.error_code ? "NOT_READY or FAULT_INIT" : name;
}

std::string nmt_of(const client::BoardView& view) {
  if (view.silent_s) return fmt::format("silent for {:.1f} s", *view.silent_s);
  return view.nmt ? client::nmt_name(*view.nmt) : "no heartbeat";
}

/// Empty when there is none. The emergency of a fault that is older than the monitor has not been heard: of that the status
/// word tells, but for a board that is not ready, with or without a fault.
std::string fault_of(const client::BoardView& view) {
  if (view.error_code && *view.error_code != 0)
    return client::fault_text({*view.error_code, view.fault_chamber});
  if (view.error_code && !view.silent_s) return "";
  namespace word = canopen::word;
  if (view.status_word && (*view.status_word & word::kReady) != 0) return "";
  return view.status_word && (*view.status_word & word::kStateMask) != 0
             ? "a fault from before: see plenum faults"
             : "not known whether in fault: see plenum faults";
}

}  // namespace

Json view_json(const client::BoardView& view, std::uint8_t node_id, unsigned chambers, double timestamp_s) {
  const std::string fault = fault_of(view);
  Json board{{"nmt", view.nmt ? Json(client::nmt_name(*view.nmt)) : Json(nullptr)},
             {"state", view.status_word ? Json(state_of(view)) : Json(nullptr)},
             {"status_word", view.status_word ? Json(*view.status_word) : Json(nullptr)},
             {"error_code", view.error_code ? Json(*view.error_code) : Json(nullptr)},
             {"fault", fault.empty() ? Json(nullptr) : Json(fault)},
             {"silent_s", view.silent_s ? number(*view.silent_s) : Json(nullptr)},
             {"frames", view.frames}};
  for (unsigned c = 0; c < chambers; ++c) {
    const client::ChamberView& chamber = view.chamber[c];
    board[fmt::format("chamber{}", c + 1)] = {{"setpoint_kPa", scaled(chamber.setpoint_Pa, 1e-3)},
                                              {"actual_kPa", scaled(chamber.actual_Pa, 1e-3)},
                                              {"command_V", scaled(chamber.command_V, 1.0)},
                                              {"volume_mL", scaled(chamber.volume_m3, 1e6)}};
  }
  return {{"timestamp", timestamp_s}, {fmt::format("node{}", node_id), board}};
}

// ---- terminal ----

namespace {

/// A line that is longer is broken by the terminal, and then drawn over in the wrong place. The lines are ASCII: a byte is a column.
std::size_t terminal_width() {
  constexpr std::size_t kUnknown = 80;
  winsize size{};
  return ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUnknown;
}

}  // namespace

TerminalView::TerminalView(std::string remedy)
    : remedy_(std::move(remedy)), terminal_(::isatty(STDOUT_FILENO) != 0) {}

std::string TerminalView::text(const client::BoardView& view, std::uint8_t node_id, unsigned chambers,
                               double time_s) {
  const std::string fault = fault_of(view);
  const std::string head = fmt::format("node {}  {}  {}  {}", node_id, nmt_of(view), state_of(view),
                                       fault.empty() ? "no fault" : fault);
  const bool heard =
      std::ranges::any_of(view.chamber, [](const auto& one) { return one.actual_Pa.has_value(); });
  const bool waits = view.nmt && *view.nmt != canopen::NmtState::operational;
  const std::string why = waits ? "they wait for `plenum nmt --start`" : remedy_;
  const std::string remedy = heard || why.empty() ? "" : "; no pressures: " + why;
  if (!terminal_) {
    std::string line = fmt::format("{:9.2f} s  {}", time_s, head);
    for (unsigned c = 0; c < chambers; ++c) {
      const client::ChamberView& one = view.chamber[c];
      line += fmt::format("  | {}: {} of {} kPa {} V {} mL", c + 1, shown(one.actual_Pa, 1e-3, 1),
                          shown(one.setpoint_Pa, 1e-3, 1), shown(one.command_V, 1.0, 2),
                          shown(one.volume_m3, 1e6, 0));
    }
    return line + remedy + '\n';
  }
  std::string text = lines_ > 0 ? fmt::format("\033[{}F", lines_) : "";
  lines_ = 0;
  const auto add = [&, width = terminal_width()](const std::string& line) {
    text += "\033[K" + line.substr(0, width) + '\n';
    ++lines_;
  };
  add(head);
  add(fmt::format("{:>7}  {:>15}  {:>12}  {:>11}  {:>11}", "chamber", "set point [kPa]", "actual [kPa]",
                  "command [V]", "volume [mL]"));
  for (unsigned c = 0; c < chambers; ++c) {
    const client::ChamberView& one = view.chamber[c];
    add(fmt::format("{:>7}  {:>15}  {:>12}  {:>11}  {:>11}", c + 1, shown(one.setpoint_Pa, 1e-3, 1),
                    shown(one.actual_Pa, 1e-3, 1), shown(one.command_V, 1.0, 2),
                    shown(one.volume_m3, 1e6, 0)));
  }
  add(fmt::format("{:.1f} s, {} frames{}; Ctrl-C ends", time_s, view.frames, remedy));
  return text;
}

// ---- datagrams ----

UdpView::UdpView(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == address.size()) {
    throw std::invalid_argument(fmt::format("--udp {}: expected HOST:PORT", address));
  }
  const std::string digits = address.substr(colon + 1);
  std::uint16_t port = 0;
  const auto [end, no_number] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (no_number != std::errc() || end != digits.data() + digits.size() || port == 0) {
    throw std::invalid_argument(
        fmt::format("--udp {}: '{}' is no port, expected a number from 1 to 65535", address, digits));
  }
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(address.substr(0, colon).c_str(), digits.c_str(), &hints, &found);
  if (error != 0) throw std::runtime_error(fmt::format("--udp {}: {}", address, ::gai_strerror(error)));
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> list(found, ::freeaddrinfo);
  socket_ = ::socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_ < 0 || ::connect(socket_, found->ai_addr, found->ai_addrlen) != 0) {
    if (socket_ >= 0) ::close(socket_);
    throw std::runtime_error(fmt::format("--udp {}: cannot be reached", address));
  }
}

UdpView::~UdpView() {
  ::close(socket_);
}

void UdpView::show(const Json& view) {
  const std::string text = view.dump();
  static_cast<void>(::send(socket_, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL));
}

}  // namespace plenum::host::tools
