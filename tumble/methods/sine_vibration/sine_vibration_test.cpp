#include <gtest/gtest.h>

#include <cmath>

#include "tumble/methods/sine_vibration/measure.hpp"
#include "tumble/methods/sine_vibration/testing/shaken.hpp"

namespace tumble::sine_vibration_test {
namespace {

using namespace testing;

const Method& method() { return sine_method(); }

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
                                                 set_truth(plan, "natural_frequency", 300.0, "Hz");
                                                 set_truth(plan, "damping_ratio", 0.7, "1");
                                               }}),
                                   {});
  EXPECT_NEAR(value(e, "gain_130Hz"), 1.0 - 0.0136, 1e-3);
  EXPECT_NEAR(value(e, "gain_10Hz"), 1.0, 1e-3);
}

TEST(SineVibration, SeveralLevelsShowTheFourthPower) {
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
  constexpr double window = 5e-3;
  EXPECT_EQ(sine_vibration::hidden_harmonic(50.0, window, 100.0), 3);
  EXPECT_EQ(sine_vibration::hidden_harmonic(200.0 / 3.0, window, 100.0), 2);
  EXPECT_EQ(sine_vibration::hidden_harmonic(49.7, window, 100.0), 0);
  const auto real = [](Plan& plan) { plan.rig.set_flag("ideal", false); };
  const auto e = method().identify(shaken({.tones = {{40.0, 3.0}, {50.0, 3.0}}, .change = real}), {});
  EXPECT_EQ(value_of(e.findings, "harmonic_on_tone", "harmonic"), 3.0);
  EXPECT_NEAR(value_of(e.findings, "harmonic_on_tone", "frequency"), 50.0, 1e-3);
  const auto sd = [&](const char* name) {
    return standard_uncertainty(e, static_cast<std::size_t>(find_parameter(e, name) - e.parameters.data()));
  };
  EXPECT_NEAR(sd("gain_40Hz"), 0.0051, 0.0002);  // reference 0.5 %, scale factor 0.1 %
  // And of 1 % all in the reference and sinc(3/4)/sinc(1/4) = 1/3 in the windows, uncertain by 30 %.
  EXPECT_NEAR(sd("gain_50Hz"), std::hypot(0.0051, 0.01 * 2.0 / 3.0, 0.01 * 0.1), 0.0004);
  EXPECT_NEAR(value(e, "gain_50Hz"), 1.0, 4.0 * sd("gain_50Hz"));
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

TEST(SineVibration, ScaleFactorFromRest) {
  const auto forget = [](Plan& plan) {
    plan.settings.set_word("scale_factor", "");
    set_truth(plan, "bias", 2.0, "mg");
  };
  const auto e = method().identify(shaken({.change = forget}), {});
  EXPECT_NE(finding_of(e.findings, "scale_factor_from_rest"), nullptr);
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
}  // namespace tumble::sine_vibration_test
