#include "host-sim/tools/output.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <system_error>

#include "host-sim/tools/command_line.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::tools {

void Output::add_to(Arguments& arguments) {
  arguments.option("--json", json_, "Write the result as JSON to this file; - for standard output")
      .type_name("FILE");
}

void Output::announce(const std::string& line) const {
  std::FILE* file = json_ == "-" ? stderr : stdout;
  fmt::print(file, "{}\n", line);
  std::fflush(file);
}

void Output::finish(const Json& result) const {
  if (json_.empty()) return;
  // a file's name may be no UTF-8, which JSON cannot hold
  const std::string text = result.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
  if (json_ == "-") {
    fmt::print("{}", text);
  } else {
    trace::write_whole_file(json_, text);
  }
}

Progress::Progress(std::string doing) : doing_(std::move(doing)), terminal_(::isatty(STDERR_FILENO) != 0) {
  show(doing_);
}

bool Progress::stands_ = false;

void Progress::clear() {
  if (stands_) fmt::print(stderr, "\r\033[K");
  stands_ = false;
}

void Progress::operator()(double done) {
  const bool is_young = std::chrono::steady_clock::now() - shown_ < std::chrono::milliseconds(100);
  if (terminal_ && !is_young) show(fmt::format("{} {:.0f} %", doing_, 100.0 * done));
}

void Progress::operator()(const std::string& what) {
  if (terminal_) show(fmt::format("{}: {}", doing_, what));
}

void Progress::show(const std::string& line) {
  if (!terminal_) return;
  constexpr std::size_t kColumns = 79;  // a line that wraps could not be taken back
  shown_ = std::chrono::steady_clock::now();
  stands_ = true;
  fmt::print(stderr, "\r\033[K{:.{}}", line, kColumns);
  std::fflush(stderr);
}

void require_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw trace::InputError(fmt::format("{}: cannot be made: {}, expected a folder to write to",
                                        folder.string(), error ? error.message() : "it is a file"));
  }
  require_writable(folder / "plenum");
}

OutputFolder::OutputFolder(std::filesystem::path folder)
    : folder_(std::move(folder)), is_new_(!std::filesystem::exists(folder_)) {
  require_folder(folder_);
}

OutputFolder::~OutputFolder() {
  std::error_code not_empty;
  if (is_new_) std::filesystem::remove(folder_, not_empty);
}

void require_writable(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::path folder = file.parent_path().empty() ? "." : file.parent_path();
  if (std::filesystem::is_directory(file, error)) {
    throw trace::InputError(fmt::format("{}: is a folder, expected a file to write", file.string()));
  }
  const std::filesystem::file_status there = std::filesystem::status(file, error);
  if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there)) {
    if (::access(file.c_str(), W_OK) == 0) return;
    throw trace::InputError(fmt::format("{}: not writable, expected a file to write", file.string()));
  }
  if (!std::filesystem::is_directory(folder, error)) {
    throw trace::InputError(
        fmt::format("{}: there is no such folder, expected one to write to", folder.string()));
  }
  if (::access(folder.c_str(), W_OK) != 0) {
    throw trace::InputError(fmt::format("{}: not writable, expected a folder to write to", folder.string()));
  }
}

void hold_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) != -1) continue;
    // Takes the least number that is free, which is this one's.
    static_cast<void>(::open("/dev/null", stream == STDOUT_FILENO ? O_RDONLY : O_WRONLY));
  }
}

void require_printed() {
  if (std::fflush(stdout) != 0)
    throw trace::InputError(fmt::format("standard output: cannot be written: {}", std::strerror(errno)));
  if (std::ferror(stdout) != 0)
    throw trace::InputError("standard output: a part of it could not be written, expected all of it");
}

std::string counted(std::size_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json number(std::optional<double> value) {
  return value ? number(*value) : Json(nullptr);
}

std::string example(const std::string& lines) {
  return "Example:\n" + lines;
}

}  // namespace plenum::host::tools
