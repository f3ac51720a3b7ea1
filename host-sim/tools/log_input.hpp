// The logs that a command is given, and the rig they are of: --rig and --format.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host-sim/trace/log.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::tools {

class Arguments;
class Output;

class LogInput {
 public:
  /// Declares --rig, explained by `rig_help`, and --format.
  void add_to(Arguments& arguments, const std::string& rig_help);

  /// The rig of --rig, else the defaults; without one, ventilator runs are of their own supply. Throws
  /// trace::InputError, also for effects that the catalogue does not have.
  trace::RigDescription rig() const;
  bool has_rig() const { return !rig_file_.empty(); }
  bool of_ventilator() const;

  /// Each file as a log, with its name, and the last of its folders where an earlier one has the same name: a page holds no path.
  /// Once they are accepted, standard error tells what columns and rows are ignored, a supply that is not the rig's, and names of
  /// several chambers: a refusal is one line. Throws trace::InputError, also for other units than those of the columns' names.
  std::vector<trace::NamedLog> read(const std::vector<std::string>& files,
                                    const trace::RigDescription& rig) const;

  /// Each on a line of standard error, with the command's name.
  void tell(const std::vector<std::string>& notices) const;

  /// What the file of rig() does not state, and the values that it has instead.
  void print_assumed(const Output& output) const;

 private:
  trace::Log log_of(const std::string& file, const trace::RigDescription& rig) const;

  std::string command_;
  std::string format_ = "csv";
  std::string rig_file_;
  mutable std::set<std::string> names_;       ///< of logs that have been read
  mutable std::vector<std::string> notices_;  ///< to be told
  mutable std::vector<std::string> assumed_;
};

/// The number of the chamber that a log is of, where its name says so: chamber-3.csv.
std::optional<unsigned> chamber_in_name(const std::string& file);

}  // namespace plenum::host::tools
