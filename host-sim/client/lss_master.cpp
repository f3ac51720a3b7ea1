#include "host-sim/client/lss_master.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "firmware/canopen/lss.hpp"
#include "host-sim/client/errors.hpp"
#include "host-sim/client/lss_commands.hpp"

namespace plenum::host::client {
namespace {

using namespace lss;

constexpr double kOthers_s = 0.02;  ///< boards answer at ticks of 10 ms, each at its own
constexpr double kStore_s = 6.0;    ///< a board tells of a store that does not come to its end after 5 s

constexpr std::array<std::uint8_t, 8> request(unsigned command, std::uint32_t number = 0) {
  std::array<std::uint8_t, 8> bytes{static_cast<std::uint8_t>(command)};
  canopen::store_le(number, std::span(bytes).subspan<1, 4>());
  return bytes;
}

}  // namespace

std::uint8_t bit_timing_row(std::uint32_t bit_rate_per_s) {
  if (const auto row = canopen::row_of_bit_rate(bit_rate_per_s)) return *row;
  throw std::invalid_argument(fmt::format(
      "bit rate {}: none of CANopen, expected 10000, 20000, 50000, 125000, 250000, 500000, 800000 or 1000000",
      bit_rate_per_s));
}

LssMaster::~LssMaster() {
  try {
    release();
  } catch (const std::exception&) {  // the link has failed, which whoever uses it was told
    return;
  }
}

std::optional<Identity> LssMaster::find_unconfigured() {
  constexpr unsigned kRestart = 0x80;
  release();
  if (!identified(0, kRestart, 0, 0)) return std::nullopt;
  std::array<std::uint32_t, kNumbers> number{};
  for (unsigned sub = 0; sub < kNumbers; ++sub) {
    for (unsigned bit = 32; bit-- > 0;) {
      if (!identified(number[sub], bit, sub, sub)) number[sub] |= std::uint32_t{1} << bit;
    }
    if (!identified(number[sub], 0, sub, (sub + 1) % kNumbers)) {
      throw ProtocolError(fmt::format(
          "LSS fastscan: no board confirms {:08X}h as number {} of its identity, expected the one "
          "that answered for each bit",
          number[sub], sub + 1));
    }
  }
  return Identity{
      .vendor_id = number[0], .product_code = number[1], .revision = number[2], .serial = number[3]};
}

void LssMaster::select(const Identity& identity) {
  release();
  say(request(kSwitchSelectively, identity.vendor_id));
  say(request(kSwitchSelectively + 1, identity.product_code));
  say(request(kSwitchSelectively + 2, identity.revision));
  if (ask(request(kSwitchSelectively + 3, identity.serial), kSwitched, answer_s_)) return;
  throw Timeout(
      fmt::format("LSS: no board of vendor {:X}h, product {:X}h, revision {:X}h, serial {} answers within "
                  "{:g} s, expected one "
                  "that is neither OPERATIONAL nor out of INIT",
                  identity.vendor_id, identity.product_code, identity.revision, identity.serial, answer_s_));
}

void LssMaster::give_node_id(std::uint8_t node_id) {
  Bytes bytes = request(kConfigureNodeId);
  bytes[1] = node_id;
  configure(bytes, "node id", answer_s_);
}

void LssMaster::give_bit_rate(std::uint32_t bit_rate_per_s) {
  Bytes bytes = request(kConfigureBitTiming);  // table 0
  bytes[2] = bit_timing_row(bit_rate_per_s);
  configure(bytes, "bit rate", answer_s_,
            "a board takes those that its board.toml offers and its interface can run at");
}

void LssMaster::store() {
  configure(request(kStore), "store", kStore_s);
}

void LssMaster::release() {
  say(request(kSwitchGlobally));
}

void LssMaster::say(const Bytes& bytes) {
  link_.send({.id = canopen::cob::kLssRequest, .length = 8, .data = bytes});
}

/// What came before the request is no answer to it.
std::optional<LssMaster::Bytes> LssMaster::ask(const Bytes& bytes, unsigned answer, double timeout_s) {
  while (link_.receive(0.0)) continue;
  say(bytes);
  const double end_s = link_.now_s() + timeout_s;
  for (double left_s = timeout_s; left_s > 0.0; left_s = end_s - link_.now_s()) {
    const std::optional<CanFrame> frame = link_.receive(left_s);
    if (!frame) break;
    const bool is_answer = !frame->extended && !frame->remote && frame->id == canopen::cob::kLssResponse &&
                           frame->length == 8 && frame->data[0] == answer;
    if (is_answer) return frame->data;
  }
  return std::nullopt;
}

bool LssMaster::identified(std::uint32_t number, unsigned lowest_bit, unsigned sub, unsigned next) {
  Bytes bytes = request(kFastscan, number);
  bytes[5] = static_cast<std::uint8_t>(lowest_bit);
  bytes[6] = static_cast<std::uint8_t>(sub);
  bytes[7] = static_cast<std::uint8_t>(next);
  if (!ask(bytes, kIdentified, answer_s_)) return false;
  // the others of whom it holds, who must not be taken for an answer to what is asked next
  const double end_s = link_.now_s() + kOthers_s;
  while (link_.now_s() < end_s && link_.receive(end_s - link_.now_s())) continue;
  return true;
}

void LssMaster::configure(const Bytes& bytes, const char* what, double timeout_s, const char* out_of_range) {
  const auto answer = ask(bytes, bytes[0], timeout_s);
  if (!answer) {
    throw Timeout(fmt::format(
        "LSS: {} had no answer within {:g} s, expected one of the board that was chosen", what, timeout_s));
  }
  if ((*answer)[1] == 0) return;
  const char* reason = (*answer)[1] == 1   ? out_of_range
                       : (*answer)[1] == 2 ? "its memory failed"
                                           : "its own reason";
  throw Refused(fmt::format("LSS: {} refused with error {}, {}", what, (*answer)[1], reason));
}

}  // namespace plenum::host::client
