#include "board/drivers/can_bit_rate.hpp"

#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <string_view>

namespace plenum::board::drivers {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::uint32_t kRestart_ms =
    100;  ///< that a controller stays off the bus after a bus-off; the kernel's 0 is for good

[[noreturn]] void refuse(const std::string& interface, const std::string& found,
                         const std::string& expected = "the kernel's answer") {
  throw std::runtime_error("can:" + interface + ": bit rate: " + found + ", expected " + expected);
}

/// Messages and attributes begin at multiples of four.
std::size_t aligned(std::size_t size) noexcept {
  return (size + 3U) & ~std::size_t{3U};
}

template <class T>
std::optional<T> at_start(Bytes bytes) noexcept {
  T value;
  if (bytes.size() < sizeof value) return std::nullopt;
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

/// What the first attribute of this type holds; empty: there is none.
Bytes attribute(Bytes list, unsigned short type) noexcept {
  while (const auto head = at_start<rtattr>(list)) {
    if (head->rta_len < sizeof *head || head->rta_len > list.size()) break;
    if ((head->rta_type & NLA_TYPE_MASK) == type)
      return list.subspan(sizeof *head, head->rta_len - sizeof *head);
    list = list.subspan(std::min(aligned(head->rta_len), list.size()));
  }
  return {};
}

bool is_can(Bytes kind) noexcept {
  constexpr std::string_view kCan("can\0", 4);  // it ends in a zero byte
  return kind.size() == kCan.size() && std::memcmp(kind.data(), kCan.data(), kCan.size()) == 0;
}

template <class T>
void append(std::vector<std::byte>& message, const T& value) {
  const auto bytes = std::as_bytes(std::span(&value, 1));
  message.insert(message.end(), bytes.begin(), bytes.end());
  message.resize(aligned(message.size()));
}

/// Appends an attribute that holds what `content` appends.
template <class Content>
void append_attribute(std::vector<std::byte>& message, unsigned short type, const Content& content) {
  const std::size_t begin = message.size();
  append(message, rtattr{.rta_len = 0, .rta_type = type});
  content();
  const auto length = static_cast<unsigned short>(message.size() - begin);
  std::memcpy(message.data() + begin + offsetof(rtattr, rta_len), &length, sizeof length);
}

/// `flags` of those in `change`.
std::vector<std::byte> link_request(unsigned short type, int index, unsigned flags = 0, unsigned change = 0) {
  const ifinfomsg link{.ifi_family = AF_UNSPEC,
                       .__ifi_pad = 0,
                       .ifi_type = 0,
                       .ifi_index = index,
                       .ifi_flags = flags,
                       .ifi_change = change};
  std::vector<std::byte> message;
  append(message, nlmsghdr{.nlmsg_len = NLMSG_LENGTH(sizeof link),
                           .nlmsg_type = type,
                           .nlmsg_flags = NLM_F_REQUEST,
                           .nlmsg_seq = 0,
                           .nlmsg_pid = 0});
  append(message, link);
  return message;
}

/// Its length as it is, and that the kernel is to answer also when all went well.
void finish(std::vector<std::byte>& message) {
  auto head = at_start<nlmsghdr>(message).value();
  head.nlmsg_len = static_cast<std::uint32_t>(message.size());
  head.nlmsg_flags |= NLM_F_ACK;
  std::memcpy(message.data(), &head, sizeof head);
}

std::vector<std::byte> state_request(int index, bool up) {
  constexpr unsigned kUp = IFF_UP;
  auto message = link_request(RTM_NEWLINK, index, up ? kUp : 0U, kUp);
  finish(message);
  return message;
}

/// Sets one attribute of a CAN controller.
template <class T>
std::vector<std::byte> controller_request(int index, unsigned short type, const T& value) {
  auto message = link_request(RTM_NEWLINK, index);
  append_attribute(message, IFLA_LINKINFO, [&] {
    append_attribute(message, IFLA_INFO_KIND, [&] { append(message, std::array{'c', 'a', 'n', '\0'}); });
    append_attribute(message, IFLA_INFO_DATA,
                     [&] { append_attribute(message, type, [&] { append(message, value); }); });
  });
  finish(message);
  return message;
}

/// 0: there is none.
int index_of(const std::string& name) {
  return static_cast<int>(::if_nametoindex(name.c_str()));
}

class Kernel {
 public:
  explicit Kernel(const std::string& interface)
      : interface_(interface), socket_(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE)) {
    const timeval patience{.tv_sec = 1, .tv_usec = 0};
    if (socket_ >= 0 && ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) == 0)
      return;
    const std::string why = std::strerror(errno);
    if (socket_ >= 0) ::close(socket_);
    refuse(interface_, why);
  }
  ~Kernel() { ::close(socket_); }
  Kernel(const Kernel&) = delete;
  Kernel& operator=(const Kernel&) = delete;

  /// The RTM_NEWLINK that describes the interface.
  std::vector<std::byte> describe(int index) const {
    auto answer = ask(link_request(RTM_GETLINK, index));
    const auto head = at_start<nlmsghdr>(answer);
    if (!head || head->nlmsg_type != RTM_NEWLINK) refuse(interface_, "no answer to RTM_GETLINK");
    return answer;
  }

  /// Has `request` carried out. Returns 0, or the errno for which the kernel did not.
  int order(const std::vector<std::byte>& request) const {
    const auto answer = ask(request);
    const auto head = at_start<nlmsghdr>(answer);
    const auto error =
        at_start<nlmsgerr>(Bytes(answer).subspan(std::min<std::size_t>(NLMSG_HDRLEN, answer.size())));
    if (!head || head->nlmsg_type != NLMSG_ERROR || !error) refuse(interface_, "no answer to RTM_NEWLINK");
    return -error->error;
  }

