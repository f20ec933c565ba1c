// dtg_centrifuge where an axis was recorded at another phase than the plan begins it with: each level in a file of its
// own, cut anywhere, and an arm that speeds up otherwise than the plan says. The instant of a segment's end belongs to
// the next segment, which begins elsewhere; the rates and the specific force of a level must not depend on it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

constexpr double rate = 20.0;     ///< [Hz]
constexpr double spin_up = 25.0;  ///< [s] after which arm and table turn evenly
constexpr double most_sd = 4.5;   ///< 7e-6 a value; some 300 values are compared

/// The plan of the source with one power-up, a short rest, and levels as long as this [s].
Plan plan_of(double level, double acceleration = 30.0) {
  Plan plan = load_plan(TUMBLE_SOURCE_DIR "/plans/dtg_centrifuge.toml", {});
  std::erase_if(plan.schedule, [](const Segment& segment) { return segment.run != 1; });
  for (auto& segment : plan.schedule)
    segment.duration = segment.label == "warm-up" ? 20.0 : segment.label == "static" ? 30.0 : level;
  plan.sample_rate = rate;
  plan.limits.clear();
  plan.truth.set_integer("oversampling", 16);
  for (const char* axis : {"arm", "table"})
    plan.rig.set_number(std::string(axis) + "_max_acceleration", si(acceleration, "deg/s^2"), Unit::parse("deg/s^2"));
  return plan;
}

/// Samples [begin, end) of a recording as a file of one segment, by a clock that begins with it.
Recording cut(const Recording& whole, std::size_t begin, std::size_t end, const Mark& mark) {
  Recording part;
  part.marks.push_back({mark.label, 0.0, mark.run});
  for (const auto& channel : whole.channels) {
    Channel piece{channel.name, channel.kind, channel.unit, {0.0, rate, nullptr}, {}};
    piece.values.assign(channel.values.begin() + static_cast<std::ptrdiff_t>(begin),
                        channel.values.begin() + static_cast<std::ptrdiff_t>(end));
    part.channels.push_back(std::move(piece));
  }
  return part;
}

/// Every level in a file of `length` [s] that begins `late` samples after the rates are even, the plan says `planned`.
Evidence in_files(std::uint64_t seed, double planned, double length, std::size_t late,
                  const std::vector<std::string>& skipped = {}) {
  const Recording whole = simulate(plan_of(spin_up + length + 2.0), seed, {});
  Evidence evidence{plan_of(planned), {}};
  std::erase_if(evidence.plan.schedule,
                [&](const Segment& segment) { return std::ranges::find(skipped, segment.label) != skipped.end(); });
  for (std::size_t m = 0; m < whole.marks.size(); ++m) {
    const Mark& mark = whole.marks[m];
    if (mark.label == "warm-up" || std::ranges::find(skipped, mark.label) != skipped.end()) continue;
    const bool rests = mark.label == "static";
    const auto at = static_cast<std::size_t>(std::llround(mark.begin * rate));
    const std::size_t begin = rests ? at : at + static_cast<std::size_t>(spin_up * rate) + (late * (m + 1)) % 19;
    const auto count = static_cast<std::size_t>(std::llround((rests ? 30.0 : length) * rate));
    evidence.recordings.push_back(cut(whole, begin, begin + count, mark));
    evidence.plan.recordings.push_back({mark.label + ".h5", mark.label, mark.run});
  }
  return evidence;
}

/// K of the plan's truth at a specific force [SI].
double true_term(const Settings& truth, double a) {
  const auto of = [&](const char* name) { return truth.number(name); };
  const double g = standard_gravity;
  return std::hypot(of("D_x") + of("D_xz") * g + (0.75 * of("D_xxx") + 0.25 * of("D_xyy")) * a * a,
                    of("D_y") + of("D_yz") * g + (0.75 * of("D_yyy") + 0.25 * of("D_yxx")) * a * a);
}

