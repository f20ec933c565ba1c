#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "tumble/math/random.hpp"
#include "tumble/math/sine_fit.hpp"
#include "tumble/methods/sine_vibration/line.hpp"
#include "tumble/methods/sine_vibration/measure.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/trial/plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble {
namespace {

constexpr double pi = std::numbers::pi, window = 5e-3;
const Method& method() { return find_method("sine_vibration"); }

/// Means of A cos(2 pi f t + p) over windows of 5 ms, exact.
struct Windows {
  std::vector<double> time, value;
};

Windows windows(double amplitude, double frequency, double phase, std::size_t count, double mean = 0.0) {
  Windows w;
  for (std::size_t j = 0; j < count; ++j) {
    w.time.push_back((static_cast<double>(j) + 0.5) * window);
    w.value.push_back(mean + amplitude * vibration::sinc(frequency * window) *
                                 std::cos(2.0 * pi * std::fmod(frequency * w.time.back(), 1.0) + phase));
  }
  return w;
}

double sd_of(const std::vector<double>& values) {
  double mean = 0.0, squares = 0.0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  for (const double v : values) squares += (v - mean) * (v - mean);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

// The numbers that the theory prints; tolerance: one unit of the last digit printed.

TEST(SineVibration, WindowTakesItsSinc) {
  const double printed[] = {0.9959, 0.9836, 0.9634, 0.9355, 0.9003, 0.8584, 0.8103,
                            0.7568, 0.6986, 0.6366, 0.5716, 0.5046, 0.4363};
  for (int k = 0; k < 13; ++k) EXPECT_NEAR(vibration::sinc(10.0 * (k + 1) * window), printed[k], 1e-4) << k;
}

TEST(SineVibration, SpreadThatTheWindowAloneGives) {
  EXPECT_NEAR(sine::sd_from_window(3.0, 10.0, window, 0.0), 2.113, 1e-3);
  EXPECT_NEAR(sine::sd_from_window(3.0, 80.0, window, 0.0), 1.606, 1e-3);
  EXPECT_NEAR(sine::sd_from_window(3.0, 100.0, window, 0.0), 1.350, 1e-3);
  EXPECT_NEAR(sine::sd_from_window(3.0, 130.0, window, 0.0), 0.926, 1e-3);
  EXPECT_DOUBLE_EQ(sine::sd_from_window(0.0, 10.0, window, 1e-4), 1e-4 / window / std::sqrt(6.0));
  EXPECT_NEAR(sd_of(windows(3.0, 80.0, 0.3, 20000).value), sine::sd_from_window(3.0, 80.0, window, 0.0), 1e-4);
}

TEST(SineVibration, AliasesOfTheCampaign) {
  EXPECT_NEAR(aliased_frequency(110.0, 200.0), 90.0, 1e-9);
  EXPECT_NEAR(aliased_frequency(120.0, 200.0), 80.0, 1e-9);
  EXPECT_NEAR(aliased_frequency(130.0, 200.0), 70.0, 1e-9);
}

// sd = A 0.6366 |cos(phase)| at exactly half of the windows a second: 0 to 1.910 g for 3 g.
TEST(SineVibration, PhaseLockAtHalfOfTheRate) {
  for (const double phase : {0.0, 0.4, 1.0, pi / 2.0}) {
    // the phase in the middle of the windows: 100 Hz advances by a quarter of a turn to the first
    const auto w = windows(3.0, 100.0, phase - 2.0 * pi * 100.0 * 0.5 * window, 20000);
    EXPECT_NEAR(sd_of(w.value), 3.0 * 0.6366 * std::abs(std::cos(phase)), 1e-3);
  }
  EXPECT_NEAR(sd_of(windows(3.0, 100.0, -pi / 2.0, 20000).value), 1.910, 1e-3);
  const std::string why = sine::objection(100.0, window, window, 100.0);
  EXPECT_NE(why.find("99.7 Hz or 100.3 Hz"), std::string::npos) << why;
  EXPECT_EQ(sine::objection(99.7, window, window, 100.0), "");
}

TEST(SineVibration, NullsOfTheWindowAreNeverCorrected) {
  for (const double f : {190.5, 200.0, 209.5, 395.0})
    EXPECT_NE(sine::objection(f, window, window, 100.0).find("null"), std::string::npos) << f;
  for (const double f : {10.0, 189.0, 211.0}) EXPECT_EQ(sine::objection(f, window, window, 100.0), "") << f;
}

// 90 Hz, 100 s, 3 g: 106 micro-g at most, reached where f is off by 1/(2T) = 5 mHz, nothing where fT is whole.
TEST(SineVibration, BrokenCyclesShiftThePlainMeanOnly) {
  double worst = 0.0;
  for (int k = 0; k < 16; ++k) {
    const auto w = windows(3.0, 90.005, pi * k / 8.0, 20000, 1.0);
    const auto line = sine::fit_line(w.time, w.value, window, 90.0);
    worst = std::max(worst, std::abs(line.plain_mean - 1.0));
    EXPECT_NEAR(line.mean, 1.0, 1e-8);
    EXPECT_NEAR(line.frequency, 90.005, 1e-8);
  }
  EXPECT_NEAR(worst, 106e-6, 1e-6);
  EXPECT_NEAR(3.0 / (pi * 90.0 * 100.0), 106e-6, 1e-6);
  const auto whole = windows(3.0, 90.0, 0.7, 20000, 1.0);
  EXPECT_NEAR(sine::fit_line(whole.time, whole.value, window, 90.0).plain_mean, 1.0, 1e-12);
}

// At a wrong frequency sinc(df T) of the amplitude is left: 1 mHz over 100 s -1.6 %, 5 mHz -36 %, 10 mHz all.
TEST(SineVibration, FrequencyErrorTakesTheAmplitude) {
  const auto w = windows(3.0, 40.0, 0.3, 20000);
  const double full = 3.0 * vibration::sinc(40.0 * window);
  const auto left = [&](double df) {
    return std::abs(fit_sine(w.time, w.value, 40.0 + df, {.harmonics = 1, .polynomial = 0}).line[0]) / full;
  };
  EXPECT_NEAR(left(1e-3) - 1.0, -0.016, 1e-3);
  EXPECT_NEAR(left(5e-3) - 1.0, -0.36, 1e-2);
  EXPECT_NEAR(left(10e-3), 0.0, 1e-3);
  for (const double df : {1e-3, -4e-3, 5e-3})
    EXPECT_NEAR(sine::fit_line(w.time, w.value, window, 40.0 + df).amplitude, full, 1e-9);
}

TEST(SineVibration, AboveHalfOfTheRateTheTrueFrequencyKeepsThePhase) {
  const double phase = 0.4;
  const auto w = windows(3.0, 130.0, phase, 20000);
  const auto at_origin = [&](const sine::Line& line, double f) {
    const double centre = 0.5 * (w.time.front() + w.time.back());
    return std::remainder(line.phase - 2.0 * pi * f * centre, 2.0 * pi);
  };
  const auto line = sine::fit_line(w.time, w.value, window, 130.0),
             alias = sine::fit_line(w.time, w.value, window, 70.0);
  EXPECT_NEAR(line.amplitude, 3.0 * vibration::sinc(0.65), 1e-9);
  EXPECT_NEAR(alias.amplitude, line.amplitude, 1e-9);
  EXPECT_NEAR(at_origin(line, 130.0), phase, 1e-6);
  EXPECT_NEAR(at_origin(alias, 70.0), pi - phase, 1e-6);
}

TEST(SineVibration, FastFitAgreesWithTheGeneralOne) {
  auto w = windows(3.0, 61.3, 0.3, 8000, 1.0);
  std::vector<double> noise(8000);
  RandomStream(4).normal(0, noise);
  for (std::size_t i = 0; i < noise.size(); ++i)
    w.value[i] += 1e-3 * noise[i] + 2e-5 * w.time[i] + 0.02 * std::cos(4.0 * pi * 61.3 * w.time[i]);
  for (std::size_t i = 3000; i < 3100; ++i) w.value[i] = std::nan("");
  const auto fast = sine::fit_line(w.time, w.value, window, 61.301);
  const auto slow =
      fit_sine(w.time, w.value, 61.301, {.harmonics = 3, .polynomial = 1, .fit_frequency = true, .rate = 200.0});
  EXPECT_NEAR(fast.frequency, slow.frequency, 0.1 * slow.frequency_sd);
  EXPECT_NEAR(fast.amplitude, std::abs(slow.line[0]), 1e-7);
  EXPECT_NEAR(fast.mean, slow.polynomial[0], 1e-7);
  EXPECT_NEAR(fast.second, 0.02, 1e-4);
  // both variances from about 40 projections of the residuals: their ratio has a sd of sqrt(2/40 + 2/40) = 0.32, less
  // as most of the projections are the same
  EXPECT_NEAR(std::pow(fast.frequency_sd / slow.frequency_sd, 2), 1.0, 0.4);
  EXPECT_NEAR(fast.log_variance / slow.log_gain_variance(), 1.0, 0.4);
}

/// Whole pulses (3.3) of windows of a force that is constant plus a sine, both in pulses a window.
std::vector<double> counted(double constant, double amplitude, double cycles, double start, std::size_t count) {
  std::vector<double> whole(count);
  double total = start, given = std::floor(start);
  for (std::size_t j = 0; j < count; ++j) {
    total += constant + amplitude * std::cos(2.0 * pi * cycles * (static_cast<double>(j) + 0.5) + 0.3);
    whole[j] = std::floor(total + 1e-9) - given;  // sums of twentieths are not exact
    given += whole[j];
  }
  return whole;
}

/// Variance and correlation of neighbours of what rounding does to each window [pulse^2], and of it all together.
struct Rounding {
  double variance = 0.0, correlation = 0.0, total = 0.0;
};

Rounding rounding_of(double constant, double amplitude, double cycles, double start) {
  constexpr std::size_t n = 4000;
  const auto whole = counted(constant, amplitude, cycles, start, n);
  Rounding r;
  std::vector<double> error(n);
  for (std::size_t j = 0; j < n; ++j) {
    error[j] = whole[j] - constant - amplitude * std::cos(2.0 * pi * cycles * (static_cast<double>(j) + 0.5) + 0.3);
    r.total += error[j];
  }
  for (std::size_t j = 0; j < n; ++j) r.variance += error[j] * error[j] / n;
  for (std::size_t j = 1; j < n; ++j) r.correlation += error[j] * error[j - 1] / n / r.variance;
  return r;
}

// Constant input, p the fraction of a pulse in each window: variance p(1 - p), neighbours -min(p, 1-p)/max(p, 1-p).
// 4000 windows hold whole periods of these fractions; ends of the record: 1/4000.
TEST(SineVibration, RoundingOfAConstantInput) {
  double mean = 0.0;
  for (int k = 1; k < 20; ++k) {
    const double p = k / 20.0;
    const auto r = rounding_of(100.0 + p, 0.0, 0.0, 0.3);
    EXPECT_NEAR(r.variance, p * (1.0 - p), 1e-3) << p;
    EXPECT_NEAR(r.correlation, -std::min(p, 1.0 - p) / std::max(p, 1.0 - p), 2e-3) << p;
    EXPECT_LE(std::abs(r.total), 1.0 + 1e-9);
    mean += r.variance / 20.0;
  }
  EXPECT_NEAR(mean, 1.0 / 6.0, 1e-3);  // the trapezoidal rule of p(1-p) over 20 parts: 1/6 - 1/2400
  EXPECT_NEAR(rounding_of(100.0, 0.0, 0.0, 0.3).variance, 0.0, 1e-12);  // no spread at all
}

// A sine on the 10 Hz raster repeats every 20 windows or fewer: the variance is anything from well below 1/6 pulse^2 to
// well above. The total stays within a pulse.
TEST(SineVibration, RoundingOfASineOnTheRaster) {
  double least = 1.0, most = 0.0;
  const RandomStream random(9);
  for (std::uint64_t k = 0; k < 300; ++k) {
    const double constant = 60.0 + std::floor(20.0 * random.uniform(4 * k)) / 20.0;
    const double amplitude = 100.0 + 50.0 * random.uniform(4 * k + 1);
    const double cycles = 0.05 * std::ceil(9.0 * random.uniform(4 * k + 2));
    const auto r = rounding_of(constant, amplitude, cycles, random.uniform(4 * k + 3));
    least = std::min(least, r.variance);
    most = std::max(most, r.variance);
    EXPECT_LE(std::abs(r.total), 1.0 + 1e-6);
  }
  EXPECT_LT(least, 0.1);
  EXPECT_GT(most, 0.28);
  EXPECT_LT(most, 1.0);  // no window is off by more than a pulse
}

// The method on short noise-free tests.

struct Tone {
  double frequency, amplitude;
};

struct Shaken {
  std::vector<Tone> tones{{10.0, 3.0}, {40.0, 3.0}, {130.0, 3.0}};
  double scale = 20000.0;  ///< [pulse/s/g]
  bool rests = true;
  double rest = 4.0, duration = 6.5;
  std::function<void(Plan&)> change = {};
};

Evidence shaken(const Shaken& how) {
  Plan plan = methods::trial_plan("sine_vibration", method().options(), "pendulous_accelerometer", "shaker", 200.0);
  plan.rig.set_flag("ideal", true);
  plan.truth.set_word("output", "count");
  methods::set_truth(plan, "pulse_scale_factor", how.scale, "pulse/s/g");
  methods::set_truth(plan, "second_order_coefficient", 20.0, "ug/g^2");
  plan.truth.set_integer("oversampling", 64);
  plan.settings.set_word("scale_factor", fmt::format("{} pulse/s/g", how.scale));
  int n = 0;
  const auto rest = [&] {
    if (how.rests) plan.schedule.push_back({fmt::format("rest {}", n++), how.rest, 1, {}});
  };
  for (const Tone& tone : how.tones) {
    rest();
    Segment segment{fmt::format("tone {}", n), how.duration, 1, {}};
    if (!how.rests) segment.label = fmt::format("tone {}", ++n);
    segment.axes["shake"] = {
        .kind = Motion::Kind::sine, .amplitude = si(tone.amplitude, "g"), .frequency = tone.frequency};
    plan.schedule.push_back(std::move(segment));
  }
  rest();
  if (how.change) how.change(plan);
  Recording recording = simulate(plan, 5, {});
  return {std::move(plan), {std::move(recording)}};
}

Channel& counts(Evidence& evidence) {
  for (auto& channel : evidence.recordings[0].channels)
    if (channel.name == "accelerometer") return channel;
  throw std::runtime_error("no accelerometer");
}

double cell(const Estimate& estimate, std::size_t row, const char* column) {
  const Table* table = find_table(estimate, "response");
  for (std::size_t c = 0; c < table->columns.size(); ++c)
    if (table->columns[c].name == column) return std::get<double>(table->rows.at(row)[c]);
  return std::nan("");
}

// 3 g: 4.5 g^2; K_2 = 20 ug/g^2 gives 90 ug. Tones are rounded to 1/20000 g s over 6 s: 0.41 pulse/T = 3.4 ug (1
// sigma), twice with the rests, over three tones.
TEST(SineVibration, RectificationOfThreeG) {
  const Estimate e = method().identify(shaken({}), {});
  EXPECT_NEAR(value(e, "vibration_rectification"), si(20.0, "ug/g^2"), si(4.0 * 5.0 / 4.5 / std::sqrt(3.0), "ug/g^2"));
  double mean = 0.0;
  for (std::size_t k = 0; k < 3; ++k) mean += cell(e, k, "mean_shift") / 3.0;
  EXPECT_NEAR(mean, si(90.0, "ug"), si(4.0 * 5.0 / std::sqrt(3.0), "ug"));
  EXPECT_NEAR(cell(e, 0, "sd"), si(2.113, "g"), si(0.003, "g"));
  EXPECT_NEAR(cell(e, 2, "sd"), si(0.926, "g"), si(0.003, "g"));
  EXPECT_NEAR(cell(e, 2, "aliased_to"), 70.0, 1e-4);
}

// G = w_n^2/(s^2 + 2 zeta w_n s + w_n^2) with 300 Hz and 0.7: 1.4 % down at 130 Hz. The simulated window is the mean of
// 64 points: (pi f H/64)^2/6 = 1.7e-4 high. Rounding to 1/20000 g s over 1300 windows: below 2e-4.
TEST(SineVibration, RollOffOfTheServo) {
  const auto e = method().identify(shaken({.change =
                                               [](Plan& plan) {
                                                 methods::set_truth(plan, "natural_frequency", 300.0, "Hz");
                                                 methods::set_truth(plan, "damping_ratio", 0.7, "1");
                                               }}),
                                   {});
  EXPECT_NEAR(value(e, "gain_130Hz"), 1.0 - 0.0136, 1e-3);
  EXPECT_NEAR(value(e, "gain_10Hz"), 1.0, 1e-3);
}

TEST(SineVibration, SeveralLevelsTellTheFourthPower) {
  const auto e =
      method().identify(shaken({.tones = {{40.0, 1.0}, {40.0, 2.0}, {40.0, 4.0}, {40.0, 6.0}}, .duration = 12.5}), {});
  const auto sd = [&](const char* name) {
    return standard_uncertainty(e, static_cast<std::size_t>(find_parameter(e, name) - e.parameters.data()));
  };
  EXPECT_NEAR(value(e, "vibration_rectification"), si(20.0, "ug/g^2"), 4.0 * sd("vibration_rectification"));
  EXPECT_NEAR(value(e, "vibration_rectification_quartic"), 0.0, 4.0 * sd("vibration_rectification_quartic"));
  EXPECT_NE(find_parameter(e, "gain_40Hz"), nullptr);
}

// The shake has a third harmonic of 1 %, which at a quarter of the rate of the windows falls upon the tone.
TEST(SineVibration, HarmonicsOnTheLineAreInItsUncertainty) {
  EXPECT_EQ(sine::hidden_harmonic(50.0, window, 100.0), 3);
  EXPECT_EQ(sine::hidden_harmonic(200.0 / 3.0, window, 100.0), 2);
  EXPECT_EQ(sine::hidden_harmonic(49.7, window, 100.0), 0);
  const auto real = [](Plan& plan) { plan.rig.set_flag("ideal", false); };
  const auto e = method().identify(shaken({.tones = {{40.0, 3.0}, {50.0, 3.0}}, .change = real}), {});
  EXPECT_TRUE(says(e.findings, "harmonic 3 of 50 Hz shows at the same frequency"));
  const auto sd = [&](const char* name) {
    return standard_uncertainty(e, static_cast<std::size_t>(find_parameter(e, name) - e.parameters.data()));
  };
  EXPECT_NEAR(sd("gain_40Hz"), 0.0051, 0.0002);  // reference 0.5 %, scale factor 0.1 %
  EXPECT_NEAR(sd("gain_50Hz"), 0.0112, 0.0004);  // and 1 %
  EXPECT_NEAR(value(e, "gain_50Hz"), 1.0, 4.0 * sd("gain_50Hz"));
}

// Faults.

TEST(SineVibration, OnHalfOfTheRateItSaysWhatToUse) {
  Evidence evidence = shaken({.tones = {{40.0, 3.0}, {100.0, 3.0}}});
  const auto e = method().identify(evidence, {});
  EXPECT_TRUE(says(e.findings, "half of the 200 windows a second"));
  EXPECT_TRUE(says(e.findings, "99.5 Hz or 100.5 Hz"));  // 3/T of 6 s
  EXPECT_EQ(find_parameter(e, "gain_100Hz"), nullptr);
  EXPECT_NE(find_parameter(e, "gain_40Hz"), nullptr);
  EXPECT_NE(refusal(method(), shaken({.tones = {{200.0, 3.0}}})).find("null of the counting window"),
            std::string::npos);
}

// 10 000 pulse/s/g: 50 a window at rest, 2 g reach -50...150; a register of 8 bits holds -128...127.
TEST(SineVibration, CounterThatRanOverIsPutRight) {
  Evidence evidence = shaken({.tones = {{10.0, 2.0}, {40.0, 2.0}}, .scale = 10000.0});
  const double before = value(method().identify(evidence, {}), "gain_40Hz");
  for (double& v : counts(evidence).values)
    if (v > 127.0) v -= 256.0;
  const auto e = method().identify(evidence, {});
  EXPECT_DOUBLE_EQ(value(e, "gain_40Hz"), before);
  EXPECT_TRUE(says(e.findings, "ran over its 8 bits"));
}

// 3 g reach -100...200, more than the register holds about the mean of 50: which windows ran over cannot be told.
TEST(SineVibration, CounterThatRanOverTooFarIsRefused) {
  Evidence evidence = shaken({.tones = {{10.0, 3.0}}, .scale = 10000.0});
  for (double& v : counts(evidence).values) v -= 256.0 * std::floor((v + 128.0) / 256.0);
  EXPECT_NE(refusal(method(), evidence).find("ran over its 8 bits"), std::string::npos);
}

TEST(SineVibration, MissedWindowsAreLeftOutWithTheirNeighbours) {
  Evidence evidence = shaken({});
  const auto whole = method().identify(evidence, {});
  auto& channel = counts(evidence);
  std::vector<double> stamps, values;
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    if (i >= 1200 && i < 1203) continue;  // in the first tone, 4...10.5 s
    stamps.push_back(channel.time(i));
    values.push_back(channel.values[i] +
                     (i == 1203 ? channel.values[1200] + channel.values[1201] + channel.values[1202] : 0.0));
  }
  channel.values = values;
  channel.timeline = {0.0, 0.0, std::make_shared<const std::vector<double>>(stamps)};
  const auto e = method().identify(evidence, {});
  EXPECT_TRUE(says(e.findings, "3 windows missed in 1 gap"));
  // rounding of the windows left out: some pulses of 1300 windows of 300
  EXPECT_NEAR(value(e, "gain_10Hz"), value(whole, "gain_10Hz"), 3e-5);
  EXPECT_NEAR(cell(e, 0, "mean_shift"), cell(whole, 0, "mean_shift"), si(10.0, "ug"));
}

// Gate times that scatter by 2 % move each count by 2 % of 1 g; divided by their own time they do not.
TEST(SineVibration, UnequalWindowsAreDividedByTheirOwnTime) {
  Evidence evidence = shaken({.scale = 2e6});
  auto& channel = counts(evidence);
  const RandomStream random(3);
  std::vector<double> stamps(channel.values.size());
  for (std::size_t i = 0; i < stamps.size(); ++i) stamps[i] = channel.time(i) + 5e-5 * random.normal(i);
  const std::vector<double> even = channel.values;
  std::vector<double> total{0.0};
  for (const double v : even) total.push_back(total.back() + v);
  for (std::size_t i = 0; i + 1 < stamps.size(); ++i) {
    const auto at = [&](double t) {
      const double x = std::clamp(t * 200.0, 0.0, static_cast<double>(stamps.size()) - 1.0);
      const auto k = static_cast<std::size_t>(x);
      return total[k] + (x - std::floor(x)) * even[k];
    };
    channel.values[i] = std::round(at(stamps[i + 1]) - at(stamps[i]));
  }
  channel.values.pop_back();
  stamps.pop_back();
  channel.timeline = {0.0, 0.0, std::make_shared<const std::vector<double>>(stamps)};
  const auto e = method().identify(evidence, {});
  EXPECT_TRUE(says(e.findings, "the windows are unequal"));
  EXPECT_NEAR(value(e, "gain_10Hz"), 1.0, 2e-3);
}

TEST(SineVibration, UnitThatClipsIsLeftOut) {
  const auto narrow = [](Plan& plan) { plan.settings.set_number("range", si(3.5, "g"), Unit::parse("g")); };
  EXPECT_NE(refusal(method(), shaken({.change = narrow})).find("range of 3.5 g: it clips"), std::string::npos);
  // Not told of the range, the flat tops show.
  const auto clipped = [](Plan& plan) { methods::set_truth(plan, "range", 3.0, "g"); };
  const auto e = method().identify(shaken({.change = clipped}), {});
  EXPECT_TRUE(says(e.findings, "the unit is clipped"));
  EXPECT_EQ(find_parameter(e, "gain_10Hz"), nullptr);
}

TEST(SineVibration, UnitThatIsDeadIsNamed) {
  Evidence evidence = shaken({});
  Channel dead = counts(evidence);
  dead.name = "S2.accelerometer";
  std::fill(dead.values.begin() + 1000, dead.values.end(), 100.0);
  evidence.recordings[0].channels.push_back(dead);
  const auto e = method().identify(evidence, {});
  EXPECT_TRUE(says(e.findings, "gives the same value throughout"));
  EXPECT_NE(find_parameter(e, "accelerometer.gain_40Hz"), nullptr);
  EXPECT_EQ(find_parameter(e, "S2.gain_40Hz"), nullptr);
}

TEST(SineVibration, ShakerThatWasNotOnOrAtAnotherFrequency) {
  Evidence evidence = shaken({});
  for (auto& segment : evidence.plan.schedule)
    if (segment.label == "tone 2") segment.axes["shake"].frequency = 55.0;
  const auto other = method().identify(evidence, {});
  EXPECT_TRUE(says(other.findings, "the plan says 55 Hz, the unit is shaken at 40 Hz"));
  for (double& v : counts(evidence).values) v = 100.0 + std::fmod(v, 2.0);
  EXPECT_NE(refusal(method(), evidence).find("the shaker was not on"), std::string::npos);
}

TEST(SineVibration, WithoutRestNoShiftButGains) {
  const auto e = method().identify(shaken({.rests = false}), {});
  EXPECT_TRUE(says(e.findings, "record the unit at rest before and after"));
  EXPECT_EQ(find_parameter(e, "vibration_rectification"), nullptr);
  EXPECT_NE(find_parameter(e, "gain_40Hz"), nullptr);
}

// A file for each segment, each with a clock of its own, is the same power-up.
TEST(SineVibration, FilesOfOnePowerUpBelongTogether) {
  Evidence evidence = shaken({});
  const auto whole = method().identify(evidence, {});
  const Recording all = evidence.recordings[0];
  evidence.recordings.clear();
  for (std::size_t k = 0; k < all.marks.size(); ++k) {
    Recording part;
    const double begin = all.marks[k].begin, end = k + 1 < all.marks.size() ? all.marks[k + 1].begin : 1e9;
    for (const Channel& channel : all.channels) {
      Channel cut = channel;
      cut.values.clear();
      for (std::size_t i = 0; i < channel.values.size(); ++i)
        if (channel.time(i) >= begin - 1e-6 && channel.time(i) < end - 1e-6) cut.values.push_back(channel.values[i]);
      part.channels.push_back(std::move(cut));
    }
    part.marks = {{all.marks[k].label, 0.0, 1}};
    evidence.recordings.push_back(std::move(part));
  }
  const auto parts = method().identify(evidence, {});
  EXPECT_NEAR(value(parts, "vibration_rectification") / value(whole, "vibration_rectification"), 1.0, 1e-6);
}

TEST(SineVibration, RestThatMovesIsNone) {
  Evidence evidence = shaken({});
  for (auto& segment : evidence.plan.schedule)
    if (segment.label == "tone 2") segment.axes.clear();
  const auto e = method().identify(evidence, {});
  EXPECT_TRUE(says(e.findings, "not at rest, as planned"));
  EXPECT_NEAR(value(e, "vibration_rectification"), si(20.0, "ug/g^2"), si(5.0, "ug/g^2"));
}

TEST(SineVibration, ScaleFactorFromRest) {
  const auto forget = [](Plan& plan) {
    plan.settings.set_word("scale_factor", "");
    methods::set_truth(plan, "bias", 2.0, "mg");
  };
  const auto e = method().identify(shaken({.change = forget}), {});
  EXPECT_TRUE(says(e.findings, "scale factor from the segments at rest"));
  const auto k = static_cast<std::size_t>(find_parameter(e, "gain_40Hz") - e.parameters.data());
  EXPECT_NEAR(value(e, "gain_40Hz"), 1.0 / 1.002, 1e-3);  // the bias is taken for scale
  EXPECT_GT(standard_uncertainty(e, k), 0.005);
  EXPECT_NE(refusal(method(), shaken({.rests = false, .change = forget})).find("its scale factor is not known"),
            std::string::npos);
}

TEST(SineVibration, UnitsAreCompared) {
  Evidence evidence = shaken({.scale = 2e6});
  Channel other = counts(evidence);
  other.name = "S2.accelerometer";
  double total = 0.0, given = 0.0;
  for (double& v : other.values) {  // one in a hundred more, in whole pulses
    total += 1.01 * v;
    v = std::floor(total) - given;
    given = std::floor(total);
  }
  evidence.recordings[0].channels.push_back(other);
  const auto e = method().identify(evidence, {});
  EXPECT_NEAR(value(e, "S2.gain_ratio"), 1.01, 1e-4);
  EXPECT_NEAR(value(e, "gain_spread"), std::log(1.01) / std::sqrt(2.0), 1e-4);
  const auto k = static_cast<std::size_t>(find_parameter(e, "S2.gain_ratio") - e.parameters.data());
  // the reference is common to both: what is left are two scale factors known to 0.1 %
  EXPECT_NEAR(standard_uncertainty(e, k), 1.01 * std::sqrt(2.0) * 1e-3, 1e-4);
}

}  // namespace
}  // namespace tumble
