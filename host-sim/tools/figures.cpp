#include "host-sim/tools/figures.hpp"

#include <cmath>
#include <utility>

namespace plenum::host::tools {
namespace {

constexpr double kKnown = 0.25;  // of the figure: a greater standard error leaves it open

bool open(const Figure& figure) {
  return !std::isnan(figure.standard_error) && !(figure.standard_error < kKnown * std::abs(figure.value));
}

}  // namespace

bool Figure::identified() const {
  return why_not.empty() && std::isfinite(value) && !open(*this);
}

std::string Figure::remark() const {
  return why_not.empty() && !identified() ? kNotTold : why_not;
}

std::string Figure::error_text() const {
  return std::isfinite(standard_error) ? fmt::format("{:.2g}", per_unit * standard_error) : std::string();
}

void print(const Output& output, const Figures& figures, int indent) {
  for (const Figure& of : figures) {
    const std::string error = of.error_text();
    std::string line =
        fmt::format("{:{}}{:<28} {:>12.6g} {:<12} {:<12} {}", "", indent, of.name, of.per_unit * of.value,
                    of.unit, error.empty() ? "" : "+- " + error, of.remark());
    line.erase(line.find_last_not_of(' ') + 1);
    output.print("{}\n", line);
  }
}

Json to_json(const Figures& figures) {
  Json json = Json::object();
  for (const Figure& of : figures) {
    Json& entry = json[of.key];
    entry = {{"value", number(of.value)},
             {"standard_error", number(of.standard_error)},
             {"identified", of.identified()}};
    if (!of.identified()) entry["why_not"] = of.remark();
  }
  return json;
}

report::Table table_of(const Figures& figures, std::string caption) {
  report::Table table{.caption = std::move(caption),
                      .columns = {"Figure", "Value", "Standard error", "These data say"},
                      .rows = {}};
  for (const Figure& of : figures) {
    const std::string error = of.error_text();
    table.rows.push_back({of.unit.empty() ? of.name : fmt::format("{} [{}]", of.name, of.unit),
                          fmt::format("{:.5g}", of.per_unit * of.value), error.empty() ? "-" : error,
                          of.identified() ? "identified" : of.remark()});
  }
  return table;
}

}  // namespace plenum::host::tools
