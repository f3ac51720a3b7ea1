// Any bytes as a model image, through the decoder and the slots of a board.
//
// What is accepted encodes to the same bytes, and its model is finite on a grid of inputs; what is refused changes
// nothing but the reason.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "firmware/config/parameter_slots.hpp"
#include "firmware/control/any_model.hpp"
#include "firmware/numeric/scalar.hpp"
#include "tests/fuzz/good_model.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using namespace plenum;
using fuzz::require;
using Bytes = std::vector<std::uint8_t>;

constexpr std::array<config::ModelKind, 3> kKinds = {config::ModelKind::tassa9, config::ModelKind::greybox,
                                                     config::ModelKind::tassa9r};

/// Most inputs are no image at all. Two bits of the first byte mend magic, schema, counts, size and CRC, so that
/// the search reaches what lies behind them; the rest say of which kind.
Bytes image_from(std::span<const std::uint8_t> data) {
  Bytes image(data.begin(), data.end());
  if (image.empty()) return image;
  const bool mend_header = (image[0] & 1U) != 0;
  const bool mend_crc = (image[0] & 2U) != 0;
  const config::ModelKind kind = kKinds[(image[0] >> 2U) % kKinds.size()];
  image.erase(image.begin());
  if (mend_header) {
    config::ModelParameters sample;
    sample.kind = kind;
    sample.count = static_cast<std::uint16_t>(config::parameter_schema(kind).size());
    Bytes header(config::kMaxImageBytes);
    header.resize(config::encode(sample, header));
    image.resize(header.size());
    std::copy_n(header.begin(), 12, image.begin());
  }
  if (mend_crc && image.size() >= 4) {
    std::uint32_t crc = config::crc32(std::span(image).first(image.size() - 4));
    for (std::size_t i = image.size() - 4; i < image.size(); ++i, crc >>= 8)
      image[i] = static_cast<std::uint8_t>(crc);
  }
  return image;
}

void require_finite(const config::ModelParameters& parameters) {
  control::AnyModel room;
  const control::PressureModel* const model = room.take_over(parameters, 0.0F, 10.0F);
  require(model != nullptr, "a kind that is accepted has a model");
  for (const float pressure_kPa : {0.0F, 101.325F, 3000.0F}) {
    for (const float command_V : {0.0F, 4.99F, 5.01F, 10.0F}) {
      for (const float volume_mL : {0.0F, 20.0F, 6000.0F}) {
        for (const float rate_mL_s : {-10000.0F, 0.0F, 10000.0F}) {
          const control::ChamberMotion motion{volume_mL, rate_mL_s};
          for (const float ticks : {0.0F, 1.0F}) {
            const control::Prediction end = model->step(pressure_kPa, command_V, motion, ticks);
            require(numeric::is_finite(end.end_kPa) && numeric::is_finite(end.mean_kPa), "a tick is finite");
          }
          const control::Inverse inverse = model->inverse(pressure_kPa, 300.0F, motion, command_V);
          require(inverse.command_V >= 0.0F && inverse.command_V <= 10.0F, "a command is in its range");
        }
      }
    }
  }
}

Bytes bytes_of(std::span<const std::uint8_t> image) {
  return {image.begin(), image.end()};
}

config::ParameterSlots board() {
  config::ParameterSlots slots;
  fuzz::put_good_models_in_force(slots, 1);
  return slots;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const config::ParameterSlots kBoard = board();
  const Bytes image = image_from({data, size});
  config::ParameterSlots slots = kBoard;
  const Bytes active = bytes_of(slots.active_image(0));
  const config::ImageVerdict verdict = slots.stage(0, image);
  const std::uint32_t crc = config::trailing_crc(image);
  const config::CommitResult result = slots.commit(1, config::commit_crc({&crc, 1}), config::kCommitKey);
  require(bytes_of(slots.active_image(0)) == active, "nothing changes between ticks");
  require((result == config::CommitResult::accepted) == static_cast<bool>(verdict),
          "what is accepted can be committed");
  require(slots.apply_at_tick_edge() == (verdict ? 1 : 0), "what is accepted is taken over");

  config::ModelParameters read;
  if (!verdict) {
    require(bytes_of(slots.active_image(0)) == active && slots.generation() == 1,
            "what is refused changes no set");
    require(!config::decode(image, read) && read.kind == config::ModelKind::none && read.count == 0,
            "a refused image is not read");
    return 0;
  }
  require(bytes_of(slots.active_image(0)) == image && slots.generation() == 2,
          "the image in force is the one accepted");
  require(static_cast<bool>(config::decode(image, read)), "an accepted image is read");
  Bytes again(config::kMaxImageBytes);
  again.resize(config::encode(read, again));
  require(again == image, "what is read is written again, byte for byte");
  require_finite(slots.active(0));
  return 0;
}
