#include "tumble/report/html/html.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tumble/report/decimate.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/testing/example_estimate.hpp"

namespace tumble {

namespace assets {
extern const std::string_view plotly_basic_min_js;
}

namespace {

bool has(std::string_view text, std::string_view part) { return text.find(part) != std::string_view::npos; }

std::size_t count_of(std::string_view text, std::string_view part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string_view::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

nlohmann::json drawings_of(const std::string& page) {
  const std::string_view mark = "id=\"drawings\">";
  const auto start = page.find(mark) + mark.size();
  return nlohmann::json::parse(page.substr(start, page.find("</script>", start) - start));
}

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
  for (auto& v : e.verdicts) v.parameter = v.limit = hostile;
  e.provenance.inputs = {{hostile, hostile}};
  e.provenance.settings = {{hostile, hostile}};
  return e;
}

TEST(html_report, says_everything_that_a_reader_needs) {
  const auto page = to_html(testing::estimate());
  for (const std::string part :
       {"<h1>Thermal bias of a fibre-optic gyro, eight start temperatures</h1>", "FOG-0117", "1 failed", "<sub>0</sub>",
        "[0.394, 0.509]", "(−4.12", "\u202F×\u202F10<sup>−5</sup>", "deg/h/K<sup>2</sup>", "≤ 0.6 deg/h",
        "turn-on repeatability", "99 %", "<b>Figure 2.</b> Allan deviation.", "2002 of 7200 points",
        "<b>Table 2.</b> runs", "Correlation coefficients", "9f86d081884c7d659a2feaa0c55ad015", "smoothing_time",
        "Simulated with seed 18446744073709551615", "Made by Tumble"}) {
    EXPECT_TRUE(has(page, part)) << part;
  }
  EXPECT_TRUE(has(page, "<td class=\"n value\">0.451</td><td class=\"sd\">± 0.018</td>"));
}

TEST(html_report, is_the_same_bytes_every_time) {
  EXPECT_EQ(to_html(testing::estimate()), to_html(testing::estimate()));
}

TEST(html_report, needs_nothing_from_outside_and_may_load_nothing) {
  auto estimate = testing::estimate();
  EXPECT_TRUE(has(to_html(estimate), "Content-Security-Policy\" content=\"default-src 'none'"));
  EXPECT_TRUE(has(to_html(estimate), "showSendToCloud: false, plotlyServerURL: \"\""));
  estimate.curves.clear();
  const auto page = to_html(estimate);
  for (const char* outside : {"http:", "https:", "src=", "@import", "url(h", "<link"}) {
    EXPECT_FALSE(has(page, outside)) << outside;
  }
}

TEST(html_report, carries_the_plotting_library_only_for_curves) {
  auto estimate = testing::estimate();
  EXPECT_TRUE(has(to_html(estimate), "plotly.js (basic - minified)"));
  estimate.curves.clear();
  const auto page = to_html(estimate);
  EXPECT_FALSE(has(page, "<script"));
  EXPECT_LT(page.size(), 100000u);
}

TEST(html_report, hostile_text_stays_text) {
  const auto page = to_html(hostile_estimate());
  // The three elements that we write: data, library, drawing.
  EXPECT_EQ(count_of(page, "<script"), 3u);
  EXPECT_EQ(count_of(page, "</script"), 3u);
  EXPECT_EQ(count_of(page, "<!--"), 0u);
  EXPECT_TRUE(has(page, "<h1>&#60;/script&#62;&#60;script&#62;document.title=&#39;owned&#39;"));
  EXPECT_EQ(drawings_of(page)[0]["traces"][0]["name"], html::escaped(hostile));
}

TEST(html_report, the_library_cannot_end_its_own_element) {
  EXPECT_FALSE(has(assets::plotly_basic_min_js, "</script"));
  EXPECT_FALSE(has(assets::plotly_basic_min_js, "<!--"));
  EXPECT_GT(assets::plotly_basic_min_js.size(), 1000000u);
}

TEST(html_report, the_library_is_the_one_whose_origin_is_written_down) {
  // SHA-256 by the system's own program; the file is embedded as it stands.
  const std::string folder = TUMBLE_SOURCE_DIR "/third_party/plotly/";
  const auto sum = output_of("sha256sum " + folder + "plotly-basic.min.js").substr(0, 64);
  std::ifstream file(folder + "SOURCE.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  ASSERT_EQ(sum.size(), 64u);
  EXPECT_TRUE(has(page, sum));
}

TEST(html_report, an_empty_estimate_is_a_page_too) {
  Estimate estimate;
  estimate.method = "static_bias";
  const auto page = to_html(estimate);
  EXPECT_TRUE(has(page, "<h1>static_bias</h1>"));
  EXPECT_TRUE(page.ends_with("</html>\n"));
}

TEST(html_figures, curves_of_a_figure_stand_together_in_the_unit_of_the_first) {
  Estimate e;
  Curve a{"a",
          "f",
          {"t", Unit::parse("min"), {60.0, 120.0}},
          {"y", Unit::parse("deg/h"), {si(1.0, "deg/h"), si(2.0, "deg/h")}},
          {},
          {},
          "",
          false,
          false};
  Curve b = a, other = a;
  b.y.unit = Unit::parse("deg/s");
  other.y = {"temperature", Unit::parse("degC"), {293.15, 303.15}};
  e.curves = {a, b, other};
  const auto drawings = drawings_of(to_html(e));
  ASSERT_EQ(drawings.size(), 2u);  // another dimension needs axes of its own
  EXPECT_EQ(drawings[0]["x"], "t [min]");
  EXPECT_EQ(drawings[0]["y"], "y [deg/h]");
  EXPECT_EQ(drawings[0]["traces"][0]["x"], nlohmann::json({1.0, 2.0}));
  EXPECT_EQ(drawings[0]["traces"][0]["y"], nlohmann::json({1.0, 2.0}));
  EXPECT_EQ(drawings[0]["traces"][1]["y"], nlohmann::json({1.0, 2.0}));
  EXPECT_EQ(drawings[1]["traces"][0]["y"], nlohmann::json({20.0, 30.0}));
}

TEST(html_figures, logarithmic_axes_say_what_they_cannot_show) {
  Estimate e;
  e.curves = {{"a",
               "f",
               {"x", {}, {0.0, 1.0, 2.0, 3.0}},
               {"y", {}, {1.0, -1.0, 4.0, NAN}},
               {0.5, 0.5, -3.0, 1.0},
               {2.0, 2.0, 5.0, 2.0},
               "95 %",
               true,
               false}};
  const auto page = to_html(e);
  const auto trace = drawings_of(page)[0]["traces"][0];
  EXPECT_EQ(trace["y"], nlohmann::json({nullptr, nullptr, 4.0, nullptr}));
  EXPECT_EQ(trace["lower"], nlohmann::json({0.5, 0.5, 0.5, 1.0}));
  EXPECT_TRUE(has(page, "“a” 2 values"));
}

TEST(points_to_draw, keeps_short_curves_whole) {
  const std::vector<double> x{1, 2, 3}, y{4, 5, 6};
  EXPECT_EQ(points_to_draw(x, y, {}, {}, false), (std::vector<std::size_t>{0, 1, 2}));
}

TEST(points_to_draw, keeps_ends_peaks_and_gaps_of_long_ones) {
  for (const bool logarithmic : {false, true}) {
    std::vector<double> x, y, lower, upper;
    for (int i = 0; i < 100000; ++i) {
      x.push_back(1.0 + i);
      y.push_back(testing::wiggle(i));
      lower.push_back(y.back() - 0.1);
      upper.push_back(y.back() + 0.1);
    }
    y[41234] = 7.0;
    y[70001] = -7.0;
    y[55555] = NAN;
    lower[333] = -9.0;
    upper[99998] = 9.0;
    const auto indices = points_to_draw(x, y, lower, upper, logarithmic);
    EXPECT_LE(indices.size(), 5002u);  // at most five a stretch, and the ends
    EXPECT_TRUE(std::is_sorted(indices.begin(), indices.end()));
    for (const std::size_t must : {0u, 333u, 41234u, 55555u, 70001u, 99998u, 99999u}) {
      EXPECT_TRUE(std::binary_search(indices.begin(), indices.end(), must)) << must;
    }
  }
}

TEST(points_to_draw, curves_that_run_back_keep_their_order) {
  std::vector<double> x, y;
  for (int i = 0; i < 20000; ++i) {
    x.push_back(std::sin(0.001 * i));
    y.push_back(std::cos(0.001 * i));
  }
  const auto indices = points_to_draw(x, y, {}, {}, false);
  EXPECT_LE(indices.size(), 5000u);
  EXPECT_GT(indices.size(), 1000u);
  EXPECT_TRUE(std::is_sorted(indices.begin(), indices.end()));
}

TEST(html_report, is_drawn_by_a_real_browser) {
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
  EXPECT_EQ(count_of(page, "class=\"plot js-plotly-plot\""), 3u);
  EXPECT_EQ(count_of(page, "data-title=\"Zoom\""), 3u);
  EXPECT_FALSE(has(page, "data-title=\"Share"));  // no button that sends data away
  EXPECT_FALSE(has(page, "<title>owned"));        // the hostile script did not run
}

}  // namespace
}  // namespace tumble
