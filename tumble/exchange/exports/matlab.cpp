#include <fmt/format.h>

#include <cmath>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"
#include "tumble/units/error.hpp"

namespace tumble::exports::matlab {
namespace {

using namespace writing;

std::vector<std::string> carries() {
  auto names = terms_ending({"bias", "scale_factor", "misalignment"});
  names.emplace_back("gyro_acceleration_sensitivity");
  return names;
}

std::vector<Option> options() {
  return {rate_option("rate of the samples of the simulated imuSensor; default: no imuSensor is made")};
}

std::string parameters(const TriadCalibration& t, const char* variable, const char* function) {
  return fmt::format(
      "{} = {}('NoiseType', 'double-sided', ...\n    'ConstantBias', {}, ...\n    'NoiseDensity', {}, "
      "...\n    'RandomWalk', {}, ...\n    'BiasInstability', {});\n",
      variable, function, writing::matlab(t.bias), writing::matlab(of_each_axis(t, &AxisNoise::white)),
      writing::matlab(of_each_axis(t, &AxisNoise::walk)), writing::matlab(of_each_axis(t, &AxisNoise::instability)));
}

/// An imuSensor gives SI.
void check_outputs_of_sensor(const ImuCalibration& c) {
  for (const TriadCalibration* t : {&c.accelerometers, &c.gyros}) {
    const Unit wanted = Unit::parse(t == &c.gyros ? "rad/s" : "m/s^2");
    if (t->calibrated && !(t->output.dimension() == wanted.dimension()))
      throw Error(Error::Kind::bad_input,
                  say("matlab: an imuSensor gives {}, but the calibration is of outputs in {}: leave the "
                      "setting rate away to have the matrices alone",
                      Name{wanted.text()}, Name{t->output.text()}));
  }
}

/// What of an imuSensor no result states.
std::string without_noise(const TriadCalibration& t, const char* what) {
  if (t.has_noise()) return "";
  return fmt::format("% no result states the noise of the {}: it is 0 here\n", what);
}

std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  if (!settings.has("rate") && !c.accelerometers.calibrated && !c.gyros.calibrated)
    throw Error(Error::Kind::bad_input,
                "matlab: the results hold noise alone, which stands in an imuSensor: --set rate=100, the rate of its "
                "samples");
  std::string text = commented(header, "%");
  text += fmt::format(
      "calibration.K_a = {};\ncalibration.b_a = {};\ncalibration.K_g = {};\ncalibration.b_g = {};\n"
      "calibration.G = {};\n",
      writing::matlab(c.accelerometers.response), writing::matlab(c.accelerometers.bias),
      writing::matlab(c.gyros.response), writing::matlab(c.gyros.bias), writing::matlab(c.gyros.by_force));
  text +=
      "% acc and gyr: one row for each sample\n"
      "calibration.force = @(acc) (acc - calibration.b_a)/calibration.K_a';\n"
      "calibration.rate = @(acc, gyr) (gyr - calibration.b_g - "
      "calibration.force(acc)*calibration.G')/calibration.K_g';\n";
  if (!settings.has("rate")) return text;
  check_outputs_of_sensor(c);
  text += without_noise(c.accelerometers, "accelerometers") + without_noise(c.gyros, "gyros");
  text += "% simulated sensor: bias and noise; its scale factors and misalignments are those of calibration.K\n";
  return text + parameters(c.accelerometers, "accelerometer", "accelparams") +
         parameters(c.gyros, "gyro", "gyroparams") +
         fmt::format(
             "imu = imuSensor('accel-gyro', 'SampleRate', {}, 'Accelerometer', accelerometer, 'Gyroscope', "
             "gyro);\n",
             real(settings.number("rate")));
}

}  // namespace

extern const Export matlab{
    .name = "matlab",
    .summary = "MATLAB: matrices with functions that compensate, and an imuSensor with bias and noise",
    .formula =
        "force = inv(K_a) (acc - b_a), rate = inv(K_g) (gyr - b_g - G force); NoiseDensity = N (double-sided), "
        "RandomWalk = K, BiasInstability = B",
    .units = "rad/s, m/s^2; densities per sqrt(Hz), two-sided",
    .frame = "axes of the calibration; specific force is +1 g upwards at rest, while imuSensor takes accelerations",
    .source = "mathworks.com/help/nav/ref/gyroparams.html, mathworks.com/help/nav/ref/accelparams.html",
    .comment = "%",
    .extension = ".m",
    .carries = carries,
    .estimates = no_terms,
    .takes_counts = true,
    .options = options,
    .write = write};

}  // namespace tumble::exports::matlab
