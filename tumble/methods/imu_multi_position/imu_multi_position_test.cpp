#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include "tumble/math/random.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_multi_position_test {
namespace {

const Method& method() { return find_method("imu_multi_position"); }

Channel& channel(Evidence& evidence, const std::string& name) {
  for (auto& recording : evidence.recordings)
    for (auto& channel : recording.channels)
      if (channel.name == name) return channel;
  throw Error(Error::Kind::internal, say("{}", Name{name}));
}

void scale(Evidence& evidence, const std::string& name, double factor) {
  for (double& value : channel(evidence, name).values) value *= factor;
}

Refused refusal(const Evidence& evidence) { return refusal(method(), evidence); }

/// Whether there is a finding of this code whose place begins with these words.
bool has(const Estimate& estimate, const std::string& code, const std::string& place) {
  return std::ranges::any_of(estimate.findings,
                             [&](const Finding& f) { return f.code == code && f.where.starts_with(place); });
}

double sd(const Estimate& estimate, const std::string& name) {
  const Parameter* p = find_parameter(estimate, name);
  return standard_uncertainty(estimate, static_cast<std::size_t>(p - estimate.parameters.data()));
}

/// The trial's test and instrument without noise, rounding or errors of the rig.
Trial exact() {
  Trial trial = trial_of(method(), 1);
  Plan plan = trial_plan(method().name, method().options(), "imu", "by_hand", 100.0);
  plan.site = trial.evidence.plan.site;
  plan.schedule = trial.evidence.plan.schedule;
  plan.rig = trial.evidence.plan.rig;
  plan.rig.set_flag("ideal", true);
  for (const auto& [name, value] : trial.truth) plan.truth.set_number(name, value, Unit::parse("1"));
  trial.evidence.recordings = {simulate(plan, 1, {})};
  trial.evidence.plan = std::move(plan);
  return trial;
}

// A sample is what is felt at its middle. Over a turn of 180 deg in 1.4 s, from rest to rest, the sum of 140 such
// values is the integral to 1e-9, and increments of up to 2 deg about an axis that the Earth's rotation moves by 1e-6
// of the rate leave cones of 1e-9. Relative tolerance 1e-7; biases of gyros 1e-7 of a radian over a second.
TEST(ImuMultiPosition, ExactWithoutNoise) {
  const Trial trial = exact();
  const Estimate estimate = method().identify(trial.evidence, {});
  for (const auto& [name, truth] : trial.truth) {
    const Parameter* p = find_parameter(estimate, name);
    ASSERT_NE(p, nullptr) << name;
    EXPECT_NEAR(p->value, truth, name.find("accelerometer") == 0 && name.ends_with("_bias") ? 1e-8 : 1e-7) << name;
  }
}

TEST(ImuMultiPosition, FindsEveryRestOfATremblingHandAndNotTheMoves) {
  const Trial trial = trial_of(method(), 3);
  const Estimate estimate = method().identify(trial.evidence, {});
  const Table& rests = *find_table(estimate, "rests");
  ASSERT_EQ(rests.rows.size(), trial.evidence.plan.schedule.size());
  double begin = 0.0;
  for (std::size_t k = 0; k < rests.rows.size(); ++k) {
    const double settled = begin + (k == 0 ? 0.0 : 1.4), from = std::get<double>(rests.rows[k][1]);
    const double until = from + std::get<double>(rests.rows[k][2]);
    begin += trial.evidence.plan.schedule[k].duration;
    EXPECT_GE(from, settled - 0.1) << k;  // the last tenth of a second of a move turns by less than the noise shows
    EXPECT_LE(from, settled + 0.5) << k;  // a window
    EXPECT_LE(until, begin + 0.1) << k;
    EXPECT_GE(until, begin - 0.5) << k;
    EXPECT_EQ(std::get<std::string>(rests.rows[k].back()), "yes");
  }
}

TEST(ImuMultiPosition, GyrosMayStandInARecordingOfTheirOwn) {
  Evidence evidence = trial_of(method(), 2).evidence;
  const Estimate together = method().identify(evidence, {});
  Recording gyros = evidence.recordings[0];
  std::erase_if(gyros.channels, [](const Channel& c) { return c.name.find("gyro") != 0; });
  std::erase_if(evidence.recordings[0].channels, [](const Channel& c) { return c.name.find("gyro") == 0; });
  const Estimate alone = method().identify(evidence, {});
  EXPECT_EQ(find_parameter(alone, "gyro_x_bias"), nullptr);
  EXPECT_NE(finding_of(alone.findings, "accelerometers_alone"), nullptr);
  evidence.recordings.push_back(gyros);
  const Estimate apart = method().identify(evidence, {});
  ASSERT_EQ(apart.parameters.size(), together.parameters.size());
  for (std::size_t i = 0; i < together.parameters.size(); ++i)
    EXPECT_EQ(apart.parameters[i].value, together.parameters[i].value) << together.parameters[i].name;
}

TEST(ImuMultiPosition, RawCountsNeedNothingToBeKnownOfThem) {
  Trial trial = trial_of(method(), 4);
  const Estimate plain = method().identify(trial.evidence, {});
  for (auto& c : trial.evidence.recordings[0].channels) {
    const bool gyro = c.name.find("gyro") == 0;
    c.kind = QuantityKind::count, c.unit = Unit::parse("LSB");
    for (double& value : c.values) value = 32768.0 + (gyro ? 4700.0 : 415.0) * value;
  }
  const Estimate counts = method().identify(trial.evidence, {});
  // the same numbers in another unit: to the precision of 32768 in the sums, relative to a few counts at rest
  for (const char* axis : {"x", "y", "z"}) {
    const std::string force = fmt::format("accelerometer_{}", axis), rate = fmt::format("gyro_{}", axis);
    EXPECT_NEAR(value(counts, force + "_scale_factor") / 415.0 - 1.0, value(plain, force + "_scale_factor_error"),
                1e-7);
    EXPECT_NEAR(value(counts, rate + "_scale_factor") / 4700.0 - 1.0, value(plain, rate + "_scale_factor_error"), 1e-6);
    EXPECT_NEAR((value(counts, rate + "_bias") - 32768.0) / 4700.0, value(plain, rate + "_bias"), 1e-7);
    EXPECT_NEAR(sd(counts, rate + "_scale_factor") / 4700.0 / sd(plain, rate + "_scale_factor_error"), 1.0, 1e-2);
  }
}

TEST(ImuMultiPosition, AMovedGravityMovesAllScaleFactorsTogether) {
  Trial trial = trial_of(method(), 5);
  const Estimate before = method().identify(trial.evidence, {});
  trial.evidence.plan.settings.set_number("gravity", 9.797 * 1.001, Unit::parse("m/s^2"));
  const Estimate after = method().identify(trial.evidence, {});
  for (const char* axis : {"x", "y", "z"}) {
    const std::string name = fmt::format("accelerometer_{}_scale_factor_error", axis);
    EXPECT_NEAR((1.0 + value(before, name)) / (1.0 + value(after, name)), 1.001, 1e-6);
  }
  EXPECT_NEAR(value(before, "gyro_z_scale_factor_error"), value(after, "gyro_z_scale_factor_error"), 1e-6);
}

TEST(ImuMultiPosition, AStatedBiasInstabilityIsInTheBiasesAlone) {
  Trial trial = trial_of(method(), 11);
  const auto with = [&](double times) {
    for (const char* name : {"gyro_bias_instability", "accelerometer_bias_instability"})
      trial.evidence.plan.settings.set_number(name, times * trial.evidence.plan.truth.number(name),
                                              Unit::parse(name[0] == 'g' ? "deg/h" : "ug"));
    return method().identify(trial.evidence, {});
  };
  const auto once = with(1.0), threefold = with(3.0);
  for (std::size_t p = 0; p < once.parameters.size(); ++p) {
    const std::string& name = once.parameters[p].name;
    const double more = threefold.covariance(p, p) - once.covariance(p, p);
    if (!name.ends_with("_bias")) {
      EXPECT_NEAR(more, 0.0, 1e-12 * once.covariance(p, p)) << name;
      continue;
    }
    // (9 - 1) k B^2: k, of flicker between means over seconds some minutes apart in a bank of 4 records, is one to four
    const double b =
        trial.evidence.plan.truth.number(name[0] == 'g' ? "gyro_bias_instability" : "accelerometer_bias_instability");
    EXPECT_GT(more, 8.0 * b * b) << name;
    EXPECT_LT(more, 8.0 * 4.0 * b * b) << name;
  }
}

TEST(ImuMultiPosition, NamesExchangedAndReversedAxes) {
  const auto with = [](const std::function<void(Evidence&)>& change) {
    Evidence evidence = trial_of(method(), 6).evidence;
    change(evidence);
    return refusal(evidence);
  };
  const auto swap = [](const char* a, const char* b) {
    return [=](Evidence& e) { std::swap(channel(e, a).values, channel(e, b).values); };
  };
  Refused said = with(swap("gyro_x", "gyro_y"));
  EXPECT_TRUE(refuses(Error::Kind::bad_data,
                      Asked{.part = "'gyro_x' shows y, 'gyro_y' shows x: the gyros are a left-handed triad"}, said));
  said = with([](Evidence& e) { scale(e, "gyro_z", -1.0); });
  EXPECT_TRUE(
      refuses(Error::Kind::bad_data, Asked{.part = "'gyro_z' shows -z: the gyros are a left-handed triad"}, said));
  said = with([](Evidence& e) { scale(e, "accelerometer_y", -1.0); });
  EXPECT_TRUE(refuses(Error::Kind::bad_data,
                      Asked{.part = "the accelerometers are a left-handed triad: 'accelerometer_y' shows -y"}, said));
  said = with(swap("accelerometer_z", "accelerometer_y"));
  EXPECT_TRUE(refuses(Error::Kind::bad_data,
                      Asked{.part = "left-handed triad: 'accelerometer_y' shows z, 'accelerometer_z' shows y"}, said));
  said = with([](Evidence& e) {
    for (const char* a : {"accelerometer_x", "accelerometer_y", "accelerometer_z"}) scale(e, a, -1.0);
  });
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "the opposite of the stated direction"}, said));
}

