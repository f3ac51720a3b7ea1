// The board.toml that plenumd has run by last, kept for the day on which the installer's is refused: that day the board still
// knows its bus, its address and where its outputs rest, and can be asked what is wrong.
//
// Text as it was read, and below it a comment with the text's CRC-32: a digit that has changed is no limit that anybody has set.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "board/config/board_file.hpp"

namespace plenum::board::config {

/// $STATE_DIRECTORY, as the service manager says it: /var/lib/plenum. Empty without one; then nothing is kept, and nothing
/// stands in for a file that is refused.
std::filesystem::path state_folder();

/// The file in that folder.
std::filesystem::path last_accepted_path(const std::filesystem::path& folder);

struct ChosenBoard {
  BoardFile board;
  std::string
      refusal;  ///< what was wrong with the installer's file, and what stands in for it, a line each; empty: nothing
};

/// The installer's file; where that is refused, the last accepted one of `folder`, with Settings::configuration_refused. Throws
/// ConfigError where there is neither: what is wrong with the former, and on a second line what is wrong with the latter.
ChosenBoard choose_board(const std::filesystem::path& path, const std::filesystem::path& folder);

/// What is kept in `folder`; nothing where that is empty, or has none that is whole.
std::optional<BoardFile> kept_in(const std::filesystem::path& folder);

/// Keeps `text` in `folder`, all of it or none, whenever the power fails. Writes nothing where it is kept already, or where
/// `folder` is empty. Returns what failed, with the file and what was expected; empty: nothing.
std::string keep_accepted(std::string_view text, const std::filesystem::path& folder);

}  // namespace plenum::board::config
