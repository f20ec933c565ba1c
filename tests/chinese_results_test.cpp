// Every name and sentence of a result has its Chinese: those that the trial of each method gives, with figures and
// tables. What remains in Latin letters is a name of a channel, a segment or a parameter, a symbol, or a unit.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>
#include <string>

#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/report/figure.hpp"
#include "tumble/report/in_language.hpp"
#include "tumble/report/names.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Texts = std::set<std::string>;

/// Longest first, so that no name is taken for the beginning of another.
std::vector<std::string> names_in(const Evidence& evidence, const Method& method, const Estimate& estimate) {
  Texts names;
  for (const auto& recording : evidence.recordings)
    for (const auto& channel : recording.channels) names.insert(channel.name);
  for (const auto& segment : evidence.plan.schedule) names.insert(segment.label);
  for (const auto& role : method.roles()) names.insert(role.name);
  for (const auto& option : method.options()) names.insert(option.name);
  for (const auto& parameter : estimate.parameters) names.insert(parameter.name.substr(0, parameter.name.find('.')));
  for (const Texts given = names; const auto& name : given) names.insert(readable_name(name));
  std::vector<std::string> sorted(names.begin(), names.end());
  std::ranges::sort(sorted, std::greater<>(), &std::string::size);
  return sorted;
}

/// Words in Latin letters, without names, units, and the words that are the same in Chinese.
Texts english_in(std::string text, const std::vector<std::string>& names) {
  static const Texts same{"Allan", "Hadamard",     "Kalibr",     "Ferraris",     "Markov", "TOTDEV", "Shupe",
                          "deg",   "arcsec",       "degC",       "ppm",          "pulse",  "sqrt",   "UTC",
                          "exp",   "startup_time", "rig_errors", "rad",          "eff",    "input",  "output",
                          "eta",   "rho_X",        "rho_Y",      "tilt_coupling"};
  for (const auto& name : names)
    for (auto at = name.empty() ? text.npos : text.find(name); at != text.npos; at = text.find(name, at))
      text.replace(at, name.size(), " ");
  text = std::regex_replace(text, std::regex("\\.run[0-9]+"), " ");  // a channel of the second recording
  static const std::regex word("[A-Za-z_]*[a-z]{3}[A-Za-z_]*");
  Texts words;
  for (std::sregex_iterator at(text.begin(), text.end(), word), end; at != end; ++at)
    if (!same.contains(at->str())) words.insert(at->str());
  return words;
}

/// Everything that a page shows of it, but titles and findings, which have texts of their own.
Texts words_of(const Estimate& original) {
  constexpr auto zh = Language::chinese;
  const Estimate estimate = in_language(zh, original);
  Texts words{readable_name(zh, estimate.method)};
  for (const auto& parameter : estimate.parameters) {
    words.insert(parameter.description);
    words.insert(readable_name(zh, parameter.name, estimate.method));
  }
  for (const auto& part : estimate.budget) words.insert(part.source);
  for (const auto& table : estimate.tables) {
    words.insert(table.caption), words.insert(readable_name(zh, table.name));
    for (const auto& column : table.columns) words.insert(column.name);
  }
  for (std::size_t t = 0; t < estimate.tables.size(); ++t)
    for (std::size_t i = 0; i < estimate.tables[t].columns.size(); ++i)
      if (!has_names(original.tables[t].columns[i].name))
        for (const auto& row : estimate.tables[t].rows)
          if (const auto* text = std::get_if<std::string>(&row[i])) words.insert(*text);
  for (const auto& figure : in_language(zh, figures_of(original))) {
    words.insert({figure.name, figure.x.name, figure.y.name, figure.z ? figure.z->name : ""});
    words.insert(figure.notes.begin(), figure.notes.end());
    for (const auto& series : figure.series) words.insert({series.name, series.band});
  }
  return words;
}

class ChineseResults : public ::testing::TestWithParam<const Method*> {
 public:
  static void expect_no_english(const Evidence& evidence, const Method& method, Estimate estimate) {
    estimate.method = method.name;
    const auto names = names_in(evidence, method, estimate);
    for (const auto& text : words_of(estimate))
      EXPECT_EQ(english_in(text, names), Texts())
          << method.name << ": '" << text << "': no Chinese in [result] of text/zh.toml";
  }
};

TEST_P(ChineseResults, HaveNoEnglish) {
  const Method& method = *GetParam();
  const auto first = trial_of(method, 1);
  expect_no_english(first.evidence, method, method.identify(first.evidence, {}));
  if (method.predict) expect_no_english(first.evidence, method, method.predict(first.evidence.plan));
  if (!trials_of(method).second) return;
  const auto second = second_trial_of(method, 1);
  expect_no_english(second.evidence, method, method.identify(second.evidence, {}));
}

INSTANTIATE_TEST_SUITE_P(All, ChineseResults, ::testing::ValuesIn(method_catalogue()),
                         [](const auto& entry) { return std::string(entry.param->name); });

/// The plans that travel with the program have every rig, with all its errors.
TEST(ChineseResultsOfPlans, HaveNoEnglish) {
  std::size_t predicted = 0;
  for (const auto& file : std::filesystem::directory_iterator(TUMBLE_SOURCE_DIR "/plans")) {
    if (file.path().extension() != ".toml") continue;
    const Plan plan = load_plan(file.path().string(), {});
    if (plan.method.empty()) continue;  // of a recording for the plans beside it
    const Method& method = find_method(plan.method);
    if (!method.predict) continue;
    ++predicted;
    ChineseResults::expect_no_english({plan, {}}, method, predict(plan));
  }
  EXPECT_GT(predicted, 10u);
}

TEST(ChineseResultsSelfTest, EnglishIsFound) {
  EXPECT_EQ(english_in("gyro_x 角度随机游走 [deg/sqrt(h)]", {"gyro_x"}), Texts{});
  EXPECT_EQ(english_in("gyro_x residual 的残差", {"gyro_x"}), Texts{"residual"});
  EXPECT_EQ(english_in("K_m/K - 1, sum", {}), Texts{"sum"});
}

}  // namespace
}  // namespace tumble
