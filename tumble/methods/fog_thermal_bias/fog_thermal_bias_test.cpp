#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>

#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/fog_thermal_bias/data.hpp"
#include "tumble/methods/fog_thermal_bias/range.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/compensate.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::fog_thermal_bias_test {
namespace {

const Method& method() { return find_method("fog_thermal_bias"); }

void set(Settings& settings, const char* name, double value, const char* unit) {
  settings.set_number(name, si(value, unit), Unit::parse(unit));
}

/// The trial's test on an instrument with next to no noise and ideal sensors.
Trial quiet_trial() {
  Trial trial = trial_of(method(), 5);
  Plan& plan = trial.evidence.plan;
  for (const char* name : {"sensor_noise", "sensor_quantum"}) set(plan.rig, name, 0.0, "K");
  set(plan.rig, "sensor_lag", 0.0, "s");
  set(plan.settings, "sensor_lag", 0.0, "s");
  set(plan.rig, "draught_sd", 0.0, "K");
  set(plan.rig, "stability_sd", 0.0, "K");
  set(plan.truth, "angle_random_walk", 1e-7, "deg/sqrt(h)");
  for (const char* name : {"bias_instability", "turn_on_repeatability"}) set(plan.truth, name, 0.0, "deg/h");
  set(plan.truth, "rate_random_walk", 0.0, "deg/h/sqrt(h)");
  trial.evidence.recordings = {simulate(plan, 5, {})};
  return trial;
}

TEST(FogThermalBias, RecoversTheTruthWithoutNoise) {
  Trial trial = quiet_trial();
  set(trial.evidence.plan.settings, "smoothing", 10.0, "s");
  const Estimate estimate = method().identify(trial.evidence, {});
  for (const auto& [name, truth] : trial.truth) {
    if (name == "turn_on_repeatability" || name.starts_with("bias_")) continue;
    // The remainder is the local quadratic over +-5 s where the air changes its rate: the slope there is wrong by up to
    // half the change for 10 s of 10 000 s. One part in 1000 bounds it.
    EXPECT_NEAR(find_parameter(estimate, name)->value / truth, 1.0, 1e-3) << name;
  }
}

TEST(FogThermalBias, TwoStagesAgreeWithOneOnQuietData) {
  Trial trial = quiet_trial();
  trial.evidence.plan.settings.set_word("estimator", "two_stage");
  const Estimate two = method().identify(trial.evidence, {});
  trial.evidence.plan.settings.set_word("estimator", "joint");
  const Estimate one = method().identify(trial.evidence, {});
  for (const char* name : {"A1_0", "A2_0", "B1_0", "C1_0"})
    EXPECT_NEAR(find_parameter(two, name)->value / find_parameter(one, name)->value, 1.0, 0.01) << name;
}

TEST(FogThermalBiasCoverage, TwoStageIntervalsHoldTheTruth) {
  int inside = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Trial trial = trial_of(method(), seed);
    trial.evidence.plan.settings.set_word("estimator", "two_stage");
    const Estimate estimate = method().identify(trial.evidence, {});
    for (const auto& [name, truth] : trial.truth)
      for (std::size_t k = 0; k < estimate.parameters.size(); ++k) {
        const Parameter& p = estimate.parameters[k];
        if (p.name != name || name.starts_with("bias_") || name.starts_with("turn_on")) continue;
        ++all;
        inside += std::abs(p.value - truth) <=
                  student_quantile(0.975, p.degrees_of_freedom) * standard_uncertainty(estimate, k);
      }
  }
  // Eight coefficients a seed, correlated within a seed at worst wholly: 4 sigma of 60 independent draws.
  EXPECT_EQ(all, 480);
  EXPECT_NEAR(inside / static_cast<double>(all), 0.95, 4.0 * std::sqrt(0.95 * 0.05 / 60.0));
}

/// Drift [rad/s] of the true coefficients over temperature alone, from the start temperature on.
double true_drift(const Trial& trial, double temperature, double start) {
  const auto terms =
      find_model("fiber_optic_gyro").outputs(fog_thermal_bias::constants_of(trial.evidence.plan.settings))[0].terms;
  Felt here, there;
  here.temperature = temperature, there.temperature = start;
  here.start_temperature = there.start_temperature = start;
  here.since_power_on = there.since_power_on = 1e9;
  double drift = 0.0;
  for (const auto& [name, value] : trial.truth)
    if (const auto term = std::ranges::find(terms, name, &Term::name); term != terms.end() && name.starts_with('A'))
      drift += value * (term->regressor(here) - term->regressor(there));
  return drift;
}

