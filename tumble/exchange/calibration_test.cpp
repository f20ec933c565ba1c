// A calibration gives what the compensation of its method gives, and its terms can be removed one by one.
#include "tumble/exchange/calibration.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/exchange/testing/random_calibration.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/reduce/compensate.hpp"
#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using testing::Parts;
using testing::random_calibration;
using testing::random_truth;

struct Conducted {
  Estimate estimate;
  Recording recording;
  Settings settings;
};

/// The method's own trial, identified.
Conducted conducted(const std::string& name) {
  const Method& method = find_method(name);
  Trial trial = trial_of(method, 1);
  Conducted out{method.identify(trial.evidence, {}), trial.evidence.recordings.front(), trial.evidence.plan.settings};
  out.estimate.method = name;
  out.estimate.provenance.settings = trial.evidence.plan.settings.texts();
  for (const auto& [role, choices] : trial.evidence.plan.channels)
    if (!choices.empty()) out.estimate.provenance.settings["channels." + role] = choices.front().channel;
  return out;
}

ImuCalibration calibration_from(const Estimate& estimate, const std::string& axis = "") {
  return calibration_of({{estimate, "result.json", "0123", axis}});
}

Refused refusal(const std::vector<CalibrationInput>& inputs) {
  return refusal_of([&] { calibration_of(inputs); });
}

/// The six outputs of a recording, and where they are.
struct SixChannels {
  SixChannels(const Recording& recording, const Settings& settings) : recording(recording), settings(settings) {
    for (const char* letter : {"x", "y", "z"}) {
      force.push_back(find_channel(recording, std::string("accelerometer_") + letter));
      rate.push_back(find_channel(recording, std::string("gyro_") + letter));
    }
  }
  /// Increments are rates times the step, and counts are divided by their nominal scale factor where there is one.
  double scale(const Channel& c) const {
    const auto kind = c.name.starts_with("gyro") ? imu::Kind::gyro : imu::Kind::accelerometer;
    const std::string nominal = std::string(imu::prefix_of(kind)) + "scale_factor";
    const bool counts = c.kind == QuantityKind::count || c.kind == QuantityKind::other;
    if (counts && !(settings.texts().contains(nominal) && settings.has(nominal))) return 1.0;
    return imu::reading_of(kind, settings, c).scale;
  }
  Vector3 of(const std::vector<const Channel*>& channels, std::size_t k) const {
    Vector3 v;
    for (std::size_t i = 0; i < 3; ++i)
      if (channels[i]) v[i] = channels[i]->values[k] * scale(*channels[i]);
    return v;
  }
  const Recording& recording;
  const Settings& settings;
  std::vector<const Channel*> force, rate;
};

/// Central differences of the compensated rates, as the compensation takes them.
Vector3 acceleration_at(const SixChannels& compensated, std::size_t k) {
  const Channel* clock = compensated.rate[0];
  const Vector3 change = compensated.of(compensated.rate, k + 1) - compensated.of(compensated.rate, k - 1);
  return change / (clock->time(k + 1) - clock->time(k - 1));
}

class ImuMethods : public ::testing::TestWithParam<const char*> {};

TEST_P(ImuMethods, CalibrationGivesWhatCompensateGives) {
  const Conducted test = conducted(GetParam());
  const Compensation by_method = compensate(test.estimate, test.recording, nullptr);
  const ImuCalibration calibration = calibration_from(test.estimate);
  const SixChannels raw(test.recording, test.settings), done(by_method.recording, test.settings);
  const std::size_t n = raw.force[0]->values.size();
  std::size_t compared = 0;
  const std::size_t step = std::max<std::size_t>(1, n / 300);
  for (std::size_t k = 1; k + 1 < n; k += step) {
    ImuSample sample{raw.of(raw.force, k), {}, 293.15, {}};
    const Vector3 force = done.of(done.force, k);
    const bool gyros = raw.rate[0] != nullptr && calibration.gyros.calibrated;
    if (gyros) {
      sample.rate = raw.of(raw.rate, k);
      sample.angular_acceleration = acceleration_at(done, k);
    }
    if (!is_finite(force) || !is_finite(sample.rate) || !is_finite(sample.angular_acceleration)) continue;
    const ImuSample found = compensated(calibration, sample);
    // compensate solves to 1e-10 of the size of an output, in four passes of three digits each
    EXPECT_LT(norm(found.force - force), 2e-11 * 10.0) << "sample " << k;
    if (gyros) {
      EXPECT_LT(norm(found.rate - done.of(done.rate, k)), 2e-11) << "sample " << k;
    }
    ++compared;
  }
  EXPECT_GT(compared, 20u);
}

