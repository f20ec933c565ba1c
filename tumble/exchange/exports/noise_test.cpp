// The noise that a consumer makes of its file, by its own discretisation, is the noise of the calibration: N and K come
// back from a record that is simulated so.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/testing/file_numbers.hpp"
#include "tumble/exchange/testing/random_calibration.hpp"
#include "tumble/math/random.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using testing::number_after;

constexpr double white = 2e-3, some_walk = 4e-4;  ///< N [rad/sqrt(s)], K [rad/s/sqrt(s)] of all axes
constexpr std::size_t samples = 60000;

/// K that a record of this rate shows well: the walk is as large as the white noise after a fortieth of the record.
double shown_walk(double rate) { return 40.0 * std::sqrt(3.0) * white * rate / static_cast<double>(samples); }

/// Standard deviations of what is drawn in each step of length dt: the sample, and the change of the bias, which decays
/// by `decay` first.
struct Steps {
  double sample = 0.0, change = 0.0, decay = 1.0;
};

Steps vins_steps(const std::string& file, double rate) {
  // 0.5 dt (n_0 + n_1) with two independent n of sd gyr_n; b += dt n of sd gyr_w
  return {std::sqrt(0.5) * number_after(file, "gyr_n:"), number_after(file, "gyr_w:") / rate};
}

Steps fast_lio_steps(const std::string& file, double rate) {
  // dt^2 Q in the covariance of the angle and of the bias
  return {std::sqrt(number_after(file, "\n    gyr_cov:")), std::sqrt(number_after(file, "b_gyr_cov:")) / rate};
}

Steps orbslam3_steps(const std::string& file, double) {
  const double root = std::sqrt(number_after(file, "IMU.Frequency:"));
  return {number_after(file, "IMU.NoiseGyro:") * root, number_after(file, "IMU.GyroWalk:") / root};
}

Steps kalibr_steps(const std::string& file, double rate) {
  return {number_after(file, "gyroscope_noise_density:") * std::sqrt(rate),
          number_after(file, "gyroscope_random_walk:") / std::sqrt(rate)};
}

Steps lio_sam_steps(const std::string& file, double rate) {
  return {number_after(file, "imuGyrNoise:") * std::sqrt(rate), number_after(file, "imuGyrBiasN:") / std::sqrt(rate)};
}

Steps gazebo_steps(const std::string& file, double rate) {
  // GaussianNoiseModel.cc: sigma_b^2 tau/2 (1 - exp(-2 dt/tau)), and the bias decays by exp(-dt/tau)
  const double tau = number_after(file, "<dynamic_bias_correlation_time>"),
               density = number_after(file, "<dynamic_bias_stddev>");
  return {number_after(file, "<stddev>"), density * std::sqrt(-0.5 * tau * std::expm1(-2.0 / (rate * tau))),
          std::exp(-1.0 / (rate * tau))};
}

Steps airsim_steps(const std::string& file, double rate) {
  // ImuSimpleParams.hpp: arw deg/sqrt(h), stability deg/h over sqrt(tau); ImuSimple.hpp: / sqrt(dt), * sqrt(dt)
  const double degrees = M_PI / 180.0, tau = number_after(file, "\"GyroBiasStabilityTau\":");
  return {number_after(file, "\"AngularRandomWalk\":") / 60.0 * degrees * std::sqrt(rate),
          number_after(file, "\"GyroBiasStability\":") / 3600.0 * degrees / std::sqrt(tau) / std::sqrt(rate)};
}

Steps psins_steps(const std::string& file, double rate) {
  // imuadderr.m: sqrt(ts) web in the angle; markov1 with sigma = sqg sqrt(taug/2)
  const double tau = number_after(file, "imuerr.taug ="),
               sigma = number_after(file, "imuerr.sqg =") * std::sqrt(tau / 2.0);
  return {number_after(file, "imuerr.web =") * std::sqrt(rate), sigma * std::sqrt(-std::expm1(-2.0 / (rate * tau))),
          std::exp(-1.0 / (rate * tau))};
}

Steps navego_steps(const std::string& file, double rate) {
  // imu_si_errors.m: /60 and degrees to radians
  const double degrees = M_PI / 180.0;
  return {number_after(file, "imu.arw =") / 60.0 * degrees * std::sqrt(rate),
          number_after(file, "imu.arrw =") / 60.0 * degrees / std::sqrt(rate)};
}

struct NoiseConsumer {
  const char* name;
  Steps (*steps)(const std::string& file, double rate);
};

// GoogleTest finds it by this name. NOLINTNEXTLINE(readability-identifier-naming)
void PrintTo(const NoiseConsumer& consumer, std::ostream* out) { *out << consumer.name; }

Estimate identified(const Steps& steps, double rate, std::uint64_t seed) {
  Channel channel{"gyro_x", QuantityKind::angular_rate, Unit::parse("rad/s"), {0.0, rate, nullptr}, {}};
  const RandomStream of_samples = RandomStream(seed).split("samples"), of_bias = RandomStream(seed).split("bias");
  double bias = 0.0;
  for (std::size_t k = 0; k < samples; ++k) {
    channel.values.push_back(bias + steps.sample * of_samples.normal(k));
    bias = steps.decay * bias + steps.change * of_bias.normal(k);
  }
  const Method& method = find_method("allan_noise");
  Evidence evidence;
  evidence.plan.method = method.name;
  evidence.plan.settings = defaults(method.options());
  evidence.recordings.emplace_back();
  evidence.recordings[0].channels = {std::move(channel)};
  return method.identify(evidence, {});
}

