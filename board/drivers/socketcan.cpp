#include "board/drivers/socketcan.hpp"

#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <vector>

namespace plenum::board::drivers {
namespace {

using std::chrono::steady_clock;

[[noreturn]] void refuse(const std::string& interface, const std::string& found,
                         const std::string& expected) {
  throw std::runtime_error("can:" + interface + ": " + found + ", expected " + expected);
}

template <class T>
bool set(int socket, int level, int option, const T& value) {
  return ::setsockopt(socket, level, option, &value, sizeof value) == 0;
}

/// The kernel takes a controller's carrier away at bus-off, and tells a socket that is opened later nothing of it.
bool has_no_carrier(const std::string& interface) {
  std::ifstream carrier("/sys/class/net/" + interface + "/carrier");
  return carrier.get() == '0';
}

}  // namespace

void ControllerState::hear(CanState told, Time now) noexcept {
  told_ = told;
  if (told == CanState::bus_off) {
    off_ = true;
    ask_from_ = Time::max();
  } else if (off_) {
    ask_from_ = std::min(ask_from_, now + kSettling);
  }
}

void ControllerState::found_off(Time now) noexcept {
  off_ = true;
  ask_from_ = now + kStale;
}

SocketCan::SocketCan(const std::string& interface, std::span<const CanFilter> filters)
    : interface_(interface) {
  socket_ = ::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (socket_ < 0) {
    const bool none = errno == EAFNOSUPPORT || errno == EPROTONOSUPPORT;
    refuse(interface, none ? "no AF_CAN in this kernel" : std::strerror(errno),
           "one with the modules can and can_raw (modprobe can_raw)");
  }
  const auto give_up = [&](const std::string& found, const std::string& expected) {
    ::close(socket_);
    refuse(interface, found, expected);
  };
  if (interface.empty() || interface.size() >= IFNAMSIZ)
    give_up("no name of an interface", "1 to " + std::to_string(IFNAMSIZ - 1) + " characters");
  const unsigned index = ::if_nametoindex(interface.c_str());
  if (index == 0) give_up("no such interface", "one that `ip -brief link show type can` lists");

  std::vector<can_filter> kernel;
  for (const CanFilter& one : filters) kernel.push_back(kernel_filter(one));
  const auto filters_size = static_cast<socklen_t>(kernel.size() * sizeof(can_filter));
  const can_err_mask_t errors = CAN_ERR_CRTL | CAN_ERR_BUSOFF | CAN_ERR_RESTARTED;
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(index);
  const bool filtered =
      kernel.empty() || ::setsockopt(socket_, SOL_CAN_RAW, CAN_RAW_FILTER, kernel.data(), filters_size) == 0;
  if (!filtered || !set(socket_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, errors) ||
      !set(socket_, SOL_SOCKET, SO_TIMESTAMPNS, 1) || !set(socket_, SOL_SOCKET, SO_RXQ_OVFL, 1) ||
      ::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    give_up(std::strerror(errno), "a CAN interface");
  }
  if (has_no_carrier(interface)) controller_.found_off(steady_clock::now());
}

SocketCan::~SocketCan() {
  ::close(socket_);
}

bool SocketCan::send(const CanFrame& frame) noexcept {
  if (frame.length > CAN_MAX_DLEN || frame.id > (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK)) return false;
  end_bus_off();
  if (state() == CanState::bus_off) return false;
  const can_frame kernel = to_kernel(frame);
  ssize_t count = 0;
  do {
    count = ::write(socket_, &kernel, sizeof kernel);
  } while (count < 0 && errno == EINTR);
  if (count < 0 && (errno == ENETDOWN || errno == ENODEV || errno == ENXIO)) go_down();
  return count == static_cast<ssize_t>(sizeof kernel);
}

/// The kernel tells of it first, and then gives out what had come before: orders on a bus that is no more, and no sign of life.
void SocketCan::go_down() noexcept {
  down_ = true;
  // When it is up again it begins anew, and no error frame tells of that.
  controller_.hear(CanState::error_active, steady_clock::now());
  constexpr int kMost = 4096;  // more than the socket's buffer holds
  can_frame old{};
  for (int i = 0; i < kMost; ++i)
    if (::recv(socket_, &old, sizeof old, MSG_DONTWAIT) < 0 && errno != EINTR) return;
}

/// As the kernel has it; false, too, when there is no such interface any more.
bool SocketCan::runs() const noexcept {
  ifreq request{};
  interface_.copy(request.ifr_name, IFNAMSIZ - 1);
  return ::ioctl(socket_, SIOCGIFFLAGS, &request) == 0 && (request.ifr_flags & IFF_RUNNING) != 0;
}

void SocketCan::end_bus_off() noexcept {
  if (controller_.may_be_on_again(steady_clock::now()) && runs()) controller_.on_again();
}

bool SocketCan::receive(CanFrame& frame) noexcept {
  end_bus_off();
  constexpr int kErrorFrames = 64;  // taken on the way to a frame
  for (int taken = 0; taken < kErrorFrames; ++taken) {
    can_frame kernel{};
    iovec part{&kernel, sizeof kernel};
    alignas(cmsghdr) std::array<char, 256> control{};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t count = ::recvmsg(socket_, &message, 0);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && (errno == ENETDOWN || errno == ENODEV)) {
      go_down();
      return false;
    }
    if (count != static_cast<ssize_t>(sizeof kernel)) return false;
    for (cmsghdr* one = CMSG_FIRSTHDR(&message); one != nullptr; one = CMSG_NXTHDR(&message, one)) {
      if (one->cmsg_level != SOL_SOCKET) continue;
      if (one->cmsg_type == SO_RXQ_OVFL) {
        std::memcpy(&lost_, CMSG_DATA(one), sizeof lost_);
      } else if (one->cmsg_type == SO_TIMESTAMPNS) {
        timespec time{};
        std::memcpy(&time, CMSG_DATA(one), sizeof time);
        received_ns_ = static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000U +
                       static_cast<std::uint64_t>(time.tv_nsec);
      }
    }
    down_ = false;
    if (const std::optional<CanState> state = state_in(kernel)) controller_.hear(*state, steady_clock::now());
    if (const std::optional<CanFrame> data = from_kernel(kernel)) {
      // Off the bus nothing comes in.
      if (state() == CanState::bus_off) controller_.hear(CanState::error_active, steady_clock::now());
      frame = *data;
      return true;
    }
  }
  return false;
}

