#include "host-sim/trace/whole_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "host-sim/trace/input_error.hpp"

namespace plenum::host::trace {

std::string read_whole_file(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
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

void write_whole_file(const std::filesystem::path& path, std::string_view bytes) {
  // Beside the target, so that the rename stays within one file system and is atomic.
  const std::filesystem::path temporary = path.string() + fmt::format(".{}.part", ::getpid());
  std::error_code ignored;
  {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    if (!file)
      throw InputError(fmt::format("{}: cannot be written: {}", path.string(), std::strerror(errno)));
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) {
      const int cause = errno;
      std::filesystem::remove(temporary, ignored);
      throw InputError(fmt::format("{}: writing failed: {}", path.string(), std::strerror(cause)));
    }
  }
  std::error_code error;
  std::filesystem::rename(temporary, path, error);
  if (error) {
    std::filesystem::remove(temporary, ignored);
    throw InputError(fmt::format("{}: cannot be written: {}", path.string(), error.message()));
  }
}

}  // namespace plenum::host::trace
