#include <fmt/format.h>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/factor.hpp"
#include "tumble/exchange/exports/writing/text.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::exports::openvins {
namespace {

using namespace writing;

std::vector<std::string> carries() {
  auto names = terms_ending({"scale_factor", "misalignment"});
  names.emplace_back("gyro_acceleration_sensitivity");
  return names;
}

std::vector<Option> options() {
  return {rate_option("rate of the samples"), text("rostopic").otherwise("/imu0").says("topic of the IMU"),
          word("model", {"kalibr", "rpng"})
              .otherwise("kalibr")
              .says("triangles of the intrinsics: lower with the accelerometers as the frame (kalibr), or upper with "
                    "the gyros as the frame (rpng)")};
}

struct Intrinsics {
  Matrix3 body_rotation;  ///< axes of the file from those of the calibration
  Matrix3 tw, gyro_rotation, ta, accelerometer_rotation, tg;
};

Intrinsics intrinsics(const ImuCalibration& c, bool rpng) {
  Intrinsics out;
  out.gyro_rotation = out.accelerometer_rotation = identity3();
  if (rpng) {
    const Factored rate = upper_factor(c.gyros.response, "gyros");
    const Factored force = upper_factor(c.accelerometers.response * transposed(rate.rotation), "accelerometers");
    out.body_rotation = rate.rotation, out.tw = rate.triangle;
    out.ta = force.triangle, out.accelerometer_rotation = force.rotation;
  } else {
    const Factored force = lower_factor(c.accelerometers.response, "accelerometers");
    const Factored rate = lower_factor(c.gyros.response * transposed(force.rotation), "gyros");
    out.body_rotation = force.rotation, out.ta = force.triangle;
    out.tw = rate.triangle, out.gyro_rotation = rate.rotation;
  }
  out.tg = c.gyros.by_force * transposed(out.body_rotation);  // of the force in the axes of the file: not Kalibr's A
  return out;
}

std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  const Noises n = noises_of(c, settings, "openvins", {.walks = true, .rate = true});
  const Intrinsics m = intrinsics(c, settings.word("model") == "rpng");
  return "%YAML:1.0\n\n" + commented(header, "#") +
         fmt::format("# rotation from the axes of the calibration to those of this file (T_i_b): {:.6g} deg\n",
                     angle_of(m.body_rotation) / degree) +
         "# Tg multiplies the specific force in the axes of this file; Kalibr's A multiplies it in those of the "
         "gyros\n" +
         "imu0:\n  T_i_b:\n" + yaml_transform(m.body_rotation, "    ") +
         fmt::format(
             "  accelerometer_noise_density: {}\n  accelerometer_random_walk: {}\n  gyroscope_noise_density: {}\n"
             "  gyroscope_random_walk: {}\n  rostopic: {}\n  time_offset: 0.0\n  update_rate: {}\n  model: \"{}\"\n",
             real(n.accelerometer.white), real(n.accelerometer.walk), real(n.gyro.white), real(n.gyro.walk),
             topic_of(settings), real(n.rate), settings.word("model")) +
         "  Tw:\n" + yaml_rows(m.tw, "    ") + "  R_IMUtoGYRO:\n" + yaml_rows(m.gyro_rotation, "    ") + "  Ta:\n" +
         yaml_rows(m.ta, "    ") + "  R_IMUtoACC:\n" + yaml_rows(m.accelerometer_rotation, "    ") + "  Tg:\n" +
         yaml_rows(m.tg, "    ");
}

}  // namespace

extern const Export openvins{
    .name = "openvins",
    .summary = "OpenVINS: kalibr_imu_chain.yaml with noise and intrinsics",
    .formula =
        "a = R_IMUtoACC' inv(Ta) (a_m - b_a); w = R_IMUtoGYRO' inv(Tw) (w_m - b_g - Tg a); the discrete noise is "
        "density^2/dt, that of the walk density^2 dt",
    .units = "rad/s, m/s^2; densities per sqrt(Hz), two-sided",
    .frame =
        "axes of this file, which T_i_b turns those of the calibration into; rotate the extrinsics of the cameras "
        "by it as well",
    .source = "github.com/rpng/open_vins: ov_msckf/src/core/VioManagerOptions.h, state/Propagator.cpp, state/State.h",
    .comment = "#",
    .extension = ".yaml",
    .carries = carries,
    .estimates = estimated_biases,
    .takes_counts = false,
    .options = options,
    .write = write};

}  // namespace tumble::exports::openvins
