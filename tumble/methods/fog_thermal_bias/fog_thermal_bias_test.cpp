#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/fog_thermal_bias/data.hpp"
#include "tumble/methods/fog_thermal_bias/range.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/models/model.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

const Method& method() { return find_method("fog_thermal_bias"); }

void set(Settings& settings, const char* name, double value, const char* unit) {
  settings.set_number(name, si(value, unit), Unit::parse(unit));
}

/// The trial's test on an instrument with next to no noise and ideal sensors.
Trial quiet_trial() {
  Trial trial = method().trial(5);
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
    Trial trial = method().trial(seed);
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

TEST(FogThermalBias, ChoosesTheTrueOrdersByAicc) {
  Trial trial = method().trial(3);
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

/// One power-up in a recording of its own, from its temperatures.
Recording power_up(const std::string& file, const std::vector<double>& celsius, const std::vector<double>& rates) {
  Recording out;
  out.origin.file = file;
  const double interval = 10.0;
  out.channels.push_back(
      {"gyro", QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, 1.0 / interval, nullptr}, rates});
  out.channels.push_back(
      {"temperature", QuantityKind::temperature, Unit::parse("degC"), {0.0, 1.0 / interval, nullptr}, celsius});
  for (double& v : out.channels[0].values) v = si(v, "deg/h");
  for (double& v : out.channels[1].values) v = si(v, "degC");
  return out;
}

Evidence without_plan() {
  Evidence evidence;
  evidence.plan.method = "fog_thermal_bias";
  evidence.plan.settings = defaults(method().options());
  set(evidence.plan.settings, "averaging", 100.0, "s");
  return evidence;
}

std::vector<double> normal(std::size_t count, double sd, const RandomStream& random) {
  std::vector<double> out(count);
  random.normal(0, out);
  for (double& v : out) v *= sd;
  return out;
}

/// Sixty power-ups, one a temperature, whose bias is a polynomial of the soak temperature; the gyro warms by 0.3 K.
Evidence soaks(std::uint64_t seed) {
  Evidence evidence = without_plan();
  for (int run = 0; run < 60; ++run) {
    const RandomStream random = RandomStream(seed).split(static_cast<std::uint64_t>(run));
    const double soak = -40.0 + 2.0 * run, x = soak - 20.0;
    std::vector<double> celsius = normal(90, 0.003, random.split("sensor"));
    std::vector<double> rates = normal(90, 0.019, random.split("gyro"));
    for (std::size_t k = 0; k < 90; ++k) {
      celsius[k] += soak + 0.3 * (1.0 - std::exp(-10.0 * (static_cast<double>(k) + 0.5) / 300.0));
      rates[k] += 0.35 + 1.5e-3 * x - 1e-5 * x * x;
    }
    evidence.recordings.push_back(power_up("soak" + std::to_string(run) + ".csv", celsius, rates));
  }
  return evidence;
}

// The levels share the errors of the coefficients and of the transient, which in such runs are far larger than their
// scatter. With the orders fixed the intervals hold in 95 %: of 60 draws of 4 parameters, correlated at worst wholly,
// 4 sqrt(0.95 0.05/60) = 0.11.
TEST(FogThermalBiasCoverage, LevelsHaveTheUncertaintyOfTheCoefficients) {
  for (const bool startup : {false, true}) {
    int inside = 0;
    constexpr int seeds = 60;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      Evidence evidence = soaks(seed);
      evidence.plan.settings.set_word("order", "1");
      evidence.plan.settings.set_word("rate_order", "0");
      if (startup) set(evidence.plan.settings, "startup_time", 300.0, "s");
      const Estimate estimate = method().identify(evidence, {});
      // T_0 is the mean of two minutes: 0.3 K less this below the soak temperature plus the warming.
      const double above = 0.3 * (1.0 - 300.0 / 120.0 * (1.0 - std::exp(-120.0 / 300.0)));
      const double truth[] = {si(0.35 - 1.5e-3 * above - 1e-5 * above * above, "deg/h"),
                              si(1.5e-3 + 2e-5 * above, "deg/h/K"), si(-1e-5, "deg/h/K^2"), 0.0};
      for (std::size_t j = 0; j < 4; ++j) {
        const Parameter* p = find_parameter(estimate, "bias_" + std::to_string(j));
        ASSERT_NE(p, nullptr);
        const double sd = standard_uncertainty(estimate, static_cast<std::size_t>(p - estimate.parameters.data()));
        inside += std::abs(p->value - truth[j]) <= student_quantile(0.975, p->degrees_of_freedom) * sd;
      }
    }
    EXPECT_NEAR(inside / (4.0 * seeds), 0.95, 4.0 * std::sqrt(0.95 * 0.05 / seeds)) << startup;
  }
}

