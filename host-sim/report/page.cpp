#include "host-sim/report/page.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "host-sim/report/assets.hpp"
#include "host-sim/report/chart_json.hpp"
#include "host-sim/report/encoding.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::report {
namespace {

using Json = nlohmann::ordered_json;

bool is_met(double value, const Target& target) {
  return target.side == Target::Side::kAtMost ? value <= target.limit : value >= target.limit;
}

// ---- one function a kind of block; each returns HTML

std::string tiles_html(const std::vector<Tile>& tiles) {
  std::string html = "<dl class=\"tiles\">\n";
  for (const Tile& tile : tiles) {
    html += fmt::format("<div class=\"tile{}\"><dt>{}</dt><dd><span class=\"value\">{}</span>",
                        !tile.target                       ? ""
                        : is_met(tile.value, *tile.target) ? " met"
                                                           : " missed",
                        escape_html(tile.label), significant(tile.value));
    if (!tile.unit.empty()) html += fmt::format(" <span class=\"unit\">{}</span>", escape_html(tile.unit));
    html += "</dd>";
    if (tile.target)
      html += fmt::format(
          "<dd class=\"target\"><span class=\"verdict\">{}</span> "
          "<span class=\"limit\">limit {} {}</span></dd>",
          is_met(tile.value, *tile.target) ? "✓ pass" : "✗ fail",
          tile.target->side == Target::Side::kAtMost ? "≤" : "≥", significant(tile.target->limit));
    if (!tile.remark.empty()) html += fmt::format("<dd class=\"remark\">{}</dd>", escape_html(tile.remark));
    html += "</div>\n";
  }
  return html + "</dl>\n";
}

std::string text_of(const std::string& cell) {
  return escape_html(cell);
}
std::string text_of(double cell) {
  return significant(cell);
}
std::string text_of(const Fixed& cell) {
  return fixed(cell.value, cell.decimals);
}

bool is_number(const Cell& cell) {
  return !std::holds_alternative<std::string>(cell);
}

std::string cell_html(const Cell& cell) {
  return fmt::format("<td{}>{}</td>", is_number(cell) ? " class=\"number\"" : "",
                     std::visit([](const auto& c) { return text_of(c); }, cell));
}

// A column's name stands over its cells: to the right where the first row holds a number.
std::string table_html(const Table& table) {
  std::string html = "<div class=\"table\" tabindex=\"0\"><table>\n";
  if (!table.caption.empty()) html += fmt::format("<caption>{}</caption>\n", escape_html(table.caption));
  html += "<thead><tr>";
  for (std::size_t column = 0; column < table.columns.size(); ++column) {
    const bool number = !table.rows.empty() && is_number(table.rows.front()[column]);
    html += fmt::format("<th scope=\"col\"{}>{}</th>", number ? " class=\"number\"" : "",
                        escape_html(table.columns[column]));
  }
  html += "</tr></thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    html += "<tr>";
    for (const Cell& cell : row) html += cell_html(cell);
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

// The markup of a page, and beside it the data of its charts in the order of their figures.
class Markup {
 public:
  std::string of(const Paragraph& block) { return "<p>" + escape_html(block.text) + "</p>\n"; }
  std::string of(const Note& block) { return "<p class=\"note\">" + escape_html(block.text) + "</p>\n"; }
  std::string of(const std::vector<Tile>& block) { return tiles_html(block); }
  std::string of(const Table& block) { return table_html(block); }

  std::string of(const List& block) {
    std::string html = "<ul>\n";
    for (const std::string& item : block.items) html += "<li>" + escape_html(item) + "</li>\n";
    return html + "</ul>\n";
  }

  std::string of(const Row& block) {
    std::string html = "<div class=\"row\">\n";
    for (const Chart& chart : block.charts) html += figure(chart);
    return html + "</div>\n";
  }

  std::string of(const Section& section, std::size_t number) {
    std::string html =
        fmt::format("<section id=\"s{}\">\n<h2>{}</h2>\n", number, escape_html(section.title()));
    for (const Block& block : section.blocks())
      html += std::visit([this](const auto& b) { return of(b); }, block);
    return html + "</section>\n";
  }

  Json data() const { return {{"arrays", pool_.json()}, {"charts", charts_}}; }

 private:
  std::string figure(const Chart& chart) {
    charts_.push_back(to_json(chart, pool_));
    std::string html =
        fmt::format("<figure><h3>{0}</h3><div class=\"plot\" role=\"img\" aria-label=\"{0}\"></div>",
                    escape_html(title_of(chart)));
    if (!caption_of(chart).empty())
      html += fmt::format("<figcaption>{}</figcaption>", escape_html(caption_of(chart)));
    return html + "</figure>\n";
  }

  ArrayPool pool_;
  Json charts_ = Json::array();
};

std::string contents_html(const std::deque<Section>& sections) {
  if (sections.size() < 3) return "";
  std::string html = "<nav aria-label=\"Sections\">\n";
  bool below = false;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const bool goes_below = sections[i].place() == Section::Place::kBelow;
    if (goes_below != below) html += goes_below ? "<div class=\"below\">\n" : "</div>\n";
    below = goes_below;
    html += fmt::format("<a href=\"#s{}\">{}</a>\n", i + 1, escape_html(sections[i].title()));
  }
  return html + (below ? "</div>\n</nav>\n" : "</nav>\n");
}

}  // namespace

