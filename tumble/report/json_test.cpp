#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "tumble/report/report.hpp"
#include "tumble/report/testing/example_estimate.hpp"
#include "tumble/report/testing/same_estimate.hpp"
#include "tumble/units/testing/asserts.hpp"
#include "tumble/version.hpp"

namespace tumble {
namespace {

constexpr double ulp = std::numeric_limits<double>::epsilon();

Problems problems_of(const std::string& text) {
  const Refused refusal = refusal_of([&] { estimate_from_json(text, "result.json"); });
  EXPECT_TRUE(refusal.empty() || refusal.kind == Error::Kind::bad_file);
  for (const Problem& problem : refusal.problems) EXPECT_EQ(problem.where.file, "result.json");
  return refusal.problems;
}

/// Whether this is the only problem of the text.
::testing::AssertionResult is_only_problem(const std::string& text, const Asked& asked) {
  const Problems problems = problems_of(text);
  if (problems.size() != 1) return ::testing::AssertionFailure() << problems.size() << " problems";
  return is_problem(problems[0], asked);
}

TEST(ResultJson, ReadsBackWhatWasWritten) {
  auto before = testing::estimate();
  before.parameters.back().lower = 0.9 * before.parameters.back().value;
  before.parameters.back().upper = 1.3 * before.parameters.back().value;
  before.parameters.back().contains = {{"another", Unit::parse("ug/g^2"), 0.7}};
  const auto after = estimate_from_json(to_json(before), "result.json");
  testing::expect_same(before, after);
}

TEST(ResultJson, AMemberThatIsThereTwiceIsRefused) {
  std::string text = to_json(testing::estimate());
  text.insert(text.find("\"title\""), "\"title\": \"of another author\", ");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"title"}}, [&] { estimate_from_json(text, "r.json"); }));
}

TEST(ResultJson, IsTheSameTextAfterReading) {
  const auto text = to_json(testing::estimate());
  EXPECT_EQ(to_json(estimate_from_json(text, "result.json")), text);
}

TEST(ResultJson, ValuesOfEverySizeAndUnitKeepTheirPlace) {
  Estimate before;
  Table table{"values", "", {}, {}};
  for (const char* unit : {"1", "deg/h", "deg/sqrt(h)", "ug/g^2", "arcsec", "ppm", "degC", "pulse/(m/s)", "deg/h/g"}) {
    table.columns.push_back({unit, Unit::parse(unit)});
  }
  for (int i = 0; i < 2000; ++i) {
    auto& row = table.rows.emplace_back();
    for (std::size_t j = 0; j < table.columns.size(); ++j) {
      row.emplace_back(testing::wiggle(i + 0.1 * static_cast<double>(j)) * std::pow(10.0, i % 40 - 20));
    }
  }
  before.tables = {table};
  const auto text = to_json(before);
  const auto after = estimate_from_json(text, "result.json");
  EXPECT_EQ(to_json(after), text);
  std::size_t exact = 0;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    for (std::size_t j = 0; j < table.columns.size(); ++j) {
      const double a = std::get<double>(table.rows[i][j]), b = std::get<double>(after.tables[0].rows[i][j]);
      exact += a == b;
      // Relative to what is added: in degC a small number stands beside the offset of 273.15 K.
      const double size = std::abs(a) + std::abs(table.columns[j].unit.offset());
      EXPECT_LE(std::abs(a - b), 2.0 * ulp * size) << table.columns[j].name << " " << a;
    }
  }
  // A factor maps the doubles of a binade onto less, or more, than one of SI: at worst about every second is missed.
  EXPECT_GT(exact, table.rows.size() * table.columns.size() / 2);
  RecordProperty("exact", static_cast<int>(exact));
}

TEST(ResultJson, ZeroHasNoSign) {
  Estimate before;
  before.tables = {{"values", "", {{"fall", Unit::parse("1")}}, {{-0.0}}}};
  const auto text = to_json(before);
  EXPECT_EQ(text.find("-0.0"), std::string::npos);
  EXPECT_EQ(to_json(estimate_from_json(text, "result.json")), text);
}