INSTANTIATE_TEST_SUITE_P(All, ImuMethods,
                         ::testing::Values("imu_turntable", "imu_ferraris", "imu_multi_position",
                                           "imu_channel_calibration"));

TEST(CalibrationOf, AccelerometerTumbleGivesWhatCompensateGives) {
  const Conducted test = conducted("accelerometer_tumble");
  const auto done = compensate(test.estimate, test.recording, nullptr).recording;
  const ImuCalibration calibration = calibration_from(test.estimate, "accelerometer_y");
  const Channel &raw = *find_channel(test.recording, "accelerometer"), &u = *find_channel(done, "accelerometer");
  const double each_second = raw.kind == QuantityKind::count ? sampling_rate(raw) : 1.0;
  for (std::size_t k = 0; k < raw.values.size(); k += 101) {
    if (std::isnan(u.values[k])) continue;
    const ImuSample found = compensated(calibration, {{0.0, raw.values[k] * each_second, 0.0}, {}, 293.15, {}});
    EXPECT_NEAR(found.force.y, u.values[k], 1e-10);
  }
  EXPECT_EQ(calibration.notes.size(), 1u);  // the terms across the input axis
}

TEST(CalibrationOf, FourPositionsOverTemperatureGiveWhatCompensateGives) {
  Conducted test = conducted("accelerometer_four_position");
  const auto done = compensate(test.estimate, test.recording, nullptr).recording;
  const ImuCalibration calibration = calibration_from(test.estimate);
  ASSERT_FALSE(calibration.accelerometers.thermal[0].scale.empty());
  const Channel &raw = *find_channel(test.recording, "accelerometer"), &u = *find_channel(done, "accelerometer"),
                &temperature = *find_channel(test.recording, "temperature");
  const std::string nominal = test.estimate.provenance.settings.at("scale_factor");
  const double scale = nominal.empty() ? 1.0 : sampling_rate(raw) / parse_si(nominal, Unit::parse("pulse/s/g"));
  for (std::size_t k = 0; k < raw.values.size(); k += 101) {
    const std::size_t at = index_at(temperature, raw.time(k));
    if (at >= temperature.values.size() || temperature.time(at) > raw.time(k) || std::isnan(u.values[k])) continue;
    const ImuSample found =
        compensated(calibration, {{raw.values[k] * scale, 0.0, 0.0}, {}, temperature.values[at], {}});
    EXPECT_NEAR(found.force.x, u.values[k], 1e-11);
  }
}

TEST(CalibrationOf, GyroScaleFactorGivesWhatCompensateGives) {
  const Conducted test = conducted("gyro_scale_factor");
  const auto done = compensate(test.estimate, test.recording, nullptr).recording;
  const ImuCalibration calibration = calibration_from(test.estimate, "gyro_z");
  const Channel &raw = *find_channel(test.recording, "gyro"), &u = *find_channel(done, "gyro");
  const bool summed = raw.kind == QuantityKind::count || raw.kind == QuantityKind::angle;
  const double each_second = summed ? sampling_rate(raw) : 1.0;
  for (std::size_t k = 0; k < raw.values.size(); k += 101) {
    if (std::isnan(u.values[k])) continue;
    const ImuSample found = compensated(calibration, {{}, {0.0, 0.0, raw.values[k] * each_second}, 293.15, {}});
    EXPECT_NEAR(found.rate.z, u.values[k], 1e-11);
  }
  EXPECT_FALSE(calibration.gyros.axes[0]);
  EXPECT_EQ(calibration.gyros.response(0, 0) > 100.0, summed);  // counts of an axis that was not tested
  EXPECT_TRUE(calibration.gyros.axes[2]);
}

