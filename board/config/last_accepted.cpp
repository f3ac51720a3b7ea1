#include "board/config/last_accepted.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "board/drivers/slot_files.hpp"
#include "board/environment.hpp"
#include "firmware/config/crc32.hpp"

namespace plenum::board::config {
namespace {

constexpr off_t kMostBytes = off_t{1} << 20U;  ///< of a file that somebody has written by hand

std::string sealed(std::string_view text) {
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  return fmt::format("{}\n# CRC-32 of the lines above: {:08X}\n", text, plenum::config::crc32(bytes));
}

/// The text in what sealed() has made; empty: it is not as it was made.
std::optional<std::string> unsealed(std::string_view bytes) {
  static const std::size_t kSealSize = sealed("").size();
  if (bytes.size() < kSealSize) return std::nullopt;
  std::string text(bytes.substr(0, bytes.size() - kSealSize));
  return sealed(text) == bytes ? std::optional(std::move(text)) : std::nullopt;
}

/// A descriptor that is closed at the end.
class File {
 public:
  File(const std::filesystem::path& path, int flags)
      : file_(::open(path.c_str(), flags | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0644)) {}
  ~File() {
    if (file_ >= 0) ::close(file_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  bool is_open() const { return file_ >= 0; }
  int get() const { return file_; }

 private:
  int file_;
};

/// All of a regular file. `--safe` reads it as root in a folder that is the service's: no link, nothing that waits or has no
/// end. Sets errno where it is empty.
std::optional<std::string> contents(const std::filesystem::path& path) {
  const File file(path, O_RDONLY);
  struct stat status {};
  if (!file.is_open() || ::fstat(file.get(), &status) != 0) return std::nullopt;
  errno = EINVAL;
  if (!S_ISREG(status.st_mode) || status.st_size > kMostBytes) return std::nullopt;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(status.st_size));
  if (!drivers::read_at(file.get(), 0, bytes)) return std::nullopt;
  return std::string(bytes.begin(), bytes.end());
}

/// False: errno says why.
bool written(const std::filesystem::path& path, std::string_view bytes) {
  const File file(path, O_WRONLY | O_CREAT | O_TRUNC);
  const std::vector<std::uint8_t> all(bytes.begin(), bytes.end());
  return file.is_open() && drivers::write_at(file.get(), 0, all) && ::fsync(file.get()) == 0;
}

BoardFile read_accepted(const std::filesystem::path& path) {
  const std::optional<std::string> bytes = contents(path);
  if (!bytes)
    throw ConfigError(
        fmt::format("{}: {}, expected the board.toml accepted last", path.string(), std::strerror(errno)));
  const std::optional<std::string> text = unsealed(*bytes);
  if (!text)
    throw ConfigError(
        fmt::format("{}: is damaged, expected a last line with the CRC-32 of those above", path.string()));
  BoardFile board = parse_board(*text, path.string());
  board.settings.configuration_refused = true;
  return board;
}

}  // namespace

std::filesystem::path state_folder() {
  return environment("STATE_DIRECTORY");
}

std::filesystem::path last_accepted_path(const std::filesystem::path& folder) {
  return folder / "board.toml.accepted";
}

ChosenBoard choose_board(const std::filesystem::path& path, const std::filesystem::path& folder) {
  std::string refusal;
  try {
    return {.board = read_board(path), .refusal = ""};
  } catch (const ConfigError& error) {
    std::error_code unreadable;
    if (folder.empty() || !std::filesystem::exists(last_accepted_path(folder), unreadable)) throw;
    refusal = error.what();
  }
  const std::filesystem::path kept = last_accepted_path(folder);
  try {
    BoardFile board = read_accepted(kept);
    return {
        .board = std::move(board),
        .refusal = fmt::format("{}\n{}: was accepted last, and stands in for it: outputs safe, fault 6320h",
                               refusal, kept.string())};
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("{}\n{}", refusal, error.what()));
  }
}

std::optional<BoardFile> kept_in(const std::filesystem::path& folder) {
  if (folder.empty()) return std::nullopt;
  try {
    return read_accepted(last_accepted_path(folder));
  } catch (const ConfigError&) {
    return std::nullopt;
  }
}

std::string keep_accepted(std::string_view text, const std::filesystem::path& folder) {
  if (folder.empty()) return "";
  const std::filesystem::path path = last_accepted_path(folder);
  const std::string bytes = sealed(text);
  if (contents(path) == bytes) return "";
  std::filesystem::path beside = path;
  beside += ".new";
  if (written(beside, bytes) && ::rename(beside.c_str(), path.c_str()) == 0 && drivers::sync_folder(folder))
    return "";
  return fmt::format("{}: {}, expected a folder that this user may write, with room for a board.toml",
                     path.string(), std::strerror(errno));
}

}  // namespace plenum::board::config
