// A report: one self-contained HTML file that opens offline, with interactive charts.
//
//   Page page{"Chamber 3"};
//   page.lead("Identified from 100 s of excitation over CAN.");
//   page.tiles({{"Drift, 95th percentile", 3.1, "% of span", at_most(4.0)}});
//   page.section("Identification")
//       .paragraph("...")
//       .chart(LineChart{.title = "Pressure", .y = {"Pressure", "kPa"}, .curves = {{"measured", t_s,
//       p_kPa}}});
//   page.write("report.html");
//
// All text is plain text in UTF-8 and is escaped; the page holds no date and no path, so that equal content
// gives equal bytes.
#pragma once

#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "host-sim/report/chart.hpp"

namespace plenum::host::report {

/// The side of `limit` on which a tile's value is good.
struct Target {
  enum class Side { kAtMost, kAtLeast };
  double limit;
  Side side;
};
Target at_most(double limit);
Target at_least(double limit);

/// One figure of a summary. With a target the tile says whether it is met; a value that is not finite never
/// meets one.
struct Tile {
  std::string label;
  double value;
  std::string unit{};
  std::optional<Target> target{};
  std::string remark{};
};

/// A number to as many decimals as its column has.
struct Fixed {
  double value;
  int decimals;
};

/// A cell that is a number is set right-aligned: to four significant digits, or Fixed where its column is of one quantity.
using Cell = std::variant<std::string, double, Fixed>;

/// Every row is as long as `columns`; the unit belongs in the column's name.
struct Table {
  std::string caption;
  std::vector<std::string> columns;
  std::vector<std::vector<Cell>> rows;
};

struct Paragraph {
  std::string text;
};
/// A paragraph set apart: what the reader must not miss, such as what the data cannot tell.
struct Note {
  std::string text;
};
struct List {
  std::vector<std::string> items;
};
/// Charts side by side where the page is wide enough.
struct Row {
  std::vector<Chart> charts;
};
using Block = std::variant<Paragraph, Note, List, std::vector<Tile>, Table, Row>;

/// Blocks under one heading, in the order of the calls. The shapes of tables and charts are checked as they
/// are added: std::invalid_argument names the chart, the array, its length and the one expected.
class Section {
 public:
  enum class Place { kTop, kBelow };
  explicit Section(std::string title, Place place = Place::kTop);

  Section& paragraph(std::string text);
  Section& note(std::string text);
  Section& list(std::vector<std::string> items);
  Section& tiles(std::vector<Tile> tiles);
  Section& table(Table table);
  Section& chart(Chart chart);
  Section& row(std::vector<Chart> charts);

  const std::string& title() const { return title_; }
  Place place() const { return place_; }
  const std::vector<Block>& blocks() const { return blocks_; }

 private:
  std::string title_;
  Place place_;
  std::vector<Block> blocks_;
};

class Page {
 public:
  explicit Page(std::string title);

  /// What the page says, in a sentence or two under its title.
  Page& lead(std::string text);
  /// The summary at the top.
  Page& tiles(std::vector<Tile> tiles);
  /// What made the page, for its foot; "plenum" where nothing else is said.
  Page& made_by(std::string program);
  /// Appends a section. The reference lives as long as the page.
  Section& section(std::string title);
  /// Likewise; the contents have it below the section before it.
  Section& subsection(std::string title);

  std::string html() const;

  /// Writes the page to `path` whole or not at all. trace::InputError names the path and the system's reason.
  void write(const std::filesystem::path& path) const;

 private:
  std::string title_;
  std::string lead_;
  std::vector<Tile> tiles_;
  std::string made_by_ = "plenum";
  std::deque<Section> sections_;
};

}  // namespace plenum::host::report
