// The command line, as commands declare it and ask it. CLI11 reads it and stands in command_line.cpp alone: a source
// that includes CLI11 compiles the whole of it anew.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace plenum::host::tools {

/// An option, a flag or a positional of a command. A copy is the same one, and valid as long as the program.
class Option {
 public:
  /// What the help shows for a value in the place of TEXT: DIR, FILE.json. require_files_apart() knows files by it.
  Option& type_name(const std::string& name);
  /// The help shows what the variable holds now.
  Option& show_default();
  Option& required();
  /// A number from `least` to `most`, both included; nan is left to require_finite_numbers().
  Option& within(int least, int most);
  Option& within(unsigned least, unsigned most);
  Option& within(double least, double most);
  Option& not_negative();
  Option& one_of(const std::vector<std::string>& values);
  /// Of a list: takes one value each time that it is given, and not all that follow.
  Option& one_at_a_time();
  /// Its value may be left out: a number is 0 then.
  Option& value_optional();
  /// The help shows it under this title, after those without one.
  Option& group(const std::string& title);
  /// Not together with the option `name`, which is declared already.
  Option& excludes(const std::string& name);

  // Once the command line is read:

  bool given() const;
  /// As a message calls it: --out.
  std::string name() const;
  /// Without their dashes: out.
  std::vector<std::string> long_names() const;
  /// What the help shows for a value: the type's name, then what is checked.
  std::string type() const;
  /// As they were given; if none was, the default that the help shows.
  std::vector<std::string> values() const;
  /// Of an option that was given: its value, which is a number.
  double number() const;

 private:
  friend class Arguments;
  explicit Option(CLI::Option* option) : option_(option) {}

  CLI::Option* option_;
};

/// What can be given to a command. A copy is of the same command, and keeps the whole program.
class Arguments {
 public:
  /// Declares what is read into `value`, which has to live until then: "-o,--out", or a positional, "LOG". T is
  /// std::string, a std::vector of them, int, unsigned, std::uint64_t, double, or std::optional of int or double.
  template <class T>
  Option option(const std::string& names, T& value, const std::string& help);
  /// Likewise, without a value of its own: makes `value` true, and by a name such as "!--no-spool" false.
  Option flag(const std::string& names, bool& value, const std::string& help);
  /// Calls `then` as soon as the command line is read, whose variables it may change: may throw std::invalid_argument and InputError.
  void when_read(const std::function<void()>& then);
  /// What the help ends with.
  void footer(const std::string& text);
  /// Declares a command `name`, which `about` tells; one of them has to be given then.
  Arguments command(const std::string& name, const std::string& about);

  std::string name() const;

  // Once the command line is read:

  /// The command itself.
  bool given() const;
  /// Its option `name`.
  bool given(const std::string& name) const;
  /// Throws std::invalid_argument unless one of these is given, and no other: "nothing is said`to`, expected one of --a, --b".
  void require_one(const std::vector<std::string>& names, const std::string& to = "") const;
  /// All options, and those of its own commands that were given.
  std::vector<Option> options() const;

 protected:
  explicit Arguments(std::shared_ptr<CLI::App> app) : app_(std::move(app)) {}

  std::shared_ptr<CLI::App> app_;
};

/// A program, whose commands these are; --help and --version are its own.
class Program : public Arguments {
 public:
  Program(const std::string& name, const std::string& about, const std::string& version);

  /// Reads the command line. Returns false where it asks for the help or the version, which is printed then. Throws
  /// std::invalid_argument that says what is wrong with it, and what when_read() throws.
  bool parse(int argc, char** argv);
};

}  // namespace plenum::host::tools
