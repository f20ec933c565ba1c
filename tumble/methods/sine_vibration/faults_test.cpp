#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

#include "tumble/math/random.hpp"
#include "tumble/methods/sine_vibration/testing/shaken.hpp"

namespace tumble {
namespace {

using namespace testing;

TEST(SineVibrationFaults, OnHalfOfTheRateItSaysWhatToUse) {
  Evidence evidence = shaken({.tones = {{40.0, 3.0}, {100.0, 3.0}}});
  const auto e = sine_method().identify(evidence, {});
  EXPECT_NEAR(value_of(e.findings, "tone_on_half_rate", "rate"), 200.0, 1e-6);
  EXPECT_NEAR(value_of(e.findings, "tone_on_half_rate", "lower"), 99.5, 1e-6);  // 3/T of 6 s
  EXPECT_NEAR(value_of(e.findings, "tone_on_half_rate", "upper"), 100.5, 1e-6);
  EXPECT_EQ(find_parameter(e, "gain_100Hz"), nullptr);
  EXPECT_NE(find_parameter(e, "gain_40Hz"), nullptr);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, asked_finding("tone_on_null", {"200 Hz"}),
                      refusal(sine_method(), shaken({.tones = {{200.0, 3.0}}}))));
}

// 10 000 pulse/s/g: 50 a window at rest, 2 g reach -50...150; a register of 8 bits holds -128...127.
TEST(SineVibrationFaults, CounterThatOverflowedIsCorrected) {
  Evidence evidence = shaken({.tones = {{10.0, 2.0}, {40.0, 2.0}}, .scale = 10000.0});
  const double before = value(sine_method().identify(evidence, {}), "gain_40Hz");
  for (double& v : counts(evidence).values)
    if (v > 127.0) v -= 256.0;
  const auto e = sine_method().identify(evidence, {});
  EXPECT_DOUBLE_EQ(value(e, "gain_40Hz"), before);
  EXPECT_EQ(value_of(e.findings, "counter_overflow_corrected", "bits"), 8.0);
}

// 3 g reach -100...200, more than the register holds about the mean of 50: the windows that overflowed are not known.
TEST(SineVibrationFaults, CounterThatOverflowedTooFarIsRefused) {
  Evidence evidence = shaken({.tones = {{10.0, 3.0}}, .scale = 10000.0});
  for (double& v : counts(evidence).values) v -= 256.0 * std::floor((v + 128.0) / 256.0);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"8"}, .pattern = "the counter passed the end"},
                      refusal(sine_method(), evidence)));
}

// A fixture that is turned over rests at +50 and at -50: each way has an expected count of its own.
TEST(SineVibrationFaults, CounterOfAUnitTurnedOverThatOverflowedIsRefused) {
  Evidence evidence = trial_of(sine_method(), 1).evidence;
  for (double& v : counts(evidence).values) v -= 512.0 * std::floor((v + 256.0) / 512.0);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"9"}, .pattern = "the counter passed the end"},
                      refusal(sine_method(), evidence)));
}

TEST(SineVibrationFaults, MissingWindowsAreSkippedWithTheirNeighbours) {
  Evidence evidence = shaken({});
  const auto whole = sine_method().identify(evidence, {});
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
  const auto e = sine_method().identify(evidence, {});
  EXPECT_EQ(value_of(e.findings, "windows_missing", "windows"), 3.0);
  EXPECT_EQ(value_of(e.findings, "windows_missing", "gaps"), 1.0);
  // rounding of the windows that were skipped: some pulses of 1300 windows of 300
  EXPECT_NEAR(value(e, "gain_10Hz"), value(whole, "gain_10Hz"), 3e-5);
  EXPECT_NEAR(cell(e, 0, "mean_shift"), cell(whole, 0, "mean_shift"), si(10.0, "ug"));
}

// Gate times that scatter by 2 % move each count by 2 % of 1 g; divided by their own time they do not.
TEST(SineVibrationFaults, UnequalWindowsAreDividedByTheirOwnTime) {
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
  const auto e = sine_method().identify(evidence, {});
  EXPECT_NE(finding_of(e.findings, "windows_of_unequal_length"), nullptr);
  EXPECT_NEAR(value(e, "gain_10Hz"), 1.0, 2e-3);
}

TEST(SineVibrationFaults, UnitThatClipsIsSkipped) {
  const auto narrow = [](Plan& plan) { plan.settings.set_number("range", si(3.5, "g"), Unit::parse("g")); };
  EXPECT_TRUE(refuses(Error::Kind::bad_data, asked_finding("tone_beyond_range", {"3.5 g"}),
                      refusal(sine_method(), shaken({.change = narrow}))));
  // If the range is not given, the flat tops show.
  const auto clipped = [](Plan& plan) { set_truth(plan, "range", 3.0, "g"); };
  const auto e = sine_method().identify(shaken({.change = clipped}), {});
  EXPECT_GT(value_of(e.findings, "tone_clipped", "harmonics"), 0.01);
  EXPECT_EQ(find_parameter(e, "gain_10Hz"), nullptr);
}

