// What every entry of every catalogue promises: its name, its summary, its page, its options and its units.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tumble/checks/check.hpp"
#include "tumble/departures/judgement.hpp"
#include "tumble/exchange/exports/export.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/models/model.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;
const fs::path source{TUMBLE_SOURCE_DIR};

std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// An entry as far as all catalogues agree.
struct Entry {
  std::string folder, name, summary, page;
  std::vector<Option> options;
};

// GoogleTest finds it by this name. NOLINTNEXTLINE(readability-identifier-naming)
void PrintTo(const Entry& entry, std::ostream* out) { *out << entry.folder << "/" << entry.name; }

std::string page_of(const std::string& folder, const std::string& name) {
  if (folder == "checks" || folder == "exchange/exports")
    return folder == "checks" ? "docs/checks.md" : "docs/exports.md";
  return "docs/" + folder + "/" + name + ".md";
}

template <typename Descriptor, typename Options>
void append(std::vector<Entry>& entries, const std::string& folder, const std::vector<const Descriptor*>& catalogue,
            Options options) {
  for (const auto* d : catalogue)
    entries.push_back({folder, d->name, d->summary, page_of(folder, d->name), options(*d)});
}

std::vector<Entry> all_entries() {
  std::vector<Entry> entries;
  const auto none = [](const auto&) { return std::vector<Option>{}; };
  append(entries, "methods", method_catalogue(), [](const Method& m) { return m.options(); });
  append(entries, "rigs", rig_catalogue(), [](const Rig& r) { return r.options(); });
  append(entries, "models", model_catalogue(), [](const Model& m) { return truth_options(m); });
  append(entries, "checks", check_catalogue(), none);
  append(entries, "formats", format_catalogue(), none);
  append(entries, "exchange/exports", export_catalogue(), [](const Export& e) {
    auto options = common_export_options();
    for (auto& option : e.options()) options.push_back(std::move(option));
    return options;
  });
  return entries;
}

class Catalogue : public ::testing::TestWithParam<Entry> {};

TEST_P(Catalogue, NameIsTheFileStemInSnakeCase) {
  const auto& entry = GetParam();
  EXPECT_TRUE(std::regex_match(entry.name, std::regex("[a-z][a-z0-9]*(_[a-z0-9]+)*")));
  const auto module = source / "tumble" / entry.folder;
  const bool alone = fs::exists(module / (entry.name + ".cpp"));
  EXPECT_TRUE(alone || fs::exists(module / entry.name / (entry.name + ".cpp")));
  EXPECT_FALSE(alone && entry.folder == "methods") << "a method has a folder of its own";
}

TEST_P(Catalogue, HasSummaryAndPage) {
  const auto& entry = GetParam();
  EXPECT_FALSE(entry.summary.empty());
  EXPECT_EQ(entry.summary.find('\n'), std::string::npos) << "a summary is one line";
  ASSERT_TRUE(fs::exists(source / entry.page)) << entry.page << " is missing";
  EXPECT_NE(text_of(source / entry.page).find(entry.name), std::string::npos) << entry.page << " does not name it";
  const auto link = "(" + entry.page.substr(std::string("docs/").size()) + ")";
  EXPECT_NE(text_of(source / "docs/README.md").find(link), std::string::npos) << "docs/README.md lacks " << link;
}

TEST_P(Catalogue, OptionsAreDescribedAndUnique) {
  std::set<std::string> seen;
  for (const auto& option : GetParam().options) {
    EXPECT_TRUE(seen.insert(option.name).second) << option.name << " twice";
    EXPECT_FALSE(option.description.empty()) << option.name;
    EXPECT_NO_THROW(Unit::parse(option.unit)) << option.name;
    EXPECT_EQ(option.type == Option::Type::word, !option.words.empty()) << option.name;
  }
}

TEST_P(Catalogue, PageNamesEveryOptionOfAMethodOrRig) {
  const auto& entry = GetParam();
  if (entry.folder != "methods" && entry.folder != "rigs") return;
  const auto page = text_of(source / entry.page);
  for (const auto& option : entry.options) {
    EXPECT_NE(page.find(option.name), std::string::npos) << entry.page << " does not mention " << option.name;
  }
}

TEST_P(Catalogue, DefaultsAreAcceptedAsAUserWouldWriteThem) {
  const auto& entry = GetParam();
  Problems problems;
  const auto settings = resolve(entry.options, {}, Sentence(entry.name.c_str()), problems);
  std::vector<Given> given;
  for (const auto& [key, text] : settings.texts()) given.push_back({key, text, Where{.place = "--set"}, true, true});
  const auto again = resolve(entry.options, given, Sentence(entry.name.c_str()), problems);
  EXPECT_TRUE(problems.empty()) << problems.front().text();
  EXPECT_EQ(again.texts(), settings.texts());
}

