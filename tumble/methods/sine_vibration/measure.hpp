#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/finding.hpp"
#include "tumble/methods/sine_vibration/line.hpp"
#include "tumble/reduce/vibration/vibration.hpp"

namespace tumble::sine_vibration {

/// One unit at one frequency and level.
struct Point {
  std::size_t series = 0;  ///< index in Data::series
  std::size_t unit = 0;
  double nominal = 0.0;  ///< [Hz] as planned, to three digits: names the parameters
  Line line;             ///< of the means over windows [m/s^2]
  double window = 0.0;   ///< [s] over which a sample is the mean

  double level = 0.0;               ///< A_ref [m/s^2] of the motion itself
  double level_log_variance = 0.0;  ///< of ln level by the noise of the reference
  double level_degrees_of_freedom = 1.0;
  std::size_t motion = 0;   ///< tones of all units with the same number share their reference
  double distortion = 0.0;  ///< second harmonic of the reference over its fundamental; NaN: not known

  double gain = 0.0;                   ///< amplitude/(A_ref |sinc(fH)|)
  double rounding_log_variance = 0.0;  ///< of ln gain, see vibration::rounding_log_variance
  int hidden_harmonic = 0;             ///< of the shake, that appears at the frequency of the tone; 0: none
  double sd_from_window = 0.0;         ///< [m/s^2] by the window alone
  double aliased_to = 0.0;             ///< [Hz]; 0: not aliased
  double cycles_effect = 0.0;          ///< [m/s^2] plain mean less the mean of the fit
  double cycles_bound = 0.0;           ///< [m/s^2] A/(pi f T), of the motion (3.11)

  double shift = 0.0;       ///< [m/s^2] of the mean against the unit at rest; NaN: no segment at rest
  bool both_sides = false;  ///< at rest before and after
  vibration::Outliers skipped;
};

/// The unit at rest in one segment.
struct Rest {
  std::size_t series = 0;
  Line line;
  vibration::Outliers skipped;
};

struct Measured {
  std::vector<Point> points;  ///< by unit, then frequency, then level, then time
  std::vector<Rest> rests;    ///< as Data::series
  bool reference = false;     ///< levels are those of the reference that was recorded; else the plan's
  Findings findings;
};

/// Every tone of every unit. Tones that cannot be used are findings: on half of the sampling rate or a null of the
/// window, a unit that clips, a shaker that was off or at another frequency or level.
Measured measure(const vibration::Data& data);

/// Why windows cannot measure a tone of this frequency; none: they can.
///
/// Given: frequency [Hz]; window, interval, span [s] and where, see vibration::hidden_tone.
std::optional<Finding> objection(double frequency, double window, double interval, double span,
                                 const std::string& where);

/// The lowest harmonic, second or third, that windows at this interval show within two cycles over `span` [s] of the
/// tone itself: 3 at a quarter of their rate, for example. 0: none.
int hidden_harmonic(double frequency, double interval, double span);

/// sd of the window means that a sine of amplitude A gives by the window alone, with the rounding of its counts (3.8):
/// sqrt((A sinc(fH))^2/2 + q^2/6), q = pulse/H.
/// Given: amplitude [u]; frequency [Hz]; window H [s]; pulse [u s]. Returned: [u].
double sd_from_window(double amplitude, double frequency, double window, double pulse);

}  // namespace tumble::sine_vibration
