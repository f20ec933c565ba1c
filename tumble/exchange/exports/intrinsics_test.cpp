// Files are read by the formulas of their consumers, which must give what the calibration gives.
#include <gtest/gtest.h>

#include <cmath>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/factor.hpp"
#include "tumble/exchange/testing/consumers.hpp"
#include "tumble/exchange/testing/file_numbers.hpp"
#include "tumble/exchange/testing/random_calibration.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::intrinsics_test {
namespace {

using testing::Consumed;
using testing::Parts;
using testing::random_calibration;
using testing::random_truth;

constexpr std::uint64_t calibrations = 1000;
/// 60 rounding errors of 20 m/s^2 through the factors, the inverses and the file.
constexpr double rounding = 3e-13;

ExportRequest request(std::initializer_list<std::pair<const char*, const char*>> sets) {
  ExportRequest out;
  for (const auto& [key, text] : sets) out.settings.push_back({key, text, "--set", true, true});
  return out;
}

/// The consumer's own result from raw outputs is that of the calibration, for many calibrations.
template <class Consumer>
void expect_same(const char* name, const Parts& parts, const ExportRequest& asked, Consumer consumer,
                 double tolerance = rounding) {
  for (std::uint64_t seed = 0; seed < calibrations; ++seed) {
    const ImuCalibration calibration = random_calibration(seed, parts);
    const std::string file = export_calibration(find_export(name), calibration, asked);
    const ImuSample raw = outputs_of(calibration, random_truth(seed)), wanted = compensated(calibration, raw);
    const Consumed found = consumer(file, raw);
    if (found.forces) {
      ASSERT_LT(norm(found.sample.force - wanted.force), tolerance) << name << ", seed " << seed;
    }
    if (found.rates) {
      ASSERT_LT(norm(found.sample.rate - wanted.rate), tolerance) << name << ", seed " << seed;
    }
  }
}

TEST(ExportKalibr, ConsumerGivesWhatTheCalibrationGives) {
  expect_same("kalibr", {}, request({{"rate", "200"}}), testing::kalibr);
}

TEST(ExportOpenvins, ConsumerGivesWhatTheCalibrationGives) {
  const auto right = [](const std::string& file, const ImuSample& raw) { return testing::openvins(file, raw); };
  expect_same("openvins", {}, request({{"rate", "200"}}), right);
  expect_same("openvins", {}, request({{"rate", "200"}, {"model", "rpng"}}), right);
}

/// Its configuration says that Tg is Kalibr's A. It is not: with A the rates are wrong by what C_gyro_i turns.
TEST(ExportOpenvins, KalibrsAInPlaceOfTgWouldBeWrong) {
  double worst = 0.0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const ImuCalibration calibration = random_calibration(seed, {});
    const std::string file = export_calibration(find_export("openvins"), calibration, request({{"rate", "200"}}));
    const ImuSample raw = outputs_of(calibration, random_truth(seed)), wanted = compensated(calibration, raw);
    worst = std::max(worst, norm(testing::openvins(file, raw, true).sample.rate - wanted.rate));
  }
  EXPECT_GT(worst, 1e-4);  // G |f| times the angle: 1e-3 * 20 * 0.05
}

TEST(ExportKalibr, ShowsTheRotationOfItsFrame) {
  ImuCalibration calibration = random_calibration(1, {.bias = false});
  const std::string file = export_calibration(find_export("kalibr"), calibration, request({{"rate", "200"}}));
  const double angle = writing::angle_of(writing::lower_factor(calibration.accelerometers.response, "").rotation);
  const double degrees = angle * 180.0 / M_PI;
  EXPECT_NEAR(testing::number_after(file, "to those of this file (T_i_b):"), degrees, 5e-6 * degrees);  // six digits
}

