// Where the clock of a recording begins says nothing about the instrument: a logger that counts from its power-on, a
// clock of the day and Unix time give the same values, uncertainties, degrees of freedom and findings. Asked of every
// trial of every method, once more with all bias instabilities stated.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/trials.hpp"

namespace tumble {
namespace {

/// The same recording by a clock that shows `later` more [s]. Channels that share stamps share them afterwards.
void shift(Recording& recording, double later) {
  std::map<const std::vector<double>*, std::shared_ptr<const std::vector<double>>> moved;
  for (auto& channel : recording.channels) {
    Timeline& timeline = channel.timeline;
    timeline.start += later;
    if (timeline.uniform()) continue;
    auto& stamps = moved[timeline.stamps.get()];
    if (!stamps) {
      auto shifted = *timeline.stamps;
      for (double& stamp : shifted) stamp += later;
      stamps = std::make_shared<const std::vector<double>>(std::move(shifted));
    }
    timeline.stamps = stamps;
  }
  for (auto& mark : recording.marks) {
    mark.begin += later;
    mark.end += later;
  }
}

/// States every bias instability that the method has an option for: flicker is what the length of a test enters.
void state_instabilities(const Method& method, Settings& settings) {
  for (const auto& option : method.options()) {
    if (!option.name.ends_with("bias_instability")) continue;
    const Unit unit = Unit::parse(option.unit);
    const bool rate = unit.dimension() == Unit::parse("deg/h").dimension();
    settings.set_number(option.name, rate ? si(5.0, "deg/h") : si(50.0, "ug"), unit);
  }
}

enum class Variant { trial, second_trial, stated };

/// A trial of a method by other clocks.
struct Case {
  const Method& method;
  Variant variant = Variant::trial;
  double shift = 0.0;      ///< [s] of the clock of the first recording
  double more_each = 0.0;  ///< [s] for each further one

  Evidence evidence() const {
    Trial trial = variant == Variant::second_trial ? second_trial_of(method, 1) : trial_of(method, 1);
    if (variant == Variant::stated) state_instabilities(method, trial.evidence.plan.settings);
    for (std::size_t r = 0; r < trial.evidence.recordings.size(); ++r)
      tumble::shift(trial.evidence.recordings[r], shift + more_each * static_cast<double>(r));
    return std::move(trial.evidence);
  }

  /// What may change of a value, in standard uncertainties. Stamps and marks are doubles: with the shift they are
  /// rounded by eps/2 of it, 1.1e-10 s at 1e6 s and 1.9e-7 s at Unix time. The trials know phases of 100 Hz and angles
  /// at 500 deg/s within some 1e-4 of a radian, which is 1.6e-7 s and 1.1e-5 s: at Unix time the rounding itself is of
  /// the size of an uncertainty. Half of one is allowed there, in proportion to the rounding before, and always what
  /// sums of 1e6 numbers leave.
  double tolerance() const { return std::max(1e-5, 0.5 * shift / 1.7e9); }
  /// And of an uncertainty, as a part of it: a shift of the data within their noise changes it by its square.
  double tolerance_of_sd() const { return std::max(1e-5, 0.25 * tolerance()); }
};

std::string said(const Finding& finding) { return finding.code + " '" + finding.where + "': " + finding.message; }

void expect_same_findings(const Findings& now, const Findings& before) {
  const auto key = [](const Finding& f) {
    return f.code + "|" + f.where + "|" + std::to_string(static_cast<int>(f.severity)) + "|" +
           std::to_string(f.occurrences.count) + "|" + f.occurrences.first.label + "|" + f.occurrences.worst.label;
  };
  std::multimap<std::string, const Finding*> remaining;
  for (const auto& finding : before) remaining.emplace(key(finding), &finding);
  for (const auto& finding : now) {
    const auto same = remaining.find(key(finding));
    if (same == remaining.end())
      ADD_FAILURE() << "a new finding: " << said(finding);
    else
      remaining.erase(same);
  }
  for (const auto& [text, finding] : remaining) ADD_FAILURE() << "no finding any more: " << said(*finding);
}

/// Two degrees of freedom, of which either may be infinite.
double freedom_apart(double now, double before) {
  if (std::isinf(now) || std::isinf(before)) return now == before ? 0.0 : std::numeric_limits<double>::infinity();
  return std::abs(now / before - 1.0);
}

void expect_same(const Estimate& now, const Estimate& before, const Case& one) {
  ASSERT_EQ(now.parameters.size(), before.parameters.size());
  for (std::size_t i = 0; i < now.parameters.size(); ++i) {
    const Parameter &a = now.parameters[i], &b = before.parameters[i];
    ASSERT_EQ(a.name, b.name);
    const double sd = std::sqrt(before.covariance(i, i));
    EXPECT_LT(std::abs(a.value - b.value) / sd, one.tolerance()) << a.name << ": value";
    EXPECT_LT(std::abs(std::sqrt(now.covariance(i, i)) / sd - 1.0), one.tolerance_of_sd()) << a.name << ": uncertainty";
    EXPECT_LT(freedom_apart(a.degrees_of_freedom, b.degrees_of_freedom), 2.0 * one.tolerance_of_sd()) << a.name;
  }
  expect_same_findings(now.findings, before.findings);
}

class ClockOrigin : public ::testing::TestWithParam<const Method*> {
 protected:
  void expect_no_change(Variant variant) const {
    const Method& method = *GetParam();
    const Estimate before = method.identify(Case{method, variant}.evidence(), {});
    for (const Case& one : {Case{method, variant, 1e3}, Case{method, variant, 1e6 + 1.0 / 3.0, 12'345.678},
                            Case{method, variant, 1.7e9 + 0.1234567}}) {
      SCOPED_TRACE(std::string(method.name) + ", the clock begins at " + std::to_string(one.shift) + " s");
      expect_same(method.identify(one.evidence(), {}), before, one);
    }
  }
};

TEST_P(ClockOrigin, ChangesNothingInTheTrial) { expect_no_change(Variant::trial); }

TEST_P(ClockOrigin, ChangesNothingInTheSecondTrial) {
  if (trials_of(*GetParam()).second != nullptr) expect_no_change(Variant::second_trial);
}

TEST_P(ClockOrigin, ChangesNothingWhereTheBiasInstabilityIsStated) {
  const auto options = GetParam()->options();
  const auto states = [](const Option& option) { return option.name.ends_with("bias_instability"); };
  if (std::ranges::any_of(options, states)) expect_no_change(Variant::stated);
}

INSTANTIATE_TEST_SUITE_P(All, ClockOrigin, ::testing::ValuesIn(method_catalogue()),
                         [](const auto& entry) { return std::string(entry.param->name); });

}  // namespace
}  // namespace tumble
