#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/core/finding.hpp"
#include "tumble/core/schedule.hpp"
#include "tumble/core/settings.hpp"

/// Parts that vibration tests of accelerometers share: units under test, read as the mean specific force over each
/// counting window, segment by segment of the schedule.
///
///   N_j/(K_1 H) = mean of a over window j                                                              (3.3), (3.8)
///
/// See Lu Hanjie, Liu Yabin, Zhou Qiang, dynamic test of linear accelerometers, 2019; docs/equations (3.3)-(3.15).
namespace tumble::vibration {

/// One accelerometer on the fixture.
struct UnitUnderTest {
  /// "S2" of a channel S2 or S2.accelerometer; of "accelerometer" with others beside it the plan's serial.
  std::string name;
  std::string prefix;              ///< of its parameters: "S1."; empty where it is the only one
  std::string channel;             ///< as recorded
  double force_per_value = 1.0;    ///< specific force [m/s^2] for one SI unit of the channel, over one window
  double pulse = 0.0;              ///< [m/s] velocity of one pulse, 1/K_1; 0: not counted
  double scale_relative_sd = 0.0;  ///< of force_per_value
  bool scale_from_rest = false;    ///< K_1 comes from the segments at rest
};

/// Specific force that a unit shows at rest, where it differs from that of the plan's rig by more than the stated
/// uncertainties allow.
struct RestDeparture {
  std::size_t unit = 0;       ///< index in Data::units
  double shown = 0.0;         ///< [m/s^2]; with the axis both ways half of the difference
  double planned = 0.0;       ///< [m/s^2] alike
  double uncertainty = 0.0;   ///< [m/s^2] of shown less planned: scale factor, bias, direction of the axis
  bool without_bias = false;  ///< the axis stood both ways: no bias is in `shown`
  double ratio() const { return shown / planned; }  ///< [1]
};

/// One unit over one segment of the schedule, after the settling time.
struct Series {
  std::size_t unit = 0;       ///< index in Data::units
  std::size_t recording = 0;  ///< index in Evidence::recordings
  int run = 1;
  std::size_t power_up = 0;        ///< series of one power-up share it, whichever recordings hold them
  double planned_begin = 0.0;      ///< [s] of the segment, since the power-up began
  std::string label;               ///< of the segment
  Motion shake;                    ///< as commanded; hold: at rest
  double window = 0.0;             ///< H [s], mean
  double averaging = 0.0;          ///< [s] over which a sample is the mean: H, or 0 where units are read as instants
  double interval = 0.0;           ///< [s] from one window to the next
  double begin = 0.0;              ///< [s] beginning of the first window, on a clock common to the power-up
  double end = 0.0;                ///< [s] end of the last
  std::vector<double> time = {};   ///< [s] middle of each window
  std::vector<double> force = {};  ///< [m/s^2] mean over each window; NaN: missing
  /// [m/s^2] of the reference, without gravity, over the same windows (see Data::reference_integrated); empty: none.
  std::vector<double> reference = {};
  double rest = 0.0;  ///< a_0 [m/s^2]: along the input axis with the shaker at rest, by the plan's rig

