#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"

namespace tumble::exports::psins {
namespace {

using namespace writing;

std::vector<std::string> carries() {
  auto names = terms_ending({"bias", "scale_factor", "misalignment"});
  names.emplace_back("gyro_acceleration_sensitivity");
  return names;
}

std::vector<Option> options() {
  return {quantity("correlation_time", "s")
              .above(0)
              .otherwise("1e6 s")
              .says("correlation time of the bias that imuadderr simulates (taug, taua)")};
}

std::string column(Vector3 v) { return fmt::format("[{}; {}; {}]", real(v.x), real(v.y), real(v.z)); }

/// PSINS leaves out the walks of all three axes where one of them is 0: what is missing there is next to nothing.
Vector3 walks(const TriadCalibration& triad) {
  constexpr double next_to_nothing = 1e-30;
  Vector3 walk = of_each_axis(triad, &AxisNoise::walk);
  if (!(norm(walk) > 0.0)) return walk;
  for (std::size_t i = 0; i < 3; ++i) walk[i] = std::max(walk[i], next_to_nothing);
  return walk;
}

std::string noise(const ImuCalibration& c, double time) {
  return fmt::format(
      "imuerr = struct('eb', zeros(3,1), 'db', zeros(3,1), 'Ka2', zeros(3,1));\n"
      "imuerr.web = {};\nimuerr.wdb = {};\nimuerr.sqg = {};\nimuerr.taug = {};\nimuerr.sqa = {};\n"
      "imuerr.taua = {};\n",
      column(of_each_axis(c.gyros, &AxisNoise::white)), column(of_each_axis(c.accelerometers, &AxisNoise::white)),
      column(walks(c.gyros)), real(time), column(walks(c.accelerometers)), real(time));
}

/// w = Kg w_m - gSens f_m - eb: gSens multiplies the raw specific force, so that eb takes up its bias.
std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  const Matrix3 ka = inverse(c.accelerometers.response), kg = inverse(c.gyros.response);
  const Matrix3 sensitivity = kg * c.gyros.by_force * ka;
  const Vector3 db = ka * c.accelerometers.bias, eb = kg * c.gyros.bias - sensitivity * c.accelerometers.bias;
  std::string text = commented(header, "%");
  if (c.accelerometers.calibrated || c.gyros.calibrated)
    text += fmt::format(
        "clbt.sf = [1; 1; 1; 1; 1; 1];\nclbt.Kg = {};\nclbt.eb = {};\nclbt.Ka = {};\nclbt.db = {};\n"
        "clbt.gSens = {};\n",
        writing::matlab(kg), column(eb), writing::matlab(ka), column(db), writing::matlab(sensitivity));
  if (c.accelerometers.has_noise() || c.gyros.has_noise()) text += noise(c, settings.number("correlation_time"));
  return text;
}

}  // namespace

extern const Export psins{
    .name = "psins",
    .summary = "PSINS: clbt for imuclbt, and imuerr with the noise for imuadderr",
    .formula =
        "w = Kg w_m - gSens f_m - eb, f = Ka f_m - db: biases are subtracted after the matrices, gSens multiplies "
        "the raw specific force; web, wdb = N, sqg, sqa = K",
    .units = "rad/s, m/s^2 (PSINS multiplies by the sampling interval); densities in SI",
    .frame = "axes of the calibration",
    .source = "psins.org.cn: imuclbt.m, imuadderr.m",
    .comment = "%",
    .extension = ".m",
    .carries = carries,
    .estimates = no_terms,
    .takes_counts = true,
    .options = options,
    .write = write};

}  // namespace tumble::exports::psins
