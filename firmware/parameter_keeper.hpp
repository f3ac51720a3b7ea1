// What a board keeps across power cycles, as one set with one generation: the models in force, the values that 1010h
// saved last, and how the node is reached (LSS).
//
// A set is composed at once and written in pieces, one a call, so that no tick waits for the medium and no change
// can mix into a set that is being written. Models are stored when they come into force; everything else on an order
// (canopen::StoreOrder), which is answered when the set is durable.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/canopen/process_image.hpp"
#include "firmware/config/parameter_record.hpp"
#include "firmware/config/record_store.hpp"
#include "firmware/controller.hpp"
#include "firmware/ports/parameter_store.hpp"

namespace plenum {

class ParameterKeeper {
 public:
  /// Attempts on end to make models durable that must fail before store_failing is a fault.
  static constexpr std::uint8_t kFailuresForFault = 3;

  /// The medium must outlive the keeper.
  explicit ParameterKeeper(ports::ParameterStore& medium) noexcept : store_(medium) {}

  /// Before the first tick: hands the newest whole set to the controller. What this firmware cannot take is
  /// skipped and counted.
  void start(Controller& controller) noexcept;

  /// A model in force is not the stored one any more.
  void models_changed() noexcept { unsaved_ = true; }

  /// Between two ticks: one bounded piece of work. A set that could not be written is composed anew with the next
  /// call, and tried again.
  void step(Controller& controller) noexcept;

  /// True once, after a start that found a set or a slot damaged, or settings in it that this firmware does not admit.
  bool take_loss() noexcept;
  const config::LssSettings& lss() const noexcept { return lss_; }
  bool failing() const noexcept { return failures_on_end_ >= kFailuresForFault; }
  /// What object 2130h shows.
  canopen::StoreImage image() const noexcept;

 private:
  using Body = std::array<std::uint8_t, config::kMaxBodyBytes>;

  std::span<const std::uint8_t> kept() const noexcept { return std::span(body_[in_force_]).first(size_); }
  void read_name(const config::RecordRow& row) noexcept;
  void hand_to(Controller& controller) noexcept;
  /// Returns false when the set is larger than a slot.
  bool compose(const Controller& controller, const canopen::StoreOrder& order) noexcept;
  void collect(const Controller& controller, canopen::Kept group, const canopen::StoreOrder& order,
               config::RowWriter& next) noexcept;
  void finish(Controller& controller, ports::StoreResult result) noexcept;

  config::RecordStore store_;
  std::array<Body, 2> body_{};  ///< the set in force, and the one being written
  std::size_t in_force_ = 0;
  std::size_t size_ = 0;       ///< of the set in force
  std::size_t next_size_ = 0;  ///< of the other
  bool unsaved_ = false;
  bool writing_ = false;
  bool models_written_ = false;  ///< what is being written is to make unsaved models durable
  bool ordered_ = false;         ///< ... and carries out the order

  config::LssSettings lss_;
  config::LssSettings next_lss_;
  std::uint8_t saved_id_ = 0;  ///< the node id when communication parameters were saved; 0: never
  std::uint8_t next_saved_id_ = 0;

  config::LoadResult loaded_ = config::LoadResult::empty;
  bool loss_ = false;
  canopen::Restored skipped_;  ///< at the start
  std::uint32_t failures_ = 0;
  std::uint8_t failures_on_end_ = 0;
};

}  // namespace plenum