TEST(ImuMultiPosition, NamesUnitsMistakenForOthers) {
  Evidence in_g = trial_of(method(), 7).evidence, in_degrees = in_g;
  for (const char* a : {"accelerometer_x", "accelerometer_y", "accelerometer_z"}) scale(in_g, a, 1.0 / 9.80665);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"g", "m/s^2"}, .pattern = "taken for"}, refusal(in_g)));
  for (const char* a : {"gyro_x", "gyro_y", "gyro_z"}) scale(in_degrees, a, 180.0 / std::numbers::pi);
  EXPECT_TRUE(
      refuses(Error::Kind::bad_data, Asked{.values = {"deg/s", "rad/s"}, .pattern = "taken for"}, refusal(in_degrees)));
}

// 100 Hz: a factor of 100 either way.
TEST(ImuMultiPosition, NamesIncrementsMistakenForRatesAndASilentAccelerometer) {
  Evidence increments = trial_of(method(), 7).evidence, rates = increments, silent = increments;
  for (const char* a : {"gyro_x", "gyro_y", "gyro_z"}) scale(increments, a, 0.01), scale(rates, a, 100.0);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "increments taken for rates"}, refusal(increments)));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "rates taken for increments"}, refusal(rates)));
  scale(silent, "accelerometer_y", 0.0);
  EXPECT_TRUE(refuses(Error::Kind::bad_data,
                      Asked{.values = {"accelerometer_y"}, .pattern = "the same value throughout"}, refusal(silent)));
}