double cell(const Table& table, const std::vector<Table::Cell>& row, const std::string& column) {
  for (std::size_t c = 0; c < table.columns.size(); ++c)
    if (table.columns[c].name == column) return std::get<double>(row[c]);
  ADD_FAILURE() << "no column " << column;
  return std::nan("");
}

/// The specific force of each level is that of its rate, and everything agrees with the truth of the plan.
void expect_truth(const Evidence& evidence) {
  const Estimate found = identify(evidence, {});
  const Settings& truth = evidence.plan.truth;
  const double radius = evidence.plan.rig.number("radius");
  const auto levels = std::ranges::find(found.tables, "nonlinearity", &Table::name);
  ASSERT_NE(levels, found.tables.end());
  for (std::size_t l = 0; l < levels->rows.size(); ++l) {
    const double w = cell(*levels, levels->rows[l], "arm_rate"), a = cell(*levels, levels->rows[l], "acceleration");
    // the Earth's rate adds 2 x 7.3e-5 rad/s to an arm of 2 rad/s and more
    EXPECT_NEAR(a / (w * w * radius), 1.0, 1e-4) << "level " << l + 1;
    const std::string name = "sensitive_term_" + std::to_string(l + 1);
    const Parameter* term = find_parameter(found, name);
    ASSERT_NE(term, nullptr) << name;
    const auto p = static_cast<std::size_t>(term - found.parameters.data());
    EXPECT_NEAR(term->value, true_term(truth, a), most_sd * std::sqrt(found.covariance(p, p))) << name;
  }
  const double expected[] = {truth.number("D_x") + truth.number("D_xz") * standard_gravity,
                             truth.number("D_y") + truth.number("D_yz") * standard_gravity};
  for (const bool y : {false, true}) {
    const Parameter* d = find_parameter(found, y ? "D_y" : "D_x");
    ASSERT_NE(d, nullptr);
    const auto p = static_cast<std::size_t>(d - found.parameters.data());
    EXPECT_NEAR(d->value, expected[y ? 1 : 0], most_sd * std::sqrt(found.covariance(p, p))) << d->name;
  }
  for (const auto& finding : found.findings) {
    EXPECT_NE(finding.severity, Finding::Severity::error) << finding.code << ": " << finding.message;
    EXPECT_NE(finding.code, "loop_lag_differs") << finding.message;
    EXPECT_NE(finding.code, "rates_differ_from_plan") << finding.message;
  }
}

TEST(DtgLevels, MayEachLieInAFileOfAnyLength) {
  std::uint64_t seed = 1;
  for (const double length : {119.0, 120.0, 121.0})
    for (const std::size_t late : {0u, 7u}) {
      SCOPED_TRACE(std::to_string(length) + " s where the plan says 120 s, cut " + std::to_string(late) +
                   " samples on");
      expect_truth(in_files(seed++, 120.0, length, late));
    }
}

TEST(DtgLevels, MayBeAsLongAsThoseOfTheSource) {
  for (const double length : {899.0, 900.0, 901.0}) {
    SCOPED_TRACE(std::to_string(length) + " s where the plan says 900 s");
    expect_truth(in_files(3, 900.0, length, 3));
  }
}

TEST(DtgLevels, MayBeFewerThanThoseOfTheRig) {
  expect_truth(in_files(11, 120.0, 120.0, 5, {"spin 2", "spin 4", "spin 6"}));
}

TEST(DtgLevels, FollowAnArmThatSpeedsUpOtherwise) {
  std::uint64_t seed = 21;
  for (const double acceleration : {25.0, 28.0, 29.0, 31.0, 32.0, 35.0}) {
    SCOPED_TRACE(std::to_string(acceleration) + " deg/s^2 where the plan says 30");
    expect_truth({plan_of(180.0), {simulate(plan_of(180.0, acceleration), seed++, {})}});
  }
}

}  // namespace
}  // namespace tumble