/// The means at each rate that the method's table states give the rates back, whatever shape their departures have.
TEST(CalibrationOf, MeasuredDeparturesOfAScaleFactorAreSubtracted) {
  const Conducted test = conducted("gyro_scale_factor");
  ImuCalibration calibration = calibration_from(test.estimate, "gyro_z");
  const double by_terms = calibration.gyros.response(2, 2);
  ASSERT_TRUE(take_measured(calibration.gyros));
  EXPECT_NEAR(calibration.gyros.response(2, 2), by_terms, 1e-3 * by_terms);
  const MeasuredDepartures& measured = *test.estimate.models.at(0).measured;
  ASSERT_GE(measured.input.size(), 3u);
  for (std::size_t r = 0; r < measured.input.size(); ++r) {
    const double rate = measured.input[r];
    const double mean = measured.slope * rate + measured.offset + measured.departure[r];
    EXPECT_NEAR(compensated(calibration, {{}, {0.0, 0.0, mean}, 293.15, {}}).rate.z, rate, 1e-13);
  }
  ImuCalibration dropped = calibration_from(test.estimate, "gyro_z");
  find_calibration_term("gyro_nonlinearity").remove(dropped);
  EXPECT_FALSE(take_measured(dropped.gyros)) << "what was dropped does not return as a table";
}

TEST(DepartureTable, IsStraightBetweenItsInputsAndConstantBeyond) {
  const DepartureTable table{{-2.0, 0.0, 1.0}, {0.5, 0.1, 0.3}};
  for (const auto& [u, wanted] :
       {std::pair{-9.0, 0.5}, {-2.0, 0.5}, {-1.0, 0.3}, {0.0, 0.1}, {0.5, 0.2}, {1.0, 0.3}, {9.0, 0.3}})
    EXPECT_NEAR(table(u), wanted, 1e-15) << u;
  EXPECT_NEAR(table.steepest(), 0.2, 1e-15);
  EXPECT_EQ(DepartureTable{}(1.0), 0.0);
}

TEST(CalibrationOf, StaticBiasIsSubtracted) {
  const Conducted test = conducted("static_bias");
  const ImuCalibration calibration = calibration_from(test.estimate, "gyro_y");
  const double bias = find_parameter(test.estimate, "bias")->value;
  EXPECT_NEAR(compensated(calibration, {{}, {0.0, 0.1, 0.0}, 293.15, {}}).rate.y, 0.1 - bias, 1e-16);
}

/// Drift with temperature alone, in a recording that begins at the reference and ends at 35 degC.
TEST(CalibrationOf, DriftOfAFogGivesWhatCompensateGives) {
  Conducted test = conducted("fog_thermal_bias");
  for (auto& parameter : test.estimate.parameters)
    if (!parameter.name.ends_with("_0") || parameter.name[0] != 'A') parameter.value = 0.0;
  Recording recording;
  Channel gyro{"gyro", QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, 1.0, nullptr}, {}}, top = gyro;
  for (int k = 0; k < 4000; ++k) {
    gyro.values.push_back(1e-5);
    top.values.push_back(273.15 + (k < 1000 ? 20.0 : 35.0));
  }
  top.kind = QuantityKind::temperature, top.unit = Unit::parse("degC");
  Channel side = top;
  top.name = "temperature_top", side.name = "temperature_side";
  recording.channels = {gyro, top, side};
  const auto done = compensate(test.estimate, recording, nullptr).recording;
  const ImuCalibration calibration = calibration_from(test.estimate);
  const ImuSample found = compensated(calibration, {{}, {1e-5, 0.0, 0.0}, 273.15 + 35.0, {}});
  EXPECT_NEAR(found.rate.x, find_channel(done, "gyro")->values[3500], 1e-17);
  EXPECT_NE(found.rate.x, 1e-5);
}

