// The charts of a report, as plain values: what to show, never how to draw it.
//
// Every array is in the unit that its axis names; a non-finite value is a gap in the curve. Arrays travel as
// 32-bit floats (7 digits), and an array that several curves share is stored in the page once, an even grid
// as three numbers.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace plenum::host::report {

/// A quantity along an axis: `quantity` and `unit` are written as "quantity (unit)", the unit left out where
/// empty.
struct Axis {
  std::string quantity{};
  std::string unit{};
  std::optional<double> min{};  ///< fixed end of the axis, in `unit`; by default the data decide
  std::optional<double> max{};
  bool logarithmic = false;
};

enum class Stroke {
  kSolid,
  kDashed,
  kDotted,
  kSteps,   ///< the value holds until the next sample, as a command does
  kPoints,  ///< a dot a sample, no line
};

enum class Ink {
  kPalette,  ///< a colour of its own; curves of one name share it, within a chart and across the page
  kNeutral,  ///< the colour of the text, a thin line above the others: what they are compared with
  kFaint,    ///< thin grey: many curves of one kind behind those that matter
};

/// `y` over `x`, of equal length. Curves of one name share a colour and an entry of the legend.
struct Curve {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
  Stroke stroke = Stroke::kSolid;
  Ink ink = Ink::kPalette;
};

/// The area between `low` and `high` over `x`, all of equal length: a confidence or a tolerance.
struct Band {
  std::string name;
  std::vector<double> x;
  std::vector<double> low;
  std::vector<double> high;
};

/// A labelled straight line at a value of the x or the y axis: a limit, a target, an instant.
struct Mark {
  enum class On { kX, kY };
  On on = On::kY;
  double at = 0.0;
  std::string label;
};

/// Curves over a shared, rising axis, mostly time. Charts of one non-empty `group` share zoom and cursor.
struct LineChart {
  std::string title;
  std::string caption{};
  Axis x{"Time", "s"};
  Axis y;
  std::vector<Curve> curves{};
  std::vector<Band> bands{};
  std::vector<Mark> marks{};
  std::string group{};
};

/// Curves in the plane, in any order of x: valve areas over the command, hysteresis loops, scatter.
struct XyChart {
  std::string title;
  std::string caption{};
  Axis x;
  Axis y;
  std::vector<Curve> curves{};
  std::vector<Band> bands{};
  std::vector<Mark> marks{};
};

/// One bar a category and series. `values` are as long as `categories`.
struct BarChart {
  struct Bars {
    std::string name;
    std::vector<double> values;
  };
  std::string title;
  std::string caption{};
  std::vector<std::string> categories;
  Axis value;
  std::vector<Bars> series;
  std::vector<Mark> marks{};  ///< on the value axis only (Mark::On::kY)
};

/// `values[row][column]`, rows from the top, as long as `rows` and `columns`.
struct HeatMap {
  std::string title;
  std::string caption{};
  std::string row_quantity;
  std::vector<std::string> rows;
  std::string column_quantity;
  std::vector<std::string> columns;
  Axis value;
  std::vector<std::vector<double>> values;
};

/// How often the finite `samples` fall into each of `bins` equal intervals between the least and the
/// greatest.
struct Histogram {
  std::string title;
  std::string caption{};
  Axis value;
  std::vector<double> samples;
  std::size_t bins = 30;
  std::vector<Mark> marks{};  ///< on the value axis (Mark::On::kX)
};

using Chart = std::variant<LineChart, XyChart, BarChart, HeatMap, Histogram>;

}  // namespace plenum::host::report
