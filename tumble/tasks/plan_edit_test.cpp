#include "tumble/tasks/plan_edit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "tumble/core/tables/document.hpp"
#include "tumble/tasks/ready_plans.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

const std::string plan = R"(# 测试: what this is for
title  = "Rate"   # shown in reports
method = "imu_turntable"

[rig]
kind     = "rate_table"
level_sd = "2 arcsec"  # 水平 measured in May

# Positions first.
[[schedule]]
label    = "up"    # the first
duration = "2 min"
axis     = {hold = "0 deg", other = 1}  # north

[[schedule]]
label = "down"
duration = "1 min"

# What it really is.
[truth]
bias = "1 deg/h"
)";

std::string set(const std::string& text, const PlanPath& path, const std::string& value) {
  return with_value(text, "plan.toml", path, value);
}

/// `text` with one place changed.
std::string with(std::string text, const std::string& what, const std::string& by) {
  const auto place = text.find(what);
  EXPECT_NE(place, std::string::npos) << what;
  return text.replace(place, what.size(), by);
}

TEST(PlanEdit, ReplacesAValueAndNothingElse) {
  EXPECT_EQ(set(plan, {"title"}, "\"静态\""), with(plan, "\"Rate\"", "\"静态\""));
  EXPECT_EQ(set(plan, {"rig", "level_sd"}, "\"3 arcsec\""), with(plan, "\"2 arcsec\"", "\"3 arcsec\""));
  EXPECT_EQ(set(plan, {"schedule", "0", "axis", "hold"}, "\"90 deg\""), with(plan, "\"0 deg\"", "\"90 deg\""));
  EXPECT_EQ(set(plan, {"schedule", "0", "axis"}, "{rate = \"1 deg/s\"}"),
            with(plan, "{hold = \"0 deg\", other = 1}", "{rate = \"1 deg/s\"}"));
}

TEST(PlanEdit, AddsAValueBelowTheOthersOfItsSection) {
  EXPECT_EQ(set(plan, {"rig", "ideal"}, "true"), with(plan, "measured in May\n", "measured in May\nideal    = true\n"));
  EXPECT_EQ(set(plan, {"prior"}, "\"archive\""),
            with(plan, "\"imu_turntable\"\n", "\"imu_turntable\"\nprior  = \"archive\"\n"));
  EXPECT_EQ(set(plan, {"schedule", "1", "run"}, "[1, 2]"), with(plan, "\"1 min\"\n", "\"1 min\"\nrun      = [1, 2]\n"));
  EXPECT_EQ(set(plan, {"schedule", "0", "axis", "to"}, "1"), with(plan, "other = 1}", "other = 1, to = 1}"));
}

TEST(PlanEdit, AddsASectionBeforeTheSchedule) {
  EXPECT_EQ(set(plan, {"site", "latitude"}, "\"34 deg\""),
            with(plan, "# Positions first.\n", "[site]\nlatitude = \"34 deg\"\n\n# Positions first.\n"));
  EXPECT_EQ(set("title = \"x\"", {"site", "latitude"}, "\"34 deg\""),
            "title = \"x\"\n\n[site]\nlatitude = \"34 deg\"\n");
  EXPECT_EQ(set("", {"title"}, "\"x\""), "title = \"x\"\n\n");
}

TEST(PlanEdit, RemovesAValueAndKeepsItsComment) {
  EXPECT_EQ(without_value(plan, "plan.toml", {"rig", "level_sd"}),
            with(plan, "level_sd = \"2 arcsec\"  # 水平", "# 水平"));
  EXPECT_EQ(without_value(plan, "plan.toml", {"schedule", "1", "duration"}), with(plan, "duration = \"1 min\"\n", ""));
  EXPECT_EQ(without_value(plan, "plan.toml", {"schedule", "0", "axis", "hold"}), with(plan, "hold = \"0 deg\", ", ""));
  EXPECT_EQ(without_value(plan, "plan.toml", {"schedule", "0", "axis", "other"}), with(plan, ", other = 1", ""));
  EXPECT_EQ(without_value(plan, "plan.toml", {"rig", "absent"}), plan);
  EXPECT_EQ(without_value(plan, "plan.toml", {"absent", "absent"}), plan);
}

