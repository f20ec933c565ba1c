// What holds for every rig that carries an instrument.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "tumble/earth/earth.hpp"
#include "tumble/rigs/error_names.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/rigs/testing/bench.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using Kind = Motion::Kind;

bool accepts(const Axis& axis, Kind kind) {
  return std::find(axis.motions.begin(), axis.motions.end(), kind) != axis.motions.end();
}

Motion gentle(const Axis& axis, Kind kind, double size) {
  if (axis.unit == "degC") return {.kind = Kind::hold, .value = 294.15};
  if (axis.name == "shake" && (kind == Kind::sine || kind == Kind::sweep))
    return {.kind = kind, .amplitude = 20.0 * size, .frequency = 20.0, .to_frequency = 40.0};
  if (kind == Kind::random) return {.kind = kind, .psd_frequency = {20.0, 50.0, 200.0}, .psd = {0.1, 2.0, 0.5}};
  const double unit = axis.unit == "deg" ? degree : 1.0;
  switch (kind) {
    case Kind::rate:
      return {.kind = kind, .value = 30.0 * unit * size};
    case Kind::slew:
      return {.kind = kind, .value = 5.0 * unit, .to = 20.0 * unit * size};
    case Kind::sine:
    case Kind::sweep:
      return {.kind = kind, .amplitude = 2.0 * unit * size, .frequency = 0.5, .to_frequency = 1.0};
    default:
      return {.kind = Kind::hold, .value = axis.unit == "deg" ? 25.0 * unit * size : 0.0};
  }
}

/// Every motion that each axis can do, one segment each, some segments silent.
Schedule exercise(const Rig& rig) {
  Schedule schedule;
  double size = 1.0;
  for (const Kind kind :
       {Kind::hold, Kind::slew, Kind::hold, Kind::rate, Kind::sine, Kind::sweep, Kind::random, Kind::hold}) {
    Segment segment{"segment " + std::to_string(schedule.size() + 1), 20.0, 1, {}};
    for (const auto& axis : rig.axes()) {
      if (accepts(axis, kind)) segment.axes[axis.name] = gentle(axis, kind, size);
      size = 0.3 + std::fmod(size * 2.3, 1.0);
    }
    schedule.push_back(segment);
  }
  return schedule;
}

std::vector<const Rig*> carriers() {
  std::vector<const Rig*> all;
  for (const auto* rig : rig_catalogue())
    if (std::string(rig->name) != "thermal_chamber") all.push_back(rig);
  return all;
}

double distance(const Felt& a, const Felt& b) {
  return norm(a.rate - b.rate) + norm(a.angular_acceleration - b.angular_acceleration) +
         norm(a.specific_force - b.specific_force) + std::abs(a.temperature - b.temperature);
}

class RigLaws : public testing::TestWithParam<const Rig*> {};

TEST_P(RigLaws, ExerciseIsAccepted) {
  const Rig& rig = *GetParam();
  const auto refusals = rig.refusals(exercise(rig), defaults(rig.options()));
  EXPECT_TRUE(refusals.empty()) << refusals.front().text();
}