TEST(ExportKalibr, NoiseAloneIsAnImuYaml) {
  ImuCalibration calibration = random_calibration(5, {});
  calibration.accelerometers.calibrated = calibration.gyros.calibrated = false;
  for (TriadCalibration* t : {&calibration.accelerometers, &calibration.gyros})
    t->response = identity3(), t->bias = {}, t->by_force = {};
  const std::string file = export_calibration(find_export("kalibr"), calibration, request({{"rate", "200"}}));
  EXPECT_EQ(file.find("imu0:"), std::string::npos);
  double squares = 0.0;
  for (const auto& axis : calibration.gyros.noise) squares += axis.white * axis.white;
  EXPECT_DOUBLE_EQ(testing::number_after(file, "gyroscope_noise_density:"), std::sqrt(squares / 3.0));
  EXPECT_EQ(testing::number_after(file, "update_rate:"), 200.0);
}

TEST(ExportKalibr, NumbersHaveAPointForYaml) {
  ImuCalibration calibration = random_calibration(5, {});
  for (auto& axis : calibration.gyros.noise) axis.white = 1e-5, axis.walk = 1e-7;
  const std::string file = export_calibration(find_export("kalibr"), calibration, request({{"rate", "200"}}));
  EXPECT_NE(file.find("gyroscope_noise_density: 1.0e-05 "), std::string::npos) << file;
}

Refused refusal(const char* name, const ImuCalibration& calibration, const ExportRequest& asked) {
  return refusal_of([&] { export_calibration(find_export(name), calibration, asked); });
}

constexpr auto input = Error::Kind::bad_input;

TEST(Export, MissingNoiseIsNamedWithItsLimit) {
  ImuCalibration calibration = random_calibration(5, {});
  for (auto& axis : calibration.gyros.noise) axis.walk = AxisNoise::none, axis.walk_limit = si(7.0, "deg/h/sqrt(h)");
  EXPECT_TRUE(refuses(input, Asked{.values = {"gyro_walk", "deg/h/sqrt(h)", "7", "deg/h/sqrt(h)"}},
                      refusal("kalibr", calibration, request({{"rate", "200"}}))));
  EXPECT_TRUE(refusal("kalibr", calibration, request({{"rate", "200"}, {"gyro_walk", "7 deg/h/sqrt(h)"}})).empty());
}

TEST(Export, AllThatIsMissingIsSaidAtOnce) {
  ImuCalibration calibration = random_calibration(5, {.curve = true});
  for (auto& axis : calibration.gyros.noise) axis.walk = AxisNoise::none;
  EXPECT_TRUE(refuses(input,
                      std::vector<Asked>{{.part = "gyro_nonlinearity", .pattern = "cannot carry"},
                                         {.values = {"gyro_walk"}, .pattern = "add a result of allan_noise"},
                                         {.part = "kalibr", .pattern = "needs the rate"}},
                      refusal("kalibr", calibration, {})));
}

TEST(Export, TermThatCannotBeCarriedIsRefusedUnlessDropped) {
  const ImuCalibration calibration = random_calibration(5, {.curve = true});
  ExportRequest asked = request({{"rate", "200"}});
  EXPECT_TRUE(refuses(input,
                      std::vector<Asked>{{.part = "accelerometer_nonlinearity", .pattern = "cannot carry"},
                                         {.part = "gyro_nonlinearity", .pattern = "cannot carry"}},
                      refusal("kalibr", calibration, asked)));
  asked.drop = {"accelerometer_nonlinearity", "gyro_nonlinearity"};
  const std::string file = export_calibration(find_export("kalibr"), calibration, asked);
  EXPECT_NE(file.find("# dropped: gyro_nonlinearity; without it the rates are off by up to"), std::string::npos);
}

TEST(Export, CountsAreRefusedByConsumersThatReadSi) {
  ImuCalibration calibration = random_calibration(5, {});
  calibration.gyros.output = Unit::parse("pulse");
  EXPECT_TRUE(refuses(input, Asked{.values = {"rad/s", "pulse"}, .pattern = "calibrated in"},
                      refusal("kalibr", calibration, request({{"rate", "200"}}))));
}

TEST(Export, ReversedAxisIsRefused) {
  ImuCalibration calibration = random_calibration(5, {});
  calibration.accelerometers.response.x = -calibration.accelerometers.response.x;
  EXPECT_TRUE(refuses(input, Asked{.part = "accelerometers", .pattern = "left-handed"},
                      refusal("kalibr", calibration, request({{"rate", "200"}}))));
  EXPECT_TRUE(refuses(input, Asked{.values = {"CAL_ACC0", "X", "x"}, .part = "-", .pattern = "SCALE"},
                      refusal("px4", calibration, {})));
}