can_filter kernel_filter(const CanFilter& filter) noexcept {
  return {filter.id | (filter.extended ? CAN_EFF_FLAG : 0U), filter.mask | CAN_EFF_FLAG | CAN_RTR_FLAG};
}

can_frame to_kernel(const CanFrame& frame) noexcept {
  can_frame kernel{};
  kernel.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0U) | (frame.remote ? CAN_RTR_FLAG : 0U);
  kernel.can_dlc = frame.length;
  if (!frame.remote) std::copy_n(frame.data.begin(), frame.length, kernel.data);
  return kernel;
}

std::optional<CanFrame> from_kernel(const can_frame& kernel) noexcept {
  if ((kernel.can_id & CAN_ERR_FLAG) != 0) return std::nullopt;
  CanFrame frame;
  frame.extended = (kernel.can_id & CAN_EFF_FLAG) != 0;
  frame.remote = (kernel.can_id & CAN_RTR_FLAG) != 0;
  frame.id = kernel.can_id & (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.length = std::min<std::uint8_t>(kernel.can_dlc, CAN_MAX_DLEN);
  if (!frame.remote) std::copy_n(kernel.data, frame.length, frame.data.begin());
  return frame;
}

std::optional<CanState> state_in(const can_frame& error_frame) noexcept {
  const std::uint32_t id = error_frame.can_id;
  if ((id & CAN_ERR_FLAG) == 0) return std::nullopt;
  if ((id & CAN_ERR_BUSOFF) != 0) return CanState::bus_off;
  if ((id & CAN_ERR_RESTARTED) != 0) return CanState::error_active;
  if ((id & CAN_ERR_CRTL) == 0) return std::nullopt;
  const unsigned controller = error_frame.data[1];
  if ((controller & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) return CanState::error_passive;
  // A warning is still error-active.
  constexpr unsigned kActive = CAN_ERR_CRTL_ACTIVE | CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING;
  if ((controller & kActive) != 0) return CanState::error_active;
  return std::nullopt;
}

}  // namespace plenum::board::drivers