TEST(ImuMultiPosition, SkipsABadRestAndABadMoveAndSaysSo) {
  Trial trial = trial_of(method(), 8);
  Evidence& evidence = trial.evidence;
  const auto at = [&](double time) { return index_at(channel(evidence, "gyro_x"), time); };
  for (std::size_t i = at(5 * 4.4 + 1.4); i < at(6 * 4.4); ++i) channel(evidence, "accelerometer_z").values[i] += 0.5;
  for (std::size_t i = at(10 * 4.4 + 0.6); i < at(10 * 4.4 + 0.8); ++i)
    channel(evidence, "gyro_y").values[i] = std::nan("");
  for (std::size_t i = at(14 * 4.4 + 0.2); i < at(14 * 4.4 + 1.0); ++i) channel(evidence, "gyro_z").values[i] *= 1.3;
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_TRUE(has(estimate, "rest_off_gravity", "rest 6 at")) << "somebody leaned on it";
  EXPECT_EQ(value_of(estimate.findings, "move_with_missing_samples", "missing"), 20.0);
  EXPECT_TRUE(has(estimate, "move_off_rests", "move from rest 14 to rest 15"));
  // 30 intervals at 99.99 % for all together: 4 standard deviations
  for (const auto& [name, truth] : trial.truth)
    EXPECT_NEAR(value(estimate, name), truth, 4.5 * sd(estimate, name)) << name;
}