TEST(ResultJson, ShowsTheDisplayedUnits) {
  const auto json = nlohmann::json::parse(to_json(testing::estimate()));
  EXPECT_EQ(json["tumble"], version);
  const auto& bias = json["parameters"][7];
  EXPECT_EQ(bias["name"], "bias");
  EXPECT_EQ(bias["unit"], "deg/h");
  EXPECT_EQ(bias["value"].dump(), "0.4512");  // the decimal that was given, not its neighbour
  const double sd = std::hypot(0.0021, 0.0003, 0.0180);
  EXPECT_NEAR(bias["sd"].get<double>(), sd, 1e-15);
  EXPECT_NEAR(json["covariance"][7][7].get<double>(), sd * sd, 1e-17);
  EXPECT_NEAR(json["budget"][2]["sd"][7].get<double>(), 0.0180, 1e-16);
  EXPECT_NEAR(bias["interval95"][1].get<double>(), 0.4512 + 3.182446 * sd, 1e-7);  // t for 3 degrees of freedom
  EXPECT_TRUE(json["parameters"][0]["degrees_of_freedom"].is_null());
  EXPECT_NEAR(json["parameters"][11]["value"].get<double>(), 24.93, 1e-13);  // degC: a temperature, with the offset
  EXPECT_NEAR(json["parameters"][11]["sd"].get<double>(), std::hypot(0.02, 0.05), 1e-15);  // a difference, without
  EXPECT_EQ(json["provenance"]["seed"], 18446744073709551615ull);
}

TEST(ResultJson, KeepsEveryKeyOfTheContractInItsOrder) {
  const auto json = nlohmann::ordered_json::parse(to_json(testing::estimate()));
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  EXPECT_EQ(keys,
            (std::vector<std::string>{"tumble", "method", "title", "instrument", "parameters", "covariance", "budget",
                                      "models", "tables", "curves", "fit", "findings", "verdicts", "provenance"}));
}

void collect_keys(const nlohmann::json& json, std::set<std::string>& keys) {
  if (json.is_array() && !json.empty()) collect_keys(json.front(), keys);
  if (!json.is_object()) return;
  for (const auto& [key, value] : json.items()) {
    keys.insert(key);
    if (key != "settings" && key != "command_line") collect_keys(value, keys);
  }
}

TEST(ResultJson, ThePageOfTheManualShowsEveryKey) {
  std::ifstream file(TUMBLE_SOURCE_DIR "/docs/report.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  const auto start = page.find("```json\n") + 8;
  const auto example = nlohmann::json::parse(page.substr(start, page.find("```", start) - start));
  auto estimate = testing::estimate();
  std::rotate(estimate.curves.begin(), estimate.curves.begin() + 2, estimate.curves.end());  // one with a band first
  std::set<std::string> written, shown;
  collect_keys(nlohmann::json::parse(to_json(estimate)), written);
  collect_keys(example, shown);
  EXPECT_EQ(written, shown);
  EXPECT_NO_THROW(estimate_from_json(example.dump(), "docs/report.md"));
}

TEST(ResultJson, FindingHasCodeValuesCountAndPlaces) {
  const Finding finding(Finding::Severity::warning, "gap", {{"lost", 34}, {"longest", 0.31, "s"}}, "t.top",
                        Occurrences{3, Place(812.4), Place("run 2", 5.0)});
  const auto json = nlohmann::json::parse(to_json(Findings(1, finding)));
  EXPECT_EQ(json, nlohmann::json::parse(R"([{"severity": "warning", "code": "gap", "count": 3, "where": "t.top",
    "message": "3 gaps, 34 samples lost; the longest: 310 ms at run 2; methods that need a constant rate cannot use data across a gap",
    "first": {"time": 812.4}, "worst": {"label": "run 2", "time": 5.0},
    "values": {"lost": 34, "longest": {"value": 0.31, "unit": "s"}}}])"));
}

TEST(ResultJson, FindingSaysWhichParametersItConcerns) {
  Estimate estimate = testing::estimate();
  estimate.findings.resize(1);
  estimate.findings[0].about = {2, 5};
  estimate.findings[0].hidden = {{"fog.x.rate_random_walk", "fog.x"}, {"hysteresis"}};
  estimate.provenance.memory = 8'000'000;
  auto json = nlohmann::json::parse(to_json(estimate));
  const auto read = estimate_from_json(json.dump(), "result.json");
  EXPECT_EQ(read.findings[0].about, estimate.findings[0].about);
  ASSERT_EQ(read.findings[0].hidden.size(), 2u);
  EXPECT_EQ(read.findings[0].hidden[0].name, "fog.x.rate_random_walk");
  EXPECT_EQ(read.findings[0].hidden[0].channel, "fog.x");
  EXPECT_EQ(read.findings[0].hidden[1].name, "hysteresis");
  EXPECT_EQ(read.provenance.memory, 8'000'000u);
  json["findings"][0]["about"][1] = estimate.parameters.size();
  EXPECT_TRUE(is_only_problem(json.dump(), {.pattern = "no such parameter", .key = "findings[0].about[1]"}));
}