TEST(SineVibrationFaults, UnitThatIsDeadIsNamed) {
  Evidence evidence = shaken({});
  Channel dead = counts(evidence);
  dead.name = "S2.accelerometer";
  std::fill(dead.values.begin() + 1000, dead.values.end(), 100.0);
  evidence.recordings[0].channels.push_back(dead);
  const auto e = sine_method().identify(evidence, {});
  ASSERT_NE(finding_of(e.findings, "unit_dead"), nullptr);
  EXPECT_TRUE(finding_of(e.findings, "unit_dead")->where.starts_with("S2, "));
  EXPECT_NE(find_parameter(e, "accelerometer.gain_40Hz"), nullptr);
  EXPECT_EQ(find_parameter(e, "S2.gain_40Hz"), nullptr);
}

TEST(SineVibrationFaults, ShakerThatWasNotOnOrAtAnotherFrequency) {
  Evidence evidence = shaken({});
  for (auto& segment : evidence.plan.schedule)
    if (segment.label == "tone 2") segment.axes["shake"].frequency = 55.0;
  const auto other = sine_method().identify(evidence, {});
  EXPECT_EQ(value_of(other.findings, "frequency_differs_from_plan", "planned"), 55.0);
  EXPECT_NEAR(value_of(other.findings, "frequency_differs_from_plan", "measured"), 40.0, 1e-3);
}

/// Changes the counts of each tone of `evidence` about their mean, by the part of the segment that has passed.
void along_tones(Evidence& evidence, const std::function<double(double)>& of_unit, double drift = 0.0) {
  auto& values = counts(evidence).values;
  for (const double begin : {4.0, 14.5, 25.0}) {
    const auto first = static_cast<std::size_t>(begin * 200.0), n = static_cast<std::size_t>(6.5 * 200.0);
    for (std::size_t i = 0; i < n; ++i) {
      const double part = static_cast<double>(i) / static_cast<double>(n);
      double& v = values[first + i];
      v = std::round(100.0 + of_unit(part) * (v - 100.0) + drift * part);
    }
  }
}

TEST(SineVibrationFaults, TonesThatAreNotSteadyAreNamed) {
  const auto sound = sine_method().identify(shaken({}), {});
  for (const char* code :
       {"vibration_not_steady", "vibration_not_throughout", "gain_changes_in_tone", "mean_drifts_in_tone"})
    EXPECT_EQ(finding_of(sound.findings, code), nullptr) << code;
  Evidence evidence = shaken({});
  along_tones(evidence, [](double part) { return 1.0 + 0.2 * part; });
  EXPECT_NEAR(value_of(sine_method().identify(evidence, {}).findings, "gain_changes_in_tone", "change"), 0.19, 0.03);
  std::erase_if(evidence.recordings[0].channels, [](const Channel& channel) { return channel.name == "reference"; });
  EXPECT_NEAR(value_of(sine_method().identify(evidence, {}).findings, "vibration_not_steady", "change"), 0.19, 0.03);
  evidence = shaken({});
  along_tones(
      evidence, [](double) { return 1.0; }, 3.0);
  EXPECT_NE(finding_of(sine_method().identify(evidence, {}).findings, "mean_drifts_in_tone"), nullptr);
  // A shaker that comes up late: the time in which it runs is used, and the gains are those of before.
  evidence = shaken({});
  along_tones(evidence, [](double part) { return part < 0.3 ? 0.0 : 1.0; });
  const auto late = sine_method().identify(evidence, {});
  EXPECT_NE(finding_of(late.findings, "vibration_not_throughout"), nullptr);
  EXPECT_NEAR(value(late, "gain_40Hz"), value(sound, "gain_40Hz"), 2e-3);
}

// Counts of a constant: 0.13 of a pulse a window beats with the windows at 26 Hz, 0.2 at 40 Hz as if it were a tone.
TEST(SineVibrationFaults, RoundingIsNoTone) {
  for (const double pulses : {99.87, 100.2}) {
    Evidence evidence = shaken({});
    double total = 0.0;
    for (double& v : counts(evidence).values) {
      const double before = std::floor(total + 1e-6);
      total += pulses;
      v = std::floor(total + 1e-6) - before;
    }
    EXPECT_TRUE(refuses(Error::Kind::bad_data, asked_finding("tone_below_noise"), refusal(sine_method(), evidence)))
        << pulses;
  }
}

