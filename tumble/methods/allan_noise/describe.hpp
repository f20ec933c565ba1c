#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/core/estimate.hpp"
#include "tumble/math/noise/noise_likelihood.hpp"
#include "tumble/math/spectrum/power_spectrum.hpp"
#include "tumble/math/stability/allan.hpp"
#include "tumble/math/stability/allan_family.hpp"
#include "tumble/math/stability/dynamic_stability.hpp"
#include "tumble/math/stability/every_tau.hpp"
#include "tumble/methods/allan_noise/words.hpp"
#include "tumble/reduce/even_signal.hpp"

namespace tumble::allan_noise {

/// Length of record that a term needs.
struct LengthAdvice {
  std::string term, now, wanted;
  double seconds = 0.0;
};

/// A sine that was fitted and subtracted.
struct FittedLine {
  double frequency = 0.0, frequency_sd = 0.0;  ///< [cycles a sample]
  double amplitude = 0.0, amplitude_sd = 0.0;  ///< [u]
  double unsteadiness = 0.0;  ///< how far parts of the record depart from it over the amplitude; 0: not beyond noise
};

/// Samples that are far from those beside them: begin <= i < end.
struct Outlier {
  std::size_t begin = 0, end = 0, worst = 0;  ///< number of the sample
  std::size_t samples = 0;                    ///< values that are far
  double departure = 0.0;                     ///< of the worst from its neighbours [u]
  double deviations = 0.0;                    ///< the same over what is usual [1]
  bool broad = false;                         ///< a mean over 16 samples and more is far

  template <class State>
  void pass(State& state) {
    state(begin, end, worst, samples, departure, deviations, broad);
  }
};

/// An exponential that dies away from the begin of the record, fitted beside the noise and subtracted.
struct WarmUp {
  double size = 0.0, size_sd = 0.0;            ///< [u] at the begin
  double time = 0.0;                           ///< [s] time constant
  double chance = 1.0;                         ///< probability of so much in noise alone
  double walk_with = 0.0, walk_without = 0.0;  ///< [SI] random walk with it in the record, and without; 0: not shown
};

/// One measure of stability of a channel.
struct FamilyCurve {
  Stability measure;
  std::vector<DeviationPoint> points;
};

/// How a channel follows the temperature of its recording.
struct TemperatureEffect {
  double range = 0.0;                      ///< [K] of the averages
  double slope = 0.0, slope_sd = 0.0;      ///< [u/K]
  double of_rate = 0.0, of_rate_sd = 0.0;  ///< [u s/K] by the rate of change of the temperature; 0: not tried
  double explained = 0.0;                  ///< share of the variance of the averages
  double average = 0.0;                    ///< [s] averaged over
  double chance = 1.0;                     ///< probability of so much of both without an effect
};

/// Result for one channel.
struct ChannelNoise {
  std::string label;
  QuantityKind kind = QuantityKind::angular_rate;
  double rate = 0.0;  ///< [Hz]
  std::size_t samples = 0;
  double confidence = 0.95;  ///< of the band
  std::vector<DeviationPoint> curve;
  bool likelihood = true;  ///< which estimator gave the fit
  NoiseFit fit;
  std::optional<PowerSpectrum> spectrum;
  std::optional<EveryTau> every, every_hadamard;
  std::vector<FamilyCurve> family;
  std::optional<DynamicStability> windows;
  double begin = 0.0;  ///< [s] time of the first sample
  std::vector<LengthAdvice> advice;
  std::vector<FittedLine> lines;
  std::vector<WarmUp> warm_ups;
  std::optional<TemperatureEffect> temperature;  ///< where a thermometer beside it moved
  std::string thermometer;                       ///< its name
  std::vector<double> course_variance;           ///< [u^2] for each point of the curve, of courses that were subtracted
  std::vector<RecordPart> set_aside;             ///< samples that are treated as missing
  std::vector<Outlier> outliers;
  std::vector<RecordPart> knocks_set_aside;  ///< of set_aside, those that are as short as knocks
  std::optional<NoiseFit> robust;            ///< of the record without its outliers, where it has some
  std::size_t robust_removed = 0;            ///< samples that this does not count
  Findings findings;
  Sentence failure;  ///< why there is no fit; empty: there is one
};

/// Allan variance [u^2] that a term of the fit gives at an averaging factor [samples].
double fitted_allan_variance(const NoiseFit& fit, const FittedTerm& term, double factor);

/// Parameters, covariance, budget, tables, curves and findings of all channels together.
/// wanted_sd: relative [1], of the advice on the length of record.
Estimate describe_noise(const std::vector<ChannelNoise>& channels, double wanted_sd);

}  // namespace tumble::allan_noise
