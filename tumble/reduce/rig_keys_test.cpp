#include "tumble/reduce/rig_keys.hpp"

#include <gtest/gtest.h>

#include "tumble/core/testing/asserts.hpp"
#include "tumble/rigs/error_names.hpp"

namespace tumble::rig_keys {
namespace {

const std::string level = error_names::level_about_east;
const std::string index_zero = std::string(error_names::index_zero_of) + "head";

Estimate result_with(std::vector<Contribution> budget) {
  Estimate estimate;
  estimate.budget = std::move(budget);
  return estimate;
}

Contribution line(const std::string& source, const std::string& key) { return {source, key, Matrix(1, 1, 2.0)}; }

std::vector<std::string> codes_of(const Findings& findings) {
  std::vector<std::string> codes;
  for (const auto& finding : findings) codes.push_back(finding.code);
  return codes;
}

TEST(RigKeys, KnowTheErrorsThatARigHasForAllTests) {
  EXPECT_TRUE(is_error_of_rig(level));
  EXPECT_TRUE(is_error_of_rig(index_zero));
  EXPECT_FALSE(is_error_of_rig(std::string(error_names::positioning_of) + "head")) << "drawn anew in every segment";
  EXPECT_FALSE(is_error_of_rig(error_names::mounting_x)) << "of one test";
  EXPECT_FALSE(is_error_of_rig("output noise"));
}

TEST(RigKeys, ResultsWithoutARigShareOne) {
  const auto one = result_with({line(level, ""), line("output noise", "")});
  const Keys keys({&one, &one});
  EXPECT_EQ(keys.of(one.budget[0]), unstated);
  EXPECT_EQ(keys.of(one.budget[1]), "");
}

// The rig that most results name is the likeliest one of a result that names none, and the cautious choice.
TEST(RigKeys, ARigThatOneResultDoesNotNameIsThatOfTheOthers) {
  const auto stated = result_with({line(level, "H-1")}), other = result_with({line(level, "H-2")});
  const auto silent = result_with({line(level, "")});
  EXPECT_EQ(Keys({&stated, &stated, &other, &silent}).of(silent.budget[0]), "H-1");
}

TEST(RigKeys, SpacesSignsAndCapitalsMakeNoOtherRig) {
  const auto one = result_with({line(level, "H-1, cert 7")}), other = result_with({line(level, "H-1, cert. 7")});
  const Keys keys({&one, &one, &other});
  EXPECT_EQ(keys.of(other.budget[0]), "H-1, cert 7");
  EXPECT_EQ(codes_of(about_keys({&one, &other})), std::vector<std::string>{"equipment_spelled_twice"});
}

TEST(RigKeys, ANumberIsNoSlipAndALetterIs) {
  EXPECT_FALSE(look_like_a_slip("H-1, cert 7", "H-2, cert 7")) << "two heads";
  EXPECT_FALSE(look_like_a_slip("H-1, cert 7", "H-1, cert 17")) << "another certificate";
  EXPECT_TRUE(look_like_a_slip("head H-1", "haed H-1") || look_like_a_slip("head H-1", "hed H-1"));
  EXPECT_TRUE(look_like_a_slip("H-1", "H-l"));
  EXPECT_FALSE(look_like_a_slip("H-1", "H-1"));
}

TEST(RigKeys, AResultTakesTheKeysOfItsPopulation) {
  const auto named = result_with({line(level, "H-1, cert 7")}), silent = result_with({line(level, unstated)});
  EXPECT_EQ(with_keys_of(result_with({line(level, "h-1 cert. 7")}), named).budget[0].key, "H-1, cert 7");
  EXPECT_EQ(with_keys_of(result_with({line(level, "")}), named).budget[0].key, "H-1, cert 7");
  EXPECT_EQ(with_keys_of(result_with({line(level, "H-1, cert 7")}), silent).budget[0].key, unstated)
      << "it may be the rig of the population, which does not say";
  EXPECT_EQ(with_keys_of(result_with({line("gravity", "gravity 9.8 m/s^2")}), silent).budget[0].key,
            "gravity 9.8 m/s^2");
}

TEST(RigKeys, ResultsThatNameTheirRigsAreNotTalkedAbout) {
  const auto one = result_with({line(level, "H-1")}),
             other = result_with({line(level, "H-2"), line("output noise", "")});
  EXPECT_TRUE(about_keys({&one, &other}).empty());
  const auto silent = result_with({line(index_zero, "")});
  EXPECT_EQ(codes_of(about_keys({&one, &silent})), std::vector<std::string>{"rig_not_stated"});
}

}  // namespace
}  // namespace tumble::rig_keys