TEST(CalibrationOf, NoiseJoinsACalibration) {
  const Conducted test = conducted("imu_ferraris");
  Estimate noise;
  noise.method = "allan_noise";
  noise.parameters = {{"imu.gyro_x.angle_random_walk", "N", Unit::parse("deg/sqrt(h)"), 1e-4, ""},
                      {"imu.gyro_x.rate_random_walk", "K", Unit::parse("deg/h/sqrt(h)"), 1e-6, ""},
                      {"az.velocity_random_walk", "N", Unit::parse("(m/s)/sqrt(h)"), 1e-3, ""}};
  noise.covariance = Matrix(3, 3);
  const ImuCalibration calibration =
      calibration_of({{test.estimate, "calibration.json", "01"}, {noise, "noise.json", "23"}});
  EXPECT_EQ(calibration.gyros.noise[0].white, 1e-4);
  EXPECT_EQ(calibration.gyros.noise[0].walk, 1e-6);
  EXPECT_TRUE(std::isnan(calibration.gyros.noise[1].white));
  EXPECT_EQ(calibration.accelerometers.noise[2].white, 1e-3);
  EXPECT_EQ(calibration.sources.size(), 2u);
}

TEST(CalibrationOf, NoiseOfAChannelWithoutAnAxisIsRefusedAmongOthers) {
  Estimate noise;
  noise.method = "allan_noise";
  noise.parameters = {{"gyro_x_dps.angle_random_walk", "N", Unit::parse("deg/sqrt(h)"), 1e-4, ""},
                      {"angular_velocity.angle_random_walk", "N", Unit::parse("deg/sqrt(h)"), 1e-3, ""}};
  noise.covariance = Matrix(2, 2);
  EXPECT_TRUE(refuses(Error::Kind::bad_input,
                      Asked{.values = {"n.json", "angular_velocity"}, .pattern = "axis is not known"},
                      refusal({{noise, "n.json", "01"}})));
  noise.parameters.erase(noise.parameters.begin());
  noise.covariance = Matrix(1, 1);
  EXPECT_EQ(calibration_from(noise).gyros.noise[0].white, 1e-3);  // the only channel: all axes
}

TEST(CalibrationOf, TwoResultsOfOneThingAreRefused) {
  const Conducted test = conducted("imu_ferraris");
  EXPECT_TRUE(refuses(Error::Kind::bad_input,
                      Asked{.values = {"b.json", "accelerometer_x bias"}, .pattern = "another result states"},
                      refusal({{test.estimate, "a.json", "01"}, {test.estimate, "b.json", "23"}})));
}

TEST(CalibrationOf, ResultsWithoutACommonTemperatureAreRefused) {
  Estimate cold = conducted("fog_thermal_bias").estimate, warm = conducted("accelerometer_four_position").estimate;
  EXPECT_TRUE(refusal({{cold, "g.json", "01"}, {warm, "a.json", "23"}}).empty());
  for (Covered& covered : warm.models.at(0).covered)
    if (covered.weights[0].first == Input::temperature)
      covered.least = si(90.0, "degC"), covered.greatest = si(95.0, "degC");
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"90.0"}, .pattern = "no temperature is covered"},
                      refusal({{cold, "g.json", "01"}, {warm, "a.json", "23"}})));
}

TEST(CalibrationOf, NegativeNoiseIsRefused) {
  Estimate noise = conducted("allan_noise").estimate;
  for (auto& parameter : noise.parameters)
    if (parameter.name.ends_with("random_walk")) parameter.value = -parameter.value;
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"n.json"}, .pattern = "is negative"},
                      refusal({{noise, "n.json", "01"}})));
}

