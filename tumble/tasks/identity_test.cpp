#include "tumble/tasks/identity.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "tumble/core/testing/asserts.hpp"
#include "tumble/core/unit_facts.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

Recording recorded_as(const std::string& file, const std::map<std::string, std::string>& facts) {
  Recording recording;
  recording.origin.file = file;
  recording.meta = facts;
  return recording;
}

/// A test by the plan of "P", with these recordings.
Evidence evidence_of(const std::vector<Recording>& recordings, const std::map<std::string, std::string>& given = {}) {
  Evidence evidence{{}, recordings};
  evidence.plan.instrument_serial = given.contains(serial_key) ? given.at(serial_key) : "P";
  evidence.plan.sha256 = "abc";
  evidence.plan.command_line = given;
  return evidence;
}

TEST(UnitIdentity, TheRecordingGoesBeforeThePlan) {
  const UnitIdentity other = unit_of(evidence_of({recorded_as("a.h5", {{"unit", "A"}})}));
  EXPECT_EQ(other.serial, "A");
  ASSERT_EQ(other.findings.size(), 1u);
  EXPECT_TRUE(is_finding(other.findings[0], "serial_of_recording", {{"recorded", "A"}, {"planned", "P"}}, "a.h5"));
  const UnitIdentity nobody = unit_of(evidence_of({recorded_as("a.h5", {})}));
  EXPECT_EQ(nobody.serial, "P");
  EXPECT_TRUE(nobody.findings.empty());
}

TEST(UnitIdentity, ARunByThisPlanStatesItsUnit) {
  const UnitIdentity unit =
      unit_of(evidence_of({recorded_as("run.h5", {{"unit unit", "DTG-07"}, {"plan_sha256", "abc"}})}));
  EXPECT_EQ(unit.serial, "DTG-07");
  EXPECT_TRUE(unit.findings.empty());
}

TEST(UnitIdentity, TheUnitOfASlotIsFound) {
  const std::map<std::string, std::string> two{{"unit a", "1"}, {"unit b", "2"}, {"plan_sha256", "abc"}};
  auto of_b = two;
  of_b["slot"] = "b";
  EXPECT_EQ(unit_of(evidence_of({recorded_as("b.h5", of_b)})).serial, "2");
  EXPECT_EQ(unit_of(evidence_of({recorded_as("both.h5", two)})).serial, "P");
  EXPECT_EQ(unit_of(evidence_of({recorded_as("both.h5", two)}, {{slot_key, "a"}, {serial_key, "1"}})).serial, "1");
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"b.h5", "b", "a"}}, [&] {
    unit_of(evidence_of({recorded_as("b.h5", of_b)}, {{slot_key, "a"}, {serial_key, "1"}}));
  }));
}

TEST(UnitIdentity, AContradictionIsRefused) {
  EXPECT_EQ(unit_of(evidence_of({recorded_as("a.h5", {{"unit", "A"}})}, {{serial_key, "A"}})).serial, "A");
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"B", "a.h5", "A"}}, [] {
    unit_of(evidence_of({recorded_as("a.h5", {{"unit", "A"}})}, {{serial_key, "B"}}));
  }));
  const std::vector<Recording> mixed{recorded_as("a.h5", {{"unit", "A"}}), recorded_as("b.h5", {{"unit", "B"}})};
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"a.h5", "A", "b.h5", "B"}},
                      [&] { unit_of(evidence_of(mixed)); }));
}

TEST(UnitIdentity, PartsOfTheUnitHaveNumbersOfTheirOwn) {
  Evidence evidence = evidence_of({recorded_as("whole.h5", {{"unit", "A"}}), recorded_as("part.h5", {{"unit", "77"}})});
  auto part = std::make_shared<Plan>(evidence.plan);
  part->instrument_model = "pendulous_accelerometer";
  evidence.plans = {nullptr, part};
  EXPECT_EQ(unit_of(evidence).serial, "A");
}

TEST(UnitIdentity, TheCommandLineStatesItWithoutAPlan) {
  const Plan plan = plan_for_method("allan_noise", {{serial_key, "S-1"}, {"rate", "100"}});
  EXPECT_EQ(plan.instrument_serial, "S-1");
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.part = serial_key}, [] {
    plan_for_method("allan_noise", {{serial_key, ""}});
  }));
}

}  // namespace
}  // namespace tumble
