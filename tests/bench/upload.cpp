// What share of the wire's own limit a transfer moves: the bits that its bytes would take in full segments of seven bytes,
// nothing else on the bus, over the bits that it took, requests, confirmations and stuffing included.
//
// A block transfer has five frames around its segments, and a last segment that may not be full. For n segments that leaves
// n / (n + 5) at best: 0.72 for one image of thirteen parameters (88 bytes), 0.95 for eight of them (705 bytes with their mask), which
// is how they are uploaded: the twelve of a 9-parameter model and its dead time, as `plenum identify` writes it. Only the bytes of the images count. The long value is the board's data sheet, read in blocks of
// 127 segments.
//
// The five are initiate and its answer, the confirmation of the last block, end and its answer: CiA 301, 7.2.4.3.9 to 7.2.4.3.12, knows
// no block download without any of them, and 704 bytes and a mask are no fewer than 101 segments, of which the images fill 100.6: 100.6 / 106 =
// 0.949 where all frames are as long. Their bytes the standard sets, too, but for the size of a block, and long runs of zeros cost them
// more stuff bits than data has. So 0.95 is out of reach for eight images of thirteen parameters, and for one of them by far. The rows ..._of_bound give the share of what is in reach: the bits of all frames that the standard asks for, written down here from
// it, over the bits used. It is 1 when nothing else was sent and nothing twice.
#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <vector>

#include "firmware/config/greybox_parameters.hpp"
#include "firmware/config/model_image.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/ports/can_frame_bits.hpp"
#include "host-sim/rig/standard_rigs.hpp"
#include "host-sim/tools/rig_link.hpp"
#include "tests/bench/row.hpp"

namespace {

using namespace plenum::host;

using Bytes = std::vector<std::uint8_t>;
using plenum::config::ModelKind;

Bytes model_image(ModelKind kind) {
  plenum::config::ModelParameters model;
  model.kind = kind;
  if (kind == ModelKind::greybox) {
    model.count = plenum::config::kGreyboxParameters;
    model.value = {5.08F, 4.92F, 60.0F,  64.0F,  1.0F,  1.0F,  2.0F,   0.12F,  -0.3F,
                   0.7F,  0.2F,  -0.1F,  0.4F,   0.53F, 0.5F,  0.98F,  0.1F,   5.0F,
                   1.2F,  0.2F,  0.004F, 0.011F, 0.8F,  0.05F, 0.006F, 620.0F, 101.325F};
  } else {
    model.count = 13;
    model.value = {5.02F, 2.5F,  4.0F, -0.05F, 0.003F,   0.02F,  40.0F,
                   0.1F,  0.08F, 0.1F, 620.0F, 101.325F, 0.0031F};
  }
  Bytes image(plenum::config::kMaxImageBytes);
  image.resize(plenum::config::encode(model, image));
  return image;
}

/// Bits of the bytes in segments, as they would follow each other; the last one is full, too.
double least_bits(const Bytes& bytes) {
  constexpr std::size_t kSegment = 7;
  double bits = 0.0;
  for (std::size_t at = 0; at < bytes.size(); at += kSegment) {
    plenum::ports::CanFrame frame{.id = 0x601, .length = 8};
    frame.data[0] = static_cast<std::uint8_t>(at / kSegment % 127 + 1);
    for (std::size_t i = 0; i < kSegment && at + i < bytes.size(); ++i) frame.data[1 + i] = bytes[at + i];
    const double share = static_cast<double>(std::min(kSegment, bytes.size() - at)) / kSegment;
    bits += share * (ports::frame_bits(frame) + ports::kIntermissionBits);
  }
  return bits;
}

constexpr std::uint32_t kToBoard = 0x601;
constexpr std::uint32_t kFromBoard = 0x581;

double wire_bits(std::uint32_t id, std::array<unsigned, 8> bytes) {
  plenum::ports::CanFrame frame{.id = id, .length = 8};
  std::transform(bytes.begin(), bytes.end(), frame.data.begin(),
                 [](unsigned byte) { return static_cast<std::uint8_t>(byte & 0xFFU); });
  return ports::frame_bits(frame) + ports::kIntermissionBits;
}

/// Bits of a block download with CRC, in blocks of 127 segments, of which no frame is lost.
double bound_bits(std::uint16_t index, std::uint8_t sub, const Bytes& value) {
  constexpr std::size_t kSegment = 7;
  constexpr unsigned kBlock = 127;
  const unsigned low = index & 0xFFU, high = index >> 8U;
  const auto size = static_cast<unsigned>(value.size());
  double bits = wire_bits(kToBoard, {0xC6, low, high, sub, size, size >> 8U}) +
                wire_bits(kFromBoard, {0xA4, low, high, sub, kBlock});
  unsigned sequence = 0;
  for (std::size_t at = 0; at < value.size(); at += kSegment) {
    const bool last = at + kSegment >= value.size();
    std::array<unsigned, 8> segment{++sequence | (last ? 0x80U : 0U)};
    for (std::size_t i = 0; i < kSegment && at + i < value.size(); ++i) segment[1 + i] = value[at + i];
    bits += wire_bits(kToBoard, segment);
    if (!last && sequence != kBlock) continue;
    bits += wire_bits(kFromBoard, {0xA2, sequence, kBlock});
    sequence = 0;
  }
  const unsigned unused = static_cast<unsigned>(kSegment - 1 - (value.size() + kSegment - 1) % kSegment);
  const unsigned crc = client::crc16(value);
  return bits + wire_bits(kToBoard, {0xC1U | unused << 2U, crc, crc >> 8U}) + wire_bits(kFromBoard, {0xA1});
}

void print_share(const char* of, double value, std::optional<double> target = {}) {
  plenum::bench::print({fmt::format("upload.wire_efficiency{}", of), value, "share", "higher", target});
}

}  // namespace

