#include "tumble/archive/past_results.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "tumble/archive/statistics.hpp"
#include "tumble/archive/testing/samples.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/math/random.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

const SummaryRequest of_gyros{.what = {"bias", "gyro", {}}};

/// Results of 12 units: some twice on a day, two rigs, one without a time.
std::vector<ResultDeposit> made(const ScratchFolder& folder) {
  const RandomStream random{5};
  std::vector<ResultDeposit> results;
  for (std::uint64_t i = 0; i < 20; ++i) {
    auto deposit = testing::sample_deposit({.serial = std::to_string(i % 12),
                                            .bias = 1.0 + random.normal(i),
                                            .ended = i == 7       ? ""
                                                     : i % 2 == 0 ? "2026-02-01T12:00:00Z"
                                                                  : "2026-02-03T12:00:00Z",
                                            .recording_sha256 = std::string(64, static_cast<char>('a' + i % 5)),
                                            .rig = i % 3 == 0 ? "rig A" : "rig B"});
    deposit.file = folder.file(std::to_string(i) + ".json");
    std::ofstream(deposit.file) << deposit.json;
    results.push_back(deposit);
  }
  return results;
}

std::vector<SummarisedResult> summaries_of(const std::vector<ResultDeposit>& deposits) {
  Problems problems;
  std::vector<SummarisedResult> summaries;
  for (const auto& deposit : deposits)
    summaries.push_back(summary_of_result(deposit, testing::sample_act().when, problems));
  EXPECT_TRUE(problems.empty());
  return summaries;
}

TEST(PastResults, AFolderAndAnArchiveGiveTheSameAnswers) {
  const ScratchFolder folder;
  const auto deposits = made(folder);
  const auto summaries = summaries_of(deposits);
  make_archive(folder.file("lab.db"), "", testing::sample_act());
  Archive archive(folder.file("lab.db"));
  put_in(archive, {.results = deposits}, testing::sample_act());
  const auto past = past_results(summaries, "bias", "gyro");
  EXPECT_EQ(to_json(summary_of_results(past, of_gyros)), to_json(summary_of_model(archive, of_gyros)));
  const ChartRequest chart{.what = of_gyros.what};
  EXPECT_EQ(to_json(chart_of_results(past, chart)), to_json(chart_of_archive(archive, chart)));
}

TEST(PastResults, AModelWithoutTheParameterIsRefused) {
  const ScratchFolder folder;
  const auto summaries = summaries_of(made(folder));
  for (const auto& [parameter, model] : {std::pair{"bias", "another"}, {"scale_factor", "gyro"}}) try {
      past_results(summaries, parameter, model);
      FAIL() << parameter << " of " << model;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind, Error::Kind::bad_input);
    }
}

TEST(PastResults, WhatIsNoResultIsAProblem) {
  Problems problems;
  const auto summary = summary_of_result({.json = "{}", .file = "x.json"}, "2026-03-02T09:00:00Z", problems);
  EXPECT_TRUE(summary.sha256.empty());
  ASSERT_FALSE(problems.empty());  // one for each member that a result has
  for (const Problem& problem : problems) EXPECT_EQ(problem.where.file, "x.json") << problem.text();
}

}  // namespace
}  // namespace tumble