// The cells of one row have one rate and one gradient, so that they differ by the terms of the temperature alone: they
// differ as those of the truth do, within four of both standard uncertainties.
TEST(FogThermalBias, TheSurfaceIsThatOfTheTruth) {
  Trial trial = trial_of(method(), 1);
  const Estimate estimate = method().identify(trial.evidence, {});
  const Table *map = find_table(estimate, "thermal_map"), *points = find_table(estimate, "thermal_points");
  ASSERT_TRUE(map != nullptr && points != nullptr);
  const auto number = [](const auto& row, std::size_t c) { return std::get<double>(row[c]); };
  const double start = trial.evidence.plan.settings.number("start_temperature_reference");
  std::size_t compared = 0;
  for (std::size_t i = 1; i < map->rows.size(); ++i) {
    const auto &one = map->rows[i - 1], &other = map->rows[i];
    if (number(one, 1) != number(other, 1)) continue;
    const double truth = true_drift(trial, number(other, 0), start) - true_drift(trial, number(one, 0), start);
    EXPECT_NEAR(number(other, 2) - number(one, 2), truth, 4.0 * (number(one, 3) + number(other, 3))) << i;
    ++compared;
  }
  EXPECT_GT(compared, 50u);
  // Points are the surface plus the mean residual of their cell.
  double squares = 0.0, residuals = 0.0;
  for (const auto& row : points->rows) {
    squares += number(row, 2) * number(row, 2);
    residuals += number(row, 3) * number(row, 3);
  }
  EXPECT_LT(residuals, 0.2 * squares);
}

TEST(FogThermalBias, ChoosesTheTrueOrdersByAicc) {
  Trial trial = trial_of(method(), 3);
  for (const char* name : {"order", "gradient_order", "rate_order"})
    trial.evidence.plan.settings.set_word(name, "auto");
  const Estimate estimate = method().identify(trial.evidence, {});
  const Table& models = *find_table(estimate, "models");
  EXPECT_EQ(models.rows.size(), 16u);
  EXPECT_EQ(models.rows[0].size(), models.columns.size());
  for (const auto& row : models.rows)
    if (std::get<std::string>(row.back()) == "yes") {
      EXPECT_EQ(std::get<double>(row[0]), 2.0);
      EXPECT_EQ(std::get<double>(row[1]), 1.0);
      EXPECT_EQ(std::get<double>(row[2]), 1.0);
    }
}

TEST(FogThermalBias, SaysThatASingleSoakCannotSeparateTemperatureFromItsRate) {
  Trial trial = quiet_trial();
  Plan& plan = trial.evidence.plan;
  // Every run: nothing but the instrument's own warming, one exponential.
  plan.schedule.clear();
  for (int run = 1; run <= 4; ++run)
    plan.schedule.push_back(
        {"soak", 9000.0, run, {{"chamber", {.kind = Motion::Kind::dwell, .value = si(-20.0 + 20.0 * run, "degC")}}}});
  for (const char* name : {"top_time", "side_time"}) set(plan.rig, name, 10.0, "min");
  for (const char* name : {"top_self_heating", "side_self_heating"}) set(plan.rig, name, 20.0, "K");
  set(plan.truth, "angle_random_walk", 1e-3, "deg/sqrt(h)");
  plan.settings.set_word("order", "1");
  plan.settings.set_word("gradient_order", "0");
  trial.evidence.recordings = {simulate(plan, 8, {})};
  const Estimate estimate = method().identify(trial.evidence, {});
  EXPECT_TRUE(std::ranges::any_of(estimate.findings, [](const Finding& finding) {
    return finding.code == "rate_follows_temperature" && std::get<double>(finding.values[0].value) > 0.95;
  }));
}

TEST(FogThermalBias, RefusesFewerStartTemperaturesThanTerms) {
  Trial trial = trial_of(method(), 1);
  trial.evidence.plan.settings.set_integer("start_temperature_power", 3);
  trial.evidence.plan.settings.set_integers("hold_out", {1, 2, 3, 6, 7, 8});
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "start temperature"}, refusal(method(), trial.evidence)));
}

TEST(FogThermalBias, RefusesRunsShorterThanAnAverage) {
  Trial trial = trial_of(method(), 1);
  set(trial.evidence.plan.settings, "averaging", 2.0, "h");
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"7200"}, .pattern = "shorter than one average"},
                      [&] { method().identify(trial.evidence, {}); }));
}