// The unit sinks by w = (30, -18, 0) deg/h in every rest of 3 s: n turns with n x w, and the gyros show w. Without it
// no test of either kind is accused.
TEST(ImuMultiPosition, ATurnThatAllRestsShareIsAnError) {
  const Vector3 w{si(30.0, "deg/h"), si(-18.0, "deg/h"), 0.0};
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    EXPECT_EQ(
        finding_of(method().identify(second_trial_of(method(), seed).evidence, {}).findings, "unit_turns_at_rest"),
        nullptr);
    Trial trial = trial_of(method(), seed);
    const Estimate sound = method().identify(trial.evidence, {});
    EXPECT_EQ(finding_of(sound.findings, "unit_turns_at_rest"), nullptr);
    for (const auto& rest : find_table(sound, "rests")->rows) {
      const Vector3 f{std::get<double>(rest[3]), std::get<double>(rest[4]), std::get<double>(rest[5])};
      const double begin = std::get<double>(rest[1]), end = begin + std::get<double>(rest[2]);
      for (std::size_t i = 0; i < 3; ++i) {
        auto& force = channel(trial.evidence, std::string("accelerometer_") + "xyz"[i]);
        auto& rate = channel(trial.evidence, std::string("gyro_") + "xyz"[i]);
        for (std::size_t k = index_at(force, begin); k < index_at(force, end); ++k) {
          force.values[k] += cross(f, w)[i] * (force.time(k) - 0.5 * (begin + end));
          rate.values[k] += w[i];
        }
      }
    }
    const auto findings = method().identify(trial.evidence, {}).findings;
    const Finding* finding = finding_of(findings, "unit_turns_at_rest");
    ASSERT_NE(finding, nullptr) << seed;
    EXPECT_EQ(finding->severity, Finding::Severity::error);
    // a tenth of the rate, five times its scatter
    EXPECT_NEAR(value_of(findings, "unit_turns_at_rest", "x"), w.x, 0.3 * w.x);
  }
}

TEST(ImuMultiPosition, SkipsMovesBeyondTheRangeOfTheGyros) {
  Evidence evidence = trial_of(method(), 9).evidence;
  for (double& v : channel(evidence, "gyro_y").values) v = std::clamp(v, -1.5, 1.5);
  const Estimate estimate = method().identify(evidence, {});
  EXPECT_GT(value_of(estimate.findings, "move_clipped", "clipped"), 0.0);
}

TEST(ImuMultiPosition, SaysWhichPosesAreMissing) {
  Evidence evidence = trial_of(method(), 10).evidence;
  for (auto& recording : evidence.recordings)
    for (auto& c : recording.channels) c.values.resize(3520);
  const auto few = refusal(evidence);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"8"}, .pattern = "lay it also with these up"}, few));
  const Estimate estimate = method().identify(trial_of(method(), 10).evidence, {});
  EXPECT_EQ(find_table(estimate, "poses")->rows.size(), 26u);
  EXPECT_GT(value_of(estimate.findings, "more_rests_advised", "gain"), 0.0);
}

// Before, the refusal named 1 s for any rest_least.
TEST(ImuMultiPosition, TheRefusalNamesTheLeastDurationOfARest) {
  Evidence evidence = trial_of(method(), 10).evidence;
  evidence.plan.settings.set_number("rest_least", 20.0, Unit::parse("s"));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"20 s"}, .pattern = "rest_least"}, refusal(evidence)));
}

