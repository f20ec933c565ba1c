#include "tumble/report/members.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tumble/report/testing/member_leaves.hpp"
#include "tumble/report/testing/member_schema.hpp"

namespace tumble {

/// Made up for these tests.
struct MadePart {
  std::string label;
  std::optional<std::size_t> parameter;
};

struct MadeValue {
  enum class State { open, shut };
  State state = State::open;
  double limit = 0.0, gain = 1.0;
  std::size_t count = 0;
  bool hidden = false;
  Unit unit;
  std::vector<double> readings;  ///< [SI]
  std::vector<MadePart> parts;
  std::string name;
};

template <class Visitor, PossiblyConst<MadePart> X>
void members(Visitor& visit, X& x) {
  visit("label", x.label).index("parameter", x.parameter);
}

const EnumerationWords made_words{"open", "shut"};

template <class Visitor, PossiblyConst<MadeValue> X>
void members(Visitor& visit, X& x) {
  visit("state", x.state, made_words)("limit", x.limit, INFINITY)("count", x.count);
  visit.optional("gain", x.gain, x.gain != 1.0).optional("hidden", x.hidden, x.hidden);
  visit("unit", x.unit)("readings", x.readings, x.unit)("parts", x.parts)("name", x.name);
  if (x.count > 9) visit.complain("count", "is too large");
}

namespace {

MadeValue made() {
  return {.state = MadeValue::State::shut,
          .limit = INFINITY,
          .count = 2,
          .unit = Unit::parse("mm"),
          .readings = {0.001, NAN},
          .parts = {{"left", 3}, {"right", {}}},
          .name = "\"a\""};
}

std::string written(const MadeValue& value) {
  auto json = nlohmann::ordered_json::object();
  MembersToJson visit{JsonObject(&json)};
  members(visit, value);
  return json.dump();
}

MadeValue read(const std::string& text, Problems& problems) {
  const auto json = nlohmann::json::parse(text);
  MadeValue value;
  MembersFromJson visit(Node(&json, "", &problems), 4);
  members(visit, value);
  return value;
}

constexpr const char* text_of_made = R"({"state":"shut","limit":null,"count":2,"unit":"mm","readings":[1.0,null],)"
                                     R"("parts":[{"label":"left","parameter":3},{"label":"right"}],"name":"\"a\""})";

TEST(Members, AreWrittenInTheirOrderAndOptionalOnesWhereTheyAreNeeded) {
  EXPECT_EQ(written(made()), text_of_made);
  MadeValue value = made();
  value.gain = 2.0;
  EXPECT_NE(written(value).find(R"("count":2,"gain":2.0,"unit")"), std::string::npos);
}

TEST(Members, AreReadAsTheyWereWritten) {
  Problems problems;
  const MadeValue value = read(text_of_made, problems);
  EXPECT_TRUE(problems.empty());
  EXPECT_EQ(written(value), text_of_made);
  EXPECT_EQ(value.limit, INFINITY);
  EXPECT_EQ(value.gain, 1.0);
  EXPECT_EQ(value.readings.at(0), 0.001);
  EXPECT_EQ(value.parts.at(0).parameter, 3u);
  EXPECT_FALSE(value.parts.at(1).parameter.has_value());
}

TEST(Members, EveryProblemIsSaidWithItsPath) {
  Problems problems;
  read(R"({"state":"ajar","limit":1,"count":12,"unit":"parsnip","readings":[],"parts":[{"label":1,"parameter":4}]})",
       problems);
  std::vector<std::string> paths;
  for (const Problem& problem : problems) paths.push_back(problem.where.key);
  EXPECT_EQ(paths,
            (std::vector<std::string>{"state", "unit", "parts[0].label", "parts[0].parameter", "name", "count"}));
}

TEST(Members, TwoValuesAreComparedByTheirLeaves) {
  const auto leaves = testing::leaves_of(made());
  EXPECT_EQ(std::get<std::string>(leaves.at("parts[0].label")), "left");
  EXPECT_EQ(std::get<double>(leaves.at("parts[0].parameter")), 3.0);
  EXPECT_FALSE(leaves.contains("parts[1].parameter"));
  EXPECT_EQ(std::get<std::string>(leaves.at("unit")), "mm");
  EXPECT_EQ(std::get<double>(leaves.at("state")), 1.0);
}

TEST(Members, SchemaSaysTypesAndWhatMayBeMissing) {
  const auto schema = testing::schema_of<MadeValue>();
  EXPECT_EQ(schema["required"],
            nlohmann::json::array({"state", "limit", "count", "unit", "readings", "parts", "name"}));
  EXPECT_EQ(schema["properties"]["state"]["enum"], nlohmann::json::array({"open", "shut"}));
  EXPECT_EQ(schema["properties"]["count"]["type"], "integer");
  EXPECT_EQ(schema["properties"]["readings"]["items"]["type"], "number");
  EXPECT_EQ(schema["properties"]["parts"]["items"]["required"], nlohmann::json::array({"label"}));
}

}  // namespace
}  // namespace tumble
