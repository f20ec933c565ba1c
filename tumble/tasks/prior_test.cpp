#include "tumble/tasks/prior.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "tumble/archive/archive.hpp"
#include "tumble/archive/deposit.hpp"
#include "tumble/exchange/populations.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/math/random.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/reduce/prior_rows.hpp"
#include "tumble/reduce/with_prior.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/recompute.hpp"
#include "tumble/tasks/shorten.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

/// Units like this result: each parameter moved by as much as three of its uncertainties.
std::vector<TestedUnit> units_like(const Estimate& estimate, std::uint64_t count) {
  std::vector<TestedUnit> units;
  for (std::uint64_t u = 0; u < count; ++u) {
    TestedUnit unit{"A-" + std::to_string(u), std::to_string(u), false, estimate};
    const auto random = RandomStream(7).split(u);
    for (std::size_t i = 0; i < estimate.parameters.size(); ++i)
      unit.estimate.parameters[i].value += 3.0 * standard_uncertainty(estimate, i) * random.normal(i);
    units.push_back(std::move(unit));
  }
  return units;
}

// Every method that takes a prior gives results that a population can be made of, and that it improves.
TEST(PriorOfMethods, IsUsedForEveryMethodThatTakesOne) {
  for (const Method* method : method_catalogue()) {
    if (!method->takes_prior) continue;
    SCOPED_TRACE(method->name);
    const Estimate result = method->identify(trial_of(*method, 3).evidence, {});
    const auto population = population_of_units("m", method->name, units_like(result, 12));
    const auto use = with_population(result, population);
    ASSERT_TRUE(use.with_prior) << use.belongs << " " << use.belongs_by_one;
    EXPECT_GE(use.with_prior->parameters.size(), population.parameters.size());
    for (std::size_t i = 0; i < use.with_prior->parameters.size(); ++i) {
      const auto& parameter = use.with_prior->parameters[i];
      const double sd = standard_uncertainty(*use.with_prior, i);
      EXPECT_TRUE(std::isfinite(sd) && sd > 0.0) << parameter.name;
      if (const auto* own = find_parameter(result, parameter.name)) {
        EXPECT_LE(sd, 1.0001 * standard_uncertainty(result, static_cast<std::size_t>(own - result.parameters.data())))
            << parameter.name;
      }
    }
  }
}

/// A plan of a tumble in eight positions, a population of both mounts, and a recording.
class PriorOfPlan : public ::testing::Test {
 protected:
  static std::string text(const std::string& top, const std::string& limit = {}) {
    std::string segments;
    for (int angle = 0; angle < 360; angle += 45)
      segments += "[[schedule]]\nlabel = \"" + std::to_string(angle) +
                  " deg\"\nduration = \"40 s\"\nhead = {hold = \"" + std::to_string(angle) + " deg\"}\n";
    return top +
           "\nmethod = \"accelerometer_tumble\"\n[instrument]\nmodel = \"pendulous_accelerometer\"\nserial = \"N-1\"\n"
           "rate = \"1 Hz\"\n[site]\nlatitude = \"34 deg\"\nheight = \"0 m\"\n[rig]\nkind = \"dividing_head\"\n" +
           segments + limit +
           "[truth]\noutput = \"count\"\npulse_scale_factor = \"2000 pulse/s/g\"\nbias = \"3.2 mg\"\n"
           "second_order_coefficient = \"18 ug/g^2\"\nangle_random_walk = \"0.02 (m/s)/sqrt(h)\"\n";
  }

  Plan plan(const std::string& top, const std::string& limit = {}) const {
    const auto file = folder_.file("plan.toml");
    std::ofstream(file) << text(top, limit);
    return load_plan(file, {});
  }

  Estimate result(const Plan& plan, std::uint64_t seed = 1) const {
    return identify(gather(plan, {}, {simulate(plan, seed, {})}, {}), {});
  }

  /// Of units near the plan's own truth.
  std::string population_file(const Plan& plan) const {
    const auto population =
        population_of_units("pendulous_accelerometer", "accelerometer_tumble", units_like(result(plan), 15));
    std::ofstream(folder_.file("population.json")) << to_json(population);
    return "population.json";
  }

  ScratchFolder folder_;
};

