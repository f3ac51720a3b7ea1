// Pages in a real browser, without a display and without a network. A probe, a script at the end of the page,
// reads back through ECharts what was drawn and leaves it in the document, which the browser prints.
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <string>

#include "host-sim/report/page.hpp"

namespace plenum::host::report {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

std::string output_of(const std::string& command) {
  std::string output;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return output;
  std::array<char, 65536> chunk;
  for (std::size_t n = 0; (n = std::fread(chunk.data(), 1, chunk.size(), pipe)) > 0;)
    output.append(chunk.data(), n);
  ::pclose(pipe);
  return output;
}

// What a probe found, and what the browser complained about.
struct Seen {
  nlohmann::json found;
  std::string document;
  std::string complaints;
};

class Browser : public ::testing::Test {
 protected:
  void SetUp() override {
    if (output_of("command -v chromium").empty())
      GTEST_SKIP() << "no chromium on the PATH, so no page was drawn; to enable: apt-get install chromium";
    folder_ =
        std::filesystem::path(::testing::TempDir()) /
        (std::string("plenum-browser-") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override {
    if (!folder_.empty()) std::filesystem::remove_all(folder_);
  }

  /// Opens the page and evaluates `expression` (JavaScript; `charts` is the array of ECharts instances) after
  /// it is drawn.
  Seen open(const Page& page, const std::string& expression, const std::string& fragment = "") {
    const auto path = folder_ / "page.html";
    std::ofstream(path) << page.html() << R"(<script type="module">
      const charts = [...document.querySelectorAll('.plot')].map((plot) => echarts.getInstanceByDom(plot));
      const found = document.createElement('pre');
      found.id = 'found';
      found.textContent = JSON.stringify()"
                        << expression << R"();
      document.body.append(found);
    </script>)";
    const auto complaints = folder_ / "complaints.txt";
    Seen seen;
    seen.document = output_of(
        "timeout 60 chromium --headless --no-sandbox --disable-gpu --no-first-run "
        "--disable-background-networking "
        "--disable-component-update --disable-sync --enable-logging=stderr --virtual-time-budget=5000 "
        "--window-size=1200,900 --dump-dom --user-data-dir='" +
        (folder_ / "profile").string() + "' 'file://" + path.string() + fragment + "' 2>'" +
        complaints.string() + "' </dev/null");
    seen.complaints = (std::ostringstream() << std::ifstream(complaints).rdbuf()).str();
    const std::string open_tag = "<pre id=\"found\">";
    const std::size_t from = seen.document.rfind(open_tag);
    if (from != std::string::npos) {
      const std::size_t begin = from + open_tag.size();
      seen.found =
          nlohmann::json::parse(seen.document.substr(begin, seen.document.find("</pre>", begin) - begin));
    }
    EXPECT_THAT(seen.complaints, Not(HasSubstr("CONSOLE"))) << "the page wrote to the browser's console";
    EXPECT_THAT(seen.document, Not(HasSubstr("data-problem")));
    return seen;
  }

  std::filesystem::path folder_;
};

std::vector<double> sine(std::size_t count, double cycles) {
  std::vector<double> y;
  for (std::size_t i = 0; i < count; ++i)
    y.push_back(
        std::sin(2.0 * std::numbers::pi * cycles * static_cast<double>(i) / static_cast<double>(count)));
  return y;
}

std::vector<double> ramp(std::size_t count, double step) {
  std::vector<double> x;
  for (std::size_t i = 0; i < count; ++i) x.push_back(step * static_cast<double>(i));
  return x;
}

Page page_of_every_kind() {
  Page page{"Every kind of chart"};
  const auto t_s = ramp(400, 0.01);
  auto gapped = sine(400, 3);
  gapped[100] = std::nan("");
  page.section("All")
      .chart(
          LineChart{.title = "line",
                    .y = {"Pressure", "kPa"},
                    .curves = {{"measured", t_s, sine(400, 2), Stroke::kSolid, Ink::kNeutral},
                               {"free run", t_s, gapped},
                               {"command", t_s, sine(400, 1), Stroke::kSteps}},
                    .bands = {{"band", t_s, std::vector<double>(400, -0.5), std::vector<double>(400, 0.5)}},
                    .marks = {{Mark::On::kY, 0.25, "limit of the line"}}})
      .chart(XyChart{.title = "xy",
                     .x = {"Command", "V"},
                     .y = {"Area", "mm²"},
                     .curves = {{"loop", sine(50, 1), sine(50, 2)},
                                {"dots", sine(50, 1), sine(50, 3), Stroke::kPoints}}})
      .chart(BarChart{
          .title = "bars", .categories = {"a", "b"}, .value = {"RMSE", "kPa"}, .series = {{"PI", {1, 2}}}})
      .chart(BarChart{.title = "lying bars",
                      .categories = {"a category with a long name", "b"},
                      .value = {"Share", "%"},
                      .series = {{"share", {1, 2}}},
                      .marks = {{Mark::On::kY, 1.5, "limit"}}})
      .chart(HeatMap{.title = "heat",
                     .row_quantity = "p",
                     .rows = {"r1", "r2"},
                     .column_quantity = "u",
                     .columns = {"c1", "c2"},
                     .value = {"RMSE", "kPa"},
                     .values = {{1, 2}, {3, std::nan("")}}})
      .chart(Histogram{.title = "histogram", .value = {"Error", "kPa"}, .samples = sine(300, 1), .bins = 10});
  return page;
}

TEST_F(Browser, DrawsEveryKindOfChart) {
  const Seen seen = open(page_of_every_kind(), "charts.map((chart) => chart.getWidth() > 300)");
  ASSERT_EQ(seen.found, nlohmann::json::array({true, true, true, true, true, true})) << seen.complaints;
  EXPECT_THAT(seen.document, HasSubstr("data-charts=\"6\""));
}

// Axes, grid and text are grey; what is drawn of the data has a colour. Legends, which have it too, are outside the grid.
TEST_F(Browser, PaintsTheDataOfEveryKindOfChart) {
  const Seen seen = open(page_of_every_kind(), R"((
    await new Promise((done) => setTimeout(done, 200)),
    charts.map((chart) => {
      const {x, y, width, height} = chart.getModel().getComponent('grid').coordinateSystem.getRect();
      const ratio = chart.getDevicePixelRatio(), columns = Math.floor(width * ratio);
      const {data} = chart.getDom().querySelector('canvas').getContext('2d')
        .getImageData(x * ratio, y * ratio, columns, height * ratio);
      const coloured = new Set();
      for (let i = 0; i < data.length; i += 4) {
        const rgb = data.subarray(i, i + 3);
        if (data[i + 3] > 127 && Math.max(...rgb) - Math.min(...rgb) > 60) coloured.add(i / 4 % columns);
      }
      return coloured.size / columns;
    })))");
  ASSERT_EQ(seen.found.size(), 6U) << seen.complaints;
  // Of the heat map one column of two: the other has the middle of the scale, a grey, and a gap.
  const std::array<double, 6> least_share{0.98, 0.9, 0.05, 0.3, 0.45, 0.9};
  for (std::size_t k = 0; k < least_share.size(); ++k)
    EXPECT_GT(seen.found[k].get<double>(), least_share[k]) << "coloured columns of chart " << k;
}

TEST_F(Browser, MakesRoomForBarsThatLieAndNotForThoseThatStand) {
  BarChart standing{.title = "standing", .categories = {}, .value = {"RMSE", "kPa"}, .series = {}};
  for (int i = 1; i <= 8; ++i) standing.categories.push_back("ch. " + std::to_string(i));
  for (const char* name : {"a", "b", "c", "d", "e", "f"})
    standing.series.push_back({name, std::vector<double>(8, 1.0)});
  BarChart lying = standing;
  lying.categories.front() = "a category with a long name";
  Page page{"Bars"};
  page.section("s").chart(standing).chart(lying);
  const Seen seen = open(page, "charts.map((chart) => chart.getHeight())");
  ASSERT_EQ(seen.found.size(), 2U) << seen.complaints;
  EXPECT_EQ(seen.found[0], 340);
  EXPECT_GT(seen.found[1], 8 * 6 * 20);
}

TEST_F(Browser, DrawsTheAxesMarksAndCurvesAsVectorsOnDemand) {
  const Seen seen = open(page_of_every_kind(),
                         "charts.map((chart) => chart.getDom().querySelectorAll('svg path').length)", "#svg");
  ASSERT_EQ(seen.found.size(), 6U);
  for (const auto& paths : seen.found) EXPECT_GT(paths.get<int>(), 3);
  for (const char* drawn :
       {"Pressure (kPa)", "limit of the line", "Area (mm²)", "a category with", "RMSE (kPa)", "Samples"})
    EXPECT_THAT(seen.document.substr(0, seen.document.find("id=\"page-data\"")), HasSubstr(drawn));
}

TEST_F(Browser, ReadsTheNumbersBackAsTheyWereGiven) {
  Page page{"Numbers"};
  page.section("s").chart(
      LineChart{.title = "c",
                .y = {"p", "kPa"},
                .curves = {{"p", {0.0, 0.01, 0.02, 0.05}, {1.5, -2.25, std::nan(""), 1e-3}}}});
  const Seen seen = open(page, "Array.from(charts[0].getOption().series[0].data)");
  ASSERT_EQ(seen.found.size(), 8U) << seen.complaints;
  EXPECT_NEAR(seen.found[2].get<double>(), 0.01, 1e-8);
  EXPECT_EQ(seen.found[1], 1.5);
  EXPECT_EQ(seen.found[3], -2.25);
  EXPECT_TRUE(seen.found[5].is_null()) << "NaN is a gap";
  EXPECT_NEAR(seen.found[7].get<double>(), 1e-3, 1e-9);
}

TEST_F(Browser, MovesTheChartsOfAGroupTogetherAndNoOther) {
  Page page{"Groups"};
  const auto t_s = ramp(500, 0.01);
  const auto chart = [&](const char* title, const char* group) {
    return LineChart{.title = title, .y = {"p", "kPa"}, .curves = {{"p", t_s, sine(500, 3)}}, .group = group};
  };
  page.section("s").chart(chart("one", "g")).chart(chart("two", "g")).chart(chart("other", ""));
  const Seen seen = open(page,
                         "(charts[0].dispatchAction({type: 'dataZoom', start: 20, end: 40}), "
                         "await new Promise((done) => setTimeout(done, 200)), "
                         "charts.map((chart) => chart.getOption().dataZoom[0].start))");
  EXPECT_EQ(seen.found, nlohmann::json::array({20, 20, 0})) << seen.complaints;
}

TEST_F(Browser, LabelsEvenTicksAloneAndEndsAtOneThatIsNear) {
  Page page{"Ends"};
  const auto chart = [](std::size_t rows) {
    return LineChart{.title = "c", .y = {"p", "kPa"}, .curves = {{"p", ramp(rows, 0.01), sine(rows, 3)}}};
  };
  page.section("s").chart(chart(6000)).chart(chart(1231));
  const Seen seen = open(page, R"((
    charts[1].dispatchAction({type: 'dataZoom', startValue: 0, endValue: 5.67}),
    charts.map((chart) => chart.getModel().getComponent('xAxis').axis)
      .map((axis) => [axis.scale.getExtent()[1], ...axis.getViewLabels().map((label) => label.formattedLabel).filter(Boolean)])))");
  ASSERT_EQ(seen.found.size(), 2U) << seen.complaints;
  EXPECT_EQ(seen.found[0], nlohmann::json::array({60, "0", "10", "20", "30", "40", "50", "60"}));
  EXPECT_EQ(seen.found[1], nlohmann::json::array({5.67, "0", "1", "2", "3", "4", "5"}));
}

