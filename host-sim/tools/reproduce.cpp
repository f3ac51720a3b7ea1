#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>

#include "host-sim/reproduce/findings_json.hpp"
#include "host-sim/reproduce/papers.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/report_file.hpp"
#include "host-sim/tools/reproduce_report.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::tools {
namespace {

using reproduce::Finding;
using reproduce::Paper;
using reproduce::Part;
using reproduce::Verdict;

struct Options {
  std::optional<int> paper;  ///< by default all
  std::string report;
  Output output;
};

std::vector<const Paper*> chosen(std::optional<int> number) {
  std::vector<const Paper*> all;
  std::string known;
  for (const Paper& paper : reproduce::papers()) {
    if (!number || paper.number == *number) all.push_back(&paper);
    known += fmt::format("{}{} ({})", known.empty() ? "" : ", ", paper.number, paper.title);
  }
  if (all.empty()) throw trace::InputError(fmt::format("--paper: {} is none, expected {}", *number, known));
  return all;
}

/// Words in lines of 100 columns at most, unless one word is longer, each indented by two.
std::string wrapped(const std::string& text) {
  constexpr std::size_t kColumns = 100;
  constexpr std::string_view kIndent = "  ";
  std::string lines;
  std::size_t column = 0;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const auto width = static_cast<std::size_t>(std::count_if(
        word.begin(), word.end(), [](char c) { return (static_cast<unsigned char>(c) >> 6U) != 2U; }));
    const bool first = column == 0;
    if (first || column + 1 + width > kColumns) {
      lines += first ? "" : "\n";
      lines += kIndent;
      column = kIndent.size() + width;
    } else {
      lines += ' ';
      column += 1 + width;
    }
    lines += word;
  }
  return lines;
}

void print(const Output& output, const Part& part) {
  output.print("\n  {}\n{}\n", part.title, wrapped(part.text));
  for (const Finding& of : part.findings) {
    const Verdict verdict = reproduce::verdict(of);
    output.print("    {:<14} {}\n", of.item, of.quantity);
    output.print(
        "    {:<14} {}{}, ours {}, {}: {}{}\n", "", paper_text(of), unit_text(of), number_text(of.ours),
        within_bound(of) ? "within bound" : fmt::format("difference {}", number_text(difference(of))),
        verdict_text(of), verdict == Verdict::kReproduced ? "" : fmt::format(". {}", of.why));
  }
}

int run(const Options& options) {
  const std::vector<const Paper*> papers = chosen(options.paper);
  std::vector<Reproduced> all;
  {
    Progress progress("reproducing");
    for (std::size_t i = 0; i < papers.size(); ++i) {
      const auto tell = [&](double share) {
        progress((static_cast<double>(i) + share) / static_cast<double>(papers.size()));
      };
      all.push_back({papers[i], papers[i]->reproduce(tell)});
    }
  }
  Json json = Json::array();
  for (const auto& [paper, parts] : all) {
    options.output.print("{}. {}\n", paper->number, paper->title);
    for (const Part& part : parts) print(options.output, part);
    options.output.print("\n");
    json.push_back(reproduce::to_json(*paper, parts));
  }
  for (const auto& [paper, parts] : all) {
    options.output.print("paper {}: {}\n", paper->number, verdicts_text(parts));
  }
  write_report(options.output, options.report, [&] { return reproduce_page(all); });
  options.output.finish({{"schema", "plenum-reproduce/1"}, {"papers", json}});
  return kDone;
}

}  // namespace

Command add_reproduce(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "reproduce", "Set what five papers state beside what their models and methods give here");
  arguments.option("--paper", options->paper, "Only this one, from 1 (default: all)").type_name("N");
  arguments.option("--report", options->report, "Page to write (default: none)").type_name("FILE.html");
  options->output.add_to(arguments);
  arguments.footer(example("  plenum reproduce --paper 4 --report papers.html"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