// The answer of automatic orders holds the truth in at least 95 % less 4 sigma of 60 draws, and its covariance is that
// of the largest model within 10 of the chosen one in AICc: wider is no fault of it.
TEST(FogThermalBiasCoverage, AutomaticOrdersKeepTheirUncertainty) {
  int inside = 0, all = 0;
  constexpr int seeds = 60;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Trial trial = method().trial(seed);
    // A third power that noise hides in most seeds.
    set(trial.evidence.plan.truth, "A3_0", 2e-7, "deg/h/K^3");
    for (const char* name : {"order", "gradient_order", "rate_order"})
      trial.evidence.plan.settings.set_word(name, "auto");
    trial.evidence.recordings = {simulate(trial.evidence.plan, seed, {})};
    const Estimate estimate = method().identify(trial.evidence, {});
    for (const auto& [name, truth] : trial.truth) {
      if (name.starts_with("turn_on")) continue;
      const Parameter* p = find_parameter(estimate, name);
      ++all;
      if (p == nullptr) continue;
      const double sd = standard_uncertainty(estimate, static_cast<std::size_t>(p - estimate.parameters.data()));
      inside += std::abs(p->value - truth) <= student_quantile(0.975, p->degrees_of_freedom) * sd;
    }
  }
  EXPECT_GE(inside / static_cast<double>(all), 0.95 - 4.0 * std::sqrt(0.95 * 0.05 / seeds));
}

// One ramp from each of four start temperatures: prediction of a run from the others extrapolates in T_0, and would
// choose too few orders. What is chosen is the smallest AICc of the table.
TEST(FogThermalBias, ChoosesTheSmallestAiccWhereEachStartTemperatureHasOneRun) {
  Trial trial = method().trial(4);
  Plan& plan = trial.evidence.plan;
  std::erase_if(plan.schedule, [](const Segment& segment) { return segment.run <= 5; });
  for (auto& segment : plan.schedule) segment.run -= 5;
  for (const char* name : {"order", "gradient_order", "rate_order"}) plan.settings.set_word(name, "auto");
  plan.settings.set_integer("start_temperature_power", 3);
  set(plan.truth, "A3_0", 3e-6, "deg/h/K^3");
  trial.evidence.recordings = {simulate(plan, 4, {})};
  const Estimate estimate = method().identify(trial.evidence, {});
  const Table& models = *find_table(estimate, "models");
  double chosen = 0.0, least = 1e300;
  for (const auto& row : models.rows) {
    const double aicc = std::get<double>(row[8]);
    const auto& mark = std::get<std::string>(row.back());
    if (mark != "not determined") least = std::min(least, aicc);
    if (mark == "yes") chosen = aicc;
  }
  EXPECT_EQ(chosen, least);
  EXPECT_TRUE(has_finding(estimate.findings, "predicted_runs_worse") ||
              find_parameter(estimate, "bias_sd_held_out")->value < find_parameter(estimate, "bias_sd_raw")->value);
}

TEST(FogThermalBias, NamesTheFileOfEachRunAndClaimsNoHeldOutRunsOfASingleOne) {
  Evidence evidence = soaks(3);
  const Estimate many = method().identify(evidence, {});
  const Table& runs = *find_table(many, "runs");
  ASSERT_EQ(runs.columns.back().name, "file");
  EXPECT_EQ(std::get<std::string>(runs.rows[7].back()), "soak7.csv");
  evidence.recordings.resize(1);
  evidence.plan.settings.set_integer("start_temperature_power", 0);
  set(evidence.plan.settings, "averaging", 60.0, "s");
  const Estimate one = method().identify(evidence, {});
  EXPECT_EQ(find_parameter(one, "bias_sd_held_out"), nullptr);
  EXPECT_FALSE(has_finding(one.findings, "predicted_runs_worse"));
}