TEST(ResultJson, FindingOfAnEarlierVersionHasOnlyASentence) {
  auto json = nlohmann::json::parse(to_json(testing::estimate()));
  json["findings"] =
      nlohmann::json::parse(R"([{"severity": "warning", "message": "gap of 0.31 s", "where": "t.top, 4120.0 s"}])");
  const auto read = estimate_from_json(json.dump(), "old.json");
  ASSERT_EQ(read.findings.size(), 1u);
  EXPECT_EQ(read.findings[0].code, "");
  EXPECT_EQ(read.findings[0].message, "gap of 0.31 s");
  EXPECT_EQ(read.findings[0].occurrences.count, 1u);
  EXPECT_FALSE(read.findings[0].occurrences.first.given());
}

TEST(ResultJson, WritesNullForWhatJsonHasNoNumberFor) {
  auto estimate = testing::estimate();
  estimate.parameters[0].value = NAN;
  estimate.covariance(1, 1) = INFINITY;
  estimate.fit.condition = INFINITY;
  const auto text = to_json(estimate);
  const auto json = nlohmann::json::parse(text);
  EXPECT_TRUE(json["parameters"][0]["value"].is_null());
  EXPECT_TRUE(json["parameters"][1]["sd"].is_null());
  const auto read = estimate_from_json(text, "result.json");
  EXPECT_TRUE(std::isnan(read.parameters[0].value));
  EXPECT_TRUE(std::isnan(read.covariance(1, 1)));
  EXPECT_TRUE(std::isinf(read.fit.condition));
  EXPECT_EQ(to_json(read), text);
}

TEST(ResultJson, AnEmptyEstimateIsAResultToo) {
  const auto text = to_json(Estimate{});
  EXPECT_EQ(to_json(estimate_from_json(text, "result.json")), text);
}

TEST(ResultJson, SurvivesTextThatIsNotUtf8) {
  auto estimate = testing::estimate();
  estimate.title = "caf\xE9";
  EXPECT_EQ(estimate_from_json(to_json(estimate), "result.json").title, "caf\uFFFD");
}

TEST(ResultJson, NamesEveryProblemWithItsPath) {
  auto json = nlohmann::json::parse(to_json(testing::estimate()));
  json["parameters"][0]["value"] = "six";
  json["parameters"][1].erase("unit");
  json["parameters"][2]["unit"] = "furlong";
  json["covariance"][3].erase(0);
  json["budget"][1]["sd"].push_back(1.0);
  json["tables"][0]["rows"][2].push_back(1.0);
  json["curves"][1]["y"]["values"][5] = true;
  json["verdicts"][0]["outcome"] = "maybe";
  json["provenance"]["seed"] = -1;
  json["fit"].erase("condition");
  json.erase("findings");
  const auto problems = problems_of(json.dump());
  const std::vector<Asked> all{{.values = {"string"}, .part = "a number (or null)", .key = "parameters[0].value"},
                               {.pattern = "is missing", .key = "parameters[1].unit"},
                               {.values = {"furlong"}, .key = "parameters[2].unit"},
                               {.values = {"12", "11"}, .part = "one for each parameter", .key = "covariance[3]"},
                               {.values = {"12", "13"}, .part = "one for each parameter", .key = "budget[1].sd"},
                               {.values = {"8", "9"}, .part = "one for each column", .key = "tables[0].rows[2]"},
                               {.values = {"5", "boolean"}, .key = "curves[1].y.values"},
                               {.values = {"maybe", "pass, fail, undecided"}, .key = "verdicts[0].outcome"},
                               {.part = "a whole number, not negative", .key = "provenance.seed"},
                               {.pattern = "is missing", .key = "fit.condition"},
                               {.pattern = "is missing", .key = "findings"}};
  for (const Asked& asked : all) EXPECT_TRUE(has_problem(problems, asked)) << asked.key;
  EXPECT_EQ(problems.size(), all.size()) << ::testing::PrintToString(texts_of(problems));
}

TEST(ResultJson, RefusesTwoParametersOfOneName) {
  auto json = nlohmann::json::parse(to_json(testing::estimate()));
  const std::string name = json["parameters"][0]["name"];
  json["parameters"][3]["name"] = name;
  EXPECT_TRUE(
      is_only_problem(json.dump(), {.values = {name}, .pattern = "another parameter", .key = "parameters[3].name"}));
}

TEST(ResultJson, RefusesACovarianceOfTheWrongSize) {
  auto json = nlohmann::json::parse(to_json(testing::estimate()));
  json["covariance"].erase(11);
  EXPECT_TRUE(is_only_problem(json.dump(),
                              {.values = {"12", "11"}, .part = "one row for each parameter", .key = "covariance"}));
}

