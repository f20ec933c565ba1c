// What a bench does wrong while a plan is carried out, judged by the clock of the rig and by the result: pulled cables,
// a unit that dies among others, a table that is off within its tolerance, an operator who comes in the morning.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/rehearsal/made_station.hpp"
#include "tumble/rehearsal/rehearse.hpp"
#include "tumble/rehearsal/virtual_stream.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {
namespace {

constexpr double for_ever = 1e9, at_fault = 40.0;  ///< [s]
constexpr double at_rest = 0.01 * degree;          ///< [rad/s]

Plan turning(std::size_t segments, double duration) {
  Plan plan = load_plan(TUMBLE_SOURCE_DIR "/plans/gyro_scale_factor.toml", {});
  plan.schedule.resize(segments);
  for (Segment& segment : plan.schedule) segment.duration = duration;
  return plan;
}

struct Bench {
  ScratchFolder scratch;
  Rehearsal rehearsal;
  std::string notes;

  explicit Bench(Plan plan) {
    rehearsal.plan = std::move(plan);
    rehearsal.folder = scratch.file("run");
    rehearsal.recording = scratch.file("run.h5");
    rehearsal.company.note = [this](const Note& note, double time) {
      notes += std::to_string(time) + " " + std::string(name(note.kind)) + ": " + note.text.text() + "\n";
    };
  }
  void fault(FaultKind kind, const std::string& about, double by = 0.0, double at = at_fault) {
    rehearsal.faults.push_back(
        {.kind = kind, .name = "it", .about = about, .at = at, .lasts = for_ever, .by = by, .ends = "stopped"});
  }
  /// The station of the plan with these slots, and its frames beside it.
  void slots(const std::vector<std::string>& names) {
    Station station = station_for(rehearsal.plan);
    station.file = scratch.file("station.toml");
    std::ofstream(scratch.file(std::string(made_frames_name))) << frames_for(rehearsal.plan);
    const StationInstrument one = station.instruments.front();
    station.instruments.clear();
    for (const auto& name : names) {
      station.instruments.push_back(one);
      station.instruments.back().slot = name;
      rehearsal.units[name] = "SN-" + name;
    }
    rehearsal.station = station;
  }
};

/// The table turns at 120 deg/s when a cable is pulled. A link that is closed is known at once, a silent one after 0.6
/// s (docs/station.md: lost_after of the station that is made), a stream after 5 s. The stop is sent within a poll of
/// 0.1 s after that, the table brakes at its own acceleration, and three readings of zero confirm it.
void expect_safe_within(FaultKind kind, const std::string& cable, double decided) {
  Bench bench(turning(3, 60.0));
  bench.fault(kind, cable);
  const double braking = si(120.0, "deg/s") / bench.rehearsal.plan.rig.number("max_acceleration");
  const Rehearsed rehearsed = rehearse(bench.rehearsal);
  EXPECT_TRUE(rehearsed.end.ending == RunEnding::stopped || rehearsed.end.ending == RunEnding::failed)
      << rehearsed.end.text.text() << "\n"
      << bench.notes;
  EXPECT_LE(std::abs(rehearsed.axes.at("table").rate), at_rest);
  // 1 s: sending, four polls, and the look at the state of the run every 0.1 s
  EXPECT_LE(rehearsed.simulated - at_fault, decided + braking + 1.0) << bench.notes;
}

TEST(PulledCable, OfAUnitLeadsToTheSafeStateInTime) {
  expect_safe_within(FaultKind::drop_link, "unit", 0.0);
  expect_safe_within(FaultKind::half_open, "unit", 5.2);
}

TEST(PulledCable, OfASupplyLeadsToTheSafeStateInTime) {
  // Nobody can confirm that the supply is off, so the run waits for it as long as the safe list says.
  for (const auto kind : {FaultKind::drop_link, FaultKind::half_open}) {
    Bench bench(turning(3, 60.0));
    bench.fault(kind, "supply");
    const Rehearsed rehearsed = rehearse(bench.rehearsal);
    EXPECT_NE(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text();
    EXPECT_LE(std::abs(rehearsed.axes.at("table").rate), at_rest) << bench.notes;
    EXPECT_LE(rehearsed.simulated - at_fault, 10.0 + 10.0 + 2.0) << "lost_after and the deadline of the safe list";
  }
}

/// A table that cannot be asked may turn: the end is loud, and in time.
TEST(PulledCable, OfTheTableIsSaidAloudInTime) {
  for (const auto& [kind, decided] : {std::pair{FaultKind::drop_link, 0.0}, std::pair{FaultKind::half_open, 0.7}}) {
    Bench bench(turning(3, 60.0));
    bench.fault(kind, "table");
    const Rehearsed rehearsed = rehearse(bench.rehearsal);
    EXPECT_EQ(rehearsed.end.ending, RunEnding::faulted) << rehearsed.end.text.text();
    EXPECT_NE(rehearsed.end.text.text().find("THE RIG IS NOT SAFE"), std::string::npos) << rehearsed.end.text.text();
    EXPECT_LE(rehearsed.simulated - at_fault, decided + 10.0 + 1.0) << "the deadline of the safe list is 10 s";
  }
}

const Parameter* parameter_of(const Estimate& estimate, const char* name) { return find_parameter(estimate, name); }

double sd_of(const Estimate& estimate, const Parameter* parameter) {
  return standard_uncertainty(estimate, static_cast<std::size_t>(parameter - estimate.parameters.data()));
}

TEST(SeveralUnits, TheOthersCompleteThePlanWhenOneDies) {
  Bench bench(turning(13, 12.0));
  bench.slots({"a", "b", "c"});
  bench.rehearsal.plan.limits = {{"scale_factor_asymmetry", {}, Quantity{1000.0, Unit::parse("ppm")}, ""}};
  bench.fault(FaultKind::drop_link, "b", 0.0, 60.0);
  const Rehearsed rehearsed = rehearse(bench.rehearsal);
  ASSERT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text() << bench.notes;
  EXPECT_NE(bench.notes.find("unit"), std::string::npos) << bench.notes;
  ASSERT_EQ(rehearsed.recordings.size(), 3u);
  std::map<std::string, std::string> file;
  for (const auto& sealed : rehearsed.recordings) file[sealed.slot] = sealed.path;
  for (const char* slot : {"a", "c"}) {
    const Estimate estimate = identify(gather(bench.rehearsal.plan, {file.at(slot)}, {}), {});
    ASSERT_NE(parameter_of(estimate, "scale_factor"), nullptr) << slot;
    ASSERT_EQ(estimate.verdicts.size(), 1u) << slot;
    EXPECT_EQ(estimate.verdicts[0].outcome, Verdict::Outcome::pass) << slot;
  }
  // What the dead one sent remains, and its result, if there is one, says what is missing.
  const Recording dead = read_recording(file.at("b"), {}, {}), whole = read_recording(file.at("a"), {}, {});
  const auto last = [](const Recording& one) {
    const Channel& channel = one.channels.front();
    return channel.time(channel.values.size() - 1);
  };
  EXPECT_LT(last(dead), last(whole) - 60.0);
  try {
    const Estimate estimate = identify(gather(bench.rehearsal.plan, {file.at("b")}, {}), {});
    EXPECT_FALSE(estimate.findings.empty());
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::bad_data) << error.what();
  }
}

TEST(SeveralUnits, TheRunEndsWhenAllAreNeeded) {
  Bench bench(turning(13, 12.0));
  bench.slots({"a", "b", "c"});
  bench.rehearsal.station->all_units = true;
  bench.fault(FaultKind::drop_link, "b", 0.0, 60.0);
  const Rehearsed rehearsed = rehearse(bench.rehearsal);
  EXPECT_EQ(rehearsed.end.ending, RunEnding::failed) << rehearsed.end.text.text();
  EXPECT_LE(std::abs(rehearsed.axes.at("table").rate), at_rest);
}

/// 0.006 deg/s is within the tolerance of the station and 21.6 deg/h of the bias, if the demand were believed.
TEST(DriftingTable, TheRateThatWasMeasuredEntersTheEstimate) {
  Bench bench(load_plan(TUMBLE_SOURCE_DIR "/plans/gyro_scale_factor.toml", {}));
  bench.fault(FaultKind::wrong_set_point, "table", 0.006 * degree, 0.0);
  const Rehearsed rehearsed = rehearse(bench.rehearsal);
  ASSERT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text();
  const Plan& plan = bench.rehearsal.plan;
  const Estimate estimate = identify(gather(plan, {bench.rehearsal.recording}, {}), {});
  const Parameter* const bias = parameter_of(estimate, "bias");
  EXPECT_NEAR(bias->value, plan.truth.number("bias"), 4.0 * sd_of(estimate, bias));
  EXPECT_LT(sd_of(estimate, bias), si(5.0, "deg/h")) << "else a wrong rate would not show";
  EXPECT_TRUE(std::ranges::any_of(estimate.findings, [](const Finding& f) { return f.code == "turn_rate_recorded"; }));
}

/// Nobody answers for twelve hours: the table stands, and the answer in the morning carries the plan on.
TEST(LateOperator, FindsTheRigAtRestInTheMorning) {
  constexpr double night = 12.0 * hour;
  Bench bench(turning(2, 30.0));
  std::optional<Prompt> open;
  double asked = 0.0, now = 0.0, fastest = 0.0;
  bool answered = false;
  bench.rehearsal.company.ask = [&](const Prompt& prompt) { open = prompt, asked = now; };
  bench.rehearsal.company.show_every = 60.0;
  bench.rehearsal.company.show = [&](const RunView& view) {
    now = view.time;
    if (!open || answered || now < asked + hour) return;
    for (const auto& axis : view.axes) fastest = std::max(fastest, std::abs(axis.rate.value_or(0.0)));
  };
  bench.rehearsal.company.orders = [&] {
    std::vector<decltype(RunEvent::what)> orders;
    if (open && !answered && now > asked + night) {
      orders.push_back(PromptAnswer{open->id, "done", "Li Wei"});
      answered = true;
    }
    return orders;
  };
  const Rehearsed rehearsed = rehearse(bench.rehearsal);
  EXPECT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text();
  EXPECT_TRUE(answered);
  EXPECT_GT(rehearsed.simulated, night);
  EXPECT_LE(fastest, at_rest);
}

}  // namespace
}  // namespace tumble
