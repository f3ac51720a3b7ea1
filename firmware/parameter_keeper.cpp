#include "firmware/parameter_keeper.hpp"

#include "firmware/canopen/objects.hpp"

namespace plenum {
namespace {

using canopen::Kept;
using canopen::StoreOrder;
using config::RecordRow;

// A row below the object dictionary, index 0, after those of config::LssSettings.
constexpr std::uint8_t kSavedIdRow = 3;  ///< the node id when communication parameters were saved: U8

bool is_model(const RecordRow& row) noexcept {
  return row.index >= canopen::object::kActiveModel &&
         row.index < canopen::object::kActiveModel + config::kChambers && row.sub == 0;
}

void add(config::RowWriter& rows, std::uint8_t sub, std::uint32_t value, std::size_t size) noexcept {
  std::array<std::uint8_t, 4> bytes{};
  canopen::store_le(value, bytes);
  rows.add({.index = 0, .sub = sub, .value = std::span(bytes).first(size)});
}

/// `order`: as of StoreOrder.
config::LssSettings changed(config::LssSettings stored, const config::LssSettings& order) noexcept {
  if (order.node_id != 0) stored.node_id = order.node_id <= canopen::kMaxNodeId ? order.node_id : 0;
  if (order.bit_rate_kbit != 0) stored.bit_rate_kbit = order.bit_rate_kbit;
  return stored;
}

/// The image in the model row of `body`; empty when there is none.
std::span<const std::uint8_t> stored_model(std::span<const std::uint8_t> body, std::uint16_t index) noexcept {
  config::RowReader rows(body);
  for (RecordRow row; rows.next(row);) {
    if (row.index == index && row.sub == 0) return row.value;
  }
  return {};
}

/// 1010h:1 and 1011h:1 are of all parameters, :2 and :3 of one group.
bool is_of(const StoreOrder& order, StoreOrder::What what, Kept group) noexcept {
  constexpr std::uint8_t kAll = 1;
  const std::uint8_t sub = group == Kept::communication ? 2 : 3;
  return order.what == what && (order.sub == kAll || order.sub == sub);
}

}  // namespace

void ParameterKeeper::start(Controller& controller) noexcept {
  const config::RecordStore::Loaded loaded = store_.load(body_[in_force_]);
  loaded_ = loaded.result;
  size_ = loaded.size;
  loss_ = loaded_ == config::LoadResult::fell_back || loaded_ == config::LoadResult::lost;
  config::RowReader rows(kept());
  for (RecordRow row; rows.next(row);) {
    if (is_model(row)) {
      const auto chamber = static_cast<std::uint8_t>(row.index - canopen::object::kActiveModel);
      if (!controller.restore(chamber, row.value)) skipped_.skip(row.index, row.sub);
    } else if (canopen::group_of_row(row.index) == Kept::no) {
      read_name(row);
    }
  }
  hand_to(controller);
  const canopen::Restored values = controller.node().restart(lss_.node_id);
  if (skipped_.skipped == 0) skipped_.first_skipped = values.first_skipped;
  skipped_.skipped = static_cast<std::uint16_t>(skipped_.skipped + values.skipped);
  loss_ = loss_ || values.settings_lost;
}

void ParameterKeeper::read_name(const RecordRow& row) noexcept {
  if (config::take_row(lss_, row)) return;
  if (row.index == 0 && row.sub == kSavedIdRow && row.value.size() == 1 &&
      row.value[0] <= canopen::kMaxNodeId) {
    saved_id_ = row.value[0];
  } else {
    skipped_.skip(row.index, row.sub);
  }
}

void ParameterKeeper::hand_to(Controller& controller) noexcept {
  controller.node().keep(kept(), saved_id_);
}

bool ParameterKeeper::compose(const Controller& controller, const StoreOrder& order) noexcept {
  config::RowWriter next(body_[1 - in_force_]);
  next_lss_ = order.what == StoreOrder::What::lss ? changed(lss_, order.lss) : lss_;
  next_saved_id_ = saved_id_;
  add(next, config::kNodeIdRow, next_lss_.node_id, 1);
  add(next, config::kBitRateRow, next_lss_.bit_rate_kbit, 2);
  for (std::uint8_t c = 0; c < config::kChambers; ++c) {
    const auto index = static_cast<std::uint16_t>(canopen::object::kActiveModel + c);
    std::span<const std::uint8_t> image = controller.active_image(c);
    if (image.empty()) image = stored_model(kept(), index);  // one that only other firmware takes
    if (!image.empty()) next.add({.index = index, .sub = 0, .value = image});
  }
  collect(controller, Kept::communication, order, next);
  collect(controller, Kept::application, order, next);
  add(next, kSavedIdRow, next_saved_id_, 1);
  next_size_ = next.size();
  return !next.overflowed();
}

/// A group is saved as it stands, left out, or carried over from the set in force, rows of other firmware with it.
void ParameterKeeper::collect(const Controller& controller, Kept group, const StoreOrder& order,
                              config::RowWriter& next) noexcept {
  if (is_of(order, StoreOrder::What::store, group)) {
    controller.node().collect(group, next);
    if (group == Kept::communication) next_saved_id_ = controller.node().node_id();
  } else if (!is_of(order, StoreOrder::What::restore, group)) {
    config::RowReader rows(kept());
    for (RecordRow row; rows.next(row);) {
      if (canopen::group_of_row(row.index) == group) next.add(row);
    }
  }
}

void ParameterKeeper::step(Controller& controller) noexcept {
  if (writing_) {
    const ports::StoreResult result = store_.step();
    if (result != ports::StoreResult::busy) finish(controller, result);
    return;
  }
  const StoreOrder& order = controller.node().order();
  const bool stands = order.what != StoreOrder::What::none && !order.done;
  ordered_ = stands && !controller.node().is_resetting();  // halfway through one it would save halves
  if (!ordered_ && !unsaved_) return;
  models_written_ = unsaved_;
  unsaved_ = false;
  writing_ = true;
  if (!compose(controller, ordered_ ? order : StoreOrder{}))
    return finish(controller, ports::StoreResult::failed);
  store_.begin(std::span(body_[1 - in_force_]).first(next_size_));
}

void ParameterKeeper::finish(Controller& controller, ports::StoreResult result) noexcept {
  writing_ = false;
  const bool done = result == ports::StoreResult::done;
  if (done) {
    in_force_ = 1 - in_force_;
    size_ = next_size_;
    lss_ = next_lss_;
    saved_id_ = next_saved_id_;
    failures_on_end_ = 0;
    hand_to(controller);
  } else {
    unsaved_ = unsaved_ || models_written_;
    ++failures_;
    // an order is answered, and its client's to repeat: only what is tried again can end the fault
    if (models_written_ && failures_on_end_ < kFailuresForFault) ++failures_on_end_;
  }
  if (!ordered_) return;
  StoreOrder& order = controller.node().order();
  order.result = done ? canopen::Abort::none : canopen::Abort::hardware_error;
  order.done = true;
}

bool ParameterKeeper::take_loss() noexcept {
  const bool loss = loss_;
  loss_ = false;
  return loss;
}

canopen::StoreImage ParameterKeeper::image() const noexcept {
  canopen::StoreImage image;
  if (writing_ || unsaved_) {
    image.phase = failures_on_end_ != 0 ? canopen::StorePhase::failing : canopen::StorePhase::writing;
  }
  image.loaded = loaded_;
  image.generation = store_.generation();
  image.skipped_rows = skipped_.skipped;
  image.first_skipped = skipped_.first_skipped;
  image.failures = failures_;
  return image;
}

}  // namespace plenum