Target at_most(double limit) {
  return {limit, Target::Side::kAtMost};
}
Target at_least(double limit) {
  return {limit, Target::Side::kAtLeast};
}

Section::Section(std::string title, Place place) : title_(std::move(title)), place_(place) {}

Section& Section::paragraph(std::string text) {
  blocks_.emplace_back(Paragraph{std::move(text)});
  return *this;
}

Section& Section::note(std::string text) {
  blocks_.emplace_back(Note{std::move(text)});
  return *this;
}

Section& Section::list(std::vector<std::string> items) {
  blocks_.emplace_back(List{std::move(items)});
  return *this;
}

Section& Section::tiles(std::vector<Tile> tiles) {
  blocks_.emplace_back(std::move(tiles));
  return *this;
}

Section& Section::table(Table table) {
  for (std::size_t row = 0; row < table.rows.size(); ++row)
    if (table.rows[row].size() != table.columns.size())
      throw std::invalid_argument(fmt::format("report: table '{}': row {} has {} cells, expected {}",
                                              table.caption, row + 1, table.rows[row].size(),
                                              table.columns.size()));
  blocks_.emplace_back(std::move(table));
  return *this;
}

Section& Section::chart(Chart chart) {
  std::vector<Chart> charts;
  charts.push_back(std::move(chart));
  return row(std::move(charts));
}

Section& Section::row(std::vector<Chart> charts) {
  for (const Chart& chart : charts) require_consistent(chart);
  blocks_.emplace_back(Row{std::move(charts)});
  return *this;
}

Page::Page(std::string title) : title_(std::move(title)) {}

Page& Page::lead(std::string text) {
  lead_ = std::move(text);
  return *this;
}

Page& Page::tiles(std::vector<Tile> tiles) {
  tiles_ = std::move(tiles);
  return *this;
}

Page& Page::made_by(std::string program) {
  made_by_ = std::move(program);
  return *this;
}

Section& Page::section(std::string title) {
  return sections_.emplace_back(std::move(title));
}

Section& Page::subsection(std::string title) {
  return sections_.emplace_back(std::move(title), Section::Place::kBelow);
}

std::string Page::html() const {
  Markup markup;
  std::string sections;
  for (std::size_t i = 0; i < sections_.size(); ++i) sections += markup.of(sections_[i], i + 1);

  std::string html;
  const auto add = [&html](std::string_view text) { html += text; };
  add("<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<title>");
  add(escape_html(title_));
  add("</title>\n<style>\n");
  add(page_style());
  // Before the first paint, so that a dark system sees no white flash while the charts' script is read.
  add("</style>\n<script>document.documentElement.dataset.theme = "
      "matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : "
      "'light';</script>\n</head>\n<body>\n<header>\n<button type=\"button\" id=\"theme\" "
      "hidden></button>\n<h1>");
  add(escape_html(title_));
  add("</h1>\n");
  if (!lead_.empty()) add("<p class=\"lead\">" + escape_html(lead_) + "</p>\n");
  if (!tiles_.empty()) add(tiles_html(tiles_));
  add(contents_html(sections_));
  add("</header>\n<main>\n<noscript><p class=\"note\">The charts need JavaScript; the tables do "
      "not.</p></noscript>\n");
  add(sections);
  add("</main>\n<footer>Made by " + escape_html(made_by_));
  add(". Charts by Apache ECharts (Apache-2.0), with ZRender (BSD-3-Clause) "
      "and tslib (0BSD); "
      "drag to zoom, double-click to reset; open the page with #svg at the end of its address for vector "
      "graphics.</footer>\n"
      "<script type=\"application/json\" id=\"page-data\">");
  add(script_safe(markup.data()));
  add("</script>\n<script>\n");
  add(echarts_script());
  add("\n</script>\n<script>\n");
  add(page_script());
  add("</script>\n</body>\n</html>\n");
  return html;
}

void Page::write(const std::filesystem::path& path) const {
  trace::write_whole_file(path, html());
}

}  // namespace plenum::host::report
