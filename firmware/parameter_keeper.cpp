#include "firmware/parameter_keeper.hpp"

#include "firmware/canopen/objects.hpp"

namespace plenum {
namespace {

using config::RecordRow;

bool is_model(const RecordRow& row) noexcept {
  return row.index >= canopen::object::kActiveModel &&
         row.index < canopen::object::kActiveModel + config::kChambers;
}

}  // namespace

void ParameterKeeper::start(Controller& controller) noexcept {
  const config::RecordStore::Loaded loaded = store_.load(body_[in_force_]);
  loaded_ = loaded.result;
  size_ = loaded.size;
  loss_ = loaded_ == config::LoadResult::fell_back || loaded_ == config::LoadResult::lost;
  config::RowReader rows(kept());
  for (RecordRow row; rows.next(row);) restore(controller, row);
}

void ParameterKeeper::restore(Controller& controller, const RecordRow& row) noexcept {
  if (is_model(row) &&
      controller.restore(static_cast<std::uint8_t>(row.index - canopen::object::kActiveModel), row.value)) {
    return;
  }
  if (skipped_ == 0) first_skipped_ = std::uint32_t{row.index} << 8 | row.sub;
  if (skipped_ < 0xFFFF) ++skipped_;
}

void ParameterKeeper::compose(const Controller& controller) noexcept {
  // kMaxBodyBytes holds all that can be stored: no row is turned away
  config::RowWriter next(body_[1 - in_force_]);
  for (std::uint8_t c = 0; c < config::kChambers; ++c) {
    const std::span<const std::uint8_t> image = controller.active_image(c);
    const auto index = static_cast<std::uint16_t>(canopen::object::kActiveModel + c);
    if (!image.empty()) next.add({.index = index, .sub = 0, .value = image});
  }
  next_size_ = next.size();
}

void ParameterKeeper::step(const Controller& controller) noexcept {
  if (writing_) {
    const ports::StoreResult result = store_.step();
    if (result != ports::StoreResult::busy) finish(result);
  } else if (unsaved_) {
    compose(controller);
    store_.begin(std::span(body_[1 - in_force_]).first(next_size_));
    unsaved_ = false;
    writing_ = true;
  }
}

void ParameterKeeper::finish(ports::StoreResult result) noexcept {
  writing_ = false;
  if (result == ports::StoreResult::done) {
    in_force_ = 1 - in_force_;
    size_ = next_size_;
    failures_on_end_ = 0;
    return;
  }
  unsaved_ = true;
  ++failures_;
  if (failures_on_end_ < kFailuresForFault) ++failures_on_end_;
}

bool ParameterKeeper::take_loss() noexcept {
  const bool loss = loss_;
  loss_ = false;
  return loss;
}

canopen::StoreImage ParameterKeeper::image() const noexcept {
  canopen::StoreImage image;
  if (writing_ || unsaved_) image.phase = canopen::StorePhase::writing;
  if (failures_on_end_ != 0) image.phase = canopen::StorePhase::failing;
  image.loaded = loaded_;
  image.generation = store_.generation();
  image.skipped_rows = skipped_;
  image.first_skipped = first_skipped_;
  image.failures = failures_;
  return image;
}

}  // namespace plenum