TEST(Export, InflateMultipliesTheNoiseAndIsStated) {
  const ImuCalibration calibration = random_calibration(5, {});
  ExportRequest asked = request({{"rate", "200"}});
  const std::string one = export_calibration(find_export("kalibr"), calibration, asked);
  asked.inflate = 10.0;
  const std::string ten = export_calibration(find_export("kalibr"), calibration, asked);
  for (const char* key : {"accelerometer_random_walk:", "gyroscope_noise_density:"})
    EXPECT_NEAR(testing::number_after(ten, key) / testing::number_after(one, key), 10.0, 1e-12);
  EXPECT_NE(ten.find("# N and K are multiplied by 10"), std::string::npos);
}

TEST(Export, OneNumberForThreeAxesIsRmsOrGreatest) {
  ImuCalibration calibration = random_calibration(5, {});
  for (std::size_t i = 0; i < 3; ++i) calibration.gyros.noise[i].white = static_cast<double>(1 + i);
  const auto white = [&](const char* axes) {
    return testing::number_after(
        export_calibration(find_export("kalibr"), calibration, request({{"rate", "200"}, {"axes", axes}})),
        "gyroscope_noise_density:");
  };
  EXPECT_DOUBLE_EQ(white("rms"), std::sqrt(14.0 / 3.0));
  EXPECT_EQ(white("max"), 3.0);
}

TEST(Export, AxesThatWereNotMeasuredDoNotCount) {
  ImuCalibration calibration = random_calibration(5, {});
  calibration.gyros.noise = {};
  calibration.gyros.noise[2] = {.white = 3.0, .walk = 2.0};
  const std::string one = export_calibration(find_export("kalibr"), calibration, request({{"rate", "200"}}));
  EXPECT_EQ(testing::number_after(one, "gyroscope_noise_density:"), 3.0);
  EXPECT_EQ(testing::number_after(one, "gyroscope_random_walk:"), 2.0);
  calibration.gyros.noise[0] = {.white = 3.0};  // measured, without a walk
  const std::string two = export_calibration(find_export("kalibr"), calibration, request({{"rate", "200"}}));
  EXPECT_EQ(testing::number_after(two, "gyroscope_random_walk:"), 2.0);  // a walk that is not shown is not 0
}

TEST(Export, TopicCannotLeaveItsLine) {
  EXPECT_TRUE(
      refuses(input, Asked{.values = {"/imu: [1"}, .pattern = "rostopic"},
              refusal("kalibr", random_calibration(5, {}), request({{"rate", "200"}, {"rostopic", "/imu: [1"}}))));
}

TEST(Export, TitleCannotLeaveItsComment) {
  ImuCalibration calibration = random_calibration(5, {});
  calibration.title = "two\nlines: [1] */ -->";
  const std::string file = export_calibration(find_export("kalibr"), calibration, request({{"rate", "200"}}));
  EXPECT_NE(file.find("# title: two lines: [1] *"), std::string::npos);
  EXPECT_EQ(file.find("\nlines"), std::string::npos);
  calibration.title = "a\u2028lines: 1\u2029lines: 2\u0085lines: 3 \uFFFE \u202E /* **/ \?\?/ \?\?\?\?/ end";
  const std::string other = export_calibration(find_export("kalibr"), calibration, request({{"rate", "200"}}));
  EXPECT_NE(other.find("# title: a lines: 1 lines: 2 lines: 3     /  ** "), std::string::npos) << other;
  for (const char* trap : {"/*", "*/", "??", "\u2028", "\u2029", "\u0085", "\uFFFE", "\u202E"})
    EXPECT_EQ(other.find(trap), std::string::npos) << trap;
  ImuCalibration noise = random_calibration(5, {.scale = false, .misalignment = false, .by_force = false});
  noise.title = "ends in \\ ";
  EXPECT_EQ(export_calibration(find_export("gtsam"), noise, request({{"language", "cpp"}})).find("\\ \n"),
            std::string::npos);
  noise.title = "ends in \\";
  const std::string code = export_calibration(find_export("gtsam"), noise, request({{"language", "cpp"}}));
  EXPECT_NE(code.find("ends in\n"), std::string::npos);
  EXPECT_EQ(code.find("\\\n"), std::string::npos);
}

