#include "host-sim/tools/reproduce_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace plenum::host::tools {

using report::Page;
using report::Section;
using report::Table;
using reproduce::Expect;
using reproduce::Finding;
using reproduce::Part;
using reproduce::Verdict;

namespace {

Table findings_table(const Part& part) {
  Table table{.caption = "",
              .columns = {"Where", "What", "Paper", "Ours", "Difference", "Unit", "Verdict"},
              .rows = {}};
  for (const Finding& of : part.findings) {
    const std::string stated =
        of.instead.empty() ? stated_text(of) : fmt::format("{} ({})", stated_text(of), of.instead);
    table.rows.push_back({of.item, of.quantity, stated, of.ours,
                          within_bound(of) ? report::Cell("within bound") : report::Cell(difference(of)),
                          of.unit, verdict_text(of)});
  }
  return table;
}

/// Why findings are not reproduced, those of one reason together.
std::vector<std::string> reasons(const Part& part) {
  std::vector<std::pair<std::string, std::string>> list;  // what, and the verdict with its reason
  for (const Finding& of : part.findings) {
    if (verdict(of) == Verdict::kReproduced) continue;
    const std::string what = fmt::format("{}, {}", of.item, of.quantity);
    const std::string why = fmt::format("{}. {}", name_of(verdict(of)), of.why);
    const auto same =
        std::find_if(list.begin(), list.end(), [&](const auto& other) { return other.second == why; });
    if (same == list.end()) {
      list.emplace_back(what, why);
    } else {
      same->first += "; " + what;
    }
  }
  std::vector<std::string> lines;
  lines.reserve(list.size());
  for (const auto& [what, why] : list) lines.push_back(fmt::format("{}: {}", what, why));
  return lines;
}

}  // namespace

std::string number_text(double value) {
  return std::isfinite(value) ? fmt::format("{:.5g}", value) : std::string("-");
}

std::string stated_text(const Finding& of) {
  return fmt::format("{}{}{}", of.expect == Expect::kNear ? "" : fmt::format("{} ", name_of(of.expect)),
                     number_text(of.paper),
                     of.tolerance > 0.0 ? fmt::format(" ± {}", number_text(of.tolerance)) : "");
}

std::string paper_text(const Finding& of) {
  return fmt::format("{} {}", of.instead.empty() ? "paper" : of.instead, stated_text(of));
}

bool within_bound(const Finding& of) {
  return of.expect != Expect::kNear && verdict(of) == Verdict::kReproduced;
}

std::string unit_text(const Finding& of) {
  return of.unit.empty() ? "" : " " + of.unit;
}

std::string verdicts_text(const std::vector<Part>& parts) {
  const auto counts = verdict_counts(parts);
  const int expected = reproduced_by_construction(parts);
  return fmt::format("{} reproduced{}, {} differ, {} where the paper contradicts itself",
                     counts.at(Verdict::kReproduced),
                     expected > 0 ? fmt::format(" ({} of them by construction)", expected) : "",
                     counts.at(Verdict::kDiffers), counts.at(Verdict::kPaperContradictsItself));
}

std::string verdict_text(const Finding& of) {
  const std::string_view name = name_of(verdict(of));
  return by_construction(of.source) ? fmt::format("{} ({})", name, name_of(of.source)) : std::string(name);
}

Page reproduce_page(const std::vector<Reproduced>& papers) {
  Page page("Five papers, reproduced");
  page.lead(
      "What the papers state that Plenum stands on, beside what their models and methods give here. A "
      "verdict follows "
      "from the two numbers and a tolerance, which comes from the digits printed or the noise stated. Where "
      "a constant of "
      "ours was set to the very number, or two forms of our own are compared, the table says so: such a "
      "finding is "
      "reproduced by construction and shows only that nothing slipped.");
  std::vector<report::Tile> tiles;
  for (const auto& [paper, parts] : papers) {
    const auto counts = verdict_counts(parts);
    tiles.push_back({fmt::format("Paper {}", paper->number),
                     static_cast<double>(counts.at(Verdict::kReproduced)),
                     "reproduced",
                     {},
                     fmt::format("{} differ, {} where the paper contradicts itself",
                                 counts.at(Verdict::kDiffers), counts.at(Verdict::kPaperContradictsItself))});
  }
  page.tiles(std::move(tiles));
  for (const auto& [paper, parts] : papers) {
    page.section(fmt::format("{}. {}", paper->number, paper->title)).paragraph(verdicts_text(parts) + ".");
    for (const Part& part : parts) {
      Section& section = page.subsection(part.title);
      section.paragraph(part.text);
      if (!part.findings.empty()) section.table(findings_table(part));
      const std::vector<std::string> why = reasons(part);
      if (!why.empty()) section.list(why);
      for (const report::Chart& chart : part.charts) section.chart(chart);
    }
  }
  return page;
}

}  // namespace plenum::host::tools
