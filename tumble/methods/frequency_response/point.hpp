#pragma once

#include <complex>
#include <limits>
#include <string>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/methods/frequency_response/data.hpp"

namespace tumble::frequency_response {

/// The response at one frequency: output over reference.
struct Point {
  double frequency = 0.0;         ///< [Hz] as found
  double nominal = 0.0;           ///< [Hz] as the plan says, or as found to three digits: names the parameters
  std::complex<double> response;  ///< corrected for windows, increments and clock
  double output_gain_variance = 0.0, output_phase_variance = 0.0, output_dof = 1.0;           ///< of ln H
  double reference_gain_variance = 0.0, reference_phase_variance = 0.0, reference_dof = 1.0;  ///< of ln H
  double counting_variance = 0.0;  ///< of ln gain and phase: counts that repeat with the tone hide their rounding
  double coherence = 0.0;
  double amplitude = 0.0;            ///< of the reference [SI]
  double cycles = 0.0;               ///< in the samples used; 0: from a sweep
  double distortion = std::nan("");  ///< harmonics 2 and 3 of the output over its fundamental
  double aliased_to = 0.0;           ///< [Hz], 0: not aliased
  std::string where;
};

struct Points {
  std::vector<Point> found;
  Findings findings;
};

/// Every tone and sweep of the data. Parts that cannot be used become findings.
Points points_of(const Data& data, const Settings& settings, const Progress& progress);

/// One tone from `begin` to `end` [s] of a part, or a finding.
void add_tone(const Part& part, double begin, double end, const Scaling& scaling, const Settings& settings,
              Points& points);
/// One sweep.
void add_sweep(const Part& part, const Scaling& scaling, const Settings& settings, Points& points);

/// What is wrong with measuring at this frequency with these windows and rates; empty: nothing. `time` [s] measured.
std::string objection(double frequency, double time, double output_rate, const Scaling& scaling,
                      const Settings& settings);

/// sin(pi x)/(pi x) [1]
double sinc(double x);
/// A ratio [output per input] without what sampling did at this frequency [Hz]: windows, increments, derivative, clock.
/// `shift`: the phase of the windows is removed as well (not where the stamps were moved to the middle of the windows).
std::complex<double> corrected(std::complex<double> ratio, double frequency, const Scaling& scaling);

}  // namespace tumble::frequency_response