// At rest the instrument feels gravity and the Earth's rate, whatever its orientation, with every error of the rig
// except the one of gravity. The place within the rig acts by w^2 R < 5e-9 m/s^2 per metre.
TEST_P(RigLaws, GravityAndEarthRateAtRestAnywhere) {
  const Rig& rig = *GetParam();
  const RandomStream random(11);
  const auto options = with(rig, {{"gravity_sd", "0 ug", "test"}});
  Schedule schedule;
  for (std::size_t s = 0; s < 20; ++s) {
    Segment segment{"rest", 200.0, 1, {}};
    std::size_t a = 0;
    for (const auto& axis : rig.axes()) {
      ++a;
      if (axis.unit == "deg")
        segment.axes[axis.name] = {.kind = Kind::hold, .value = 2.0 * std::numbers::pi * random.uniform(10 * s + a)};
    }
    schedule.push_back(segment);
  }
  RigRun run = run_of(schedule, options);
  const auto errors = rig.errors(options, run.site);
  run.errors = Matrix(errors.size(), schedule.size());
  for (std::size_t e = 0; e < errors.size(); ++e)
    for (std::size_t s = 0; s < schedule.size(); ++s)
      run.errors(e, s) = errors[e].sd * random.split("e").normal(e * 100 + (errors[e].each_segment ? s : 0));
  const auto reference = rig.reference(run);
  std::set<long> seen;
  for (std::size_t s = 0; s < schedule.size(); ++s) {
    const double begin = 200.0 * static_cast<double>(s);
    ASSERT_GE(reference.settled[s], begin);
    ASSERT_LT(reference.settled[s], begin + 190.0);
    const auto at = felt(reference, reference.settled[s] + 1e-6, 1.0, 1).front();
    EXPECT_NEAR(norm(at.specific_force), 9.7966, 1e-8);
    EXPECT_NEAR(norm(at.rate), earth_rate, 1e-17 + 1e-13 * earth_rate);
    EXPECT_EQ(norm(at.angular_acceleration), 0.0);
    EXPECT_EQ(at.temperature, 293.15);
    seen.insert(std::lround(1e6 * at.specific_force.x));
  }
  EXPECT_GT(seen.size(), 15u) << "the orientation does not change";
}

TEST_P(RigLaws, WithoutASiteStandardGravityAndNoEarth) {
  const Rig& rig = *GetParam();
  RigRun run = run_of({{"rest", 10.0, 1, {}}}, defaults(rig.options()));
  run.site.reset();
  const auto at = felt(rig.reference(run), 5.0, 1.0, 1).front();
  EXPECT_NEAR(norm(at.specific_force), standard_gravity, 1e-12);
  EXPECT_EQ(norm(at.rate), 0.0);
}

// Whole samples are the same in whatever blocks they are asked for.
TEST_P(RigLaws, BlocksDoNotMatter) {
  const Rig& rig = *GetParam();
  const auto reference = rig.reference(run_of(exercise(rig), defaults(rig.options())));
  const double step = 0.0625;
  const auto whole = felt(reference, 0.5 * step, step, 2240);
  std::vector<double> readings(whole.size());
  for (const std::size_t size : {1u, 7u, 640u}) {
    for (std::size_t first = 0; first < whole.size(); first += size) {
      const auto count = std::min(size, whole.size() - first);
      const auto part = felt(reference, (static_cast<double>(first) + 0.5) * step, step, count);
      for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(distance(part[i], whole[first + i]), 0.0) << first + i;
    }
    for (const auto& sensor : reference.sensors) {
      sensor.read(0.5 * step, step, readings);
      for (std::size_t first = 0; first < whole.size(); first += size) {
        std::vector<double> part(std::min(size, whole.size() - first));
        sensor.read((static_cast<double>(first) + 0.5) * step, step, part);
        for (std::size_t i = 0; i < part.size(); ++i) ASSERT_EQ(part[i], readings[first + i]) << sensor.channel.name;
      }
    }
  }
}

TEST_P(RigLaws, SteadyMeansThatNothingChanges) {
  const Rig& rig = *GetParam();
  const auto reference = rig.reference(run_of(exercise(rig), defaults(rig.options())));
  ASSERT_TRUE(reference.steady_until);
  int steady = 0;
  for (double time = 0.0; time < 150.0; time += 0.173) {
    const double until = reference.steady_until(time);
    ASSERT_GE(until, time);
    if (until == time) continue;
    ++steady;
    const double last = std::min(until, 200.0) - 1e-9;
    for (const double share : {0.3, 0.9, 1.0}) {
      const double later = time + share * (last - time);
      EXPECT_EQ(distance(felt(reference, time, 1.0, 1)[0], felt(reference, later, 1.0, 1)[0]), 0.0) << time << later;
    }
  }
  EXPECT_GT(steady, 20);
  EXPECT_EQ(reference.steady_until(1e6), std::numeric_limits<double>::infinity());
}