TEST(FogThermalBias, RefusesOptionsThatCannotBeMeantAllAtOnce) {
  Trial trial = trial_of(method(), 1);
  Settings& settings = trial.evidence.plan.settings;
  set(settings, "averaging", 20.0, "s");  // smoothing is 30 s
  settings.set_integers("hold_out", {99});
  try {
    method().identify(trial.evidence, {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::bad_input);
    EXPECT_EQ(error.problems.size(), 2u);
  }
}

Estimate with_provenance(const Trial& trial) {
  Estimate estimate = method().identify(trial.evidence, {});
  estimate.provenance.settings = trial.evidence.plan.settings.texts();
  return estimate;
}

/// Sd [rad/s] of the averages of 100 s about their mean, for each power-up.
std::vector<double> sd_of_averages(const Recording& recording) {
  constexpr std::size_t each = 20;  // samples of a clock of 0.2 Hz
  const Channel& gyro = *find_channel(recording, "gyro");
  std::vector<double> all;
  for (const auto& run : runs_of({recording})) {
    std::vector<double> means;
    const std::size_t last = std::min(index_at(gyro, run.end), gyro.values.size());
    for (std::size_t at = index_at(gyro, run.begin); at + each <= last; at += each)
      means.push_back(std::accumulate(&gyro.values[at], &gyro.values[at] + each, 0.0) / each);
    double mean = 0.0, squares = 0.0;
    for (const double m : means) mean += m / static_cast<double>(means.size());
    for (const double m : means) squares += (m - mean) * (m - mean);
    all.push_back(std::sqrt(squares / static_cast<double>(means.size() - 1)));
  }
  return all;
}

TEST(FogThermalBias, CompensatesAnotherSessionToItsNoise) {
  const Trial trial = trial_of(method(), 1), later = trial_of(method(), 2);
  const Compensation out = compensate(with_provenance(trial), later.evidence.recordings[0], nullptr);
  // White noise of 0.001 deg/sqrt(h) in averages of 100 s: 0.006 deg/h; slow noise adds about 0.003 deg/h over a run.
  for (const double sd : sd_of_averages(out.recording)) EXPECT_LT(sd, si(0.012, "deg/h"));
  EXPECT_NE(find_channel(out.recording, "gyro.compensation_sd"), nullptr);
  EXPECT_EQ(out.recording.channels.size(), 5u);
}

TEST(FogThermalBias, CompensatesOnlyWithASoundResultAndOnlyOnce) {
  const Trial trial = trial_of(method(), 1);
  const Recording& recording = trial.evidence.recordings[0];
  const Estimate sound = with_provenance(trial);
  const auto refused = [&](const Estimate& estimate, const Recording& on) {
    try {
      compensate(estimate, on, nullptr);
      return false;
    } catch (const Error&) {
      return true;
    }
  };
  EXPECT_FALSE(refused(sound, recording));
  Estimate edited = sound;
  edited.parameters[0].value = std::nan("");
  EXPECT_TRUE(refused(edited, recording));
  edited = sound;
  edited.models.clear();
  EXPECT_TRUE(refused(edited, recording));
  EXPECT_TRUE(refused(sound, compensate(sound, recording, nullptr).recording));
}

TEST(FogThermalBias, LeavesBlankWhatHasNoTemperature) {
  const Trial trial = trial_of(method(), 1);
  Recording recording = trial.evidence.recordings[0];
  for (auto& channel : recording.channels)
    if (channel.name != "gyro")
      for (std::size_t k = 200; k < 300; ++k) channel.values[k] = std::nan("");
  const Compensation out = compensate(with_provenance(trial), recording, nullptr);
  EXPECT_TRUE(std::isnan(find_channel(out.recording, "gyro")->values[250]));
  EXPECT_FALSE(std::isnan(find_channel(out.recording, "gyro")->values[350]));
  const Finding* blank = finding_of(out.findings, "input_missing");
  ASSERT_NE(blank, nullptr);
  EXPECT_EQ(blank->where, "gyro");
  EXPECT_GE(blank->occurrences.count, 90u);  // of 100, without those near enough to a reading
}

/// The samples whose index in the channel `lost` does not name, with their stamps.
Channel without(const Channel& channel, const std::function<bool(std::size_t)>& lost) {
  Channel out = channel;
  std::vector<double> stamps;
  out.values.clear();
  for (std::size_t k = 0; k < channel.values.size(); ++k) {
    if (lost(k)) continue;
    stamps.push_back(channel.time(k));
    out.values.push_back(channel.values[k]);
  }
  out.timeline = {0.0, 0.0, std::make_shared<const std::vector<double>>(std::move(stamps))};
  return out;
}

/// Number of a sample of a channel within its run.
std::function<std::size_t(std::size_t)> within_run(const Recording& recording, const Channel& channel) {
  std::vector<std::size_t> begins;
  for (const auto& run : runs_of({recording})) begins.push_back(index_at(channel, run.begin));
  return [begins](std::size_t k) { return k - *(std::ranges::upper_bound(begins, k) - 1); };
}

// The share of an interval is of the samples that its clock of 0.2 Hz gives, also where half of the record is lost.
TEST(FogThermalBias, LostSamplesLessenTheShareOfTheirInterval) {
  Trial trial = trial_of(method(), 1);
  Recording& recording = trial.evidence.recordings[0];
  const auto number = within_run(recording, recording.channels[0]);
  recording.channels[0] = without(recording.channels[0], [&](std::size_t k) {
    const std::size_t of_interval = number(k) % 20, interval = number(k) / 20;
    return interval == 3 ? of_interval < 8 : interval == 5 ? of_interval < 12 : interval > 20 && interval % 2 == 0;
  });
  const auto constants = fog_thermal_bias::constants_of(trial.evidence.plan.settings);
  const auto terms = find_model("fiber_optic_gyro").outputs(constants)[0].terms;
  const auto runs = fog_thermal_bias::run_data(trial.evidence, terms, 0.0, 100.0);
  EXPECT_NEAR(runs[0].share[2], 1.0, 1e-6);
  EXPECT_NEAR(runs[0].share[3], 0.6, 1e-6);
  EXPECT_EQ(runs[0].share[5], 0.0);  // less than half
}

TEST(FogThermalBias, FlagsSamplesOutsideOfTheCalibratedRange) {
  const Trial trial = trial_of(method(), 1);
  Trial hot = trial_of(method(), 2);
  for (auto& segment : hot.evidence.plan.schedule)
    for (auto& [axis, motion] : segment.axes) (motion.kind == Motion::Kind::ramp ? motion.to : motion.value) += 15.0;
  const Recording recording = simulate(hot.evidence.plan, 2, {});
  const Compensation out = compensate(with_provenance(trial), recording, nullptr);
  EXPECT_NE(finding_of(out.findings, "extrapolated"), nullptr);
  const Channel& flag = *find_channel(out.recording, "gyro.extrapolated");
  const auto outside = std::ranges::count(flag.values, 1.0);
  EXPECT_GT(outside, 0);
  EXPECT_LT(outside, static_cast<std::ptrdiff_t>(flag.values.size()));
  // The fifth soak starts at 75 degC, 15 K beyond the hottest start: all of it is outside.
  const std::size_t begin = index_at(flag, recording.marks[4].begin);
  for (std::size_t k = begin; k < begin + 100; ++k) EXPECT_EQ(flag.values[k], 1.0);
}

TEST(ThermalChamber, TemperatureRateIsTheDerivativeOfTemperature) {
  const Trial trial = quiet_trial();
  const Plan& plan = trial.evidence.plan;
  Schedule run;
  for (const auto& segment : plan.schedule)
    if (segment.run == 6) run.push_back(segment);
  const auto reference = find_rig("thermal_chamber").reference({run, plan.rig, {}, 1.0, {}, RandomStream(1)});
  std::vector<Felt> felt(10200);
  reference.felt(0.5, 1.0, felt);
  for (std::size_t k = 1; k + 1 < felt.size(); ++k) {
    const double difference = 0.5 * (felt[k + 1].temperature - felt[k - 1].temperature);
    // Central difference over 2 s: T''' /6 below 1e-8, and half a second of a jump of T'' (5 K/min over 600 s) at
    // corners.
    EXPECT_NEAR(difference, felt[k].temperature_rate, 0.25 * si(5.0, "K/min") / 600.0) << k;
  }
}

TEST(ThermalChamber, RefusesAllItCannotDoAtOnce) {
  Plan plan = trial_of(method(), 1).evidence.plan;
  plan.schedule[0].axes["chamber"].value = si(120.0, "degC");
  plan.schedule[6].axes["chamber"].value = si(40.0, "K/min");
  EXPECT_EQ(find_rig("thermal_chamber").refusals(plan.schedule, plan.rig).size(), 2u);
}

TEST(Simulate, TheSameSeedGivesTheSameBytesAndAnotherOtherOnes) {
  const Plan plan = trial_of(method(), 1).evidence.plan;
  const Recording a = simulate(plan, 7, {}), b = simulate(plan, 7, {}), c = simulate(plan, 8, {});
  for (std::size_t k = 0; k < a.channels.size(); ++k) EXPECT_EQ(a.channels[k].values, b.channels[k].values);
  EXPECT_NE(a.channels[0].values, c.channels[0].values);
}

TEST(Simulate, ListsAllThatAPlanLacks) {
  try {
    simulate(Plan{}, 1, {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.problems.size(), 4u);
  }
}

}  // namespace
}  // namespace tumble::fog_thermal_bias_test