TEST(PlanEdit, CopiesMovesAndDeletesSegments) {
  const std::string down = "[[schedule]]\nlabel = \"down\"\nduration = \"1 min\"\n";
  EXPECT_EQ(with_copy(plan, "plan.toml", {"schedule", 1}), with(plan, down, down + "\n" + down));
  EXPECT_EQ(without_table(plan, "plan.toml", {"schedule", 1}), with(plan, down + "\n", ""));
  const auto moved = with_next_before(plan, "plan.toml", {"schedule", 0});
  EXPECT_LT(moved.find("\"down\""), moved.find("\"up\""));
  EXPECT_LT(moved.find("# Positions first."), moved.find("\"down\""));
  EXPECT_EQ(with_next_before(moved, "plan.toml", {"schedule", 0}), plan);
  EXPECT_EQ(with_table(plan, "plan.toml", "schedule", "label = \"new\"\n"),
            with(plan, down, down + "\n[[schedule]]\nlabel = \"new\"\n"));
  EXPECT_EQ(with_table("title = \"x\"\n", "plan.toml", "limit", "parameter = \"bias\""),
            "title = \"x\"\n\n[[limit]]\nparameter = \"bias\"\n");
  const auto none = without_table(without_table(plan, "plan.toml", {"schedule", 0}), "plan.toml", {"schedule", 0});
  EXPECT_EQ(none.find("[[schedule]]"), std::string::npos);
  EXPECT_NE(none.find("# Positions first."), std::string::npos);
}

TEST(PlanEdit, RefusesWhatItCannotDo) {
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "the place of the value is missing"},
                      [&] { set(plan, {}, "1"); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"rig"}, .pattern = "is a section"},
                      [&] { set(plan, {"rig"}, "1"); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"not TOML"}}, [&] {
    set(plan, {"rig", "kind"}, "not TOML");
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"1\nother = 2"}}, [&] {
    set(plan, {"rig", "kind"}, "1\nother = 2");
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.part = "schedule.7.label"}, [&] {
    set(plan, {"schedule", "7", "label"}, "1");
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.part = "title.deeper"}, [&] {
    set(plan, {"title", "deeper"}, "1");
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "not TOML", .file = "plan.toml", .line = 1},
                      [&] { set("title = ", {"title"}, "1"); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"plan.toml", "schedule"}, .pattern = "no such"}, [&] {
    with_copy(plan, "plan.toml", {"schedule", 2});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"plan.toml"}, .pattern = "the last one"}, [&] {
    with_next_before(plan, "plan.toml", {"schedule", 1});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"plan.toml", "schedule", "schedule"}}, [&] {
    without_table("schedule = [{label = \"a\"}]", "plan.toml", {"schedule", 0});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"plan.toml"}, .pattern = "not TOML"},
                      [&] { with_table(plan, "plan.toml", "schedule", "label = "); }));
}

std::size_t comments_of(const std::string& text) { return static_cast<std::size_t>(std::ranges::count(text, '#')); }

/// Every value of a plan, one after the other.
void each_value(const toml::node& node, const PlanPath& path, const std::function<void(const PlanPath&)>& visit) {
  if (const auto* table = node.as_table()) {
    for (const auto& [key, child] : *table) {
      auto next = path;
      next.emplace_back(key.str());
      each_value(child, next, visit);
    }
  } else if (const auto* array = node.as_array(); array && array->is_array_of_tables()) {
    for (std::size_t i = 0; i < array->size(); ++i) {
      auto next = path;
      next.push_back(std::to_string(i));
      each_value(*array->get(i), next, visit);
    }
  } else {
    visit(path);
  }
}

// Each value of each plan that comes with the program can be changed and removed, and no comment is lost. That nothing
// else changes is what the functions check themselves.
TEST(PlanEdit, EveryValueOfEveryReadyPlan) {
  std::size_t values = 0;
  for (const auto& ready : ready_plans()) {
    const std::string text(ready.text);
    const auto document = tables::document_of(text, std::string(ready.name));
    each_value(document, {}, [&](const PlanPath& path) {
      if (values++ % 5 != 0) return;  // a fifth of them: the whole would take a minute
      EXPECT_EQ(comments_of(set(text, path, "\"changed\"")), comments_of(text)) << ready.name;
      EXPECT_EQ(comments_of(without_value(text, "plan", path)), comments_of(text)) << ready.name;
    });
    const auto* schedule = document["schedule"].as_array();
    for (std::size_t i = 0; schedule && i < schedule->size(); i += 7) {
      const PlanList segment{"schedule", i};
      const auto copied = with_copy(text, "plan", segment);
      EXPECT_EQ(without_table(copied, "plan", {"schedule", i + 1}), text) << ready.name << i;
      if (i + 1 < schedule->size()) {
        EXPECT_EQ(with_next_before(with_next_before(text, "plan", segment), "plan", segment), text) << ready.name << i;
      }
    }
  }
  EXPECT_GT(values, 1000u);
}

}  // namespace
}  // namespace tumble