TEST(CalibrationOf, ResultsWithoutAModelAndWithoutNoiseAreRefused) {
  Estimate other;
  other.method = "north_finding";
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"north.json", "north_finding"}},
                      refusal({{other, "north.json", "01"}})));
}

/// What each method finds can be placed, or its note names it: none is lost in silence.
class EveryModel : public ::testing::TestWithParam<const Method*> {};

TEST_P(EveryModel, IsPlacedOrNamed) {
  const Method& method = *GetParam();
  if (!method.compensates) return;
  const Conducted test = conducted(method.name);
  const ImuCalibration calibration = calibration_from(test.estimate);
  std::string notes;
  for (const auto& note : calibration.notes) notes += note + "; ";
  EXPECT_TRUE(calibration.gyros.calibrated || calibration.accelerometers.calibrated);
  for (const OutputModel& model : test.estimate.models)
    for (const ModelTerm& term : model.terms) {
      const bool simple = std::ranges::all_of(term.regressor, [](const Product& p) { return p.factors.size() <= 1; });
      if (!simple) continue;
      // a bias or the own axis always has a place
      const bool own = term.regressor.front().factors.empty() ||
                       term.regressor.front().factors.front() == TermFactor{.input = model.shows};
      if (own) {
        EXPECT_EQ(notes.find(term.term + ","), std::string::npos) << term.term;
      }
    }
}

INSTANTIATE_TEST_SUITE_P(All, EveryModel, ::testing::ValuesIn(method_catalogue()),
                         [](const auto& entry) { return std::string(entry.param->name); });

TEST(Calibration, InverseOfTheOutputsIsTheInput) {
  const Parts everything{.curve = true, .lever = true, .thermal_bias = true, .thermal_scale = true};
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const ImuCalibration calibration = random_calibration(seed, everything);
    const ImuSample truth = random_truth(seed);
    // 30 rounding errors of 20 m/s^2
    EXPECT_LT(testing::difference(compensated(calibration, outputs_of(calibration, truth)), truth), 1.5e-13);
  }
}

TEST(Calibration, EveryTermIsFoundAndRemoved) {
  const ImuCalibration calibration = random_calibration(
      3, {.curve = true, .lever = true, .thermal_bias = true, .thermal_scale = true, .noise = false});
  for (const auto& term : calibration_terms()) {
    if (std::string_view(term.name) == "gyro_thermal_transient") continue;
    ImuCalibration without = calibration;
    EXPECT_TRUE(term.is_in(calibration)) << term.name;
    EXPECT_GT(error_without(calibration, term), 0.0) << term.name;
    term.remove(without);
    EXPECT_FALSE(term.is_in(without)) << term.name;
    for (const auto& other : calibration_terms())
      if (std::string_view(other.name) != term.name) {
        EXPECT_EQ(other.is_in(without), other.is_in(calibration)) << other.name << " by " << term.name;
      }
  }
}

/// No input of the range shows more than is stated, and one shows nearly as much.
TEST(Calibration, StatedErrorOfADroppedTermIsTheWorst) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const ImuCalibration calibration = random_calibration(seed, {});
    for (const auto& term : calibration_terms()) {
      if (!term.is_in(calibration)) continue;
      ImuCalibration without = calibration;
      term.remove(without);
      double worst = 0.0;
      for (std::uint64_t k = 0; k < 2000; ++k) {
        const ImuSample truth = random_truth(2000 * seed + k);
        const ImuSample found = compensated(without, outputs_of(calibration, truth));
        const Vector3 error = absolute(term.gyro ? found.rate - truth.rate : found.force - truth.force);
        worst = std::max({worst, error.x, error.y, error.z});
      }
      const double stated = error_without(calibration, term);
      EXPECT_LE(worst, stated * (1.0 + 1e-9)) << term.name;
      EXPECT_GT(worst, 0.5 * stated) << term.name;
    }
  }
}

}  // namespace
}  // namespace tumble