TEST_P(Catalogue, MistypedOptionIsRefusedWithTheNearestName) {
  const auto& entry = GetParam();
  for (const auto& option : entry.options) {
    Problems problems;
    const auto mistyped = option.name + "q";  // with an x D_x would become D_xx, which some gyros have
    resolve(entry.options, {{mistyped, "1", Where{.place = "plan.toml:7"}, true, false}}, Sentence(entry.name.c_str()),
            problems);
    ASSERT_EQ(problems.size(), 1u) << option.name;
    const std::string problem = problems[0].text();
    EXPECT_NE(problem.find(mistyped), std::string::npos) << problem;
    EXPECT_NE(problem.find("plan.toml:7"), std::string::npos) << problem;
    const auto rest = std::regex_replace(problem, std::regex(mistyped), "");
    const auto suggested = std::any_of(entry.options.begin(), entry.options.end(),
                                       [&](const Option& o) { return rest.find(o.name) != std::string::npos; });
    EXPECT_TRUE(suggested) << "suggests nothing: " << problem;
  }
}

TEST_P(Catalogue, QuantityOfTheWrongDimensionIsRefused) {
  const auto& entry = GetParam();
  for (const auto& option : entry.options) {
    if (option.type != Option::Type::quantity) continue;
    Problems problems;
    resolve(entry.options, {{option.name, "1 kg^3", Where{.place = "plan.toml:7"}, true, false}},
            Sentence(entry.name.c_str()), problems);
    EXPECT_EQ(problems.size(), 1u) << option.name;
  }
}

