#include "host-sim/client/stream.hpp"

#include <bit>
#include <span>

#include "firmware/canopen/cia301.hpp"

namespace plenum::host::client {

std::optional<std::uint32_t> stream_block(const CanFrame& frame) {
  if (frame.extended || frame.id < kStreamIds) return std::nullopt;
  const std::uint32_t block = (frame.id - kStreamIds) / kStreamBlock;
  return block < kStreamBlocks ? std::optional(block) : std::nullopt;
}

Stream::Stream(const StreamConfig& config, std::uint32_t first_cob_id, std::uint32_t supply_cob_id,
               double volume_lsb_m3)
    : config_(config),
      first_cob_id_(first_cob_id),
      supply_cob_id_(supply_cob_id),
      volume_lsb_m3_(volume_lsb_m3) {}

std::optional<StreamSample> Stream::decode(const CanFrame& frame) const {
  if (frame.extended || frame.remote || frame.length != 8 || frame.id < first_cob_id_) return std::nullopt;
  const std::size_t chamber = frame.id - first_cob_id_;
  if (chamber >= kChambers || (std::uint32_t{config_.chambers} >> chamber & 1U) == 0) return std::nullopt;
  const std::span data(frame.data);
  StreamSample sample;
  sample.chamber = chamber;
  sample.actual_Pa = static_cast<double>(std::bit_cast<float>(canopen::load_le(data.subspan<0, 4>())));
  if (config_.position) {
    sample.position_V = static_cast<double>(std::bit_cast<float>(canopen::load_le(data.subspan<4, 4>())));
    return sample;
  }
  sample.command_V = canopen::load_le(data.subspan<4, 2>()) * kCommandLsb_V;
  sample.volume_m3 = canopen::load_le(data.subspan<6, 2>()) * volume_lsb_m3_;
  return sample;
}

bool Stream::accept(double time_s, const CanFrame& frame,
                    const std::function<void(const StreamRow&)>& on_row) {
  if (config_.supply && !frame.extended && !frame.remote && frame.id == supply_cob_id_ && frame.length == 4) {
    supply_Pa_ =
        static_cast<double>(std::bit_cast<float>(canopen::load_le(std::span(frame.data).first<4>())));
    return true;
  }
  const std::optional<StreamSample> sample = decode(frame);
  if (!sample) return false;
  const auto bit = static_cast<std::uint8_t>(1U << sample->chamber);
  if ((row_.chambers & bit) != 0) {  // the chamber's next sample: the row it would belong to has lost others
    on_row(row_);
    row_ = {};
  }
  if (row_.chambers == 0) row_.time_s = time_s;
  row_.supply_Pa = supply_Pa_;
  row_.sample[sample->chamber] = *sample;
  row_.chambers = static_cast<std::uint8_t>(row_.chambers | bit);
  if (row_.chambers == config_.chambers) {
    on_row(row_);
    row_ = {};
  }
  return true;
}

}  // namespace plenum::host::client