/// What PX4 and ArduPilot carry: no misalignment, gyros without scale factors.
constexpr Parts autopilot{.misalignment = false, .by_force = false, .thermal_bias = true, .noise = false};

ImuCalibration of_autopilot(std::uint64_t seed) {
  ImuCalibration calibration = random_calibration(seed, autopilot);
  calibration.gyros.response = identity3();
  return calibration;
}

/// A float has an error of 2^-24 of itself: of 20 m/s^2 by the scale, of the offset, of the polynomials.
constexpr double float_rounding = 4.0 * 20.0 / (1 << 24);

TEST(ExportPx4, ConsumerGivesWhatTheCalibrationGives) {
  for (std::uint64_t seed = 0; seed < calibrations; ++seed) {
    const ImuCalibration calibration = of_autopilot(seed);
    const std::string file = export_calibration(find_export("px4"), calibration,
                                                request({{"accelerometer_id", "1310988"}, {"gyro_id", "1310988"}}));
    const ImuSample raw = outputs_of(calibration, random_truth(seed)), wanted = compensated(calibration, raw);
    ASSERT_LT(testing::difference(testing::px4(file, raw).sample, wanted), float_rounding) << seed;
  }
}

TEST(ExportPx4, TemperaturesAtTheEndsAndBeyondAreLimited) {
  const ImuCalibration calibration = of_autopilot(7);
  const std::string file = export_calibration(find_export("px4"), calibration,
                                              request({{"accelerometer_id", "1310988"}, {"gyro_id", "1310988"}}));
  for (const auto& [temperature, limited] :
       {std::pair{263.15, 263.15}, {293.15, 293.15}, {323.15, 323.15}, {250.0, 263.15}, {340.0, 323.15}}) {
    const ImuSample raw{{1.0, 2.0, 3.0}, {0.1, 0.2, 0.3}, temperature, {}};
    ImuSample at_end = raw;
    at_end.temperature = limited;
    EXPECT_LT(testing::difference(testing::px4(file, raw).sample, compensated(calibration, at_end)), float_rounding);
  }
}

TEST(ExportPx4, OffsetsThatNoResultStatesStayThoseOfTheVehicle) {
  ImuCalibration calibration = of_autopilot(7);
  calibration.gyros.axes = {true, false, true};
  calibration.gyros.bias.z = 0.0;  // a drift with temperature alone
  const ExportRequest asked = request({{"accelerometer_id", "1"}, {"gyro_id", "1"}});
  for (const auto& [name, offset] : {std::pair{"px4", "CAL_GYRO0_{}OFF"}, std::pair{"ardupilot", "INS_GYROFFS_{}"}}) {
    const std::string file = export_calibration(find_export(name), calibration, asked);
    for (const char* axis : {"X", "Y", "Z"}) {
      std::string key = offset;
      key.replace(key.find("{}"), 2, axis);
      EXPECT_EQ(file.find(key) != std::string::npos, axis[0] == 'X') << key;
    }
  }
}

TEST(ExportPx4, NeedsTheIdentifiersOfTheVehicle) {
  EXPECT_TRUE(refuses(
      input, std::vector<Asked>{{.part = "accelerometer_id", .pattern = "px4"}, {.part = "gyro_id", .pattern = "px4"}},
      refusal("px4", of_autopilot(7), {})));
}

TEST(ExportPx4, FourthPowerOfTheTemperatureIsRefused) {
  ImuCalibration calibration = of_autopilot(7);
  calibration.gyros.thermal[1].output = {1e-5, 1e-6, 1e-7, 1e-8};
  EXPECT_TRUE(refuses(input, Asked{.values = {"gyro", "4"}, .pattern = "powers of the temperature"},
                      refusal("px4", calibration, request({{"accelerometer_id", "1"}, {"gyro_id", "1"}}))));
}

