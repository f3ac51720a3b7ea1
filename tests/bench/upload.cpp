// What share of the wire's own limit a transfer moves: the bits that its bytes would take in full segments of seven bytes,
// nothing else on the bus, over the bits that it took, requests, confirmations and stuffing included.
//
// A block transfer has five frames around its segments, and a last segment that may not be full. For n segments that leaves
// n / (n + 5) at best: 0.70 for one image of twelve parameters (80 bytes), 0.95 for eight of them (641 bytes with their mask), which
// is how they are uploaded. Only the bytes of the images count. The long value is the board's data sheet, read in blocks of
// 127 segments.
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

using plenum::config::ModelKind;

std::vector<std::uint8_t> model_image(ModelKind kind) {
  plenum::config::ModelParameters model;
  model.kind = kind;
  if (kind == ModelKind::greybox) {
    model.count = plenum::config::kGreyboxParameters;
    model.value = {5.08F, 4.92F, 60.0F,  64.0F,  1.0F,  1.0F,  2.0F,   0.12F,  -0.3F,
                   0.7F,  0.2F,  -0.1F,  0.4F,   0.53F, 0.5F,  0.98F,  0.1F,   5.0F,
                   1.2F,  0.2F,  0.004F, 0.011F, 0.8F,  0.05F, 0.006F, 620.0F, 101.325F};
  } else {
    model.count = 12;
    model.value = {5.02F, 2.5F, 4.0F, -0.05F, 0.003F, 0.02F, 40.0F, 0.1F, 0.08F, 0.1F, 620.0F, 101.325F};
  }
  std::vector<std::uint8_t> image(plenum::config::kMaxImageBytes);
  image.resize(plenum::config::encode(model, image));
  return image;
}

/// Bits of the bytes in segments, as they would follow each other; the last one is full, too.
double least_bits(const std::vector<std::uint8_t>& bytes) {
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
  const auto efficiency = [&](auto&& transfer) {
    const std::uint64_t before = rig.bus().counters().bits;
    const std::vector<std::uint8_t> bytes = transfer();
    return least_bits(bytes) / static_cast<double>(rig.bus().counters().bits - before);
  };
  const auto upload_set = [&](ModelKind kind) {
    return efficiency([&] {
      const std::vector<std::uint8_t> image = model_image(kind);
      std::vector<std::uint8_t> images;
      for (std::size_t chamber = 0; chamber < plenum::config::kChambers; ++chamber)
        images.insert(images.end(), image.begin(), image.end());
      std::vector<std::uint8_t> set{0xFF};
      set.insert(set.end(), images.begin(), images.end());
      session.sdo_write(plenum::canopen::object::kStagedSet, 1, set);
      return images;
    });
  };
  const auto staged = [&] {
    session.listen(0.2);  // an image a tick
    if (session.read<std::uint8_t>(plenum::canopen::object::kStagedSet, 2) == 0) return true;
    std::fprintf(stderr, "the set is not staged\n");
    return false;
  };
  print_share("", upload_set(ModelKind::tassa9), 0.95);
  if (!staged()) return 1;
  print_share("_greybox", upload_set(ModelKind::greybox));
  if (!staged()) return 1;
  const double one_image = efficiency([&] {
    std::vector<std::uint8_t> image = model_image(ModelKind::tassa9);
    session.sdo_write(plenum::canopen::object::kStagedModel, 0, image);
    return image;
  });
  print_share("_one_image", one_image, 0.95);
  print_share("_data_sheet", efficiency([&] { return session.sdo_read_domain(0x1021, 0); }));
}
