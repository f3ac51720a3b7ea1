#include "host-sim/report/chart_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plenum::host::report {
namespace {

using Json = nlohmann::ordered_json;

// ---- shapes

void require_length(const std::string& chart, const std::string& array, std::size_t found,
                    std::size_t expected) {
  if (found != expected)
    throw std::invalid_argument(
        fmt::format("report: chart '{}': {} has {} values, expected {}", chart, array, found, expected));
}

template <class Lines>
void require_curves(const Lines& chart) {
  for (const Curve& curve : chart.curves)
    require_length(chart.title, "y of curve '" + curve.name + "'", curve.y.size(), curve.x.size());
  for (const Band& band : chart.bands) {
    require_length(chart.title, "low of band '" + band.name + "'", band.low.size(), band.x.size());
    require_length(chart.title, "high of band '" + band.name + "'", band.high.size(), band.x.size());
  }
}

void require_shape(const LineChart& chart) {
  require_curves(chart);
}
void require_shape(const XyChart& chart) {
  require_curves(chart);
}

void require_shape(const BarChart& chart) {
  for (const BarChart::Bars& bars : chart.series)
    require_length(chart.title, "series '" + bars.name + "'", bars.values.size(), chart.categories.size());
}

void require_shape(const HeatMap& chart) {
  require_length(chart.title, "the column of rows", chart.values.size(), chart.rows.size());
  for (std::size_t row = 0; row < chart.values.size(); ++row)
    require_length(chart.title, "row '" + chart.rows[row] + "'", chart.values[row].size(),
                   chart.columns.size());
}

void require_shape(const Histogram& chart) {
  if (chart.bins == 0)
    throw std::invalid_argument(fmt::format("report: chart '{}': 0 bins, expected at least 1", chart.title));
}

// ---- JSON

Json axis_json(const Axis& axis) {
  Json json{{"quantity", axis.quantity}, {"unit", axis.unit}};
  if (axis.min) json["min"] = *axis.min;
  if (axis.max) json["max"] = *axis.max;
  if (axis.logarithmic) json["log"] = true;
  return json;
}

const char* word(Stroke stroke) {
  switch (stroke) {
    case Stroke::kSolid:
      return "solid";
    case Stroke::kDashed:
      return "dashed";
    case Stroke::kDotted:
      return "dotted";
    case Stroke::kSteps:
      return "steps";
    case Stroke::kPoints:
      return "points";
  }
  throw std::invalid_argument("report: unknown stroke");
}

const char* word(Ink ink) {
  switch (ink) {
    case Ink::kPalette:
      return "palette";
    case Ink::kNeutral:
      return "neutral";
    case Ink::kFaint:
      return "faint";
  }
  throw std::invalid_argument("report: unknown ink");
}

Json marks_json(const std::vector<Mark>& marks) {
  Json json = Json::array();
  for (const Mark& mark : marks)
    json.push_back({{"on", mark.on == Mark::On::kX ? "x" : "y"}, {"at", mark.at}, {"label", mark.label}});
  return json;
}

template <class Lines>
Json lines_json(const char* kind, const Lines& chart, ArrayPool& pool) {
  Json curves = Json::array();
  for (const Curve& curve : chart.curves)
    curves.push_back({{"name", curve.name},
                      {"x", pool.add(curve.x)},
                      {"y", pool.add(curve.y)},
                      {"stroke", word(curve.stroke)},
                      {"ink", word(curve.ink)}});
  Json bands = Json::array();
  for (const Band& band : chart.bands)
    bands.push_back({{"name", band.name},
                     {"x", pool.add(band.x)},
                     {"low", pool.add(band.low)},
                     {"high", pool.add(band.high)}});
  return {{"kind", kind},     {"x", axis_json(chart.x)}, {"y", axis_json(chart.y)},
          {"curves", curves}, {"bands", bands},          {"marks", marks_json(chart.marks)}};
}

Json json_of(const LineChart& chart, ArrayPool& pool) {
  Json json = lines_json("line", chart, pool);
  json["group"] = chart.group;
  return json;
}

Json json_of(const XyChart& chart, ArrayPool& pool) {
  return lines_json("xy", chart, pool);
}

Json json_of(const BarChart& chart, ArrayPool& pool) {
  Json series = Json::array();
  for (const BarChart::Bars& bars : chart.series)
    series.push_back({{"name", bars.name}, {"values", pool.add(bars.values)}});
  return {{"kind", "bar"},
          {"categories", chart.categories},
          {"value", axis_json(chart.value)},
          {"series", series},
          {"marks", marks_json(chart.marks)}};
}

Json json_of(const HeatMap& chart, ArrayPool& pool) {
  std::vector<double> cells;
  for (const auto& row : chart.values) cells.insert(cells.end(), row.begin(), row.end());
  return {{"kind", "heat"},
          {"rows", chart.rows},
          {"row_quantity", chart.row_quantity},
          {"columns", chart.columns},
          {"column_quantity", chart.column_quantity},
          {"value", axis_json(chart.value)},
          {"cells", pool.add(cells)}};
}

Json json_of(const Histogram& chart, ArrayPool& pool) {
  std::vector<double> samples = chart.samples;
  std::erase_if(samples, [](double v) { return !std::isfinite(v); });
  std::vector<double> edges;
  std::vector<double> counts;
  if (!samples.empty()) {
    const auto [least, greatest] = std::ranges::minmax(samples);
    // Equal samples make one bar of some width instead of a division by zero.
    const double span = greatest > least ? greatest - least : std::max(1e-9, 1e-3 * std::abs(least));
    const double from = greatest > least ? least : least - 0.5 * span;
    const double width = span / static_cast<double>(chart.bins);
    counts.assign(chart.bins, 0.0);
    for (const double sample : samples)
      counts[std::min(static_cast<std::size_t>((sample - from) / width), chart.bins - 1)] += 1.0;
    for (std::size_t i = 0; i <= chart.bins; ++i) edges.push_back(from + width * static_cast<double>(i));
  }
  return {{"kind", "histogram"},
          {"value", axis_json(chart.value)},
          {"edges", pool.add(edges)},
          {"counts", pool.add(counts)},
          {"marks", marks_json(chart.marks)}};
}

}  // namespace

void require_consistent(const Chart& chart) {
  std::visit([](const auto& c) { require_shape(c); }, chart);
}

nlohmann::ordered_json to_json(const Chart& chart, ArrayPool& pool) {
  Json json = std::visit([&pool](const auto& c) { return json_of(c, pool); }, chart);
  json["title"] = title_of(chart);
  return json;
}

const std::string& title_of(const Chart& chart) {
  return std::visit([](const auto& c) -> const std::string& { return c.title; }, chart);
}

const std::string& caption_of(const Chart& chart) {
  return std::visit([](const auto& c) -> const std::string& { return c.caption; }, chart);
}

}  // namespace plenum::host::report