TEST_F(PriorOfPlan, OfTheCommandLineIsThatOfTheResultWhenItIsRepeated) {
  population_file(plan(""));
  const auto by_file = load_plan(folder_.file("plan.toml"), {{"prior", folder_.file("population.json")}});
  write_recording(simulate(by_file, 1, {}), folder_.file("data.h5"));
  const auto estimate = identify(by_file, {folder_.file("data.h5")}, std::numeric_limits<std::uintmax_t>::max(), {});
  ASSERT_TRUE(estimate.prior);
  make_archive(folder_.file("lab.db"), "", {"Li Wei", "2026-03-02T09:00:00Z", {}});
  Archive archive(folder_.file("lab.db"));
  Deposit deposit;
  deposit.results.push_back({.json = to_json(estimate), .file = "result.json"});
  for (const char* const name : {"plan.toml", "data.h5"})
    deposit.files.push_back({.path = folder_.file(name), .name = name});
  const auto put = put_in(archive, deposit, {"Li Wei", "2026-03-02T09:00:00Z", {}});
  const ScratchFolder scratch;
  const auto again = recompute(archive, put.result_ids.front(), scratch.path.string(), {});
  EXPECT_TRUE(again.same);
  EXPECT_TRUE(again.differing.empty()) << again.differing.front();
}

TEST_F(PriorOfPlan, AResultOfAnEarlierVersionIsTheSameWhenItIsMadeAgain) {
  const auto loaded = plan("", "[[limit]]\nparameter = \"bias\"\nmax = \"1 g\"\n");
  write_recording(simulate(loaded, 1, {}), folder_.file("data.h5"));
  const auto estimate = identify(loaded, {folder_.file("data.h5")}, std::numeric_limits<std::uintmax_t>::max(), {});
  auto json = nlohmann::ordered_json::parse(to_json(estimate));
  ASSERT_EQ(json["verdicts"].size(), 1u);
  EXPECT_EQ(json["verdicts"][0].erase("upper"), 1u) << "it had the text alone";
  json.erase("models");
  make_archive(folder_.file("lab.db"), "", {"Li Wei", "2026-03-02T09:00:00Z", {}});
  Archive archive(folder_.file("lab.db"));
  Deposit deposit;
  deposit.results.push_back({.json = json.dump(), .file = "result.json"});
  for (const char* const name : {"plan.toml", "data.h5"})
    deposit.files.push_back({.path = folder_.file(name), .name = name});
  const auto put = put_in(archive, deposit, {"Li Wei", "2026-03-02T09:00:00Z", {}});
  const ScratchFolder scratch;
  const auto again = recompute(archive, put.result_ids.front(), scratch.path.string(), {});
  EXPECT_FALSE(again.same_bytes);
  EXPECT_TRUE(again.same);
  EXPECT_TRUE(again.differing.empty()) << again.differing.front();
}

TEST_F(PriorOfPlan, StandsInTheResultBesideTheEstimateWithoutIt) {
  const auto alone = result(plan(""));
  population_file(plan(""));
  const auto with = result(plan("prior = \"population.json\""));
  ASSERT_TRUE(with.prior && with.prior->with_prior);
  for (std::size_t i = 0; i < alone.parameters.size(); ++i) {
    EXPECT_EQ(with.parameters[i].value, alone.parameters[i].value) << "the estimate without prior is unchanged";
    EXPECT_LT(standard_uncertainty(*with.prior->with_prior, i), standard_uncertainty(alone, i));
  }
  EXPECT_NE(to_text(with).find("Parameters with the prior of 15 units"), std::string::npos);
  EXPECT_NE(to_html(with).find("<section id=\"with_prior\">"), std::string::npos);
  EXPECT_NE(to_html(with, {.language = Language::chinese}).find("<section id=\"with_prior\">"), std::string::npos);
  EXPECT_EQ(to_json(alone).find("prior"), std::string::npos) << "without a prior the file is as before";
  EXPECT_EQ(with.prior->from, "population.json");
  EXPECT_EQ(with.provenance.settings.at("prior.sha256"), with.prior->population->population->sha256);
  const auto text = to_json(with);
  const auto read = estimate_from_json(text, "result.json");
  EXPECT_EQ(to_json(read), text);
  // the result itself can be named: the prior's numbers stand in it
  std::ofstream(folder_.file("result.json")) << text;
  const auto again = result(plan("prior = \"result.json\""));
  EXPECT_EQ(again.prior->with_prior->parameters[0].value, with.prior->with_prior->parameters[0].value);
}