TEST(ExportArdupilot, ConsumerGivesWhatTheCalibrationGives) {
  for (std::uint64_t seed = 0; seed < calibrations; ++seed) {
    const ImuCalibration calibration = of_autopilot(seed);
    const std::string file = export_calibration(find_export("ardupilot"), calibration, {});
    const ImuSample raw = outputs_of(calibration, random_truth(seed)), wanted = compensated(calibration, raw);
    ASSERT_LT(testing::difference(testing::ardupilot(file, raw).sample, wanted), float_rounding) << seed;
  }
}

TEST(ExportArdupilot, ReferenceBeyondTheTemperaturesOfTheTestIsBroughtIntoThem) {
  ImuCalibration calibration = of_autopilot(7);
  for (const double reference : {253.15, 343.15}) {
    calibration.reference_temperature = reference;
    const std::string file = export_calibration(find_export("ardupilot"), calibration, {});
    for (const double temperature : {263.15, 293.15, 323.15}) {
      const ImuSample raw{{1.0, 2.0, 3.0}, {0.1, 0.2, 0.3}, temperature, {}};
      EXPECT_LT(testing::difference(testing::ardupilot(file, raw).sample, compensated(calibration, raw)),
                float_rounding);
    }
  }
}

TEST(ExportArdupilot, OffsetsOfTheVehicleKeepTheirTemperature) {
  ImuCalibration calibration = of_autopilot(7);
  calibration.gyros.bias = {};  // a drift with temperature alone
  const std::string file = export_calibration(find_export("ardupilot"), calibration, {});
  EXPECT_EQ(file.find("INS_GYR1_CALTEMP"), std::string::npos);
  EXPECT_NE(file.find("INS_ACC1_CALTEMP"), std::string::npos);
}

TEST(ExportAutopilots, ScaleFactorsStayWhereTheBiasIsDropped) {
  for (const auto& [name, scale] : {std::pair{"px4", "CAL_ACC0_ZSCALE"}, std::pair{"ardupilot", "INS_ACCSCAL_Z"}}) {
    ExportRequest asked = request({{"accelerometer_id", "1"}, {"gyro_id", "1"}});
    asked.drop = {"accelerometer_bias"};
    const std::string file = export_calibration(find_export(name), of_autopilot(7), asked);
    EXPECT_NE(file.find(scale), std::string::npos) << name;
    for (const char* offset : {"CAL_ACC0_ZOFF", "INS_ACCOFFS_Z"})
      EXPECT_EQ(file.find(offset), std::string::npos) << name;
  }
}

TEST(ExportArdupilot, ValuesThatTheVehicleRefusesAreErrors) {
  ImuCalibration calibration = of_autopilot(7);
  calibration.accelerometers.bias.x = 4.0;
  calibration.accelerometers.response(2, 2) = 1.5;
  EXPECT_TRUE(refuses(input,
                      {{.values = {"4", "x"}, .pattern = "offset"}, {.values = {"0.667", "z"}, .pattern = "scale"}},
                      refusal("ardupilot", calibration, {})));
}

TEST(ExportImuTk, ConsumerGivesWhatTheCalibrationGives) {
  for (const bool gyros : {false, true})
    expect_same("imu_tk", {.by_force = false}, request({{"sensors", gyros ? "gyros" : "accelerometers"}}),
                [gyros](const std::string& file, const ImuSample& raw) { return testing::imu_tk(file, raw, gyros); });
}

TEST(ExportRosImuCalib, ConsumerGivesWhatTheCalibrationGives) {
  ExportRequest asked;
  asked.drop = {"gyro_scale_factor", "gyro_misalignment", "gyro_acceleration_sensitivity"};
  expect_same("ros_imu_calib", {}, asked, testing::ros_imu_calib);
}

TEST(ExportImucal, ConsumerGivesWhatTheCalibrationGives) { expect_same("imucal", {}, {}, testing::imucal); }

TEST(ExportPsins, ConsumerGivesWhatTheCalibrationGives) { expect_same("psins", {}, {}, testing::psins); }