int main() {
  rig::Rig rig(rig::mpye_rig({.boards = 1, .chambers = 8}));
  tools::RigLink link(rig);
  client::Session session(link, 1);
  session.write<std::uint16_t>(plenum::canopen::object::kHeartbeatTime, 0, 0);
  session.listen(0.1);
  const auto bits_of = [&](auto&& transfer) {
    const std::uint64_t before = rig.bus().counters().bits;
    transfer();
    return static_cast<double>(rig.bus().counters().bits - before);
  };
  const auto upload = [&](const char* of, std::uint16_t index, std::uint8_t sub, const Bytes& value,
                          const Bytes& images, std::optional<double> target) {
    const double bits = bits_of([&] { session.sdo_write(index, sub, value); });
    print_share(of, least_bits(images) / bits, target);
    print_share(fmt::format("{}_of_bound", of).c_str(), bound_bits(index, sub, value) / bits, 1.0);
  };
  const auto upload_set = [&](const char* of, ModelKind kind, std::optional<double> target) {
    const Bytes image = model_image(kind);
    Bytes images;
    for (std::size_t chamber = 0; chamber < plenum::config::kChambers; ++chamber)
      images.insert(images.end(), image.begin(), image.end());
    Bytes set{0xFF};
    set.insert(set.end(), images.begin(), images.end());
    upload(of, plenum::canopen::object::kStagedSet, 1, set, images, target);
  };
  const auto staged = [&] {
    session.listen(0.5);  // an image and its check in four ticks
    if (session.read<std::uint8_t>(plenum::canopen::object::kStagedSet, 2) == 0) return true;
    std::fprintf(stderr, "the set is not staged\n");
    return false;
  };
  upload_set("", ModelKind::tassa9, 0.95);
  if (!staged()) return 1;
  upload_set("_greybox", ModelKind::greybox, {});
  if (!staged()) return 1;
  const Bytes image = model_image(ModelKind::tassa9);
  upload("_one_image", plenum::canopen::object::kStagedModel, 0, image, image, 0.95);
  Bytes sheet;
  const double bits = bits_of([&] { sheet = session.sdo_read_domain(0x1021, 0); });
  print_share("_data_sheet", least_bits(sheet) / bits);
}