TEST(FogThermalBias, SaysThatASensorIsStuck) {
  Trial trial = method().trial(6);
  const auto said = [&](const Evidence& evidence) {
    return finding_of(method().identify(evidence, {}).findings, "temperature_sensor_stuck") != nullptr;
  };
  EXPECT_FALSE(said(trial.evidence));
  Recording& recording = trial.evidence.recordings[0];
  for (auto& channel : recording.channels) {
    if (channel.name != "temperature_side") continue;
    // Run 7: 900 s at rest, then a ramp of 1 K/min: stuck for 10 min in the middle of it.
    const std::size_t begin = index_at(channel, runs_of({recording})[6].begin) + 350;
    for (std::size_t k = begin; k < begin + 120; ++k) channel.values[k] = channel.values[begin];
  }
  EXPECT_TRUE(said(trial.evidence));
  // With one sensor: the jump at the end shows it.
  for (auto& channel : recording.channels)
    channel.name = channel.name == "temperature_side" ? "temperature" : channel.name == "gyro" ? "gyro" : "other";
  trial.evidence.plan.settings.set_word("gradient_order", "0");
  EXPECT_TRUE(said(trial.evidence));
}

/// The trial with a drift added to its gyro: a function of the temperature of the top sensor, smoothed, in each run.
Trial with_drift(std::uint64_t seed, const std::function<std::vector<double>(const std::vector<double>&)>& drift) {
  Trial trial = method().trial(seed);
  Recording& recording = trial.evidence.recordings[0];
  Channel& gyro = recording.channels[0];
  const Channel& top = *find_channel(recording, "temperature_top");
  for (const auto& run : runs_of({recording})) {
    const std::size_t begin = index_at(gyro, run.begin), end = std::min(gyro.values.size(), index_at(gyro, run.end));
    std::vector<double> celsius(top.values.begin() + static_cast<std::ptrdiff_t>(begin),
                                top.values.begin() + static_cast<std::ptrdiff_t>(end));
    const auto added = drift(celsius);
    for (std::size_t k = begin; k < end; ++k) gyro.values[k] += added[k - begin];
  }
  return trial;
}

// A bias that lags by 30 % of 5 K behind reversals of the temperature: 0.1 deg/h between up and down.
TEST(FogThermalBias, SaysThatUpAndDownDiffer) {
  const Trial trial = with_drift(2, [](const std::vector<double>& temperature) {
    std::vector<double> out;
    double centre = temperature.front();
    for (const double t : temperature) {
      centre = std::clamp(centre, t - 2.5, t + 2.5);  // a play of 5 K
      out.push_back(si(0.02, "deg/h") * (centre - t));
    }
    return out;
  });
  const Estimate estimate = method().identify(trial.evidence, {});
  ASSERT_TRUE(has_finding(estimate.findings, "hysteresis"));
  EXPECT_NEAR(value_of(estimate.findings, "hysteresis", "size"), si(0.1, "deg/h"), si(0.04, "deg/h"));
}