TEST_F(Browser, DrawsEveryPointOfACurveOverALogarithmicAxis) {
  Page page{"Log"};
  page.section("All").chart(XyChart{.title = "over decades",
                                    .x = {.quantity = "Noise", .unit = "Pa", .logarithmic = true},
                                    .y = {"Fit", "%"},
                                    .curves = {{"fit", {10, 100, 1000, 3000}, {98, 97, 90, 70}}}});
  const Seen seen = open(page, R"((() => {
    const grid = charts[0].getModel().getComponent('grid').coordinateSystem.getRect();
    return [10, 100, 1000, 3000].map((x) => {
      const at = charts[0].convertToPixel({xAxisIndex: 0}, x);
      return at >= grid.x - 1 && at <= grid.x + grid.width + 1;
    });
  })())");
  EXPECT_EQ(seen.found, (nlohmann::json{true, true, true, true}));
}

TEST_F(Browser, KeepsAllOfAHundredThousandPointsAndDrawsAFew) {
  Page page{"Long"};
  page.section("s").chart(
      LineChart{.title = "c", .y = {"p", "kPa"}, .curves = {{"p", ramp(100000, 0.01), sine(100000, 40)}}});
  const Seen seen = open(page,
                         "[charts[0].getOption().series[0].data.length / 2, "
                         "charts[0].getModel().getSeriesByIndex(0).getData().count()]");
  ASSERT_EQ(seen.found.size(), 2U) << seen.complaints;
  EXPECT_EQ(seen.found[0], 100000);
  EXPECT_LT(seen.found[1].get<int>(), 5000);
  EXPECT_GT(seen.found[1].get<int>(), 500);
}

