#include "tumble/reduce/imu/sensors.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/clocks/clock.hpp"
#include "tumble/reduce/accelerometer/output.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu {

double samples_per_second(const Channel& channel) {
  if (channel.timeline.uniform()) return channel.timeline.rate;
  const double rate = clock_of(channel).rate;
  return rate > 0.0 ? rate : mean_rate(channel);
}

std::string role_of(Kind kind, std::size_t axis) {
  return fmt::format("{}_{}", kind == Kind::gyro ? "gyro" : "accelerometer", letters[axis]);
}

Reading reading_of(Kind kind, const Settings& settings, const Channel& channel) {
  const auto pulses_of = [&](const char* option, const char* unit) {
    if (!settings.has(option) || settings.word(option).empty())
      throw Error(Error::Kind::bad_input,
                  say("channel '{}' is in {}: [settings] {} must give the reference scale factor in {}", channel.name,
                      Name{channel.unit.text()}, option, unit));
    const double scale = parse_si(settings.word(option), Unit::parse(unit));
    if (!(std::abs(scale) > 0.0)) throw Error(Error::Kind::bad_input, say("[settings] {} must not be zero", option));
    return scale;
  };
  const auto is = [&](const char* unit) { return channel.unit.dimension() == Unit::parse(unit).dimension(); };
  if (kind == Kind::accelerometer) {
    if (is("m/s")) return {samples_per_second(channel), 0.0};
    const auto output = accelerometer::output_of(channel);
    if (output.scale_factor == Unit()) return {};
    const double scale = pulses_of("accelerometer_scale_factor", output.scale_factor.text().c_str());
    return {output.per_second / scale, output.pulses ? 1.0 / std::abs(scale) : 0.0};
  }
  if (is("deg/s")) return {};
  if (is("deg")) return {samples_per_second(channel), 0.0};
  if (!is("pulse"))
    throw Error(Error::Kind::bad_data, say("channel '{}' is in {}: a gyro's output must be an angular rate, an "
                                           "angle gained in each sample, or pulses",
                                           channel.name, Name{channel.unit.text()}));
  const double scale = pulses_of("gyro_scale_factor", "pulse/arcsec");
  return {samples_per_second(channel) / scale, 1.0 / std::abs(scale)};
}

std::vector<Option> scale_factor_options() {
  return {
      text("accelerometer_scale_factor").says("reference scale factor K_m of all accelerometers, \"2000 pulse/s/g\""),
      text("gyro_scale_factor").says("reference scale factor K_m of all gyros, \"2 pulse/arcsec\"")};
}

}  // namespace tumble::imu
