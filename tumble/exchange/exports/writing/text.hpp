#pragma once

#include <string>
#include <vector>

#include "tumble/core/settings.hpp"
#include "tumble/exchange/calibration.hpp"

/// Numbers and blocks of text as the files of consumers have them.
namespace tumble::writing {

/// The shortest decimal that is this double [u], always with a point, for YAML 1.1 reads 1e-05 as a word: "1.0e-05".
std::string real(double value);
/// The shortest decimal that is the float nearest to a value [u], with a point. Throws Error::bad_input beyond floats.
std::string real_of_float(double value);

/// Each line after `comment` and a blank.
std::string commented(const std::vector<std::string>& lines, const std::string& comment);

/// "[a, b, c]"
std::string row(Vector3 v);
/// "[a, b, c; d, e, f; g, h, i]" as MATLAB reads it.
std::string matlab(const Matrix3& m);
std::string matlab(Vector3 v);
/// Three lines "<indent>- [ a, b, c ]".
std::string yaml_rows(const Matrix3& m, const std::string& indent);
/// Four lines of the transform with this rotation and no translation.
std::string yaml_transform(const Matrix3& rotation, const std::string& indent);

/// One number for three axes.
struct OneNoise {
  double white = AxisNoise::none;  ///< N [u sqrt(s)]
  double walk = AxisNoise::none;   ///< K [u/sqrt(s)]
};
/// Root mean square or greatest of the axes that were measured, as the setting `axes` says. NaN where no axis has it.
/// Axes that state no value are not part of it; the header of the file names them.
OneNoise one_noise(const TriadCalibration& triad, const Settings& settings);

/// Parts of the noise that a consumer wants in addition to N of both triads.
struct NoiseNeeds {
  bool walks = false;  ///< K of both triads
  bool rate = false;   ///< of the samples
};
struct Noises {
  OneNoise gyro, accelerometer;
  double rate = AxisNoise::none;  ///< [Hz]: the option `rate`, else that of the records of the noise
};
/// Noise for a consumer. Each needed part must be there and above 0. Throws Error::bad_input with all that is missing
/// and how to give it.
Noises noises_of(const ImuCalibration& calibration, const Settings& settings, const char* consumer, NoiseNeeds needs);

/// Throws Error::bad_input where the results hold noise alone, which the file of this consumer does not state.
void require_calibration(const ImuCalibration& calibration, const char* consumer);

/// One value [its unit] of each axis; `otherwise` where an axis does not state it.
Vector3 of_each_axis(const TriadCalibration& triad, double AxisNoise::*value, double otherwise = 0.0);

/// The option `rate` without a default.
Option rate_option(const char* description);

/// The setting `rostopic`. Throws Error::bad_input where it is not the name of a topic.
std::string topic_of(const Settings& settings);

/// Names of terms: those of both triads with these endings.
std::vector<std::string> terms_ending(const std::vector<std::string>& endings);
/// The biases and their change with temperature, which estimators follow.
std::vector<std::string> estimated_biases();
std::vector<std::string> no_terms();

}  // namespace tumble::writing
