#include "tumble/report/parameter_rows.hpp"

#include <gtest/gtest.h>

#include "tumble/report/testing/example_estimate.hpp"
#include "tumble/report/typeset.hpp"

namespace tumble {
namespace {

TEST(ParameterRows, AreRoundedBySdAndSplitAtThePoint) {
  const auto rows = parameter_rows(testing::estimate());
  const auto& small = rows[1];  // -4.117e-5 deg/h/K^2
  EXPECT_EQ(small.value.before + small.value.after, "-4.12");
  EXPECT_EQ(small.value.after, ".12");
  EXPECT_EQ(small.sd.before + small.sd.after, "0.33");
  EXPECT_EQ(small.power, "× 10⁻⁵");
  EXPECT_EQ(small.degrees_of_freedom, "∞");
  const auto& bias = rows[7];
  EXPECT_EQ(bias.power, "");
  EXPECT_EQ(bias.text, "0.451 ± 0.018");
  EXPECT_EQ(bias.lower.before + bias.lower.after, "0.394");
  EXPECT_EQ(bias.upper.before + bias.upper.after, "0.509");
  EXPECT_EQ(rows[8].readable, "angle random walk");
}

TEST(Typeset, NumbersInCharacters) {
  EXPECT_EQ(number_in_characters("(-0.5 ± 1.2)e-6"), "(−0.5 ± 1.2) × 10⁻⁶");
  EXPECT_EQ(number_in_characters("1.5e12"), "1.5 × 10¹²");
  for (const char* text : {"unknown", "–", "0.12", "", "e", "2e"}) EXPECT_EQ(number_in_characters(text), text);
}

TEST(ParameterRows, WhatIsNotDeterminedSaysSo) {
  auto estimate = testing::estimate();
  estimate.parameters[0].value = std::numeric_limits<double>::quiet_NaN();
  estimate.covariance(1, 1) = std::numeric_limits<double>::infinity();
  const auto rows = parameter_rows(estimate);
  EXPECT_EQ(rows[0].value.before, "unknown");
  EXPECT_EQ(rows[0].lower.before, "");
  EXPECT_EQ(rows[1].sd.before, "unbounded");
  EXPECT_FALSE(rows[1].rounded);
}

}  // namespace
}  // namespace tumble
