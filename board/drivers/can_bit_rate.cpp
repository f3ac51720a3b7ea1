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
#include <cstring>
#include <stdexcept>
#include <string_view>

namespace plenum::board::drivers {
namespace {

using Bytes = std::span<const std::byte>;

[[noreturn]] void refuse(const std::string& interface, const std::string& found) {
  throw std::runtime_error("can:" + interface + ": bit rate: " + found + ", expected the kernel's answer");
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

class Socket {
 public:
  Socket() : descriptor_(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE)) {}
  ~Socket() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int descriptor() const noexcept { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace

std::optional<std::uint32_t> bit_rate_in(Bytes answer) noexcept {
  const auto head = at_start<nlmsghdr>(answer);
  constexpr std::size_t kBefore = NLMSG_HDRLEN + NLMSG_ALIGN(sizeof(ifinfomsg));
  if (!head || head->nlmsg_type != RTM_NEWLINK || head->nlmsg_len > answer.size() ||
      head->nlmsg_len < kBefore)
    return std::nullopt;
  const Bytes link = attribute(answer.subspan(kBefore, head->nlmsg_len - kBefore), IFLA_LINKINFO);
  if (!is_can(attribute(link, IFLA_INFO_KIND))) return std::nullopt;
  const auto timing = at_start<can_bittiming>(attribute(attribute(link, IFLA_INFO_DATA), IFLA_CAN_BITTIMING));
  return timing ? std::optional(timing->bitrate) : std::nullopt;
}

std::optional<std::uint32_t> can_bit_rate(const std::string& interface) {
  const unsigned index = ::if_nametoindex(interface.c_str());
  if (index == 0) refuse(interface, "no such interface");
  struct {
    nlmsghdr head;
    ifinfomsg link;
  } question{};
  question.head.nlmsg_len = sizeof question;
  question.head.nlmsg_type = RTM_GETLINK;
  question.head.nlmsg_flags = NLM_F_REQUEST;
  question.link.ifi_family = AF_UNSPEC;
  question.link.ifi_index = static_cast<int>(index);
  const Socket socket;
  const timeval patience{.tv_sec = 1, .tv_usec = 0};
  alignas(nlmsghdr) std::array<std::byte, 32768> answer{};  // of which the kernel needs an eighth or so
  if (socket.descriptor() < 0 ||
      ::setsockopt(socket.descriptor(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) != 0 ||
      ::send(socket.descriptor(), &question, sizeof question, 0) < 0)
    refuse(interface, std::strerror(errno));
  const ssize_t length = ::recv(socket.descriptor(), answer.data(), answer.size(), 0);
  if (length < 0) refuse(interface, std::strerror(errno));
  const Bytes message(answer.data(), static_cast<std::size_t>(length));
  const auto head = at_start<nlmsghdr>(message);
  if (!head || head->nlmsg_type != RTM_NEWLINK) refuse(interface, "no answer to RTM_GETLINK");
  return bit_rate_in(message);
}

}  // namespace plenum::board::drivers
