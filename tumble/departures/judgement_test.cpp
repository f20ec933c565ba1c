#include "tumble/departures/judgement.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tumble {
namespace {

using Answers = std::vector<Answer>;

/// Ten answers that are off by this number of standard uncertainties, with these codes.
Answers ten(double deviation, std::vector<std::string> codes = {}) {
  return Answers(10, Answer{.deviations = {deviation}, .codes = std::move(codes)});
}

const std::vector<std::string> gap{"gap"};

TEST(CellJudgement, HeldBelowTheLimit) {
  EXPECT_EQ(judge_cell(ten(2.19), ten(1.0), gap, false).handling, Handling::held);
  EXPECT_EQ(judge_cell(ten(2.21), ten(1.0), gap, false).handling, Handling::silent);
}

TEST(CellJudgement, OneParameterThatIsWrongIsEnough) {
  Answers answers = ten(0.5);
  for (Answer& answer : answers) answer.deviations.push_back(3.0);
  const CellVerdict verdict = judge_cell(answers, ten(1.0), gap, false);
  EXPECT_EQ(verdict.handling, Handling::silent);
  EXPECT_EQ(verdict.worst, 1u);
  EXPECT_DOUBLE_EQ(verdict.worst_rms, 3.0);
}

TEST(CellJudgement, AnInfiniteDeviationIsWrong) {
  EXPECT_EQ(judge_cell(ten(INFINITY), ten(1.0), gap, false).handling, Handling::silent);
}

TEST(CellJudgement, AValueThatIsNotGivenIsNotWrong) {
  EXPECT_EQ(judge_cell(ten(std::nan("")), ten(1.0), gap, false).handling, Handling::held);
}

TEST(CellJudgement, ToldInNineOfTen) {
  Answers answers = ten(50.0, {"gap"});
  answers[3].codes.clear();
  EXPECT_EQ(judge_cell(answers, ten(1.0), gap, false).handling, Handling::named);
  answers[4].codes.clear();
  EXPECT_EQ(judge_cell(answers, ten(1.0), gap, false).handling, Handling::silent);
}

TEST(CellJudgement, WhatIsSaidOfSoundTestsTellsNothing) {
  EXPECT_EQ(judge_cell(ten(50.0, {"gap"}), ten(1.0, {"gap"}), gap, false).handling, Handling::silent);
}

TEST(CellJudgement, AWrongFindingBesideAWrongNumberIsSilent) {
  const CellVerdict verdict = judge_cell(ten(50.0, {"outlier"}), ten(1.0), gap, false);
  EXPECT_EQ(verdict.handling, Handling::silent);
  EXPECT_EQ(verdict.other_codes, std::vector<std::string>{"outlier"});
}

TEST(CellJudgement, ARefusalNamesTheDepartureOrNot) {
  Answers answers(10, Answer{.refusal = "no", .refusal_code = "gap"});
  EXPECT_EQ(judge_cell(answers, ten(1.0), gap, false).handling, Handling::named);
  for (Answer& answer : answers) answer.refusal_code = "outlier";
  EXPECT_EQ(judge_cell(answers, ten(1.0), gap, false).handling, Handling::refused);
}

TEST(CellJudgement, RefusedInHalfAndWrongInTheOthersIsSilent) {
  Answers answers = ten(50.0);
  for (std::size_t i = 0; i < 5; ++i) answers[i] = Answer{.refusal = "no"};
  EXPECT_EQ(judge_cell(answers, ten(1.0), gap, false).handling, Handling::silent);
}

TEST(CellJudgement, CannotBeSeenIsListedAndShown) {
  EXPECT_EQ(judge_cell(ten(50.0), ten(1.0), gap, true).handling, Handling::cannot_be_seen);
  Answers worse = ten(50.0);
  worse[0].reduced_chi_square = 3.0;  // 1 in the sound tests
  EXPECT_EQ(judge_cell(worse, ten(1.0), gap, true).handling, Handling::silent);
  Answers contradicted = ten(50.0);
  contradicted[0].other_channels_changed = true;
  EXPECT_EQ(judge_cell(contradicted, ten(1.0), gap, true).handling, Handling::silent);
  EXPECT_EQ(judge_cell(ten(50.0, {"outlier"}), ten(1.0), gap, true).handling, Handling::silent);
}

TEST(CellJudgement, EachThatCannotBeSeenLooksSoundOrIsNamed) {
  Answers some = ten(50.0);
  for (std::size_t i = 0; i < 3; ++i) some[i].codes = {"gap"}, some[i].reduced_chi_square = 3.0;
  EXPECT_EQ(judge_cell(some, ten(1.0), gap, true).handling, Handling::cannot_be_seen);
  EXPECT_EQ(judge_cell(some, ten(1.0), gap, false).handling, Handling::silent);
  some[5].codes = {"outlier"};
  EXPECT_EQ(judge_cell(some, ten(1.0), gap, true).handling, Handling::silent);
}

// A dead band that the output is never in.
TEST(CellJudgement, SeedsThatTheDepartureDoesNotMoveAreNoCasesOfIt) {
  Answers answers = ten(50.0, {"gap"});
  for (std::size_t i = 0; i < 3; ++i) answers[i] = {.deviations = {1.05}};
  EXPECT_EQ(judge_cell(answers, ten(1.0), gap, false).handling, Handling::named);
  answers[0].deviations = {1.2};  // 7 of 8 are named
  EXPECT_EQ(judge_cell(answers, ten(1.0), gap, false).handling, Handling::silent);
  answers[0] = {.deviations = {1.05}, .codes = {"outlier"}};
  EXPECT_EQ(judge_cell(answers, ten(1.0), gap, false).handling, Handling::silent);
}

TEST(CellJudgement, SoundTestsThatAreAccusedAreCounted) {
  Answers sound = ten(1.0);
  sound[2].codes = {"gap", "jitter"};
  sound[5] = Answer{.refusal = "no"};
  const Accusations accusations = accusations_in(sound);
  EXPECT_EQ(accusations.tests, 10u);
  EXPECT_EQ(accusations.warned, 1u);
  EXPECT_EQ(accusations.refused, 1u);
  EXPECT_EQ(accusations.codes, (std::vector<std::string>{"gap", "jitter"}));
}

// A value of 3 +- 1 with 4 degrees of freedom: its interval is +- 2.776, so that a truth of 0 is 3 x 1.96/2.776 = 2.118 away.
TEST(Answers, CountInWidthsOfTheInterval) {
  Estimate estimate;
  estimate.parameters = {{"a", "a", Unit(), 3.0, "", 4.0}};
  estimate.covariance = Matrix(1, 1, 1.0);
  estimate.findings = {{Finding::Severity::info, "single_power_up", {}}};
  const Answer answer = answer_of(estimate, {{"a", 0.0}, {"b", 1.0}});
  EXPECT_NEAR(answer.deviations[0], 2.118, 5e-4);  // half a unit of the last digit
  EXPECT_TRUE(std::isnan(answer.deviations[1]));
  EXPECT_TRUE(answer.codes.empty());
}

TEST(Unseen, IsFoundByDepartureAndMethod) {
  EXPECT_NE(find_unseen("output_gain", "allan_noise"), nullptr);
  EXPECT_NE(find_unseen("asymmetry", "static_bias"), nullptr);
  EXPECT_EQ(find_unseen("asymmetry", "sdof_gyro_dynamic"), nullptr);
}

}  // namespace
}  // namespace tumble
