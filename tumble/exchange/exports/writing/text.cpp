#include "tumble/exchange/exports/writing/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "tumble/units/error.hpp"

namespace tumble::writing {
namespace {

std::string with_point(std::string text) {
  if (text.find('.') != std::string::npos || text.find("inf") != std::string::npos) return text;
  const auto exponent = text.find('e');
  return exponent == std::string::npos ? text + ".0" : text.insert(exponent, ".0");
}

/// Of the axes that state this value: one that states none is not known to have none. NaN: no axis states it.
double of_axes(const TriadCalibration& triad, double AxisNoise::*value, bool greatest) {
  double squares = 0.0, most = 0.0, stated = 0.0;
  for (const AxisNoise& axis : triad.noise) {
    const double one = axis.*value;
    if (std::isnan(one)) continue;
    stated += 1.0;
    squares += one * one;
    most = std::max(most, one);
  }
  if (stated == 0.0) return AxisNoise::none;
  return greatest ? most : std::sqrt(squares / stated);
}

/// What to do about a noise that is missing.
void add_missing(const TriadCalibration& triad, double found, double AxisNoise::*value, const char* option,
                 const char* unit, const char* consumer, Problems& problems) {
  if (found > 0.0) return;
  const bool walk = value == &AxisNoise::walk;
  const Sentence needs = say("{} needs {}: add a result of allan_noise, or --set {}=\"... {}\"", Name{consumer},
                             walk ? "a random walk K of the bias" : "a white noise N", Name{option}, Name{unit});
  double limit = 0.0;
  for (const auto& axis : triad.noise)
    if (!std::isnan(axis.walk_limit)) limit = std::max(limit, axis.walk_limit);
  if (walk && limit > 0.0)
    problems.push_back(say("{}; the result shows none and says that it is below {:.3g} {} (95 %)", needs,
                           Unit::parse(unit).difference_from_si(limit), Name{unit}));
  else
    problems.push_back(needs);
}

}  // namespace

std::string real(double value) { return with_point(fmt::format("{}", value)); }

std::string real_of_float(double value) {
  if (std::abs(value) > std::numeric_limits<float>::max())
    throw Error(Error::Kind::bad_input, say("{:.3g} is beyond the largest number of 32 bits, {:.3g}", value,
                                            std::numeric_limits<float>::max()));
  return with_point(fmt::format("{}", static_cast<float>(value)));
}

std::string commented(const std::vector<std::string>& lines, const std::string& comment) {
  std::string text;
  for (const auto& line : lines) text += comment + " " + line + "\n";
  return text;
}

std::string row(Vector3 v) { return fmt::format("[{}, {}, {}]", real(v.x), real(v.y), real(v.z)); }

std::string matlab(Vector3 v) { return row(v); }

std::string matlab(const Matrix3& m) {
  std::string text = "[";
  for (std::size_t i = 0; i < 3; ++i)
    text += fmt::format("{}{}, {}, {}", i == 0 ? "" : "; ", real(m(i, 0)), real(m(i, 1)), real(m(i, 2)));
  return text + "]";
}

std::string yaml_rows(const Matrix3& m, const std::string& indent) {
  std::string text;
  for (std::size_t i = 0; i < 3; ++i)
    text += fmt::format("{}- [ {}, {}, {} ]\n", indent, real(m(i, 0)), real(m(i, 1)), real(m(i, 2)));
  return text;
}

std::string yaml_transform(const Matrix3& rotation, const std::string& indent) {
  std::string text;
  for (std::size_t i = 0; i < 3; ++i)
    text += fmt::format("{}- [ {}, {}, {}, 0.0 ]\n", indent, real(rotation(i, 0)), real(rotation(i, 1)),
                        real(rotation(i, 2)));
  return text + indent + "- [ 0.0, 0.0, 0.0, 1.0 ]\n";
}

OneNoise one_noise(const TriadCalibration& triad, const Settings& settings) {
  const bool greatest = settings.word("axes") == "max";
  return {of_axes(triad, &AxisNoise::white, greatest), of_axes(triad, &AxisNoise::walk, greatest)};
}

namespace {

/// [Hz] of the records of all axes whose noise is known; NaN where one is not known, or they differ.
double rate_of_records(const ImuCalibration& calibration) {
  double common = AxisNoise::none;
  for (const TriadCalibration* triad : {&calibration.gyros, &calibration.accelerometers})
    for (const AxisNoise& axis : triad->noise) {
      if (std::isnan(axis.white)) continue;
      if (std::isnan(common)) common = axis.rate;
      if (!(std::abs(axis.rate - common) < 0.01 * common)) return AxisNoise::none;
    }
  return common;
}

}  // namespace

Noises noises_of(const ImuCalibration& calibration, const Settings& settings, const char* consumer, NoiseNeeds needs) {
  Noises all{one_noise(calibration.gyros, settings), one_noise(calibration.accelerometers, settings)};
  Problems problems;
  const auto need = [&](bool gyro, double found, double AxisNoise::*value, const char* option, const char* unit) {
    add_missing(gyro ? calibration.gyros : calibration.accelerometers, found, value, option, unit, consumer, problems);
  };
  need(true, all.gyro.white, &AxisNoise::white, "gyro_white", "deg/sqrt(h)");
  need(false, all.accelerometer.white, &AxisNoise::white, "accelerometer_white", "(m/s)/sqrt(h)");
  if (needs.walks) {
    need(true, all.gyro.walk, &AxisNoise::walk, "gyro_walk", "deg/h/sqrt(h)");
    need(false, all.accelerometer.walk, &AxisNoise::walk, "accelerometer_walk", "ug/sqrt(h)");
  }
  if (needs.rate) {
    all.rate = settings.has("rate") ? settings.number("rate") : rate_of_records(calibration);
    if (!std::isfinite(all.rate)) problems.push_back(say("{} needs the rate of the samples: --set rate=200", consumer));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return all;
}

void require_calibration(const ImuCalibration& calibration, const char* consumer) {
  if (!calibration.accelerometers.calibrated && !calibration.gyros.calibrated)
    throw Error(Error::Kind::bad_input,
                say("{}: the results hold noise alone, of which this file makes no use", consumer));
}

Vector3 of_each_axis(const TriadCalibration& triad, double AxisNoise::*value, double otherwise) {
  Vector3 out;
  for (std::size_t i = 0; i < 3; ++i) out[i] = std::isnan(triad.noise[i].*value) ? otherwise : triad.noise[i].*value;
  return out;
}

Option rate_option(const char* description) { return quantity("rate", "Hz").above(0).bare().says(description); }

std::string topic_of(const Settings& settings) {
  const std::string& topic = settings.word("rostopic");
  const auto plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '/' || c == '_' || c == '~';
  };
  if (topic.empty() || !std::ranges::all_of(topic, plain))
    throw Error(Error::Kind::bad_input,
                say("rostopic = '{}': the name of a topic has letters, digits, / and _", topic));
  return topic;
}

std::vector<std::string> terms_ending(const std::vector<std::string>& endings) {
  std::vector<std::string> names;
  for (const auto& term : calibration_terms())
    if (std::ranges::any_of(endings, [&](const std::string& ending) {
          return std::string_view(term.name) == "gyro_" + ending ||
                 std::string_view(term.name) == "accelerometer_" + ending;
        }))
      names.emplace_back(term.name);
  return names;
}

std::vector<std::string> estimated_biases() { return terms_ending({"bias", "thermal_bias", "thermal_transient"}); }

std::vector<std::string> no_terms() { return {}; }

}  // namespace tumble::writing