/// The vector [rad] about and by which a rotation of less than a quarter of a turn turns the axes.
Vector3 turn_of(const Rotation& r) {
  const Vector3 v{0.5 * (r.y.z - r.z.y), 0.5 * (r.z.x - r.x.z), 0.5 * (r.x.y - r.y.x)};
  const double sine = norm(v);
  return sine > 0.0 ? (std::asin(sine) / sine) * v : v;
}

double bend(Vector3 before, Vector3 now, Vector3 after) { return norm(after - 2.0 * now + before); }

// The picture moves as the instrument feels it: its turning and its path, by differences over 2 h = 0.2 ms, give what
// is felt, with all errors of the rig and with tremor. The fastest of these motions is the tremor: 0.3 deg up to 10 Hz,
// 100 mm from the hand. Differences are off by h^2/6 of the third derivative of the angle (2e-6 rad/s), by h^2/12 of
// the fourth of the path (1e-5 m/s^2), and by rounding/h^2 (1e-8 m/s^2). Where the acceleration jumps within h, they
// are means of both sides: such instants are skipped, but for jumps whose half is less than the tolerances. So is the
// path of the shaker, which is not drawn.
TEST_P(RigLaws, PartsMoveAsTheInstrumentFeels) {
  const Rig& rig = *GetParam();
  const auto options = defaults(rig.options());
  const auto schedule = exercise(rig);
  RigRun run = run_of(schedule, options);
  const auto errors = rig.errors(options, run.site);
  run.errors = Matrix(errors.size(), schedule.size());
  for (std::size_t e = 0; e < errors.size(); ++e)
    for (std::size_t s = 0; s < schedule.size(); ++s)
      if (errors[e].name != error_names::gravity && errors[e].name != error_names::latitude)
        run.errors(e, s) = errors[e].sd * (e % 2 == 0 ? 1.0 : -1.0);
  const auto reference = rig.reference(run);
  ASSERT_FALSE(reference.parts.empty());
  const RigPart& instrument = reference.parts.back();
  EXPECT_EQ(instrument.name, "instrument");
  const double h = 1e-4;
  const Vector3 earth = earth_rate_in_level(site), up{0.0, 0.0, gravity(site)};
  int compared = 0, turning = 0;
  for (double time = 0.41; time < 159.0; time += 0.177) {
    const auto felt_then = felt(reference, time - h, h, 3);
    if (bend(felt_then[0].angular_acceleration, felt_then[1].angular_acceleration, felt_then[2].angular_acceleration) >
            0.01 ||
        bend(felt_then[0].specific_force, felt_then[1].specific_force, felt_then[2].specific_force) > 5e-5)
      continue;
    const auto before = instrument.at(time - h), now = instrument.at(time), after = instrument.at(time + h);
    const Vector3 turn = (0.5 / h) * turn_of(after.part_from_level * inverse(before.part_from_level));
    EXPECT_LT(norm(now.part_from_level * earth + turn - felt_then[1].rate), 1e-5) << time;
    if (norm(turn) > 1e-3) ++turning;
    if (std::string(rig.name) != "shaker") {
      const Vector3 path = (1.0 / (h * h)) * (after.origin - 2.0 * now.origin + before.origin);
      const Vector3 speed = (0.5 / h) * (after.origin - before.origin);
      const Vector3 force = now.part_from_level * (up + path + 2.0 * cross(earth, speed));
      EXPECT_LT(norm(force - felt_then[1].specific_force), 1e-4) << time;
    }
    ++compared;
  }
  EXPECT_GT(compared, std::string(rig.name) == "shaker" ? 300 : 600);
  if (std::string(rig.name) != "shaker") {
    EXPECT_GT(turning, 3);
  }
}