// A unit whose loop passes 1 % of the level: 1 % is far above its noise. Truth: 1 over 1 + i 100 in the limit of
// damping alone, f_n = 4 Hz, zeta = 0.5 at 40 Hz: 1/sqrt(99^2 + 10^2) = 0.01005; rounding hides 2e-4 of 3 g.
TEST(SineVibrationFaults, ToneOfOnePerCentIsMeasured) {
  const auto weak = [](Plan& plan) {
    set_truth(plan, "natural_frequency", 4.0, "Hz");
    set_truth(plan, "damping_ratio", 0.5, "1");
  };
  const auto e = sine_method().identify(shaken({.tones = {{40.0, 3.0}}, .change = weak}), {});
  EXPECT_NEAR(value(e, "gain_40Hz"), 1.0 / std::hypot(99.0, 10.0), 4e-4);
  EXPECT_NE(finding_of(e.findings, "improbable_gain"), nullptr);
}

// 5 pulses lost in one of 80 windows, everywhere: the mean would be 0.6 mg off, seven times K_2 A^2/2. In the tone and
// at rest the windows are skipped, and one finding says so. Rounding of 3 s to 6 s: 0.6 pulse/T, 8 ug.
TEST(SineVibrationFaults, LostPulsesAreSkippedAndSaid) {
  Evidence evidence = shaken({});
  const double before = value(sine_method().identify(evidence, {}), "vibration_rectification");
  auto& values = counts(evidence).values;
  RandomStream random(77);
  std::size_t lost = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (random.uniform(i) < 0.0125) values[i] -= 5.0, ++lost;
  const auto e = sine_method().identify(evidence, {});
  EXPECT_NEAR(value(e, "vibration_rectification"), before, si(10.0, "ug/g^2"));
  const Finding* finding = finding_of(e.findings, "windows_off_by_pulses");
  ASSERT_NE(finding, nullptr);
  EXPECT_GT(finding->occurrences.count, lost * 7 / 10);  // what settling skips is not looked at
  EXPECT_LE(finding->occurrences.count, lost);
  EXPECT_EQ(std::ranges::count(e.findings, "windows_off_by_pulses", &Finding::code), 1);
}

// The scale factor of the settings is 5 % off: rest and gain show it alike. A bias of 50 mg shows at rest alone.
TEST(SineVibrationFaults, RestsContradictTheScaleFactor) {
  Evidence evidence = shaken({});
  evidence.plan.settings.set_word("scale_factor", "21000 pulse/s/g");
  const auto e = sine_method().identify(evidence, {});
  EXPECT_NEAR(value_of(e.findings, "scale_factor_differs_at_rest", "difference"), 1.0 / 1.05 - 1.0, 1e-3);
  const Finding* finding = finding_of(e.findings, "scale_factor_differs_at_rest");
  EXPECT_EQ(finding->severity, Finding::Severity::error);
  const auto names = std::ranges::find(finding->values, "parameters", &FindingValue::name);
  EXPECT_NE(std::get<std::string>(names->value).find("gain_40Hz"), std::string::npos);
  const auto biased = [](Plan& plan) { set_truth(plan, "bias", 50.0, "mg"); };
  const auto bias = sine_method().identify(shaken({.change = biased}), {});
  EXPECT_EQ(finding_of(bias.findings, "scale_factor_differs_at_rest"), nullptr);
  EXPECT_EQ(finding_of(bias.findings, "bias_beyond_stated")->severity, Finding::Severity::info);
  evidence = shaken({});
  for (double& v : counts(evidence).values) v = -v;
  EXPECT_EQ(finding_of(sine_method().identify(evidence, {}).findings, "rest_inverted")->severity,
            Finding::Severity::error);
  const auto sound = sine_method().identify(shaken({}), {});
  for (const char* code : {"scale_factor_differs_at_rest", "rest_differs_from_plan", "bias_beyond_stated"})
    EXPECT_EQ(finding_of(sound.findings, code), nullptr) << code;
}

TEST(SineVibrationFaults, WithoutRestNoShiftButGains) {
  const auto e = sine_method().identify(shaken({.rests = false}), {});
  EXPECT_NE(finding_of(e.findings, "tone_without_rest"), nullptr);
  EXPECT_EQ(find_parameter(e, "vibration_rectification"), nullptr);
  EXPECT_NE(find_parameter(e, "gain_40Hz"), nullptr);
}

TEST(SineVibrationFaults, RestThatMovesIsNone) {
  Evidence evidence = shaken({});
  for (auto& segment : evidence.plan.schedule)
    if (segment.label == "tone 2") segment.axes.clear();
  const auto e = sine_method().identify(evidence, {});
  EXPECT_GT(value_of(e.findings, "moves_at_rest", "ratio"), 20.0);
  EXPECT_NEAR(value(e, "vibration_rectification"), si(20.0, "ug/g^2"), si(5.0, "ug/g^2"));
}

}  // namespace
}  // namespace tumble
