#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::exports::navego {
namespace {

using namespace writing;

std::vector<Option> options() { return {rate_option("rate of the samples (freq)")}; }

/// Dynamic bias and its correlation time: a Gauss-Markov process where the result has one on every axis, else K with an
/// infinite time, for which NaveGo takes the number as the density itself.
struct DynamicBias {
  Vector3 size;  ///< [u], or [u/sqrt(s)] where the time is infinite
  Vector3 time;  ///< [s]
};

DynamicBias dynamic_bias(const TriadCalibration& t, double walk) {
  DynamicBias out;
  bool markov = true;
  for (const auto& axis : t.noise) markov = markov && axis.markov_time > 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const AxisNoise& axis = t.noise[i];
    out.size[i] = markov ? axis.markov_sd : std::isnan(axis.walk) ? walk : axis.walk;
    out.time[i] = markov ? axis.markov_time : std::numeric_limits<double>::infinity();
  }
  return out;
}

std::string times(Vector3 v) { return std::isinf(v.x) ? "[Inf, Inf, Inf]" : writing::matlab(v); }

std::string write(const ImuCalibration& c, const Settings& settings, const std::vector<std::string>& header) {
  const Noises n = noises_of(c, settings, "navego", {.rate = true});
  const double walk_g = std::isnan(n.gyro.walk) ? 0.0 : n.gyro.walk,
               walk_a = std::isnan(n.accelerometer.walk) ? 0.0 : n.accelerometer.walk;
  const DynamicBias gyro = dynamic_bias(c.gyros, walk_g), force = dynamic_bias(c.accelerometers, walk_a);
  const double per_root_hour = 60.0, milli_g = 1e-3 * standard_gravity;
  std::string text = commented(header, "%");
  const auto line = [&](const char* name, const std::string& value, const char* unit) {
    text += fmt::format("imu.{} = {};   % {}\n", name, value, unit);
  };
  using writing::matlab;
  line("arw", matlab(per_root_hour * degrees_per_radian * of_each_axis(c.gyros, &AxisNoise::white, n.gyro.white)),
       "deg/root(hour)");
  line("vrw", matlab(per_root_hour * of_each_axis(c.accelerometers, &AxisNoise::white, n.accelerometer.white)),
       "m/s/root(hour)");
  line("arrw", matlab(per_root_hour * degrees_per_radian * of_each_axis(c.gyros, &AxisNoise::walk, walk_g)),
       "K: deg/root(hour)/s, which NaveGo divides by 60");
  line("vrrw", matlab(per_root_hour * of_each_axis(c.accelerometers, &AxisNoise::walk, walk_a)),
       "K: m/s/root(hour)/s, which NaveGo divides by 60");
  line("gb_sta", "[0.0, 0.0, 0.0]", "deg/s, of compensated gyros");
  line("ab_sta", "[0.0, 0.0, 0.0]", "mg, of compensated accelerometers");
  line("gb_dyn", matlab(degrees_per_radian * gyro.size), "deg/s; with gb_corr = Inf the density of the walk");
  line("ab_dyn", matlab(force.size / milli_g), "mg; with ab_corr = Inf the density of the walk");
  line("gb_corr", times(gyro.time), "s");
  line("ab_corr", times(force.time), "s");
  line("freq", real(n.rate), "Hz");
  return text;
}

}  // namespace

extern const Export navego{
    .name = "navego",
    .summary = "NaveGo: struct imu with the noise, for imu_si_errors",
    .formula =
        "N = arw/60 and vrw/60, K = arrw/60 and vrrw/60; the filter's density of the bias is gb_dyn/sqrt(gb_corr), "
        "or gb_dyn where gb_corr = Inf",
    .units = "deg, mg, root(hour), as each line says",
    .frame = "axes of the calibration",
    .source = "github.com/rodralez/NaveGo: conversions/imu_si_errors.m",
    .comment = "%",
    .extension = ".m",
    .carries = no_terms,
    .estimates = estimated_biases,
    .takes_counts = false,
    .options = options,
    .write = write};

}  // namespace tumble::exports::navego
