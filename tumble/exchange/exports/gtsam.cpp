#include <fmt/format.h>

#include <cmath>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"
#include "tumble/units/error.hpp"

namespace tumble::exports::gtsam {
namespace {

using namespace writing;

std::vector<Option> options() {
  return {word("language", {"python", "cpp"}).otherwise("python").says("language of the file"),
          quantity("gravity", "m/s^2").otherwise("9.80665 m/s^2").above(0).says("gravity of the place"),
          word("navigation_frame", {"ENU", "NED"}).otherwise("ENU").says("z axis of the navigation frame: up or down")};
}

/// Squares of one noise of the axes, which all have their own; an axis that does not state it has that of the others.
Vector3 variances(const TriadCalibration& triad, double AxisNoise::*value, double of_all) {
  const Vector3 v = of_each_axis(triad, value, of_all);
  return scaled(v, v);
}

std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  const Noises n = noises_of(c, settings, "gtsam", {.walks = true});
  const bool python = settings.word("language") == "python";
  const std::string up = settings.word("navigation_frame") == "ENU" ? "U" : "D";
  const char* mark = python ? "#" : "//";
  const auto line = [&](const char* name, Vector3 v) {
    const std::string values = fmt::format("{}, {}, {}", real(v.x), real(v.y), real(v.z));
    return python ? fmt::format("    params.set{}(np.diag([{}]))\n", name, values)
                  : fmt::format("  params->set{}(gtsam::Vector3({}).asDiagonal());\n", name, values);
  };
  std::string text = commented(header, mark);
  if (python)
    text +=
        "import gtsam\nimport numpy as np\n\n\ndef preintegration_params():\n    params = "
        "gtsam.PreintegrationCombinedParams.MakeShared" +
        up + "(" + real(settings.number("gravity")) + ")\n";
  else
    text +=
        "#include <gtsam/navigation/CombinedImuFactor.h>\n\ninline auto preintegration_params() {\n  auto params = "

        "gtsam::PreintegrationCombinedParams::MakeShared" +
        up + "(" + real(settings.number("gravity")) + ");\n";
  text += line("AccelerometerCovariance", variances(c.accelerometers, &AxisNoise::white, n.accelerometer.white)) +
          line("GyroscopeCovariance", variances(c.gyros, &AxisNoise::white, n.gyro.white)) +
          line("BiasAccCovariance", variances(c.accelerometers, &AxisNoise::walk, n.accelerometer.walk)) +
          line("BiasOmegaCovariance", variances(c.gyros, &AxisNoise::walk, n.gyro.walk));
  return text + (python ? "    return params\n" : "  return params;\n}\n");
}

}  // namespace

extern const Export gtsam{
    .name = "gtsam",
    .summary = "GTSAM: parameters of the combined IMU factor, as a Python or C++ function",
    .formula = "continuous-time covariances: N^2 of each axis for the samples, K^2 of each axis for the biases",
    .units = "(m/s^2)^2/Hz, (rad/s)^2/Hz; of the biases (m/s^3)^2/Hz, (rad/s^2)^2/Hz",
    .frame = "axes of the calibration; the navigation frame has z up (ENU) or down (NED)",
    .source = "github.com/borglab/gtsam: gtsam/navigation/PreintegrationParams.h, CombinedImuFactor.h",
    .comment = "#",
    .extension = ".py",
    .carries = no_terms,
    .estimates = estimated_biases,
    .takes_counts = false,
    .options = options,
    .write = write};

}  // namespace tumble::exports::gtsam
