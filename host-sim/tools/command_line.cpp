#include "host-sim/tools/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <type_traits>

namespace plenum::host::tools {
namespace {

/// CLI11's, but for what only its own user can read.
class HelpText : public CLI::Formatter {
 public:
  HelpText() { label("SUBCOMMAND", "COMMAND"); }
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override {
    constexpr std::string_view kNegated = "{false}";
    std::string name = Formatter::make_option_name(option, is_positional);
    if (const std::size_t at = name.find(kNegated); at != std::string::npos) name.erase(at, kNegated.size());
    return name;
  }
  std::string make_option_opts(const CLI::Option* option) const override {
    constexpr std::string_view kMore = " ...";
    std::string text = Formatter::make_option_opts(option);
    if (!option->get_allow_extra_args() && text.ends_with(kMore)) text.erase(text.size() - kMore.size());
    return text;
  }
};

}  // namespace

Option& Option::type_name(const std::string& name) {
  option_->type_name(name);
  return *this;
}

Option& Option::show_default() {
  option_->capture_default_str();
  return *this;
}

Option& Option::required() {
  option_->required();
  return *this;
}

Option& Option::within(int least, int most) {
  option_->check(CLI::Range(least, most, fmt::format("{}..{}", least, most)));
  return *this;
}

Option& Option::within(unsigned least, unsigned most) {
  option_->check(CLI::Range(least, most, fmt::format("{}..{}", least, most)));
  return *this;
}

Option& Option::within(double least, double most) {
  option_->check(CLI::Range(least, most, fmt::format("{}..{}", least, most)));
  return *this;
}

Option& Option::not_negative() {
  option_->check(CLI::Validator(CLI::NonNegativeNumber).description(">=0"));
  return *this;
}

Option& Option::one_of(const std::vector<std::string>& values) {
  option_->check(CLI::IsMember(values));
  return *this;
}

Option& Option::one_at_a_time() {
  option_->allow_extra_args(false);
  return *this;
}

Option& Option::value_optional() {
  option_->expected(0, 1);
  return *this;
}

Option& Option::group(const std::string& title) {
  option_->group(title);
  return *this;
}

Option& Option::excludes(const std::string& name) {
  option_->excludes(name);
  return *this;
}

bool Option::given() const {
  return option_->count() > 0;
}

std::string Option::name() const {
  return option_->get_name();
}

std::vector<std::string> Option::long_names() const {
  return option_->get_lnames();
}

std::string Option::type() const {
  return option_->get_type_name();
}

std::vector<std::string> Option::values() const {
  if (given()) return option_->results();
  const std::string standard = option_->get_default_str();
  return standard.empty() ? std::vector<std::string>{} : std::vector<std::string>{standard};
}

double Option::number() const {
  return option_->as<double>();
}

template <class T>
Option Arguments::option(const std::string& names, T& value, const std::string& help) {
  Option option(app_->add_option(names, value, help));
  if constexpr (std::is_unsigned_v<T>) option.type_name("INT");
  return option;
}
template Option Arguments::option(const std::string&, std::string&, const std::string&);
template Option Arguments::option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Arguments::option(const std::string&, int&, const std::string&);
template Option Arguments::option(const std::string&, unsigned&, const std::string&);
template Option Arguments::option(const std::string&, std::uint64_t&, const std::string&);
template Option Arguments::option(const std::string&, double&, const std::string&);
template Option Arguments::option(const std::string&, std::optional<int>&, const std::string&);
template Option Arguments::option(const std::string&, std::optional<double>&, const std::string&);

Option Arguments::flag(const std::string& names, bool& value, const std::string& help) {
  return Option(app_->add_flag(names, value, help));
}

void Arguments::when_read(const std::function<void()>& then) {
  app_->callback(then);
}

void Arguments::footer(const std::string& text) {
  app_->footer(text);
}

Arguments Arguments::command(const std::string& name, const std::string& about) {
  app_->require_subcommand(1);
  return Arguments(std::shared_ptr<CLI::App>(app_, app_->add_subcommand(name, about)->group("Commands")));
}

std::string Arguments::name() const {
  return app_->get_name();
}

bool Arguments::given() const {
  return app_->parsed();
}

bool Arguments::given(const std::string& name) const {
  return app_->count(name) > 0;
}

void Arguments::require_one(const std::vector<std::string>& names, const std::string& to) const {
  const auto count =
      std::count_if(names.begin(), names.end(), [this](const auto& name) { return given(name); });
  if (count == 1) return;
  throw std::invalid_argument(fmt::format("{}{}, expected one of {}",
                                          count == 0 ? "nothing is said" : "several things are said", to,
                                          fmt::join(names, ", ")));
}

std::vector<Option> Arguments::options() const {
  std::vector<Option> all;
  for (CLI::Option* const option : app_->get_options()) all.push_back(Option(option));
  for (CLI::App* const command : app_->get_subcommands()) {
    const std::vector<Option> more = Arguments(std::shared_ptr<CLI::App>(app_, command)).options();
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

Program::Program(const std::string& name, const std::string& about, const std::string& version)
    : Arguments(std::make_shared<CLI::App>(about, name)) {
  app_->formatter(std::make_shared<HelpText>());
  app_->set_version_flag("--version", version, "Print the version and exit");
}

bool Program::parse(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
    return true;
  } catch (const CLI::Success& asked) {
    app_->exit(asked);
    return false;
  } catch (const CLI::ParseError& error) {
    throw std::invalid_argument(error.what());
  }
}

}  // namespace plenum::host::tools
