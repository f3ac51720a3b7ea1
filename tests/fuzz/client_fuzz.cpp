// Any answers of a board, and any traffic beside them, to the PC's SDO client.
//
// A transfer ends with bytes or with one of the client's exceptions, though frames come for ever; and whatever is said can be decoded.
//
// An input is a byte, what the client does (Task), and a row of Arrivals, the last of which comes again and again.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "host-sim/client/decode.hpp"
#include "host-sim/client/errors.hpp"
#include "host-sim/client/sdo_client.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using namespace plenum;
using namespace plenum::host::client;
using fuzz::require;
namespace cob = canopen::cob;

constexpr std::uint8_t kNode = 5;
constexpr std::uint16_t kIndex = 0x2110;
constexpr std::uint8_t kSub = 0;
constexpr double kFrame_s =
    5.0e-3;  // a slow bus: no more than a thousand frames until the client's patience ends
constexpr double kLongest_s = 60.0;
constexpr SdoConfig kConfig{.largest_bytes = 1024, .seed = 1};

/// The low bits of what comes say how; the rest of the byte is left to the search.
enum class Arrival : std::uint8_t {
  of_object = 0,  ///< an answer that names the object: command, four bytes
  answer = 1,     ///< an answer of eight bytes
  silence = 2,    ///< nothing within the time-out
  foreign = 3,    ///< another master's request of eight bytes
  any = 4,        ///< identifier, U16; length; eight bytes
};
constexpr unsigned kArrivals = 5;

enum class Task : std::uint8_t { read, read_domain, write_short, write_long };
constexpr unsigned kTasks = 4;

class Answering final : public Link {
 public:
  explicit Answering(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) take(bytes);
  }
  void send(const CanFrame& frame) override { require(frame.length == 8, "a request has eight bytes"); }
  std::optional<CanFrame> receive(double timeout_s) override {
    require(now_s_ < kLongest_s, "a transfer ends");
    if (arrivals_.empty()) return silence(timeout_s);
    const std::optional<CanFrame> frame = arrivals_[next_];
    next_ = std::min(next_ + 1, arrivals_.size() - 1);
    if (!frame || timeout_s < kFrame_s) return silence(timeout_s);
    now_s_ += kFrame_s;
    return frame;
  }
  double now_s() const override { return now_s_; }

 private:
  std::optional<CanFrame> silence(double timeout_s) {
    now_s_ += timeout_s;
    return std::nullopt;
  }
  void take(std::span<const std::uint8_t>& bytes) {
    const auto byte = [&bytes] {
      if (bytes.empty()) return std::uint8_t{0};
      const std::uint8_t first = bytes.front();
      bytes = bytes.subspan(1);
      return first;
    };
    CanFrame frame{.id = cob::kSdoResponse + kNode, .length = 8};
    std::size_t from = 0;
    switch (static_cast<Arrival>(byte() % kArrivals)) {
      case Arrival::silence:
        arrivals_.emplace_back();
        return;
      case Arrival::of_object:
        frame.data = {byte(), kIndex & 0xFFU, kIndex >> 8U, kSub};
        from = 4;
        break;
      case Arrival::answer:
        break;
      case Arrival::foreign:
        frame.id = cob::kSdoRequest + kNode;
        break;
      case Arrival::any: {
        const std::uint32_t low = byte();
        frame.id = (low | std::uint32_t{byte()} << 8U) & cob::kIdMask;
        frame.length = byte() % 9;
        break;
      }
    }
    for (; from < frame.length; ++from) frame.data[from] = byte();
    arrivals_.emplace_back(frame);
    decoder_.decode(frame);
  }

  std::vector<std::optional<CanFrame>> arrivals_;
  std::size_t next_ = 0;
  double now_s_ = 0.0;
  Decoder decoder_;
};

void carry_out(Task task, SdoClient& client) {
  constexpr std::array<std::uint8_t, 300> kLong{};
  switch (task) {
    case Task::read:
      require(client.read(kIndex, kSub).size() <= kConfig.largest_bytes, "a value has its bounds");
      break;
    case Task::read_domain:
      require(client.read_domain(kIndex, kSub).size() <= kConfig.largest_bytes, "a value has its bounds");
      break;
    case Task::write_short:
      client.write(kIndex, kSub, std::span(kLong).first(9));
      break;
    case Task::write_long:
      client.write(kIndex, kSub, kLong);
      break;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  Answering link({data + 1, size - 1});
  SdoClient client(link, kNode, kConfig, {});
  try {
    carry_out(static_cast<Task>(data[0] % kTasks), client);
  } catch (const SdoAbort&) {  // each of them is an end
  } catch (const Timeout&) {
  } catch (const ProtocolError&) {
  } catch (const ChannelTaken&) {
  }
  return 0;
}
