#include "tumble/report/html/html.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tumble/report/report.hpp"
#include "tumble/report/testing/example_estimate.hpp"
#include "tumble/report/testing/text_parts.hpp"

namespace tumble::html_test {

namespace {

std::string output_of(const std::string& command) {
  std::string text;
  auto* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return text;
  std::array<char, 65536> buffer;
  while (const auto size = fread(buffer.data(), 1, buffer.size(), pipe)) text.append(buffer.data(), size);
  pclose(pipe);
  return text;
}

constexpr const char* hostile = "</script><script>document.title='owned'</script><!--<script>\"'&amp;";

/// Every text that a file or a plan can put into a report.
Estimate hostile_estimate() {
  auto e = testing::estimate();
  e.method = e.title = e.instrument_model = e.instrument_serial = hostile;
  for (auto& p : e.parameters) p.name = p.symbol = p.description = hostile;
  for (auto& part : e.budget) part.source = hostile;
  for (auto& table : e.tables) {
    table.name = table.caption = table.columns[0].name = hostile;
    table.rows[0][0] = std::string(hostile);
  }
  for (auto& c : e.curves) c.name = c.figure = c.band = c.x.name = c.y.name = hostile;
  for (auto& f : e.findings) f.message = f.where = hostile;
  for (auto& v : e.verdicts) v.parameter = hostile;
  e.provenance.inputs = {{hostile, hostile}};
  e.provenance.settings = {{hostile, hostile}};
  return e;
}

TEST(HtmlReport, SaysEverythingThatAReaderNeeds) {
  const auto page = to_html(testing::estimate());
  for (const std::string part :
       {"<h1>Thermal bias of a fibre-optic gyro, eight start temperatures</h1>", "FOG-0117", "1 failed", "<sub>0</sub>",
        "(−4<span class=\"f\"", "\u202F×\u202F10<sup>−5</sup>", "deg/h/K<sup>2</sup>", "≤ 0.6 deg/h",
        "turn-on repeatability", "99 %", "<b>Figure 2.</b> Allan deviation.", "2002 of 7200 points",
        "<b>Table 2.</b> runs", "Correlation coefficients", "9f86d081884c7d659a2feaa0c55ad015", "smoothing_time",
        "Simulated with seed 18446744073709551615", "Made by Tumble"}) {
    EXPECT_TRUE(has(page, part)) << part;
  }
  // Points below each other: what stands before and behind them has a width of its own.
  EXPECT_TRUE(has(page, ">.451</span></td><td class=\"sd\">± <span class=\"b\" style=\"min-width:"));
  EXPECT_TRUE(has(page, "angle random walk <code>angle_random_walk</code>"));
}

TEST(HtmlReport, ShowsAFigureBeforeTheNumbers) {
  const auto page = to_html(testing::estimate());
  const auto figure = page.find("<figure id=\"figure-1\">");
  EXPECT_LT(page.find("<section id=\"verdicts\">"), figure);
  EXPECT_LT(figure, page.find("<section id=\"parameters\">"));
  EXPECT_GT(page.find("<figure id=\"figure-2\">"), page.find("<section id=\"budget\">"));
}

TEST(HtmlReport, EachSheetHasTitleSerialAndNumber) {
  const auto page = to_html(testing::estimate());
  for (const char* part : {"@top-right { content: \"Serial FOG\\2d 0117\"; }", "counter(page) \" / \" counter(pages)",
                           "@media screen and (prefers-color-scheme: dark)", "@page sideways"})
    EXPECT_TRUE(has(page, part)) << part;
  EXPECT_EQ(count_of(to_html(hostile_estimate()), "</style>"), 1u);
}

TEST(HtmlReport, EveryColourOfADrawingHasOneOnADarkPage) {
  const auto page = to_html(testing::estimate());
  for (const auto& colour : palette())
    EXPECT_TRUE(has(page, "figure [stroke=\"" + colour + "\"] { stroke: ")) << colour;
  for (const char* part : {"[fill=\"#1b2733\"]", "[stroke=\"#51606e\"]", "[stroke=\"#e1e6eb\"]"})
    EXPECT_TRUE(has(page, part)) << part;
}

TEST(HtmlReport, TablesForProgramsAreNamedAndNotPrinted) {
  auto estimate = testing::estimate();
  estimate.tables[0].for_programs = true;
  const auto page = to_html(estimate);
  EXPECT_TRUE(has(page, "For programs, in the result file only: " + estimate.tables[0].name + "."));
  EXPECT_FALSE(has(page, ".</b> " + estimate.tables[0].name));
}

TEST(HtmlReport, ManySourcesAreListedByParameter) {
  auto estimate = testing::estimate();
  const auto part = estimate.budget.front();
  for (int i = 0; i < 4; ++i) estimate.budget.push_back(part);
  const auto page = to_html(estimate);
  EXPECT_TRUE(has(page, "<td class=\"sources-list\">"));
}

TEST(HtmlReport, IsTheSameBytesEveryTime) { EXPECT_EQ(to_html(testing::estimate()), to_html(testing::estimate())); }

TEST(HtmlReport, NeedsNothingFromOutsideAndMayLoadNothing) {
  const auto page = to_html(testing::estimate());
  EXPECT_TRUE(has(page, "Content-Security-Policy\" content=\"default-src 'none'"));
  EXPECT_TRUE(has(page, "<svg"));
  for (const char* outside : {"https:", "src=", "@import", "url(h", "<link", "<script"})
    EXPECT_FALSE(has(page, outside)) << outside;
  EXPECT_EQ(count_of(page, "http:"), count_of(page, "xmlns=\"http:"));
  EXPECT_LT(page.size(), 300'000u);
}

TEST(HtmlReport, HostileTextStaysText) {
  const auto page = to_html(hostile_estimate());
  EXPECT_EQ(count_of(page, "<script"), 0u);
  EXPECT_EQ(count_of(page, "<!--"), 0u);
  EXPECT_TRUE(has(page, "<h1>&#60;/script&#62;&#60;script&#62;document.title=&#39;owned&#39;"));
}

TEST(HtmlReport, AnEmptyEstimateIsAPageToo) {
  Estimate estimate;
  estimate.method = "static_bias";
  const auto page = to_html(estimate);
  EXPECT_TRUE(has(page, "<h1>static_bias</h1>"));
  EXPECT_TRUE(page.ends_with("</html>\n"));
}

TEST(HtmlReport, IsDrawnByARealBrowser) {
  if (output_of("command -v chromium").empty()) GTEST_SKIP() << "no chromium here";
  const auto folder = std::filesystem::temp_directory_path() / ("tumble_report_test_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder / "profile");
  std::ofstream(folder / "report.html") << to_html(hostile_estimate());
  const auto page = output_of(
      "timeout 120 chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking "
      "--disable-sync --user-data-dir=" +
      (folder / "profile").string() + " --dump-dom --virtual-time-budget=5000 file://" +
      (folder / "report.html").string() + " 2>/dev/null");
  std::filesystem::remove_all(folder);
  if (page.empty()) GTEST_SKIP() << "chromium does not start here";
  // The hostile names give all curves one figure, which the dimensions of their axes part into three plots.
  EXPECT_EQ(count_of(page, "<figure id"), 3u);
  EXPECT_EQ(count_of(page, "role=\"img\" aria-label=\"Plot of"), 6u);  // for a page, and for a phone
  EXPECT_FALSE(has(page, "<title>owned"));                             // the hostile text did not become an element
}

TEST(Html, InChineseHasNoPlusMinusAndNoEnglishHeading) {
  const auto page = to_html(testing::estimate(), {.language = Language::chinese});
  EXPECT_TRUE(has(page, "<html lang=\"zh-CN\">"));
  for (const char* text : {"<h2>参数</h2>", "标准不确定度 u（k = 1）", "<h2>数据来源</h2>", "不合格", "95% 包含区间"})
    EXPECT_TRUE(has(page, text)) << text;
  // "±" would read as an expanded uncertainty there.
  const auto begin = page.find("<section id=\"verdicts\">"), end = page.find("<section id=\"findings\">");
  EXPECT_FALSE(has(std::string_view(page).substr(begin, end - begin), "±"));
  for (const char* heading : {"<h2>Parameters", "<h2>Verdicts", "<h2>Findings", "<h2>Uncertainty", "<h2>Figures",
                              "<h2>Tables", "<h2>Correlation", "<h2>Provenance", ">Value ± sd<", "Made by"})
    EXPECT_FALSE(has(page, heading)) << heading;
}

}  // namespace
}  // namespace tumble::html_test
