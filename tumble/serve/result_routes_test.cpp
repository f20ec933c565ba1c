#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/report/figure.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/testing/example_estimate.hpp"
#include "tumble/serve/workbench.hpp"

namespace tumble {
namespace {

/// A workbench over a folder with two results of one instrument and a file that is none.
class ResultRoutes : public ::testing::Test {
 protected:
  void SetUp() override {
    auto later = testing::estimate();
    later.parameters[7].value += si(0.2, "deg/h");
    write("first.json", to_json(testing::estimate()));
    write("later.json", to_json(later));
    write("other.json", "{\"tumble\": \"0.1.0\", ");
    write("plain.json", "{}");
    WorkbenchOptions options;
    options.folder = folder_.path;
    options.cache = folder_.path / "cache";
    options.clock = [] { return 0.0; };
    options.port = 8321;
    workbench_ = std::make_unique<Workbench>(options);
  }

  void write(const std::string& name, const std::string& text) { std::ofstream(folder_.path / name) << text; }

  HttpResponse get(const std::string& path, std::vector<std::pair<std::string, std::string>> query) {
    HttpRequest request;
    request.method = "GET";
    request.path = path;
    request.query = std::move(query);
    request.headers["host"] = "127.0.0.1:8321";
    return workbench_->handler().answer(request);
  }

  ScratchFolder folder_;
  std::unique_ptr<Workbench> workbench_;
};

using Query = std::vector<std::pair<std::string, std::string>>;

TEST_F(ResultRoutes, ListsResultsAlone) {
  const auto list = nlohmann::json::parse(get("/api/results", {}).body);
  ASSERT_EQ(list["results"].size(), 2u);
  EXPECT_EQ(list["results"][0]["serial"], "FOG-0117");
  EXPECT_EQ(list["results"][0]["failed"], 1);
}

TEST_F(ResultRoutes, AnswersInTheUnitThatIsAsked) {
  const auto at = [&](const Query& query) {
    return nlohmann::json::parse(get("/api/result", query).body)["parameters"][7];
  };
  const auto plain = at({{"file", "first.json"}}), other = at({{"file", "first.json"}, {"unit", "bias~deg/s"}});
  EXPECT_EQ(plain["value"], nlohmann::json({"0", ".451"}));
  EXPECT_EQ(plain["power"], "");
  EXPECT_EQ(other["value"], nlohmann::json({"1", ".253"}));  // 0.4512/3600 deg/s
  EXPECT_EQ(other["power"], "× 10⁻⁴");
  double sum = 0.0;
  for (const auto& part : plain["budget"]) sum += part["share"].get<double>();
  EXPECT_NEAR(sum, 1.0, 1e-9);
  EXPECT_EQ(get("/api/result", {{"file", "first.json"}, {"unit", "bias~m"}}).status, 400u);
  EXPECT_EQ(get("/api/result", {{"file", "first.json"}, {"unit", "nothing~m"}}).status, 400u);
}

TEST_F(ResultRoutes, FiguresAreThoseOfTheReport) {
  const Query first{{"file", "first.json"}, {"figure", "1"}};
  const auto svg = get("/api/result/figure.svg", first).body;
  EXPECT_EQ(svg, to_svg(figures_of(testing::estimate()).at(0)));
  EXPECT_EQ(get("/api/result/figures", {{"file", "first.json"}}).body, to_json(figures_of(testing::estimate())));
  EXPECT_EQ(get("/api/result/page", {{"file", "first.json"}}).body, to_html(testing::estimate()));
  EXPECT_EQ(get("/api/result/figure.csv", {{"file", "first.json"}, {"figure", "99"}}).status, 404u);
  EXPECT_EQ(get("/api/result/figure.csv", {{"file", "first.json"}, {"figure", "nan"}}).status, 400u);
}

TEST_F(ResultRoutes, TheMatrixIsInTheUnitsThatAreShown) {
  const auto estimate = testing::estimate();
  const auto answer = nlohmann::json::parse(get("/api/result", {{"file", "first.json"}, {"unit", "bias~deg/s"}}).body);
  const auto last = answer["parameters"].size() - 1;
  EXPECT_EQ(answer["covariance"].size(), estimate.parameters.size());
  EXPECT_EQ(answer["covariance"][last].size(), last + 1);
  const auto csv = [&](const Query& query) { return get("/api/result/matrix.csv", query).body; };
  const auto lines = [](const std::string& text) { return std::ranges::count(text, '\n'); };
  const auto covariance = csv({{"file", "first.json"}, {"kind", "covariance"}, {"unit", "bias~deg/s"}});
  EXPECT_EQ(lines(covariance), static_cast<std::ptrdiff_t>(estimate.parameters.size() + 1));
  const double sd = standard_uncertainty(estimate, 7) / si(1.0, "deg/s");  // bias
  EXPECT_NE(covariance.find("\nbias[deg/s],"), std::string::npos);
  EXPECT_NE(covariance.find(fmt::format(",{:.12g}", sd * sd).substr(0, 9)), std::string::npos);
  EXPECT_NE(csv({{"file", "first.json"}, {"kind", "correlation"}}).find("\nbias,"), std::string::npos);
  EXPECT_EQ(get("/api/result/matrix.csv", {{"file", "first.json"}, {"kind", "other"}}).status, 400u);
}

TEST_F(ResultRoutes, CompareAsTheCommandLineDoes) {
  const auto answer =
      nlohmann::json::parse(get("/api/results/compare", {{"file", "first.json"}, {"file", "later.json"}}).body);
  ASSERT_EQ(answer["pairs"].size(), 1u);
  EXPECT_EQ(answer["pairs"][0]["differences"].size(), testing::estimate().parameters.size());
  EXPECT_EQ(answer["figures"].size(), testing::estimate().parameters.size());
  EXPECT_EQ(answer["values"][7][1]["value"], "0.651 deg/h");
  EXPECT_EQ(get("/api/results/compare", {{"file", "first.json"}}).status, 400u);
}

TEST_F(ResultRoutes, RefuseWhatIsNoResultAndWhatIsOutside) {
  for (const char* name : {"other.json", "plain.json"})
    EXPECT_EQ(get("/api/result", {{"file", name}}).status, 422u) << name;
  EXPECT_EQ(get("/api/result", {{"file", "gone.json"}}).status, 404u);
  for (const char* name : {"../first.json", "/etc/passwd", ".hidden.json", ""})
    EXPECT_EQ(get("/api/result", {{"file", name}}).status, 400u) << name;
}

TEST_F(ResultRoutes, AChangedFileIsReadAgain) {
  EXPECT_EQ(nlohmann::json::parse(get("/api/result", {{"file", "first.json"}}).body)["title"],
            testing::estimate().title);
  auto changed = testing::estimate();
  changed.title = "another and longer title";
  write("first.json", to_json(changed));
  EXPECT_EQ(nlohmann::json::parse(get("/api/result", {{"file", "first.json"}}).body)["title"], changed.title);
}

}  // namespace
}  // namespace tumble
