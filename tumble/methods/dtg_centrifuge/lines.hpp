#pragma once

#include <array>
#include <complex>
#include <vector>

#include "tumble/core/finding.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/methods/dtg_centrifuge/data.hpp"

/// The lines of the gyros at the table's angle and at the heading, by least squares, docs/equations (1.12).
namespace tumble::dtg_centrifuge {

using Complex = std::complex<double>;

/// Phasors of one signal: y = mean + drift + Re sum_h Z_h exp(i h theta) + Re E exp(i beta), theta = -table angle,
/// beta = arm angle + table angle. [SI]
struct Phasors {
  std::array<Complex, 3> line{};  ///< Z_1, Z_2, Z_3
  Complex earth;                  ///< E
};

struct Lines {
  Phasors value;
  double mean = 0.0;
  /// Phasors of parts of the time: their mean, weighted with the samples of each, is `value`, and their scatter is that
  /// of the noise near the lines.
  std::vector<Phasors> part;
  std::vector<double> weight;  ///< samples of each part; 0: none
  double samples = 0.0;        ///< used
  double lost = 0.0;           ///< missing
  double step = 0.0;           ///< [s] between samples
  double residual_sd = 0.0;    ///< [SI] of a sample
  bool present = false;
  Findings faults;  ///< why it cannot be used: clipped, constant
};

/// Lines of one level in one power-up.
struct Measured {
  const Spin* stretch = nullptr;
  std::array<Lines, most_signals> of;       ///< by Signal
  double arm_rate = 0.0, table_rate = 0.0;  ///< [rad/s] as turned
  double unsteady = 0.0;                    ///< greatest relative departure of a sixteenth's rate from the mean
  double weakest = 1.0;       ///< least eigenvalue of the design's correlations; 0: indistinguishable lines
  bool rates_visible = true;  ///< without encoders: a line shows them
  Findings faults;            ///< why the level cannot be used
  double theta_rate() const { return -table_rate; }           ///< [rad/s]
  double beta_rate() const { return arm_rate + table_rate; }  ///< [rad/s]
};

/// Response of the electronics to a line: averaging over a sample, docs/equations (1.15), capture loop, late clock.
struct Channelling {
  double averaging = -1.0;                              ///< [s]; below 0: one sampling interval
  double natural_frequency = 0.0, damping_ratio = 0.0;  ///< [rad/s], [1]; 0: no loop of second order
  double time_constant = 0.0;                           ///< [s] of a loop of first order
  double late = 0.0;                                    ///< [s] by which the stamps are late
  /// Factor by which a line at `rate` [rad/s] is shown.
  Complex gain(double rate, double step) const;
};

struct Instruments {
  std::array<Channelling, most_signals> of;
  bool encoders_in_middle = true;  ///< the angles are those of the middle of the interval that begins at the stamp
};

Instruments instruments_of(const Settings& settings);

Measured measure(const Test& test, const Spin& stretch, const Instruments& instruments);

/// Mean of a signal [SI] from `begin` to `end` [s]; NaN without samples.
double mean_of(const Channel& channel, double begin, double end);

}  // namespace tumble::dtg_centrifuge
