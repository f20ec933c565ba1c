#pragma once

#include <complex>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/methods/frequency_response/data.hpp"

namespace tumble::frequency_response {

/// The response at one frequency: output over reference.
struct Point {
  double frequency = 0.0;         ///< [Hz] as found
  double nominal = 0.0;           ///< [Hz] by the plan, else as found, to three digits: names the parameters
  std::complex<double> response;  ///< corrected for windows, increments and clock
  double output_gain_variance = 0.0, output_phase_variance = 0.0, output_dof = 1.0;           ///< of ln H
  double reference_gain_variance = 0.0, reference_phase_variance = 0.0, reference_dof = 1.0;  ///< of ln H
  /// Scatter of ln H between repeats of a measurement, beyond their noise.
  double scatter_gain_variance = 0.0, scatter_phase_variance = 0.0, scatter_gain_dof = 1.0, scatter_phase_dof = 1.0;
  double counting_variance = 0.0;  ///< of ln gain and phase, see vibration::rounding_log_variance
  double coherence = 0.0;
  double amplitude = 0.0;            ///< of the reference [SI]
  double cycles = 0.0;               ///< in the samples used; 0: from a sweep
  double distortion = std::nan("");  ///< harmonics 2 and 3 of the output over its fundamental
  double aliased_to = 0.0;           ///< [Hz], 0: not aliased
  std::string where;
};

struct Points {
  std::vector<Point> usable;  ///< by frequency
  Findings findings;
};

/// Every tone and sweep of the data. Parts that cannot be used become findings.
Points points_of(const Data& data, const Settings& settings, const Progress& progress);

/// One tone from `begin` to `end` [s] of a part, or a finding.
void add_tone(const Part& part, double begin, double end, const Scaling& scaling, const Settings& settings,
              Points& points);
/// One sweep.
void add_sweep(const Part& part, const Scaling& scaling, const Settings& settings, Points& points);

/// Why output and reference cannot be measured at this frequency [Hz]; none: they can. `span` [s] measured, `where` the
/// place of the finding.
std::optional<Finding> objection(double frequency, double span, double output_rate, const Scaling& scaling,
                                 const Settings& settings, const std::string& where);

/// A ratio [output per input] without the effect of sampling at this frequency [Hz]: windows, increments, derivative.
std::complex<double> corrected(std::complex<double> ratio, double frequency, const Scaling& scaling);

}  // namespace tumble::frequency_response