 private:
  std::vector<std::byte> ask(const std::vector<std::byte>& request) const {
    std::vector<std::byte> answer(32768);  // of which the kernel needs an eighth or so
    if (::send(socket_, request.data(), request.size(), 0) < 0) refuse(interface_, std::strerror(errno));
    const ssize_t length = ::recv(socket_, answer.data(), answer.size(), 0);
    if (length < 0) refuse(interface_, std::strerror(errno));
    answer.resize(static_cast<std::size_t>(length));
    return answer;
  }

  std::string interface_;
  int socket_;
};

}  // namespace

CanInterface interface_in(Bytes answer) {
  CanInterface interface;
  const auto head = at_start<nlmsghdr>(answer);
  constexpr std::size_t kBefore = NLMSG_HDRLEN + NLMSG_ALIGN(sizeof(ifinfomsg));
  if (!head || head->nlmsg_type != RTM_NEWLINK || head->nlmsg_len > answer.size() ||
      head->nlmsg_len < kBefore)
    return interface;
  interface.up = (at_start<ifinfomsg>(answer.subspan(NLMSG_HDRLEN)).value().ifi_flags & IFF_UP) != 0;
  const Bytes link = attribute(answer.subspan(kBefore, head->nlmsg_len - kBefore), IFLA_LINKINFO);
  interface.controller = is_can(attribute(link, IFLA_INFO_KIND));
  const Bytes data = interface.controller ? attribute(link, IFLA_INFO_DATA) : Bytes{};
  if (const auto timing = at_start<can_bittiming>(attribute(data, IFLA_CAN_BITTIMING)))
    interface.bit_rate = timing->bitrate;
  const auto limits = at_start<can_bittiming_const>(attribute(data, IFLA_CAN_BITTIMING_CONST));
  const auto clock = at_start<can_clock>(attribute(data, IFLA_CAN_CLOCK));
  if (limits && clock)
    interface.limits = {.clock_Hz = clock->freq,
                        .first = {limits->tseg1_min, limits->tseg1_max},
                        .second = {limits->tseg2_min, limits->tseg2_max},
                        .prescaler = {limits->brp_min, limits->brp_max, limits->brp_inc}};
  interface.most = at_start<std::uint32_t>(attribute(data, IFLA_CAN_BITRATE_MAX)).value_or(0);
  for (Bytes rates = attribute(data, IFLA_CAN_BITRATE_CONST); rates.size() >= sizeof(std::uint32_t);
       rates = rates.subspan(sizeof(std::uint32_t)))
    interface.only.push_back(at_start<std::uint32_t>(rates).value());
  return interface;
}

bool CanInterface::can_run_at(std::uint32_t rate) const noexcept {
  if (rate == 0 || (most != 0 && rate > most)) return false;
  if (!only.empty()) return std::find(only.begin(), only.end(), rate) != only.end();
  if (!limits) return true;
  const std::uint64_t clock_Hz = limits->clock_Hz;
  const std::uint32_t least = 1 + limits->first.least + limits->second.least;
  const std::uint32_t most_quanta = 1 + limits->first.most + limits->second.most;
  const std::uint32_t step = std::max(limits->prescaler.step, 1U);
  for (std::uint64_t prescaler = std::max(limits->prescaler.least, 1U); prescaler <= limits->prescaler.most;
       prescaler += step) {
    const std::uint64_t per_quantum = prescaler * rate;
    const std::uint64_t quanta = (clock_Hz + per_quantum / 2) / per_quantum;
    if (quanta < least) break;  // and fewer with each larger one
    if (quanta <= most_quanta && is_near(quanta * per_quantum, clock_Hz)) return true;
  }
  return false;
}

std::vector<std::byte> bit_rate_request(int interface_index, std::uint32_t bit_rate) {
  can_bittiming timing{};
  timing.bitrate = bit_rate;
  return controller_request(interface_index, IFLA_CAN_BITTIMING, timing);
}

std::vector<std::byte> restart_request(int interface_index, std::uint32_t restart_ms) {
  return controller_request(interface_index, IFLA_CAN_RESTART_MS, restart_ms);
}

std::optional<CanInterface> can_interface(const std::string& name) {
  const int index = index_of(name);
  if (index == 0) return std::nullopt;
  return interface_in(Kernel(name).describe(index));
}

void set_can_bit_rate(const std::string& name, std::uint32_t bit_rate) {
  const Kernel kernel(name);
  const int index = index_of(name);
  const auto require = [&](int error, const std::string& what) {
    if (error != 0) refuse(name, what + ": " + std::strerror(error), "the kernel to do it");
  };
  const bool was_up = interface_in(kernel.describe(index)).up;
  require(kernel.order(state_request(index, false)), "taking it down");
  const int refusal = kernel.order(bit_rate_request(index, bit_rate));
  // Since Linux 6.16 refused where the driver cannot do it (EOPNOTSUPP), before that taken and without effect.
  if (refusal == 0) kernel.order(restart_request(index, kRestart_ms));
  const int silence = was_up || refusal == 0 ? kernel.order(state_request(index, true)) : 0;
  require(refusal, std::to_string(bit_rate) + " bit/s");
  require(silence, "bringing it up");
}

}  // namespace plenum::board::drivers
