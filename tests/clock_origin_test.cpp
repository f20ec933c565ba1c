// Where the clock of a recording begins says nothing about the instrument: a logger that counts from its power-on, a day
// clock and Unix time give the same values, uncertainties, degrees of freedom and findings. Asked of every trial of every
// method.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tumble/methods/method.hpp"

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

/// One trial of a method, and by how much the clocks of its recordings are shifted [s].
struct Case {
  const Method* method = nullptr;
  bool second = false;
  double shift = 0.0, more_each = 0.0;  ///< of the first recording; more for each further one

  Evidence evidence() const {
    Trial trial = second ? method->second_trial(1) : method->trial(1);
    for (std::size_t r = 0; r < trial.evidence.recordings.size(); ++r)
      tumble::shift(trial.evidence.recordings[r], shift + more_each * static_cast<double>(r));
    return std::move(trial.evidence);
  }

  /// Of the stamps [s]: half of the last binary place of the greatest.
  double rounding() const { return 0.5 * (std::nextafter(latest(), std::numeric_limits<double>::infinity()) - latest()); }
  double latest() const { return 1e4 + shift + 4.0 * more_each; }
};

/// What a time may be a part of.
bool as_before(double now, double before, const Case& one) {
  if (std::isnan(before)) return std::isnan(now);
  if (std::isinf(before)) return now == before;
  return std::abs(now - before) <= 1e-5 * std::abs(before) + 1e-12;
  (void)one;
}

std::string said(const Finding& finding) {
  return finding.code + " '" + finding.where + "': " + finding.message;
}

void expect_same_findings(const Findings& now, const Findings& before) {
  std::multimap<std::string, std::size_t> left;
  const auto key = [](const Finding& f) {
    return f.code + "|" + f.where + "|" + std::to_string(static_cast<int>(f.severity)) + "|" +
           std::to_string(f.occurrences.count);
  };
  for (std::size_t i = 0; i < before.size(); ++i) left.emplace(key(before[i]), i);
  for (const auto& finding : now) {
    const auto found = left.find(key(finding));
    if (found == left.end())
      ADD_FAILURE() << "said by the other clock alone: " << said(finding);
    else
      left.erase(found);
  }
  for (const auto& [text, i] : left) ADD_FAILURE() << "no longer said: " << said(before[i]);
}

void expect_same(const Estimate& now, const Estimate& before, const Case& one) {
  ASSERT_EQ(now.parameters.size(), before.parameters.size());
  double worst = 0.0, worst_sd = 0.0, worst_dof = 0.0;
  std::string name, name_sd, name_dof;
  for (std::size_t i = 0; i < now.parameters.size(); ++i) {
    const Parameter &a = now.parameters[i], &b = before.parameters[i];
    ASSERT_EQ(a.name, b.name);
    const double sd = std::sqrt(before.covariance(i, i)), sd_now = std::sqrt(now.covariance(i, i));
    const double off = std::abs(a.value - b.value) / sd, off_sd = std::abs(sd_now / sd - 1.0);
    const double off_dof = std::isfinite(b.degrees_of_freedom) ? std::abs(a.degrees_of_freedom / b.degrees_of_freedom - 1.0) : (std::isfinite(a.degrees_of_freedom) ? 1e9 : 0.0);
    if (off > worst) worst = off, name = a.name;
    if (off_sd > worst_sd) worst_sd = off_sd, name_sd = a.name;
    if (off_dof > worst_dof) worst_dof = off_dof, name_dof = a.name;
  }
  std::printf("%s%s by %g: value %.2g sd (%s), sd %.2g (%s), dof %.2g (%s)\n", one.method->name, one.second ? " second" : "", one.shift, worst, name.c_str(), worst_sd, name_sd.c_str(), worst_dof, name_dof.c_str());
  EXPECT_LT(worst, 1e-3) << name;
  EXPECT_LT(worst_sd, 1e-3) << name_sd;
  EXPECT_LT(worst_dof, 1e-3) << name_dof;
  expect_same_findings(now.findings, before.findings);
}

class ClockOrigin : public testing::TestWithParam<const Method*> {};

TEST_P(ClockOrigin, DoesNotChangeTheAnswer) {
  for (const bool second : {false, true}) {
    const Method& method = *GetParam();
    if (second && method.second_trial == nullptr) continue;
    const Estimate before = method.identify(Case{&method, second}.evidence(), {});
    for (const double shift : {1e3, 1e6, 1.7e9}) {
      const Case one{&method, second, shift, shift == 1e6 ? 12345.0 : 0.0};
      SCOPED_TRACE(std::string(method.name) + (second ? " second trial" : "") + ", clock begins at " + std::to_string(shift) + " s");
      expect_same(method.identify(one.evidence(), {}), before, one);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ClockOrigin, testing::ValuesIn(method_catalogue()),
                         [](const auto& entry) { return std::string(entry.param->name); });

}  // namespace
}  // namespace tumble