TEST(ResultJson, RefusesAnSdThatTheCovarianceContradicts) {
  auto json = nlohmann::json::parse(to_json(testing::estimate()));
  json["parameters"][7]["sd"] = 0.001;
  EXPECT_TRUE(
      is_only_problem(json.dump(), {.values = {"0.001", "7", "7"}, .part = "0.018", .key = "parameters[7].sd"}));
}

TEST(ResultJson, OfAlmostNoDegreesOfFreedomIsShown) {
  auto json = nlohmann::json::parse(to_json(testing::estimate()));
  json["parameters"][7]["degrees_of_freedom"] = 1e-300;
  const auto again = nlohmann::json::parse(to_json(estimate_from_json(json.dump(), "result.json")));
  EXPECT_TRUE(again["parameters"][7]["interval95"][0].is_null());
}

TEST(ResultJson, RefusesACovarianceThatIsNone) {
  const auto whole = nlohmann::json::parse(to_json(testing::estimate()));
  auto one_sided = whole, too_close = whole;
  const double most = whole["parameters"][7]["sd"].get<double>() * whole["parameters"][2]["sd"].get<double>();
  one_sided["covariance"][7][2] = 0.5 * most, one_sided["covariance"][2][7] = -0.5 * most;
  too_close["covariance"][7][2] = too_close["covariance"][2][7] = 1.1 * most;
  EXPECT_TRUE(is_problem(problems_of(one_sided.dump()).at(0),
                         {.values = {"7", "2"}, .pattern = "is not symmetric", .key = "covariance"}));
  EXPECT_TRUE(is_problem(problems_of(too_close.dump()).at(0),
                         {.values = {"7", "2"}, .pattern = "a correlation of 1", .key = "covariance"}));
}

TEST(ResultJson, SaysWhereTheTextStopsBeingJson) {
  for (const std::string text : {"", "{\"tumble\": ", "\xFF\xFE"})
    EXPECT_TRUE(is_only_problem(text, {.pattern = "not JSON", .line = 1})) << text;
  EXPECT_TRUE(is_only_problem("{\n  \"a\": 1,\n  b\n}", {.pattern = "not JSON", .line = 3, .column = 3}));
  EXPECT_TRUE(is_only_problem("{\"a\": 1e999}", {.pattern = "too large for a double"}));
}

TEST(ResultJson, RefusesAnyOtherJson) {
  for (const std::string text : {"null", "3", "[]", "\"text\"", "{}"}) EXPECT_FALSE(problems_of(text).empty()) << text;
}

TEST(ResultJson, EveryTruncationIsRefusedAndNoneCrashes) {
  const auto text = to_json(testing::estimate());
  for (std::size_t length = 0; length + 2 < text.size(); length += 19997) {
    EXPECT_EQ(problems_of(text.substr(0, length)).size(), 1u) << length;
  }
}

TEST(ResultJson, ABudgetWithoutFactorsIsReadAndSaid) {
  const Estimate estimate = testing::estimate();
  auto json = nlohmann::json::parse(to_json(estimate));
  for (auto& line : json["budget"]) {
    line.erase("factor");
    line.erase("key");
  }
  const Estimate again = estimate_from_json(json.dump(), "old.json");
  ASSERT_EQ(again.budget.size(), estimate.budget.size());
  for (std::size_t k = 0; k < again.budget.size(); ++k)
    for (std::size_t i = 0; i < again.parameters.size(); ++i) {
      const double written = estimate.budget[k].variance(i);
      EXPECT_NEAR(again.budget[k].variance(i), written, (4.0 + 12.0) * ulp * written) << again.budget[k].source;
    }
  ASSERT_FALSE(again.findings.empty());
  EXPECT_EQ(again.findings.front().code, "budget_without_factors");
  EXPECT_EQ(again.findings.front().severity, Finding::Severity::info);
}

TEST(ResultJson, FactorsThatDoNotAddUpToTheCovarianceAreRefused) {
  auto json = nlohmann::json::parse(to_json(testing::estimate()));
  auto& element = json["budget"][0]["factor"][1][0];
  element = 1.001 * element.get<double>();
  EXPECT_TRUE(is_only_problem(json.dump(), {.pattern = "factors give the covariance"}));
  json["budget"][0]["factor"].erase(0);
  EXPECT_FALSE(problems_of(json.dump()).empty());
}

TEST(ResultJson, AResultThatDoesNotFitTogetherIsADefect) {
  auto estimate = testing::estimate();
  estimate.covariance = Matrix(3, 3);
  estimate.budget[0].factor.rows -= 1;
  try {
    to_json(estimate);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::internal);
    EXPECT_EQ(error.problems.size(), 2u);
  }
}

}  // namespace
}  // namespace tumble