TEST(ImuMultiPosition, NeedsGravityFromSomewhere) {
  Evidence evidence = trial_of(method(), 11).evidence;
  evidence.plan.site.reset();
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "--set gravity="}, refusal(evidence)));
}

/// 5 % of single samples missing, or lost with their stamps: every rest and every move is used, and without noise the
/// answer is that of all samples, but for what half a sample of a hand's motion makes: 1e-3 of a turn.
TEST(ImuMultiPosition, SingleLostSamplesLoseNoRest) {
  const Trial trial = exact();
  for (const bool with_stamps : {false, true}) {
    Evidence evidence = trial.evidence;
    const RandomStream random = RandomStream(17).split("lost");
    Recording& recording = evidence.recordings[0];
    const auto lost = [&](std::size_t i) { return i > 0 && random.uniform(i) < 0.05; };
    std::vector<double> stamps;
    for (std::size_t i = 0; i < recording.channels[0].values.size(); ++i)
      if (!lost(i)) stamps.push_back(recording.channels[0].time(i));
    const auto shared = std::make_shared<const std::vector<double>>(std::move(stamps));
    for (Channel& channel : recording.channels) {
      std::vector<double> values;
      for (std::size_t i = 0; i < channel.values.size(); ++i)
        if (!lost(i))
          values.push_back(channel.values[i]);
        else if (!with_stamps)
          values.push_back(std::nan(""));
      channel.values = std::move(values);
      if (with_stamps) channel.timeline.stamps = shared;
    }
    const Estimate estimate = method().identify(evidence, {});
    for (const auto& row : find_table(estimate, "rests")->rows) EXPECT_EQ(std::get<std::string>(row.back()), "yes");
    EXPECT_EQ(find_table(estimate, "rests")->rows.size(), trial.evidence.plan.schedule.size());
    for (const auto& [name, truth] : trial.truth)
      EXPECT_NEAR(find_parameter(estimate, name)->value, truth, 1e-3 * (name.find("accelerometer") == 0 ? 1e-3 : 1.0))
          << name;
  }
}

TEST(ImuMultiPosition, ABiasThatStepsBetweenRestsIsNamedAndInTheUncertainty) {
  Trial trial = trial_of(method(), 1);
  EXPECT_FALSE(has_finding(method().identify(trial.evidence, {}).findings, "bias_steps_between_rests"));
  Channel& gyro = channel(trial.evidence, "gyro_x");
  for (std::size_t i = gyro.values.size() * 3 / 5; i < gyro.values.size(); ++i) gyro.values[i] += si(300.0, "deg/h");
  const Estimate estimate = method().identify(trial.evidence, {});
  EXPECT_TRUE(has(estimate, "bias_steps_between_rests", "gyro_x"));
  const double error = find_parameter(estimate, "gyro_x_bias")->value - si(900.0, "deg/h");
  EXPECT_LT(std::abs(error), 2.5 * sd(estimate, "gyro_x_bias"));
}

TEST(ImuMultiPosition, AClockThatContradictsThePlanIsNamedWhereItMatters) {
  Trial trial = trial_of(method(), 1);
  const auto named_at = [&](double fast) {
    Evidence evidence = trial.evidence;
    for (Channel& one : evidence.recordings[0].channels) one.timeline.rate /= 1.0 + fast;
    return has_finding(method().identify(evidence, {}).findings, "clock_moves_scale_factors");
  };
  EXPECT_FALSE(named_at(0.0));
  EXPECT_FALSE(named_at(1e-4));  // below the uncertainty of the scale factors
  EXPECT_TRUE(named_at(1e-3));
}

// Rest 3 of this test lies where the noise crosses one of the steps of 2 mg more and more seldom.
TEST(ImuMultiPosition, RoundingIsNoDriftOfARest) {
  EXPECT_FALSE(has_finding(method().identify(trial_of(method(), 1006).evidence, {}).findings, "rest_drifts"));
}

}  // namespace
}  // namespace tumble::imu_multi_position_test