/// imuadderr simulates walks only where `min(abs(imuerr.sqg)) > 0`.
TEST(ExportPsins, WalkOfOneAxisIsNotLostBecauseAnotherHasNone) {
  ImuCalibration calibration = random_calibration(5, {});
  calibration.gyros.noise[1].walk = AxisNoise::none;
  for (auto& axis : calibration.accelerometers.noise) axis.walk = AxisNoise::none;
  const std::string file = export_calibration(find_export("psins"), calibration, {});
  EXPECT_EQ(testing::number_after(file, "imuerr.sqg = ["), calibration.gyros.noise[0].walk);
  EXPECT_NE(file.find("; 1.0e-30; "), std::string::npos) << file;
  EXPECT_NE(file.find("imuerr.sqa = [0.0; 0.0; 0.0]"), std::string::npos) << file;
}

TEST(ExportMatlab, SensorOfCountsIsRefusedAndMissingNoiseIsSaid) {
  ImuCalibration calibration = random_calibration(5, {.noise = false});
  const std::string file = export_calibration(find_export("matlab"), calibration, request({{"rate", "100"}}));
  EXPECT_NE(file.find("no result states the noise of the gyros"), std::string::npos);
  calibration.gyros.output = Unit::parse("pulse/s");
  EXPECT_TRUE(refuses(input, Asked{.values = {"rad/s", "pulse/s"}, .pattern = "imuSensor"},
                      refusal("matlab", calibration, request({{"rate", "100"}}))));
  EXPECT_TRUE(refusal("matlab", calibration, {}).empty());
}

TEST(ExportMatlab, ConsumerGivesWhatTheCalibrationGives) { expect_same("matlab", {}, {}, testing::matlab); }

/// Every consumer either writes the file or says what it cannot carry and how to go on.
TEST(Export, EveryConsumerWritesOrSaysWhatItNeeds) {
  for (const Export* entry : export_catalogue()) {
    ExportRequest asked = request({});
    for (const Option& option : entry->options()) {
      if (option.name == "rate") asked.settings.push_back({"rate", "200", "--set", true, true});
      if (option.name.ends_with("_id")) asked.settings.push_back({option.name, "17", "--set", true, true});
    }
    const ImuCalibration calibration =
        random_calibration(11, {.curve = true, .lever = true, .thermal_bias = true, .thermal_scale = true});
    std::string said;
    for (const std::string& text : texts_of(refusal(entry->name, calibration, asked).problems)) said += text + "\n";
    for (const auto& term : calibration_terms())
      if (said.find(std::string("--drop ") + term.name + " ") != std::string::npos) asked.drop.emplace_back(term.name);
    const std::string file = export_calibration(*entry, calibration, asked);
    EXPECT_NE(file.find("random calibration"), std::string::npos) << entry->name << " lacks its header";
    EXPECT_NE(file.find("serial number 11"), std::string::npos) << entry->name;
    for (const auto& term : asked.drop) EXPECT_NE(file.find("dropped: " + term), std::string::npos) << entry->name;
    EXPECT_EQ(file.find("nan"), std::string::npos) << entry->name;
    EXPECT_EQ(file.back(), '\n') << entry->name;
  }
}

TEST(Export, NamesTakeAHyphenAsWell) { EXPECT_STREQ(find_export("lio-sam").name, "lio_sam"); }

TEST(Export, FactorsGiveTheMatrixBack) {
  for (std::uint64_t seed = 0; seed < calibrations; ++seed) {
    const Matrix3 k = random_calibration(seed, {}).accelerometers.response;
    for (const auto& f : {writing::lower_factor(k, ""), writing::upper_factor(k, "")}) {
      const Matrix3 rest = f.triangle * f.rotation - k, unit = f.rotation * transposed(f.rotation) - identity3();
      EXPECT_LT(norm(rest.x) + norm(rest.y) + norm(rest.z), 3e-15);
      EXPECT_LT(norm(unit.x) + norm(unit.y) + norm(unit.z), 3e-15);
      EXPECT_NEAR(determinant(f.rotation), 1.0, 1e-15);
    }
  }
}

}  // namespace
}  // namespace tumble::intrinsics_test
