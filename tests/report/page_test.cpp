#include "host-sim/report/page.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace plenum::host::report {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

TEST(Page, EscapesAllTextThatItIsGiven) {
  const std::string evil = "<img src=x onerror=alert(1)>";
  Page page{evil};
  page.lead(evil).tiles({{evil, 1.0, evil, {}, evil}});
  page.section(evil)
      .paragraph(evil)
      .note(evil)
      .list({evil})
      .table({evil, {evil}, {{evil}}})
      .chart(
          LineChart{.title = evil, .caption = evil, .y = {evil, evil}, .curves = {{evil, {0, 1}, {0, 1}}}});
  EXPECT_EQ(page.html().find("<img src=x"), std::string::npos);
}

TEST(Page, SaysAtItsFootWhatMadeIt) {
  EXPECT_THAT((Page{"t"}.made_by("plenum 1.2 <b>").html()),
              HasSubstr("<footer>Made by plenum 1.2 &lt;b&gt;."));
  EXPECT_THAT(Page{"t"}.html(), HasSubstr("<footer>Made by plenum."));
}

TEST(Page, NamesNoAddressThatABrowserWouldFetch) {
  Page page{"Offline"};
  page.section("One").chart(LineChart{.title = "c", .y = {"p", "kPa"}, .curves = {{"p", {0, 1}, {0, 1}}}});
  const std::string html = page.html();
  for (const char* fetching : {"<link", "src=\"", "@import", "url("})
    EXPECT_THAT(html.substr(0, html.find("<script type=")), Not(HasSubstr(fetching)));
}

TEST(Page, HoldsNoScriptThatEndsEarly) {
  const std::string html = Page{"t"}.html();
  const auto count = [&html](std::string_view text) {
    int n = 0;
    for (std::size_t at = 0; (at = html.find(text, at)) != std::string::npos; ++at) ++n;
    return n;
  };
  EXPECT_EQ(count("</script"), count("<script"))
      << "the embedded library must not hold the tag that would close it";
}

TEST(Page, TellsWhetherATargetIsMetOnEitherSideAndNeverMeetsOneWithoutAValue) {
  const auto verdict = [](double value, Target target) {
    const std::string html = Page{"t"}.tiles({{"x", value, "", target}}).html();
    return html.find("class=\"tile met\"") != std::string::npos ? "met" : "missed";
  };
  EXPECT_STREQ(verdict(4.0, at_most(4.0)), "met");
  EXPECT_STREQ(verdict(4.1, at_most(4.0)), "missed");
  EXPECT_STREQ(verdict(500.0, at_least(500.0)), "met");
  EXPECT_STREQ(verdict(499.0, at_least(500.0)), "missed");
  EXPECT_STREQ(verdict(std::nan(""), at_most(4.0)), "missed");
  EXPECT_STREQ(verdict(std::nan(""), at_least(4.0)), "missed");
}

TEST(Page, SetsANumberToTheDecimalsOfItsColumnAndRightAligned) {
  Page page{"t"};
  page.section("s").table({"", {"Error [kPa]", "Ratio"}, {{Fixed{1.5, 2}, 1.5}, {Fixed{2.07, 2}, "none"}}});
  const std::string html = page.html();
  for (const char* cell :
       {"<td class=\"number\">1.50</td>", "<td class=\"number\">2.07</td>", "<td class=\"number\">1.5</td>",
        "<td>none</td>", "<th scope=\"col\" class=\"number\">Error [kPa]</th>"})
    EXPECT_THAT(html, HasSubstr(cell));
}

TEST(Page, PutsSubsectionsBelowTheirSectionInTheContents) {
  Page page{"t"};
  page.section("One");
  page.subsection("First of one");
  page.subsection("Second of one");
  page.section("Two");
  EXPECT_THAT(page.html(),
              HasSubstr("<a href=\"#s1\">One</a>\n<div class=\"below\">\n<a href=\"#s2\">First of one</a>\n"
                        "<a href=\"#s3\">Second of one</a>\n</div>\n<a href=\"#s4\">Two</a>\n</nav>"));
}

TEST(Page, EqualContentGivesEqualBytes) {
  const auto build = [] {
    Page page{"Same"};
    page.section("s").chart(Histogram{.title = "h", .value = {"x", "V"}, .samples = {1, 2, 2, 3}});
    return page.html();
  };
  EXPECT_EQ(build(), build());
}

TEST(Section, RefusesArraysThatDoNotBelongTogetherByName) {
  Page page{"t"};
  Section& section = page.section("s");
  EXPECT_THAT(
      [&] {
        section.chart(LineChart{.title = "Chamber 1", .y = {}, .curves = {{"measured", {0, 1, 2}, {0, 1}}}});
      },
      ThrowsMessage<std::invalid_argument>(AllOf(HasSubstr("Chamber 1"), HasSubstr("measured"),
                                                 HasSubstr("2 values"), HasSubstr("expected 3"))));
  EXPECT_THAT(
      [&] {
        section.table({"Parameters", {"a", "b"}, {{1.0, 2.0}, {1.0}}});
      },
      ThrowsMessage<std::invalid_argument>(
          AllOf(HasSubstr("Parameters"), HasSubstr("row 2"), HasSubstr("expected 2"))));
  EXPECT_THAT(
      [&] {
        section.chart(HeatMap{.title = "Map",
                              .row_quantity = "p",
                              .rows = {"r"},
                              .column_quantity = "u",
                              .columns = {"a", "b"},
                              .value = {},
                              .values = {{1.0}}});
      },
      ThrowsMessage<std::invalid_argument>(
          AllOf(HasSubstr("Map"), HasSubstr("'r'"), HasSubstr("expected 2"))));
  EXPECT_TRUE(section.blocks().empty());
}

class WrittenPage : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  const std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) /
      (std::string("plenum-") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(WrittenPage, ReplacesAnOlderOneAndLeavesNothingBesideIt) {
  const auto path = folder_ / "report.html";
  std::ofstream(path) << "older";
  Page page{"New"};
  page.write(path);
  EXPECT_EQ((std::ostringstream() << std::ifstream(path).rdbuf()).str(), page.html());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1);
}

TEST_F(WrittenPage, SaysWhichPathCannotBeWrittenAndWhy) {
  EXPECT_THAT(
      [&] { Page{"t"}.write(folder_ / "absent" / "report.html"); },
      ThrowsMessage<std::runtime_error>(AllOf(HasSubstr("absent/report.html"), HasSubstr("No such file"))));
  std::filesystem::create_directory(folder_ / "taken");
  std::ofstream(folder_ / "taken" / "file") << "x";
  EXPECT_THAT([&] { Page{"t"}.write(folder_ / "taken"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("taken")));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1) << "a partial file was left";
}

}  // namespace
}  // namespace plenum::host::report