// Every error moves something: a budget can difference it. (A lever along an upward axis acts through the Earth alone,
// by 1e-11 m/s^2.) Names are unique.
TEST_P(RigLaws, EveryErrorMovesSomething) {
  const Rig& rig = *GetParam();
  const auto options = defaults(rig.options());
  const auto schedule = exercise(rig);
  RigRun run = run_of(schedule, options);
  const auto errors = rig.errors(options, run.site);
  const auto nominal = felt(rig.reference(run), 0.005, 0.01, 14000);
  std::vector<std::vector<double>> nominal_readings;
  for (const auto& sensor : rig.reference(run).sensors) {
    nominal_readings.emplace_back(14000);
    sensor.read(0.005, 0.01, nominal_readings.back());
  }
  std::set<std::string> names;
  for (std::size_t e = 0; e < errors.size(); ++e) {
    EXPECT_TRUE(names.insert(errors[e].name).second) << errors[e].name;
    EXPECT_GT(errors[e].sd, 0.0) << errors[e].name << ": a default of 0 is not realistic";
    run.errors = Matrix(errors.size(), schedule.size());
    for (std::size_t s = 0; s < schedule.size(); ++s) run.errors(e, s) = 10.0 * errors[e].sd;
    const auto reference = rig.reference(run);
    const auto moved = felt(reference, 0.005, 0.01, 14000);
    double most = 0.0;
    for (std::size_t i = 0; i < moved.size(); ++i) most = std::max(most, distance(moved[i], nominal[i]));
    for (std::size_t n = 0; n < reference.sensors.size(); ++n) {
      std::vector<double> readings(14000);
      reference.sensors[n].read(0.005, 0.01, readings);
      for (std::size_t i = 0; i < readings.size(); ++i)
        most = std::max(most, std::abs(readings[i] - nominal_readings[n][i]));
    }
    EXPECT_GT(most, 1e-13) << errors[e].name;
  }
}

TEST_P(RigLaws, IdealRigHasNoErrors) {
  const Rig& rig = *GetParam();
  for (const auto& error : rig.errors(with(rig, {{"ideal", "true", "test", false}}), Site{})) EXPECT_EQ(error.sd, 0.0);
}

TEST_P(RigLaws, StandardDeviationsAreNotNegative) {
  for (const auto& option : GetParam()->options()) {
    if (!option.name.ends_with("_sd")) continue;
    Problems problems;
    resolve({option}, {{option.name, "-1 " + option.unit, "test"}}, "rig", problems);
    ASSERT_EQ(problems.size(), 1u) << option.name;
    EXPECT_TRUE(is_problem(problems[0], {.values = {"-1 " + option.unit}, .part = "at least 0", .key = option.name}));
  }
}

// Foreign axes and motions: everything at once.
TEST_P(RigLaws, RefusalsComeAllAtOnce) {
  const Rig& rig = *GetParam();
  const std::vector<std::string> expected{"no_such_axis", "cannot ramp", "mount_roll cannot rate"};
  const auto options = defaults(rig.options());
  Schedule schedule = exercise(rig);
  schedule[0].axes["no_such_axis"] = {};
  schedule[1].axes[rig.axes().front().name] = {.kind = Kind::ramp, .value = 1.0, .to = 2.0};
  schedule[2].axes["mount_roll"] = {.kind = Kind::rate, .value = 1.0};
  std::string all;
  for (const auto& problem : rig.refusals(schedule, options)) all += problem.text() + "\n";
  for (const auto& part : expected) EXPECT_NE(all.find(part), std::string::npos) << part << " in\n" << all;
}

TEST_P(RigLaws, MotionsThatAreNotFiniteAreRefused) {
  const Rig& rig = *GetParam();
  for (const double odd : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    Schedule schedule{{"odd", 10.0, 1, {{"mount_yaw", {.kind = Kind::hold, .value = odd}}}}};
    EXPECT_EQ(rig.refusals(schedule, defaults(rig.options())).size(), 1u);
  }
}

INSTANTIATE_TEST_SUITE_P(All, RigLaws, testing::ValuesIn(carriers()),
                         [](const auto& rig) { return std::string(rig.param->name); });

}  // namespace
}  // namespace tumble