  bool at_rest() const { return shake.kind == Motion::Kind::hold; }
  double middle() const { return 0.5 * (begin + end); }  ///< [s]
};

struct Data {
  std::vector<UnitUnderTest> units;
  std::vector<Series> series;         ///< by unit, then power-up, then time
  bool reference_integrated = false;  ///< false: the reference is read as an instant in the middle of each window
  std::optional<double> range;        ///< [m/s^2] of the units
  std::vector<RestDeparture> departures;
  Findings findings;
};

/// Options that every vibration test has.
std::vector<Option> options();

/// Units, windows and reference of all recordings, with faults of the windows as findings: counters that overflowed
/// (unwrapped where that is unambiguous), missing windows, counts of several windows in one after a gap, gate times
/// that scatter (each count divided by its own H), units that give a constant, a missing reference.
///
/// Throws Error::bad_input, bad_data that list everything that is missing or impossible: no recording, no unit, a scale
/// factor that neither the settings nor segments at rest give, counters that overflowed beyond repair.
Data data_of(const Evidence& evidence);

/// A mean as a sum of weights times the means of segments at rest.
struct AtRest {
  struct Part {
    std::size_t series = 0;  ///< index in Data::series
    double weight = 0.0;
  };
  std::vector<Part> parts;  ///< one or two; none: no segment at rest in that run
  bool both_sides = false;  ///< at rest before and after: drift is interpolated
};

/// Whether the fixture stands alike in both: their rests differ by 1 mg at most, or one of them is not known.
bool is_same_rest(const Series& a, const Series& b);

/// Output of the unit in the middle of `series` if the shaker were at rest: its segments at rest before and after, in
/// one power-up, interpolated linearly in time.
AtRest at_rest(const Data& data, const Series& series);

/// Findings of the rests about the scale factors: one for each of Data::departures. With the axis both ways the scale
/// factor is wrong, else a tone decides: a wrong scale factor raises gain and rest alike, a bias the rest alone. The
/// finding is an error where it is the scale factor or the sign; it names the parameters.
///
/// Given     log_gain     ln of the gain [1] of each unit where its loop does not act; NaN: not known
///           uncertainty  of it [1], of each unit
///           estimate     with its parameters: each finding concerns those that rest on the scale factor of its unit
void report_departures(const Data& data, const std::vector<double>& log_gain, const std::vector<double>& uncertainty,
                       Estimate& estimate);

/// Motion across over that along the shake [1], where no rig states it: a fixture of good quality.
constexpr double usual_cross_motion = 0.02;

/// Values that lie far off a smooth fit: lost or added pulses, knocks.
struct Outliers {
  std::vector<std::size_t> index;  ///< of the residuals
  double sum = 0.0;                ///< of these residuals [u]
};

/// Specific force [g] along the input axis, from which on a rest shows the scale factor rather than the bias.
constexpr double along_input = 0.2;

/// One window in so many may be an outlier: where there are more, the values are of another shape.
constexpr std::size_t windows_of_outlier = 20;

/// Residuals beyond six of their robust standard deviations (1.4826 times the median of |r|, and at least `least`):
/// two of a thousand million normal numbers are. Where more than one in twenty is beyond, the residuals are of another
/// shape, and none is an outlier.
/// Given: residual [u], NaN where missing; least [u], the spread by rounding.
Outliers outliers_of(const std::vector<double>& residual, double least);

/// sd [m/s^2] of the values of a series by rounding: to whole pulses, or to the least step of the values where nothing
/// is counted. Given: pulse [m/s].
double rounding_sd(const Series& series, double pulse);

/// Adds windows that the method skips as outliers to the finding of their unit, or such a finding.
void add_outliers(const Data& data, const Series& series, const Outliers& outliers, Findings& findings);

/// Mean of a series and its uncertainty.
struct Mean {
  double value = 0.0;     ///< [m/s^2]
  double variance = 0.0;  ///< of the mean: of white noise by means over blocks, and of the rounding to pulses
  double degrees_of_freedom = 1.0;
  std::size_t windows = 0;
};

/// Plain mean over the windows. The rounding to pulses adds up to one pulse at most however long the series, so that
/// its variance is 1/6 pulse^2 over the time squared (3.14); the variance of everything else comes from means over 16
/// blocks, with the rounding of these subtracted. Given: pulse [m/s].
Mean mean_of(const Series& series, double pulse);

/// Root mean square of values [u] about their mean [u]; missing values (NaN) do not count.
double spread(const std::vector<double>& values);

/// sin(pi x)/(pi x) [1]
double sinc(double x);

/// A frequency [Hz] to three digits, for names of parameters.
double three_digits(double frequency);

/// Part [1] of the windows of a tone, within which its rounding must repeat to be a line: four times then.
constexpr double raster_within = 0.25;

/// How far [Hz] a frequency is moved to be clear of another: 0.3 %, or three lines of a record of `span` [s].
inline double next_frequency(double frequency, double span) { return std::max(0.003 * frequency, 3.0 / span); }

/// Windows after which tone and total count meet the windows at equal phases again, to less than one spacing of the
/// phases and to less than one pulse over all `samples`; `samples` where they do not. Given and returned: [1].
double raster(double cycles_per_window, double pulses_per_window, double samples);

/// Variance [1] of ln amplitude by the rounding of counts that repeat with the tone, (3.14): the rounding of the
/// running total, 1/12 pulse^2, differenced, is 4 sin^2(pi f H) of it at f. Over a raster of P windows, after which
/// tone and total repeat, only P of them are independent: 2/P of that on the square of the amplitude. Where tone and
/// total do not repeat, rounding is noise and part of the residuals: 0.
///
/// Given: amplitude [pulse] of the counts of one window; the others [1], see `raster`.
double rounding_log_variance(double amplitude, double cycles_per_window, double pulses_per_window, double samples);

/// Place of a finding: the label of the segment, after the name of the unit where there are several.
std::string place_of(const Data& data, const Series& series);

/// Whether two findings have one code and equal values (numbers to 1e-5, relative), at any place.
bool same_matter(const Finding& a, const Finding& b);

/// Adds a finding unless there is one of the same matter at the same place.
void add_once(Finding finding, Findings& findings);

}  // namespace tumble::vibration
