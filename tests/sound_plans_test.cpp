// A test that is carried out as a ready plan says gets no warning, as a laboratory has it: a file of numbers, and a plan without
// a truth. What a reader, a column of text or a rounded stamp adds is not seen by tests in memory.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <set>
#include <string>
#include <vector>

#include "tumble/formats/format.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/tasks/ready_plans.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {
namespace {

/// Tests of one plan, and how many of them may get a warning: more have p < 2e-3 where one in a hundred does.
struct Wanted {
  std::size_t seeds, most_warned;
};
constexpr Wanted wanted_always{1, 0}, wanted_of_long_plans{5, 1}, wanted_of_all{20, 2};
constexpr std::uint64_t first_seed = 501;

/// Plans whose samples take seconds to write and to read: where the tests may take long.
const std::set<std::string_view> long_plans{
    "dtg_centrifuge", "dtg_centrifuge_spin_down", "frequency_response", "imu_at_rest",
    "imu_turntable",  "random_vibration",         "sine_vibration",     "north_finding_turning"};

bool may_take_long() {
  const char* seeds = std::getenv("TUMBLE_COVERAGE_SEEDS");
  return seeds != nullptr && std::atoi(seeds) >= 400;
}

/// Those that one recording answers.
std::vector<std::string> plans_of_one_recording() {
  std::vector<std::string> names;
  for (const ReadyPlan& plan : ready_plans())
    if (!plan.method.empty() && plan.beside.empty()) names.emplace_back(plan.name);
  return names;
}

/// What a laboratory has: nobody knows the truth of a real instrument.
Plan without_truth(Plan plan) {
  plan.truth = {};
  for (auto& one : plan.beside) one.truth = {};
  return plan;
}

std::set<std::string> warnings_of(const Plan& plan, std::uint64_t seed, const ScratchFolder& scratch) {
  const std::string file = scratch.file("recording.csv");
  write_recording(simulate(plan, seed, {}), file);
  std::set<std::string> codes;
  for (const Finding& finding : identify(without_truth(plan), {file}, std::size_t{1} << 30, {}).findings)
    if (finding.severity != Finding::Severity::info) codes.insert(finding.code);
  return codes;
}

class SoundPlanCoverage : public ::testing::TestWithParam<std::string> {};

TEST_P(SoundPlanCoverage, GetsNoWarningFromAFile) {
  const bool all = may_take_long(), is_long = long_plans.contains(GetParam());
  if (!all && is_long) GTEST_SKIP() << "in script/test --full";
  const Wanted wanted = is_long ? wanted_of_long_plans : all ? wanted_of_all : wanted_always;
  const ScratchFolder scratch;
  const Plan plan = load_plan(TUMBLE_SOURCE_DIR "/plans/" + GetParam() + ".toml", {});
  std::set<std::string> codes;
  std::size_t warned = 0;
  for (std::uint64_t seed = first_seed; seed < first_seed + wanted.seeds; ++seed) {
    const std::set<std::string> one = warnings_of(plan, seed, scratch);
    warned += !one.empty();
    codes.insert(one.begin(), one.end());
  }
  EXPECT_LE(warned, wanted.most_warned) << fmt::format("{}", fmt::join(codes, " "));
}

INSTANTIATE_TEST_SUITE_P(Plans, SoundPlanCoverage, ::testing::ValuesIn(plans_of_one_recording()),
                         [](const auto& plan) { return plan.param; });

}  // namespace
}  // namespace tumble
