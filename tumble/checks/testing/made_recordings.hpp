#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tumble/checks/check.hpp"
#include "tumble/core/testing/asserts.hpp"
#include "tumble/math/random.hpp"

/// Small recordings for the tests of checks, and what a check says of them.
namespace tumble::testing {

inline Channel channel(std::string name, const char* unit, std::vector<double> values_in_unit, double rate = 100.0) {
  Channel made;
  made.name = std::move(name);
  made.unit = Unit::parse(unit);
  made.kind = kind_of(made.unit);
  made.timeline.rate = rate;
  made.values = std::move(values_in_unit);
  for (double& value : made.values) value = made.unit.to_si(value);
  return made;
}

inline Recording recording(std::vector<Channel> channels) {
  Recording made;
  made.channels = std::move(channels);
  return made;
}

inline std::vector<double> series(std::size_t count, const std::function<double(std::size_t)>& value) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = value(i);
  return values;
}

inline std::vector<double> white(std::size_t count, std::uint64_t seed) {
  std::vector<double> values(count);
  RandomStream(seed).normal(0, values);
  return values;
}

inline Findings findings_of(std::string_view check, const Recording& recording, const Plan* plan = nullptr) {
  for (const Check* entry : check_catalogue())
    if (entry->name == check) return entry->run(recording, plan);
  ADD_FAILURE() << "no check " << check;
  return {};
}

inline std::string said(const Findings& findings) {
  std::string text;
  for (const auto& finding : findings) text += finding.where + ": " + finding.message + "\n";
  return text;
}

/// The only finding.
inline Finding finding_of(std::string_view check, const Recording& recording, const Plan* plan = nullptr) {
  const Findings findings = findings_of(check, recording, plan);
  EXPECT_EQ(findings.size(), 1u) << said(findings);
  return findings.empty() ? Finding{} : findings[0];
}

inline Recording stamped(std::vector<double> stamps) {
  Channel made = channel("gyro", "deg/h", white(stamps.size(), 1));
  made.timeline.rate = 0.0;
  made.timeline.stamps = std::make_shared<const std::vector<double>>(std::move(stamps));
  return recording({made});
}

inline Channel counts(std::vector<double> values) { return channel("accelerometer", "pulse", std::move(values)); }

inline Plan two_runs() {
  Plan plan;
  plan.schedule = {{"soak", 60.0, 1, {}}, {"ramp", 120.0, 1, {}}, {"soak", 60.0, 2, {}}, {"ramp", 120.0, 2, {}}};
  return plan;
}

}  // namespace tumble::testing