TEST_P(Catalogue, BareNumberIsRefusedInAPlanWhereAUnitIsNeeded) {
  const auto& entry = GetParam();
  for (const auto& option : entry.options) {
    if (option.type != Option::Type::quantity) continue;
    if (Unit::parse(option.unit).dimension() == Dimension{}) continue;
    for (const bool quoted : {false, true}) {
      Problems problems;
      resolve(entry.options, {{option.name, "1", Where{.place = "plan.toml:7"}, quoted, false}},
              Sentence(entry.name.c_str()), problems);
      EXPECT_EQ(problems.size(), 1u) << option.name << (quoted ? " quoted" : " unquoted");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Catalogue, ::testing::ValuesIn(all_entries()), [](const auto& entry) {
  std::string name = entry.param.folder + "_" + entry.param.name;
  std::ranges::replace(name, '/', '_');
  return name;
});

TEST(CatalogueFolders, NamesAreUniqueInEachFolder) {
  std::set<std::string> seen;
  for (const auto& entry : all_entries())
    EXPECT_TRUE(seen.insert(entry.folder + "/" + entry.name).second) << entry.name;
}

TEST(Readme, HasARowForEveryMethod) {
  const auto readme = text_of(source / "README.md");
  for (const auto* method : method_catalogue()) {
    const std::string name = method->name;
    const auto row = "| [`" + name + "`](docs/methods/" + name + ".md) | " + method->summary + " |";
    EXPECT_NE(readme.find(row), std::string::npos) << "README.md lacks the row\n" << row;
  }
}

template <typename Descriptor>
std::string entry_name(const ::testing::TestParamInfo<const Descriptor*>& entry) {
  return entry.param->name;
}

class Models : public ::testing::TestWithParam<const Model*> {};

TEST_P(Models, OutputsAndTermsAreWhole) {
  const Model& model = *GetParam();
  EXPECT_NE(std::string(model.source), "");
  EXPECT_EQ(&find_model(model.name), &model);
  const auto outputs = model.outputs(defaults(model.constants()));
  ASSERT_FALSE(outputs.empty());
  std::set<std::string> seen, channels;
  for (const auto& output : outputs) {
    EXPECT_TRUE(channels.insert(output.channel).second) << output.channel << " twice";
    EXPECT_EQ(kind_of(Unit::parse(output.unit)), output.kind) << output.channel;
    EXPECT_FALSE(output.terms.empty()) << output.channel;
    for (const auto& term : output.terms) {
      EXPECT_TRUE(seen.insert(term.name).second) << term.name << " twice";
      EXPECT_FALSE(term.symbol.empty() || term.description.empty()) << term.name;
      EXPECT_NO_THROW(Unit::parse(term.unit)) << term.name;
      EXPECT_TRUE(std::isfinite(term.regressor(Felt{}))) << term.name;
      EXPECT_EQ(term.regressor(Felt{}), term.regressor(Felt{})) << term.name;
    }
  }
}

TEST_P(Models, PhysicsGivesCoefficientsOfItsOwnTerms) {
  const Model& model = *GetParam();
  EXPECT_EQ(model.physics == nullptr, model.coefficients == nullptr);
  if (!model.physics) return;
  const auto truth = defaults(truth_options(model));
  std::set<std::string> terms;
  for (const auto& output : model.outputs(truth)) {
    for (const auto& term : output.terms) terms.insert(term.name);
    for (const double coefficient : coefficients_of(model, output, truth)) EXPECT_TRUE(std::isfinite(coefficient));
  }
  for (const auto& [name, value] : model.coefficients(truth)) EXPECT_TRUE(terms.contains(name)) << name;
}

TEST_P(Models, RecordsEveryOutputTheSameWhateverTheBlocks) {
  const Model& model = *GetParam();
  if (!model.record) return;
  const auto truth = defaults(truth_options(model));
  for (std::size_t k = 0; k < model.outputs(truth).size(); ++k) {
    const Recorded whole = model.record(truth, k, 0.01, RandomStream(3)),
                   parts = model.record(truth, k, 0.01, RandomStream(3));
    EXPECT_EQ(kind_of(Unit::parse(whole.unit)), whole.kind);
    if (!whole.response) continue;
    std::vector<double> once(100), twice;
    for (std::size_t i = 0; i < once.size(); ++i) once[i] = 1e-3 * static_cast<double>(i % 7);
    twice = once;
    whole.response(once);
    parts.response(std::span(twice).first(33));
    parts.response(std::span(twice).subspan(33));
    EXPECT_EQ(once, twice);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Models, ::testing::ValuesIn(model_catalogue()), entry_name<Model>);

class Rigs : public ::testing::TestWithParam<const Rig*> {};

TEST_P(Rigs, AxesAreWholeAndAScheduleWithoutThemIsRefused) {
  const Rig& rig = *GetParam();
  const auto axes = rig.axes();
  EXPECT_FALSE(axes.empty());
  for (const auto& axis : axes) {
    EXPECT_NO_THROW(Unit::parse(axis.unit)) << axis.name;
    EXPECT_FALSE(axis.motions.empty() || axis.description.empty()) << axis.name;
  }
  Segment segment{"odd", 10.0, 1, {{"no_such_axis", Motion{}}}};
  const auto refusals = rig.refusals({segment}, defaults(rig.options()));
  EXPECT_FALSE(refusals.empty());  // a plan's reader names the axis (tasks); a rig must not run without its own
}

INSTANTIATE_TEST_SUITE_P(All, Rigs, ::testing::ValuesIn(rig_catalogue()), entry_name<Rig>);

class Checks : public ::testing::TestWithParam<const Check*> {};

/// One channel at 10 Hz with these values, evenly sampled or stamped.
Recording recording_of(const std::vector<double>& values, bool stamped) {
  Recording recording;
  Channel channel{"gyro", QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, 10.0, nullptr}, values};
  if (stamped) {
    auto stamps = std::make_shared<std::vector<double>>();
    for (std::size_t i = 0; i < values.size(); ++i) stamps->push_back(0.1 * static_cast<double>(i));
    channel.timeline = {0.0, 0.0, stamps};
  }
  recording.channels = {channel};
  return recording;
}

TEST_P(Checks, SurvivesEveryPoorRecording) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  const std::vector<std::vector<double>> poor{
      {}, {1.0}, {nan}, {nan, nan, nan, nan}, {1.0, 1.0, 1.0, 1.0}, {infinity, -infinity, 0.0}, {1.0, nan, 2.0}};
  const Plan plan;
  for (const auto& values : poor) {
    for (const bool stamped : {false, true}) {
      for (const Plan* with : {static_cast<const Plan*>(nullptr), &plan}) {
        for (const auto& finding : GetParam()->run(recording_of(values, stamped), with)) {
          EXPECT_FALSE(finding.message.empty());
        }
      }
    }
  }
  EXPECT_NO_THROW(GetParam()->run(Recording{}, nullptr));
}

INSTANTIATE_TEST_SUITE_P(All, Checks, ::testing::ValuesIn(check_catalogue()), entry_name<Check>);

/// The section of a page that begins with this heading; empty: there is none.
std::string section_of(const std::string& page, const std::string& heading) {
  const auto begin = page.find("\n## " + heading + "\n");
  return begin == page.npos ? "" : page.substr(begin, page.find("\n## ", begin + 1) - begin);
}

TEST(UnseenDepartures, StandOnThePageOfTheirMethod) {
  for (const Unseen& unseen : unseen_departures())
    for (const Method* method : method_catalogue()) {
      if (find_unseen(unseen.departure, method->name) != &unseen) continue;
      const bool of_any = *unseen.method == '\0';
      const std::string page = of_any ? "docs/departures.md" : page_of("methods", method->name);
      const std::string section =
          section_of(text_of(source / page), of_any ? "What no test can see" : "What this test cannot see");
      EXPECT_NE(section.find(std::string("`") + unseen.departure + "`"), std::string::npos)
          << page << ": what cannot be seen lacks " << unseen.departure;
    }
}

}  // namespace
}  // namespace tumble