class NoiseOfConsumer : public ::testing::TestWithParam<NoiseConsumer> {};

TEST_P(NoiseOfConsumer, ComesBackFromItsOwnDiscretisation) {
  for (const double rate : {100.0, 200.0, 1000.0}) {
    const double walk = shown_walk(rate);
    ImuCalibration calibration;
    for (TriadCalibration* t : {&calibration.accelerometers, &calibration.gyros})
      for (auto& axis : t->noise) axis.white = white, axis.walk = walk;
    ExportRequest asked;
    for (const Option& option : find_export(GetParam().name).options())
      if (option.name == "rate") asked.settings.push_back({"rate", std::to_string(rate), "--set", true, true});
    const std::string file = export_calibration(find_export(GetParam().name), calibration, asked);
    const Estimate estimate = identified(GetParam().steps(file, rate), rate, static_cast<std::uint64_t>(rate));
    for (const auto& [name, wanted] :
         {std::pair{"gyro_x.angle_random_walk", white}, std::pair{"gyro_x.rate_random_walk", walk}}) {
      const Parameter* parameter = find_parameter(estimate, name);
      ASSERT_NE(parameter, nullptr) << name << " at " << rate << " Hz";
      const auto p = static_cast<std::size_t>(parameter - estimate.parameters.data());
      EXPECT_NEAR(parameter->value, wanted, 3.0 * standard_uncertainty(estimate, p)) << name << " at " << rate << " Hz";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, NoiseOfConsumer,
                         ::testing::Values(NoiseConsumer{"vins", vins_steps}, NoiseConsumer{"fast_lio", fast_lio_steps},
                                           NoiseConsumer{"orbslam3", orbslam3_steps},
                                           NoiseConsumer{"kalibr", kalibr_steps},
                                           NoiseConsumer{"lio_sam", lio_sam_steps},
                                           NoiseConsumer{"gazebo", gazebo_steps}, NoiseConsumer{"airsim", airsim_steps},
                                           NoiseConsumer{"psins", psins_steps}, NoiseConsumer{"navego", navego_steps}));

TEST(NoiseOfExport, VariancesAreThoseOfASample) {
  ImuCalibration calibration;
  for (TriadCalibration* t : {&calibration.accelerometers, &calibration.gyros})
    for (std::size_t i = 0; i < 3; ++i)
      t->noise[i].white = white * static_cast<double>(1 + i), t->noise[i].walk = some_walk;
  ExportRequest asked;
  asked.settings.push_back({"rate", "400", "--set", true, true});
  const std::string ros = export_calibration(find_export("ros_covariance"), calibration, asked);
  const auto row = testing::numbers_after(ros, "angular_velocity_covariance:", 9);
  EXPECT_DOUBLE_EQ(row[0], white * white * 400.0);
  EXPECT_DOUBLE_EQ(row[8], 9.0 * white * white * 400.0);
  EXPECT_EQ(row[1], 0.0);
  EXPECT_EQ(number_after(ros, "orientation_covariance:"), -1.0);
  const std::string carla = export_calibration(find_export("carla"), calibration, asked);
  EXPECT_DOUBLE_EQ(number_after(carla, "\"noise_gyro_stddev_y\":"), 2.0 * white * 20.0);
  asked.settings.clear();
  const std::string gtsam = export_calibration(find_export("gtsam"), calibration, asked);
  const auto variances = testing::numbers_after(gtsam, "setGyroscopeCovariance(np.diag(", 3);
  EXPECT_DOUBLE_EQ(variances[1], 4.0 * white * white);
  const auto walks = testing::numbers_after(gtsam, "setBiasAccCovariance(np.diag(", 3);
  EXPECT_DOUBLE_EQ(walks[0], some_walk * some_walk);
}

TEST(NoiseOfExport, BiasInstabilityIsNeverAWalk) {
  ImuCalibration calibration;
  for (TriadCalibration* t : {&calibration.accelerometers, &calibration.gyros})
    for (auto& axis : t->noise) axis.white = white, axis.instability = 7.7e-5;
  ExportRequest asked;
  asked.settings.push_back({"rate", "200", "--set", true, true});
  for (const char* name : {"kalibr", "openvins", "vins", "orbslam3", "fast_lio"})
    EXPECT_THROW(export_calibration(find_export(name), calibration, asked), std::runtime_error) << name;
}

TEST(NoiseOfExport, MarkovBiasGoesToGazebo) {
  ImuCalibration calibration;
  for (TriadCalibration* t : {&calibration.accelerometers, &calibration.gyros})
    for (auto& axis : t->noise) axis.white = white, axis.markov_sd = 3e-4, axis.markov_time = 50.0;
  ExportRequest asked;
  asked.settings.push_back({"rate", "200", "--set", true, true});
  const std::string file = export_calibration(find_export("gazebo"), calibration, asked);
  const Steps steps = gazebo_steps(file, 200.0);
  // the standard deviation that the recursion settles at
  EXPECT_NEAR(steps.change / std::sqrt(1.0 - steps.decay * steps.decay), 3e-4, 1e-12);
}

/// Noise of three axes from a record whose curve begins at `first` [s], by these averaging times.
Estimate noise_result(bool gyro, double first, const std::string& taus) {
  Estimate noise;
  noise.method = "allan_noise";
  noise.provenance.settings["taus"] = taus;
  for (const char axis : {'x', 'y', 'z'}) {
    const std::string label = (gyro ? "gyro." : "accelerometer.") + std::string(1, axis);
    noise.parameters.push_back({label + (gyro ? ".angle_random_walk" : ".velocity_random_walk"), "N",
                                Unit::parse(gyro ? "deg/sqrt(h)" : "(m/s)/sqrt(h)"), 1e-4, ""});
    Curve curve;
    curve.name = label + " allan_deviation";
    curve.x.values = {first, 2.0 * first};
    noise.curves.push_back(curve);
  }
  noise.covariance = Matrix(3, 3);
  return noise;
}

TEST(NoiseOfExport, TheRateIsThatOfTheRecordsWhereTheySayOne) {
  const auto exported = [](const Estimate& gyros, const Estimate& accelerometers) {
    try {
      return export_calibration(find_export("ros_covariance"),
                                calibration_of({{gyros, "g.json", "01"}, {accelerometers, "a.json", "23"}}), {});
    } catch (const Error& error) {
      return std::string(error.what());
    }
  };
  const auto asks = [](const std::string& text) { return text.find("needs the rate") != std::string::npos; };
  EXPECT_FALSE(asks(exported(noise_result(true, 0.005, "log"), noise_result(false, 0.005, "octave"))));
  EXPECT_TRUE(asks(exported(noise_result(true, 0.005, "log"), noise_result(false, 0.01, "log")))) << "two rates";
  EXPECT_TRUE(asks(exported(noise_result(true, 1.0, "1 s, 2 s"), noise_result(false, 1.0, "1 s, 2 s"))))
      << "listed times";
  EXPECT_TRUE(asks(exported(noise_result(true, 0.005, "log"), noise_result(false, 1.0, "1 s, 2 s"))));
}

std::string kalibr_of(const ImuCalibration& calibration, const std::vector<Given>& settings) {
  return export_calibration(find_export("kalibr"), calibration, {.settings = settings});
}

TEST(NoiseOfExport, AnAxisWithoutAWalkIsNoZero) {
  ImuCalibration noise;
  for (auto* triad : {&noise.accelerometers, &noise.gyros})
    for (auto& axis : triad->noise) axis = {.rate = 100.0, .white = white, .walk = some_walk};
  noise.gyros.noise[2].walk = AxisNoise::none;
  const std::string file = kalibr_of(noise, {});
  EXPECT_DOUBLE_EQ(number_after(file, "gyroscope_random_walk:"), some_walk);
  EXPECT_NE(file.find("K of the gyros is not shown for z"), std::string::npos);
  EXPECT_EQ(file.find("K of the accelerometers is not shown"), std::string::npos);
  const std::string given = kalibr_of(noise, {{"gyro_walk", "5 deg/h/sqrt(h)", "--set", true, true}});
  EXPECT_NE(given.find("K of the gyros is that of the setting gyro_walk"), std::string::npos);
  EXPECT_EQ(given.find("is not shown for"), std::string::npos);
}

/// A file without a single number would pass for a calibration.
TEST(Export, NoiseAloneIsRefusedByFilesThatDoNotStateIt) {
  ImuCalibration noise;
  for (auto* triad : {&noise.accelerometers, &noise.gyros})
    for (auto& axis : triad->noise) axis = {.rate = 100.0, .white = white, .walk = some_walk};
  for (const char* name : {"px4", "ardupilot", "imu_tk", "matlab", "c"})
    EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "the results hold noise alone"}, [&] {
      export_calibration(find_export(name), noise, {});
    })) << name;
  ExportRequest asked;
  asked.settings.push_back({"rate", "100", "--set", true, true});
  EXPECT_NE(export_calibration(find_export("matlab"), noise, asked).find("imuSensor("), std::string::npos);
}

TEST(Export, NumbersBeyondFloatsAreRefusedByFilesOfFloats) {
  ImuCalibration calibration = testing::random_calibration(3, {.misalignment = false, .by_force = false});
  calibration.accelerometers.bias.y = 1e39;
  for (const char* name : {"px4", "c"}) {
    ExportRequest asked;
    asked.drop = {"gyro_scale_factor"};
    if (std::string_view(name) == "px4")
      for (const char* id : {"accelerometer_id", "gyro_id"}) asked.settings.push_back({id, "17", "--set", true, true});
    EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "largest number of 32 bits"}, [&] {
      export_calibration(find_export(name), calibration, asked);
    })) << name;
  }
}

}  // namespace
}  // namespace tumble
