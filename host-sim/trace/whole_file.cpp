#include "host-sim/trace/whole_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <system_error>

#include "host-sim/trace/input_error.hpp"

namespace plenum::host::trace {
namespace {

namespace fs = std::filesystem;

constexpr int kMostLinks = 40;  // as in Linux

/// The file that `path` leads to, which need not be there. Throws InputError.
fs::path behind_links(const fs::path& path) {
  fs::path target = path;
  std::error_code error;
  for (int links = 0; fs::is_symlink(fs::symlink_status(target, error)); ++links) {
    if (links == kMostLinks)
      throw InputError(fmt::format("{}: cannot be written: {}", path.string(), std::strerror(ELOOP)));
    target = target.parent_path() / fs::read_symlink(target, error);
  }
  return target;
}

/// Opens `file`, gives it `permissions`, writes. `asked` is the path in the InputError.
void write_into(const fs::path& file, const fs::path& asked, std::string_view bytes,
                std::optional<fs::perms> permissions = std::nullopt) {
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  if (!out) throw InputError(fmt::format("{}: cannot be written: {}", asked.string(), std::strerror(errno)));
  std::error_code error;
  if (permissions) fs::permissions(file, *permissions, error);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw InputError(fmt::format("{}: writing failed: {}", asked.string(), std::strerror(errno)));
}

}  // namespace

std::string read_whole_file(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    throw InputError(fmt::format("{}: is a directory, expected a file", path.string()));
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(fmt::format("{}: cannot be opened: {}", path.string(), std::strerror(errno)));
  std::string bytes;
  std::array<char, 65536> block{};
  do {
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    bytes.append(block.data(), static_cast<std::size_t>(file.gcount()));
  } while (file);
  if (file.bad())
    throw InputError(fmt::format("{}: reading failed: {}", path.string(), std::strerror(errno)));
  return bytes;
}

void write_whole_file(const fs::path& path, std::string_view bytes) {
  std::error_code error;
  const fs::file_status old = fs::status(path, error);
  if (fs::exists(old) && !fs::is_regular_file(old)) {
    write_into(path, path, bytes);
    return;
  }
  const fs::path target = behind_links(path);
  // Beside the target, so that the rename stays within one file system and is atomic.
  const fs::path temporary = target.string() + fmt::format(".{}.part", ::getpid());
  try {
    write_into(temporary, path, bytes, fs::exists(old) ? std::optional(old.permissions()) : std::nullopt);
    fs::rename(temporary, target, error);
    if (error) throw InputError(fmt::format("{}: cannot be written: {}", path.string(), error.message()));
  } catch (const InputError&) {
    fs::remove(temporary, error);
    throw;
  }
}

}  // namespace plenum::host::trace
