#include <fmt/format.h>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/factor.hpp"
#include "tumble/exchange/exports/writing/text.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::exports::imu_tk {
namespace {

using namespace writing;

std::vector<std::string> carries() { return terms_ending({"bias", "scale_factor", "misalignment"}); }

std::vector<Option> options() {
  return {word("sensors", {"accelerometers", "gyros"})
              .otherwise("accelerometers")
              .says("triad of the file, for imu_tk has one file for each")};
}

std::string rows(const Matrix3& m) {
  std::string text;
  for (std::size_t i = 0; i < 3; ++i) text += fmt::format("{} {} {}\n", real(m(i, 0)), real(m(i, 1)), real(m(i, 2)));
  return text + "\n";
}

/// T K = Q inv(response) with a diagonal of ones in T; Q turns so that the T of the accelerometers is upper triangular.
std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  const bool gyros = settings.word("sensors") == "gyros";
  const TriadCalibration& t = gyros ? c.gyros : c.accelerometers;
  require_calibration(c, "imu_tk");
  if (!t.calibrated)
    throw Error(Error::Kind::bad_input,
                say("imu_tk: the results hold no calibration of the {}; --set sensors={}",
                    gyros ? "gyros" : "accelerometers", Name{gyros ? "accelerometers" : "gyros"}));
  const Matrix3 rotation = upper_factor(c.accelerometers.response, "accelerometers").rotation;
  Matrix3 product = rotation * inverse(t.response);
  if (!gyros) product(1, 0) = product(2, 0) = product(2, 1) = 0.0;  // rounding errors
  const Vector3 scale = diagonal_of(product);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) product(i, j) = i == j ? 1.0 : product(i, j) / scale[j];
  std::string text = rows(product) + rows(diagonal3(scale));
  for (std::size_t i = 0; i < 3; ++i) text += real(t.bias[i]) + "\n";
  return text + "\n" + commented(header, "#") +
         fmt::format("# {} of this file; rotation from the axes of the calibration to those of imu_tk: {:.6g} deg\n",
                     gyros ? "gyros" : "accelerometers", angle_of(rotation) / degree) +
         "# rotation " + matlab(rotation) + "\n";
}

}  // namespace

extern const Export imu_tk{
    .name = "imu_tk",
    .summary = "imu_tk: one .calib file for the accelerometers or the gyros",
    .formula =
        "X' = T K (X - B); T of the accelerometers upper triangular with ones, T of the gyros full with ones, K "
        "diagonal; the header follows the numbers, where imu_tk does not read",
    .units = "K turns the outputs into m/s^2 or rad/s; B in units of the outputs",
    .frame = "axes of imu_tk: the accelerometer z along z, y in the plane yz; the last line has the rotation",
    .source = "bitbucket.org/alberto_pretto/imu_tk: include/imu_tk/calibration.h",
    .comment = "#",
    .extension = ".calib",
    .carries = carries,
    .estimates = no_terms,
    .takes_counts = true,
    .options = options,
    .write = write};

}  // namespace tumble::exports::imu_tk
