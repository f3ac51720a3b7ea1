// What the commands print: text for people, JSON for programs, progress for whoever waits.
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace plenum::host::tools {

class Arguments;

using Json = nlohmann::ordered_json;

/// A line on standard error that says how far the work is; silent unless that is a terminal. What Output prints takes its place.
class Progress {
 public:
  explicit Progress(std::string doing);
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void operator()(double done);  ///< as a share; not shown when the line is younger than 0.1 s
  void operator()(const std::string& what);

  /// Takes away the line that stands, if any.
  static void clear();

 private:
  void show(const std::string& line);

  static bool stands_;
  std::string doing_;
  bool terminal_;
  std::chrono::steady_clock::time_point shown_;
};

/// Text for people on standard output, and the same result as JSON where --json asks for it. With `--json -`
/// standard output is the JSON alone.
class Output {
 public:
  /// Declares --json.
  void add_to(Arguments& arguments);

  template <class... Args>
  void print(fmt::format_string<Args...> format, Args&&... args) const {
    if (json_ == "-") return;
    Progress::clear();
    fmt::print(format, std::forward<Args>(args)...);
  }
  /// A line that whoever waits for this program needs at once: on standard output, beside `--json -` on standard
  /// error.
  void announce(const std::string& line) const;
  /// Writes the JSON where it was asked for. Throws InputError when that cannot be written.
  void finish(const Json& result) const;

 private:
  std::string json_;
};

/// Makes the folder, and sees that files can be written there before any long work. Throws InputError.
void require_folder(const std::filesystem::path& folder);
/// The same folder; taken away again when it is new and nothing was written to it.
class OutputFolder {
 public:
  /// Throws InputError.
  explicit OutputFolder(std::filesystem::path folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

 private:
  std::filesystem::path folder_;
  bool is_new_;
};

/// Sees that `file` can be written. Throws InputError.
void require_writable(const std::filesystem::path& file);

/// Takes the place of standard streams that were closed, so that no file that is opened later gets what is printed:
/// what is printed on standard output fails, what is said on standard error goes nowhere.
void hold_closed_streams();
/// Sees that all that was printed so far is out. Throws InputError.
void require_printed();

/// "1 chamber", "8 chambers".
std::string counted(std::size_t count, std::string_view what);

/// A number, or null where it is not finite.
Json number(double value);
Json number(std::optional<double> value);

/// The footer of a command's help.
std::string example(const std::string& lines);

}  // namespace plenum::host::tools