TEST_F(Browser, TellsTheValueOfEveryCurveAtTheCursor) {
  Page page{"Cursor"};
  const auto t_s = ramp(20001, 0.01);
  page.section("s").chart(LineChart{
      .title = "c",
      .y = {"p", "kPa"},
      .curves = {{"rising", t_s, ramp(20001, 0.02)},
                 {"flat", t_s, std::vector<double>(20001, 7.0)},
                 {"wavy", t_s, sine(20001, 50)}},
      .bands = {{"tolerance", t_s, std::vector<double>(20001, 1.0), std::vector<double>(20001, 3.0)}}});
  const Seen seen = open(page,
                         "charts[0].getOption().tooltip[0].formatter([{axisValue: 100}]).replace(/<[^>]*>/g, "
                         "' ').replaceAll('&', '+')");
  ASSERT_TRUE(seen.found.is_string()) << seen.complaints;
  const std::string tip = seen.found;
  EXPECT_THAT(tip, HasSubstr("Time 100 s"));
  EXPECT_THAT(tip, ContainsRegex("rising[^k]*200 kPa"));
  EXPECT_THAT(tip, HasSubstr("wavy"));
  EXPECT_THAT(tip, ContainsRegex("flat[^k]* 7 kPa"));
  EXPECT_THAT(tip, ContainsRegex("tolerance[^k]* 1 to 3 kPa"));
}

TEST_F(Browser, ShowsHostileNamesAsText) {
  Page page{"Hostile"};
  const std::string evil = "</script><img src=x onerror=\"document.documentElement.dataset.problem='ran'\">";
  page.section(evil).chart(LineChart{.title = evil, .y = {evil, evil}, .curves = {{evil, {0, 1}, {0, 1}}}});
  const Seen seen =
      open(page,
           "[charts.length, document.querySelectorAll('img').length, "
           "charts[0].getOption().tooltip[0].formatter([{axisValue: 0}]).includes('<' + 'img')]");
  EXPECT_EQ(seen.found, nlohmann::json::array({1, 0, false})) << seen.complaints;
}

}  // namespace
}  // namespace plenum::host::report
