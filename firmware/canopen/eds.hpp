// The electronic data sheet of the board (CiA 306), as object 1021h carries it and the host writes it to a file.
//
// No text is kept: each line is made from the object dictionary when it is read. What a reader finds in the sheet is
// therefore what the node answers to.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/canopen/communication.hpp"
#include "firmware/canopen/text_line.hpp"

namespace plenum::canopen {

/// Adds a value as the sheet has it: signed numbers in decimal, for hexadecimal ones are read with either sign by the tools.
void put_value(TextLine& line, DataType type, std::uint32_t bits) noexcept;

class DataSheet {
 public:
  /// `installed`: the settings that a reset without a stored set leads to, which are copied. `desk` and `recorder` are never
  /// asked: they complete the device whose defaults are read.
  DataSheet(const Identity& identity, const config::SettingsDesk& installed, config::ModelDesk& desk,
            telemetry::Recorder& recorder) noexcept;
  DataSheet(const DataSheet&) = delete;
  DataSheet& operator=(const DataSheet&) = delete;

  /// Bytes of the sheet from `offset` on; returns their count, 0 at the end. To be read forward; one may go back by
  /// kRepeat bytes, or to 0. Any other offset is answered as the end. Work: the lines that the bytes belong to, and
  /// kMarkEvery bytes and a line before them when going back.
  std::size_t read(std::uint32_t offset, std::span<std::uint8_t> bytes) noexcept;

  /// Bytes of the whole sheet. The first call makes every line once, about a millisecond of a PC: to be called before the
  /// first tick, and cheap ever after.
  std::uint32_t size() noexcept;

  /// The device whose defaults the sheet gives: node id 0, so that identifiers read as their bases.
  const Device& delivered() const noexcept { return device_; }

  static constexpr std::uint32_t kRepeat = 127 * 7;  ///< the longest block of an SDO block upload

 private:
  enum class Part : std::uint8_t { head, mandatory, optional, manufacturer, objects, end };

  /// A line of the sheet, and where it begins.
  struct Position {
    std::uint32_t offset = 0;
    Part part = Part::head;
    std::uint8_t instance = 0;
    std::uint8_t sub = 0;
    std::uint8_t line = 0;     ///< of an object's section
    bool whole = true;         ///< the section of the object, not of a sub-index
    std::uint16_t row = 0;     ///< the first of the object's rows
    std::uint16_t number = 0;  ///< line of the head, or of a list
  };

  void restart(const Position& at) noexcept;
  void go_back(std::uint32_t offset) noexcept;
  Position& mark(std::size_t age) noexcept;
  void advance() noexcept;
  void make_line(Position& at) noexcept;
  void head_line(Position& at) noexcept;
  void list_line(Position& at) noexcept;
  void object_line(Position& at) noexcept;
  static void to_next_section(Position& at) noexcept;
  void limit_line(std::string_view key, const Entry& entry, float limit) noexcept;
  void default_line(const Entry& entry, std::uint8_t instance, std::uint8_t sub) noexcept;

  Config delivered_;  ///< node id 0: what depends on it reads as its base
  ProcessImage image_;
  config::SettingsDesk settings_;
  Device device_;  ///< as delivered, read for the defaults
  TextLine line_;  ///< the one that begins at begun_, and next_ is where it ends
  Position begun_, next_;
  static constexpr std::uint32_t kMarkEvery = 16;
  /// Enough for kRepeat bytes behind the line that is being read: marks are never nearer to each other than kMarkEvery.
  static constexpr std::size_t kMarks = (kRepeat + 2 * TextLine::kCapacity) / kMarkEvery + 2;
  std::array<Position, kMarks> marks_{};  ///< a ring of places behind
  std::size_t newest_mark_ = 0;
  std::size_t held_marks_ = 1;
  std::uint32_t size_ = 0;
};

}  // namespace plenum::canopen
