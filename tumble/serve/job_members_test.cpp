#include "tumble/serve/job_members.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tumble/report/testing/member_leaves.hpp"
#include "tumble/report/testing/member_schema.hpp"

namespace tumble {
namespace {

Job job() {
  return {.id = "000007",
          .kind = "identify",
          .title = "bench.toml",
          .steps = {{"identify", "bench.toml"}, {"report", "{folder}/result.json"}},
          .state = Job::State::failed,
          .progress = 0.5,
          .problems = {Problem(say("cannot read '{}'", Name{"a.csv"}))},
          .begun = 1.75e9,
          .owner = "Li",
          .folder = 18446744073709551615ull,
          .files = {"result.json"},
          .scratch = "plan.toml"};
}

Job read(const nlohmann::json& json) {
  Problems problems;
  Job job;
  MembersFromJson visit(Node(&json, "", &problems));
  kept_members(visit, job);
  EXPECT_EQ(texts_of(problems), std::vector<std::string>());
  return job;
}

nlohmann::json written(const Job& job) {
  auto json = nlohmann::ordered_json::object();
  MembersToJson visit{JsonObject(&json)};
  kept_members(visit, job);
  return nlohmann::json::parse(json.dump());
}

TEST(JobMembers, AJobIsKeptWithItsProblems) {
  const Job again = read(written(job()));
  EXPECT_EQ(written(again), written(job()));
  EXPECT_EQ(again.steps, job().steps);
  EXPECT_EQ(again.folder, job().folder);
  ASSERT_EQ(again.problems.size(), 1u);
  EXPECT_EQ(again.problems[0].what.pattern, "cannot read '{}'");
}

TEST(JobMembers, AJobOfAnEarlierVersionHasTextsAlone) {
  auto json = written(job());
  json.erase("errors");
  EXPECT_EQ(texts_of(read(json).problems), std::vector<std::string>{"cannot read 'a.csv'"});
}

TEST(JobMembers, TheDescriptionOfTheServerHasThem) {
  std::ifstream file(TUMBLE_SOURCE_DIR "/web/openapi.json");
  const auto description = nlohmann::json::parse(file);
  const auto schema = testing::schema_of<Job>();
  EXPECT_EQ(description["components"]["schemas"]["Job"], schema) << schema.dump(1);
}

}  // namespace
}  // namespace tumble
