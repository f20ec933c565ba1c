#include "tumble/tasks/noticed.hpp"

#include <gtest/gtest.h>

namespace tumble {
namespace {

constexpr auto warning = Finding::Severity::warning;

Finding gaps(const std::string& channel, std::size_t count, double time) {
  return {warning, Phrase{"gaps", "there are {count} gaps"}, {}, channel, {count, Place(time), Place(time)}};
}

TEST(Noticed, OneRecordingSaysEachOfItsFindings) {
  const auto findings = gathered({{"a.csv", {gaps("x", 2, 1.0), gaps("y", 3, 1.0)}}});
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].where, "x");
}

TEST(Noticed, SixtyFilesWithOneFaultAreOneFinding) {
  std::vector<NoticedIn> noticed;
  for (std::size_t i = 0; i < 60; ++i)
    noticed.push_back({"part-" + std::to_string(i) + ".csv", {gaps("x", i == 7 ? 5u : 1u, 1.0)}});
  const auto findings = gathered(noticed);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].where, "part-0.csv, x and 59 more places");
  EXPECT_EQ(findings[0].occurrences.count, 64u);
  EXPECT_EQ(findings[0].occurrences.worst.label, "part-7.csv, x");
}

TEST(Noticed, OtherSeveritiesAndOtherFaultsStayApart) {
  Finding severe = gaps("x", 1, 1.0), other = gaps("x", 1, 1.0);
  severe.severity = Finding::Severity::error;
  other.code = "backward";
  const auto findings = gathered({{"a.csv", {gaps("x", 1, 1.0), severe, other}}, {"b.csv", {gaps("x", 1, 1.0)}}});
  ASSERT_EQ(findings.size(), 3u);
  EXPECT_EQ(findings[0].where, "a.csv, x and 1 more place");
  EXPECT_EQ(findings[1].where, "a.csv, x");
}

}  // namespace
}  // namespace tumble