TEST_F(PriorOfPlan, VerdictsRestOnTheEstimateWithoutPriorUnlessThePlanSaysOtherwise) {
  population_file(plan(""));
  const auto both = result(plan("prior = \"population.json\""));
  const double without = standard_uncertainty(both, 0), with = standard_uncertainty(*both.prior->with_prior, 0);
  ASSERT_LT(with, without);
  const auto& value = both.prior->with_prior->parameters[0];
  // a limit that only the narrower interval keeps
  const double far = std::abs(both.parameters[0].value - value.value) + 2.5 * with;
  const auto shown = [&](double si) { return std::to_string(value.unit.from_si(si)) + " " + value.unit.text(); };
  const std::string limit = "[[limit]]\nparameter = \"" + value.name + "\"\nmin = \"" + shown(value.value - far) +
                            "\"\nmax = \"" + shown(value.value + far) + "\"\n";
  const auto by_own = result(plan("prior = \"population.json\"", limit));
  const auto by_prior = result(plan("prior = {from = \"population.json\", verdicts = \"with\"}", limit));
  EXPECT_EQ(by_prior.verdicts.at(0).outcome, Verdict::Outcome::pass);
  EXPECT_TRUE(by_prior.prior->verdicts);
  EXPECT_FALSE(by_own.prior->verdicts);
  EXPECT_EQ(by_own.verdicts.at(0).outcome, result(plan("", limit)).verdicts.at(0).outcome);
}

TEST_F(PriorOfPlan, AUnitThatDoesNotFitGetsNone) {
  population_file(plan(""));
  auto alien = plan("prior = \"population.json\"");
  alien.truth = load_plan(alien.file, {{"truth.bias", "40 mg"}}).truth;
  const auto found = result(alien);
  ASSERT_TRUE(found.prior);
  EXPECT_FALSE(found.prior->with_prior);
  EXPECT_TRUE(
      std::ranges::any_of(found.findings, [](const Finding& one) { return one.code == "unit_not_of_population"; }));
  EXPECT_EQ(to_json(estimate_from_json(to_json(found), "x")), to_json(found));
}

TEST_F(PriorOfPlan, IsRefusedWithAllThatIsWrong) {
  const auto input = Error::Kind::bad_input;
  EXPECT_TRUE(refuses(input, Asked{.pattern = "--archive ARCHIVE"}, [&] { result(plan("prior = \"archive\"")); }));
  EXPECT_TRUE(refuses(input, Asked{.key = "prior"}, [&] { plan("prior = 3"); }));
  EXPECT_TRUE(refuses(
      input, {{.values = {"from", "from"}, .pattern = "is missing"}, {.pattern = "is \"without\"", .key = "verdicts"}},
      [&] { plan("prior = {form = \"archive\", verdicts = \"maybe\"}"); }));
  EXPECT_TRUE(refuses(input, Asked{.part = "allan_noise"}, [&] {
    plan_for_method("allan_noise", {{"prior", "x.json"}});
  }));
  std::ofstream(folder_.file("other.json")) << to_json(result(plan("")));
  EXPECT_TRUE(refuses(input, Asked{.part = "other.json", .pattern = "the prior"},
                      [&] { result(plan("prior = \"other.json\"")); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "absent.json", .pattern = "cannot read"},
                      [&] { result(plan("prior = \"absent.json\"")); }));
}

TEST_F(PriorOfPlan, IsPartOfThePrediction) {
  population_file(plan(""));
  const auto predicted = predict(plan("prior = \"population.json\""));
  ASSERT_TRUE(predicted.prior && predicted.prior->with_prior);
  EXPECT_LT(standard_uncertainty(*predicted.prior->with_prior, 0), standard_uncertainty(predicted, 0));
  EXPECT_TRUE(find_table(predicted, "prior"));
}

TEST_F(PriorOfPlan, ShortensTheTestAndSaysByHowMuch) {
  population_file(plan(""));
  auto asked = plan("prior = \"population.json\"");
  OptimiseOptions options;
  options.step = 0.7853981633974483;  // 45 deg
  const auto found = shorten(asked, options, {});
  const Table* table = find_table(found.estimate, "shorter_tests");
  ASSERT_TRUE(table);
  const auto time = [&](std::size_t row) { return std::get<double>(table->rows.at(row)[1]); };
  EXPECT_LE(time(1), time(0));
  EXPECT_LE(time(2), time(1));
  double total = 0.0;
  for (const auto& segment : found.schedule) total += segment.duration;
  EXPECT_NEAR(total, time(2), 1e-6);
  EXPECT_LE(std::get<double>(table->rows[2][3]), 1.002);
}

}  // namespace
}  // namespace tumble
