#include "host-sim/client/decode.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "firmware/canopen/object_dictionary.hpp"
#include "host-sim/client/abort_text.hpp"
#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/emergency_text.hpp"
#include "host-sim/client/lss_text.hpp"
#include "host-sim/client/sdo_frames.hpp"
#include "host-sim/client/session.hpp"

namespace plenum::host::client {
namespace {

using canopen::DataType;
namespace cob = canopen::cob;

/// "Actual pressure [Pa]" as the dictionary writes it: the name proper, and the unit.
DecodedValue named(std::string_view text) {
  const std::size_t open = text.rfind(" [");
  if (open == std::string_view::npos || !text.ends_with(']')) return {std::string(text), 0.0, ""};
  return {std::string(text.substr(0, open)), 0.0, std::string(text.substr(open + 2, text.size() - open - 3))};
}

std::string bytes_text(std::span<const std::uint8_t> bytes) {
  return fmt::format("{:02X}", fmt::join(bytes, " "));
}

/// "6381h:1 Actual value, chamber 2", or the index alone where the board has no such object.
std::string object_text(std::uint16_t index, std::uint8_t sub) {
  const canopen::Found found = canopen::find(index, sub);
  std::string text = fmt::format("{:04X}h:{}", index, sub);
  if (found.entry == nullptr) return text;
  text += fmt::format(" {}", found.entry->name);
  if (found.entry->instances > 1)
    text += fmt::format(", {} {}", index < 0x2000 ? "PDO" : "chamber", found.place.instance + 1);
  return text;
}

/// The value of an object in up to four bytes, or the bytes of an object that is no number.
std::string value_text(std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> bytes) {
  const canopen::Found found = canopen::find(index, sub);
  const bool is_number = found.entry != nullptr && found.entry->read_bytes == nullptr &&
                         found.entry->write_bytes == nullptr && found.entry->read_stream == nullptr;
  if (!is_number) return bytes_text(bytes);
  const bool is_real =
      found.entry->type == DataType::real32;  // nine digits tell a float, ten a 32-bit integer
  return fmt::format("{:.{}g} ({})", number_of(found.entry->type, bytes), is_real ? 9 : 10,
                     bytes_text(bytes));
}

const char* command_text(std::uint8_t command) {
  switch (static_cast<canopen::NmtCommand>(command)) {
    case canopen::NmtCommand::start:
      return "start";
    case canopen::NmtCommand::stop:
      return "stop";
    case canopen::NmtCommand::enter_pre_operational:
      return "enter pre-operational";
    case canopen::NmtCommand::reset_node:
      return "reset node";
    case canopen::NmtCommand::reset_communication:
      return "reset communication";
  }
  return "unknown command";
}

/// What a heartbeat says; the state of a node that initialises is sent once, as its boot-up message.
const char* state_text(std::uint8_t state) {
  const auto nmt = static_cast<canopen::NmtState>(state);
  return nmt == canopen::NmtState::initialising ? "boot-up" : nmt_name(nmt);
}

Decoded decode_emergency_text(const Emergency& emergency) {
  std::string where = emergency.chamber == 0 ? "" : fmt::format(", chamber {}", emergency.chamber);
  if (emergency.lost_node != 0) where += fmt::format(", of node {}", emergency.lost_node);
  return {"EMCY",
          emergency.node_id,
          fmt::format("{:04X}h {}{}, error register {:02X}h", emergency.code, emergency_text(emergency.code),
                      where, emergency.error_register),
          {}};
}

Decoded decode_stream(const CanFrame& frame) {
  const std::span<const std::uint8_t> data(frame.data);
  Decoded decoded{"stream", 0, "", {}};
  const unsigned chamber = (frame.id - kStreamIds) % kStreamBlock + 1;
  decoded.values = {
      {fmt::format("actual pressure, chamber {}", chamber), number_of(DataType::real32, data.first(4)), "Pa"},
      {fmt::format("command, chamber {}", chamber), kCommandLsb_V * canopen::load_le(data.subspan(4, 2)),
       "V"},
      {fmt::format("volume code, chamber {}", chamber),
       static_cast<double>(canopen::load_le(data.subspan(6, 2))), ""}};
  return decoded;
}

std::string values_text(const std::vector<DecodedValue>& values) {
  std::string text;
  for (const DecodedValue& one : values) {
    text += fmt::format("{}{} = {:.6g}{}{}", text.empty() ? "" : "; ", one.name, one.value,
                        one.unit.empty() ? "" : " ", one.unit);
  }
  return text;
}

Decoded decode_pdo(const Pdo& pdo, std::span<const std::uint8_t> data) {
  Decoded decoded{fmt::format("{}{}", pdo.receive ? "RPDO" : "TPDO", pdo.number), pdo.node, "", {}};
  if (!pdo.values) {
    decoded.text = bytes_text(data) + " (not mapped so, as far as is known)";
    return decoded;
  }
  for (const PdoValue& carried : *pdo.values) {
    DecodedValue value = named(carried.entry->name);
    value.value = carried.value;
    if (carried.is_pressure) value.unit = "Pa";
    const bool sub_of_chamber =
        carried.entry->last_sub > carried.entry->sub;  // an array with a value a chamber
    if (carried.entry->instances > 1) value.name += fmt::format(", chamber {}", carried.instance + 1);
    if (sub_of_chamber) value.name += fmt::format(", {}", carried.sub);
    decoded.values.push_back(std::move(value));
  }
  decoded.text = values_text(decoded.values);
  return decoded;
}

}  // namespace

Decoded Decoder::decode(const CanFrame& frame) {
  const std::span data = std::span<const std::uint8_t>(frame.data).first(frame.length);
  const std::uint32_t function = frame.id & 0x780U;
  const unsigned node = frame.id & 0x7FU;
  Decoded other{"other", 0, frame.remote ? "remote frame" : bytes_text(data), {}};
  if (frame.extended || frame.remote) return other;
  if (frame.id == cob::kNmt && data.size() == 2)
    return {"NMT", data[1], fmt::format("{}{}", command_text(data[0]), data[1] == 0 ? " all nodes" : ""), {}};
  if (frame.id == cob::kSync && data.size() <= 1)
    return {"SYNC", 0, data.empty() ? std::string() : fmt::format("counter {}", data[0]), {}};
  if (const auto emergency = decode_emergency(frame)) return decode_emergency_text(*emergency);
  pdos_.hear(frame);
  if (const auto pdo = pdos_.read(frame)) return decode_pdo(*pdo, data);
  if (stream_block(frame) && data.size() == 8) {
    Decoded decoded = decode_stream(frame);
    decoded.text = values_text(decoded.values);
    return decoded;
  }
  if (frame.length == 8 && frame.id == cob::kLssRequest) return {"LSS", 0, lss_request_text(frame.data), {}};
  if (frame.length == 8 && frame.id == cob::kLssResponse) return {"LSS", 0, lss_answer_text(frame.data), {}};
  if (node == 0) return other;
  if (function == cob::kHeartbeat && data.size() == 1) return {"heartbeat", node, state_text(data[0]), {}};
  const bool request = function == cob::kSdoRequest;
  if ((request || function == cob::kSdoResponse) && data.size() == 8)
    return {"SDO", node, decode_sdo(frame, request, transfer_[node]), {}};
  return other;
}

/// CiA 301, 7.2.4.3: the command specifier is in the first three bits; inside a block the first byte numbers a segment.
std::string Decoder::decode_sdo(const CanFrame& frame, bool request, Transfer& transfer) {
  const std::span<const std::uint8_t, 8> data(frame.data);
  const std::uint8_t command = data[0];
  const unsigned specifier = command >> 5;
  const auto place = [&] { return object_text(transfer.index, transfer.sub); };
  const auto open = [&](const char* doing) {
    transfer = {static_cast<std::uint16_t>(canopen::load_le(data.subspan<1, 2>())), data[3], Blocks::none, 0};
    return fmt::format("{} {}", doing, place());
  };
  const auto expedited = [&] { return value_text(transfer.index, transfer.sub, sdo::expedited(data)); };
  // Another block follows, but where the last segment was taken.
  const auto go_on = [&](Blocks blocks) {
    if (transfer.last == 0 || data[1] != transfer.last) transfer.blocks = blocks;
    transfer.last = 0;
  };
  const std::uint32_t last_word = canopen::load_le(data.subspan<4, 4>());
  const auto segment = [&](const char* what, std::size_t unused) {
    return fmt::format("{} of {}: {}", what, place(), bytes_text(data.subspan(1, 7 - unused)));
  };

  if (command == 0x80) {
    const std::string text = open("abort");
    return fmt::format("{}: {:08X}h, {}", text, last_word, abort_text(last_word));
  }
  if (transfer.blocks == (request ? Blocks::to_board : Blocks::from_board)) {
    if ((command & 0x80U) != 0) {
      transfer.blocks = Blocks::none;
      transfer.last = static_cast<std::uint8_t>(command & 0x7FU);
    }
    return segment("block segment", 0);
  }
  if (request) {
    switch (specifier) {
      case 0:
        return segment("segment", (command >> 1) & 7U);
      case 1: {
        const std::string text = open("write");
        return (command & 2U) != 0 ? fmt::format("{} = {}", text, expedited())
                                   : fmt::format("{}, {} bytes in segments", text, last_word);
      }
      case 2:
        return open("read");
      case 3:
        return fmt::format("next segment of {}", place());
      case 5:
        if ((command & 3U) == 0) return open("read in blocks");
        if ((command & 3U) == 1) return fmt::format("end of the blocks of {}", place());
        go_on(Blocks::from_board);
        return (command & 3U) == 3 ? fmt::format("begin the blocks of {}", place())
                                   : fmt::format("block of {} taken up to segment {}", place(), data[1]);
      case 6:
        if ((command & 1U) == 0) return fmt::format("{}, {} bytes", open("write in blocks"), last_word);
        return fmt::format("end of the blocks of {}", place());
      default:
        break;
    }
    return fmt::format("unknown command {:02X}h", command);
  }
  switch (specifier) {
    case 0:
      return segment("segment", (command >> 1) & 7U);
    case 1:
      return fmt::format("segment of {} taken", place());
    case 2: {
      const std::string text = open("answer");
      return (command & 2U) != 0 ? fmt::format("{} = {}", text, expedited())
                                 : fmt::format("{}, {} bytes in segments", text, last_word);
    }
    case 3:
      return open("written");
    case 5:
      if ((command & 3U) == 1) return fmt::format("blocks of {} taken", place());
      if ((command & 3U) == 0) {
        std::string text = open("ready for blocks of");
        transfer.blocks = Blocks::to_board;
        return text;
      }
      go_on(Blocks::to_board);
      return fmt::format("block of {} taken up to segment {}", place(), data[1]);
    case 6:
      if ((command & 1U) == 0) return fmt::format("{}, {} bytes", open("answer in blocks"), last_word);
      return fmt::format("end of the blocks of {}", place());
    default:
      return fmt::format("unknown command {:02X}h", command);
  }
}

}  // namespace plenum::host::client
