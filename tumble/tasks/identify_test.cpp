// What identification says of recordings that hold a segment each.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {
namespace {

Recording part_of(const Recording& whole, std::size_t mark) {
  Recording part = whole;
  part.origin.file = "part-" + std::to_string(mark) + ".csv";
  part.marks = {whole.marks[mark]};
  const double begin = whole.marks[mark].begin;
  for (Channel& channel : part.channels) {
    const double rate = channel.timeline.rate, start = channel.timeline.start;
    const auto at = [&](double time) {
      return channel.values.begin() + static_cast<std::ptrdiff_t>(std::min((time - start) * rate + 0.5,
                                                                           static_cast<double>(channel.values.size())));
    };
    const auto end = mark + 1 < whole.marks.size() ? at(whole.marks[mark + 1].begin) : channel.values.end();
    channel.values = std::vector<double>(at(begin), end);
    channel.timeline.start = begin;
  }
  return part;
}

/// The trial of a tumble, each position in a file of its own, all of one plan beside the test's own.
Evidence in_files() {
  const Evidence trial = trial_of(find_method("polar_axis_tumble"), 1).evidence;
  const auto geometry = std::make_shared<const Plan>(trial.plan);
  Evidence evidence{trial.plan, {}};
  evidence.plan.method = "polar_axis_tumble";
  for (std::size_t m = 0; m < trial.recordings[0].marks.size(); ++m) {
    evidence.recordings.push_back(part_of(trial.recordings[0], m));
    evidence.plans.push_back(geometry);
    evidence.plan.recordings.push_back(
        {evidence.recordings.back().origin.file, trial.recordings[0].marks[m].label, 0, geometry});
  }
  return evidence;
}

std::vector<Finding> about_segments(const Estimate& estimate) {
  std::vector<Finding> found;
  for (const Finding& finding : estimate.findings)
    if (finding.code.starts_with("segment_") || finding.code == "not_recorded") found.push_back(finding);
  return found;
}

TEST(Identify, FilesOfOneSegmentEachLackNothing) {
  const auto found = about_segments(identify(in_files(), {}));
  EXPECT_TRUE(found.empty()) << found.front().message;
}

TEST(Identify, ASegmentThatNoFileHoldsIsSaidOnce) {
  Evidence evidence = in_files();
  const std::string lost = evidence.plan.recordings[4].segment;
  evidence.recordings.erase(evidence.recordings.begin() + 4);
  evidence.plans.erase(evidence.plans.begin() + 4);
  evidence.plan.recordings.erase(evidence.plan.recordings.begin() + 4);
  const auto found = about_segments(identify(evidence, {}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "not_recorded");
  EXPECT_NE(found[0].message.find(lost), std::string::npos) << found[0].message;
}

}  // namespace
}  // namespace tumble