// Sound data: no departure is significant in 30 trials, at a p-value of 1e-4.
TEST(FogThermalBias, AccusesNoSoundTest) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed)
    for (const auto& trial : {method().trial(seed), method().second_trial(seed)}) {
      const Estimate estimate = method().identify(trial.evidence, {});
      for (const char* code :
           {"hysteresis", "drift_lags_temperature", "temperature_sensor_stuck", "predicted_runs_worse"})
        EXPECT_FALSE(has_finding(estimate.findings, code)) << code << ", seed " << seed;
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
  Trial trial = method().trial(1);
  trial.evidence.plan.settings.set_integer("start_temperature_power", 3);
  trial.evidence.plan.settings.set_integers("hold_out", {1, 2, 3, 6, 7, 8});
  try {
    method().identify(trial.evidence, {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::bad_data);
    EXPECT_NE(std::string(error.what()).find("start temperature"), std::string::npos);
  }
}

TEST(FogThermalBias, RefusesRunsShorterThanAnAverage) {
  Trial trial = method().trial(1);
  set(trial.evidence.plan.settings, "averaging", 2.0, "h");
  EXPECT_THROW(method().identify(trial.evidence, {}), Error);
}

TEST(FogThermalBias, RefusesOptionsThatCannotBeMeantAllAtOnce) {
  Trial trial = method().trial(1);
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

TEST(FogThermalBias, CompensatesAnotherSessionToItsNoise) {
  const Trial trial = method().trial(1), later = method().trial(2);
  const Compensation out = method().compensate(with_provenance(trial), later.evidence.recordings[0], nullptr);
  const Table& table = out.tables.at(0);
  // White noise of 0.001 deg/sqrt(h) in averages of 100 s: 0.006 deg/h; slow noise adds about 0.003 deg/h over a run.
  for (const auto& row : table.rows) EXPECT_LT(std::get<double>(row[4]), si(0.012, "deg/h"));
  EXPECT_NE(find_channel(out.recording, "gyro.compensation_sd"), nullptr);
  EXPECT_EQ(out.recording.channels.size(), 5u);
}

TEST(FogThermalBias, CompensatesOnlyWithASoundResultAndOnlyOnce) {
  const Trial trial = method().trial(1);
  const Recording& recording = trial.evidence.recordings[0];
  const Estimate sound = with_provenance(trial);
  const auto refused = [&](const Estimate& estimate, const Recording& on) {
    try {
      method().compensate(estimate, on, nullptr);
      return false;
    } catch (const Error&) {
      return true;
    }
  };
  EXPECT_FALSE(refused(sound, recording));
  Estimate edited = sound;
  edited.parameters[0].unit = Unit::parse("m");
  EXPECT_TRUE(refused(edited, recording));
  edited = sound;
  edited.parameters[0].name = "Z9";
  EXPECT_TRUE(refused(edited, recording));
  edited = sound;
  edited.parameters[0].value = std::nan("");
  EXPECT_TRUE(refused(edited, recording));
  edited = sound;
  for (auto& table : edited.tables) table.rows.clear();
  EXPECT_TRUE(refused(edited, recording));
  edited = sound;
  edited.provenance.settings.erase("sensor_lag");
  EXPECT_TRUE(refused(edited, recording));
  EXPECT_TRUE(refused(sound, method().compensate(sound, recording, nullptr).recording));
}

TEST(FogThermalBias, LeavesBlankWhatHasNoTemperature) {
  const Trial trial = method().trial(1);
  Recording recording = trial.evidence.recordings[0];
  for (auto& channel : recording.channels)
    if (channel.name != "gyro")
      for (std::size_t k = 200; k < 300; ++k) channel.values[k] = std::nan("");
  const Compensation out = method().compensate(with_provenance(trial), recording, nullptr);
  EXPECT_TRUE(std::isnan(find_channel(out.recording, "gyro")->values[250]));
  EXPECT_FALSE(std::isnan(find_channel(out.recording, "gyro")->values[350]));
  const Finding* blank = finding_of(out.findings, "samples_without_temperature");
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

// An average of 100 s holds 20 samples of the clock of 0.2 Hz: one period of this output, whose averages are zero. By
// the mean rate without every second stretch of 1000 s, 0.1 Hz, they would be of half periods: 0.64 deg/h.
TEST(FogThermalBias, LostSamplesDoNotChangeTheAveragesOfCompensation) {
  const Trial trial = method().trial(1);
  Recording recording = trial.evidence.recordings[0];
  Channel& gyro = recording.channels[0];
  ASSERT_EQ(gyro.name, "gyro");
  ASSERT_EQ(gyro.timeline.rate, 0.2);
  const auto number = within_run(recording, gyro);
  for (std::size_t k = 0; k < gyro.values.size(); ++k)
    gyro.values[k] = si(1.0, "deg/h") * std::sin(two_pi * static_cast<double>(number(k)) / 20.0);
  gyro = without(gyro, [&](std::size_t k) { return number(k) / 200 % 2 == 1; });
  const Compensation out = method().compensate(with_provenance(trial), recording, nullptr);
  for (const auto& row : out.tables.at(0).rows) EXPECT_LT(std::get<double>(row[3]), si(1e-9, "deg/h"));
}

// The share of an interval is of the samples that its clock of 0.2 Hz gives, also where half of the record is lost.
TEST(FogThermalBias, LostSamplesLessenTheShareOfTheirInterval) {
  Trial trial = method().trial(1);
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
  const Trial trial = method().trial(1);
  Trial hot = method().trial(2);
  for (auto& segment : hot.evidence.plan.schedule)
    for (auto& [axis, motion] : segment.axes) (motion.kind == Motion::Kind::ramp ? motion.to : motion.value) += 15.0;
  const Recording recording = simulate(hot.evidence.plan, 2, {});
  const Compensation out = method().compensate(with_provenance(trial), recording, nullptr);
  ASSERT_EQ(out.findings.size(), 1u);
  EXPECT_EQ(out.findings[0].code, "outside_calibrated_range");
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
  Plan plan = method().trial(1).evidence.plan;
  plan.schedule[0].axes["chamber"].value = si(120.0, "degC");
  plan.schedule[6].axes["chamber"].value = si(40.0, "K/min");
  EXPECT_EQ(find_rig("thermal_chamber").refusals(plan.schedule, plan.rig).size(), 2u);
}

TEST(Simulate, TheSameSeedGivesTheSameBytesAndAnotherOtherOnes) {
  const Plan plan = method().trial(1).evidence.plan;
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
}  // namespace tumble
