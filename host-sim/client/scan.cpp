#include "host-sim/client/scan.hpp"

#include <algorithm>
#include <array>

#include "host-sim/client/sdo_frames.hpp"

namespace plenum::host::client {
namespace {

namespace cob = canopen::cob;
namespace object = canopen::object;

constexpr std::uint8_t kLastNode = 127;

constexpr double kBetweenAsked_s = 0.0027;  ///< an SDO request takes 5 % of this at 1 Mbit/s
constexpr double kAnswer_s = 0.05;          ///< that the last one asked is given

/// On a slow bus: requests that pile up before it are answered when nobody listens any more.
struct Pace {
  double between_s = kBetweenAsked_s;
  double answer_s = kAnswer_s;

  explicit Pace(std::optional<std::uint32_t> bit_rate) {
    if (!bit_rate || *bit_rate == 0) return;
    constexpr double kFrameBits = 135.0;  // the longest of eight bytes, with the pause behind it
    const double frame_s = kFrameBits / *bit_rate;
    between_s = std::max(between_s, 3.0 * frame_s);  // a request, its answer, and somebody else's frame
    answer_s = std::max(answer_s, 12.0 * frame_s);
  }
};

/// What has been heard.
class Roll {
 public:
  void take(const CanFrame& frame) {
    if (frame.extended || frame.remote) return;
    const std::uint32_t function = frame.id & ~std::uint32_t{kLastNode};
    const std::uint32_t id = frame.id & kLastNode;
    if (id == 0) return;
    if (function == cob::kHeartbeat && frame.length == 1) {
      node_[id].seen = true;
      node_[id].nmt = static_cast<canopen::NmtState>(frame.data[0] & 0x7FU);
    } else if (function == cob::kSdoResponse && frame.length == 8) {
      node_[id].seen = true;
    } else if (function == cob::kSdoRequest) {
      node_[id].asked = true;
    }
  }

  struct Node {
    bool seen = false;
    bool asked = false;  ///< by another master: if the node is there, its answer tells
    std::optional<canopen::NmtState> nmt;
  };
  const Node& operator[](std::size_t id) const { return node_[id]; }

 private:
  std::array<Node, kLastNode + 1> node_{};
};

void listen(Link& link, double until_s, Roll& roll) {
  while (const auto frame = link.receive(std::max(0.0, until_s - link.now_s()))) {
    roll.take(*frame);
    if (link.now_s() >= until_s) return;
  }
}

void ask_for(Link& link, std::uint8_t id) {
  link.send(
      {.id = cob::kSdoRequest + id, .length = 8, .data = sdo::request(0x40, object::kDeviceTypeIndex, 0)});
}

/// Heartbeats tell of most nodes, and disturb nobody; only ids that are silent are asked, one after the other.
void call(Link& link, double duration_s, const Pace& pace, Roll& roll,
          const std::function<void(unsigned node)>& progress) {
  if (progress) progress(0);
  const double end_s = link.now_s() + duration_s;
  listen(link, end_s - kLastNode * kBetweenAsked_s - kAnswer_s, roll);
  for (std::uint8_t id = 1; id <= kLastNode; ++id) {
    if (roll[id].seen || roll[id].asked) continue;
    if (progress) progress(id);
    ask_for(link, id);
    listen(link, link.now_s() + pace.between_s, roll);
  }
  listen(link, std::max(end_s, link.now_s() + pace.answer_s), roll);
}

std::string text_or_nothing(Session& session, std::uint16_t index) {
  try {
    return session.read_text(index);
  } catch (const SdoAbort&) {
    return {};
  }
}

BoardSummary summarise(Session& session) {
  BoardSummary board;
  board.status_word = session.status_word();
  board.fault = read_fault(session);
  board.compatible = session.read<std::uint32_t>(object::kSchema, 1) == own_schema_hash();
  for (std::uint16_t chamber = 0; chamber < kChambers; ++chamber) {
    const std::uint16_t state = object::nth(object::kSetState, chamber);
    if (session.read<std::uint32_t>(state, 3) != 0) ++board.models;
  }
  return board;
}

void ask(Session& session, ScannedNode& node) {
  node.device_type = session.read<std::uint32_t>(object::kDeviceTypeIndex, 0);
  node.identity = read_identity(session);
  node.name = text_or_nothing(session, object::kDeviceName);
  node.software = text_or_nothing(session, object::kSoftwareVersion);
  if (node.device_type == canopen::kDeviceType) node.board = summarise(session);
}

}  // namespace

bool is_on_bus(Link& link, std::uint8_t node_id, double duration_s) {
  Roll roll;
  ask_for(link, node_id);
  listen(link, link.now_s() + duration_s, roll);
  return roll[node_id].seen;
}

std::vector<ScannedNode> scan(Link& link, double duration_s, const SessionConfig& config,
                              const std::function<void(unsigned node)>& progress,
                              std::optional<std::uint32_t> bit_rate) {
  Roll roll;
  call(link, duration_s, Pace(bit_rate ? bit_rate : link.bit_rate()), roll, progress);
  std::vector<ScannedNode> found;
  for (std::uint8_t id = 1; id <= kLastNode; ++id) {
    if (!roll[id].seen) continue;
    if (progress) progress(id);
    ScannedNode node;
    node.node_id = id;
    node.nmt = roll[id].nmt;
    Session session(link, id, config);
    session.subscribe([&](const Arrival& arrival) { roll.take(arrival.frame); });
    try {
      ask(session, node);
    } catch (const SdoAbort& error) {
      node.trouble = error.what();
    } catch (const Timeout& error) {
      node.trouble = error.what();
    } catch (const ProtocolError& error) {
      node.trouble = error.what();
    } catch (const ChannelTaken& error) {
      node.trouble = error.what();
    }
    found.push_back(node);
  }
  for (ScannedNode& node : found) {
    if (!node.nmt) node.nmt = roll[node.node_id].nmt;  // heard while others were asked
  }
  return found;
}

}  // namespace plenum::host::client
