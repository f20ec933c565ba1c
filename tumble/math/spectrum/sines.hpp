#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "tumble/math/noise/noise_bands.hpp"
#include "tumble/math/room.hpp"

namespace tumble {

/// Re[amplitude exp(2 pi i f (n - middle))] at sample n, `middle` that of the record.
struct Sine {
  double frequency = 0.0;               ///< [cycles a sample]
  std::complex<double> amplitude{0.0};  ///< [u]
};

/// Uncertainty and other properties of a fitted sine.
struct SineQuality {
  double level = 0.0;         ///< [u^2] variance of white noise of the density about it
  double amplitude_sd = 0.0;  ///< [u]
  double frequency_sd = 0.0;  ///< [cycles a sample]
  double power = 0.0;         ///< amplitude^2 over twice its variance: mean 1, exponential, where there is no sine
  double wander = 0.0;  ///< mean square of what parts of the record depart from it, over what noise makes: 1 if steady
  double unsteadiness = 0.0;  ///< root mean square of these departures over the amplitude
};

/// Sines of constant amplitude and frequency in a record, each fitted beside the others by least squares, and the
/// record without them. The ends of the record, and of gaps longer than a period, are tapered over four periods, so
/// that neither drift nor walk reaches a sine; beyond that the estimates are those of maximum likelihood.
///
///   Var A = 2 s sum w^2/(sum w)^2,   Var 2 pi f = 2 s sum w^2 t^2/(A sum w t^2)^2
///
/// with s the variance of white noise of the density at f: of long records 2 s/n and 24 s/(A^2 n^3), the bound.
///
/// See  D. C. Rife and R. R. Boorstyn, Single-tone parameter estimation from discrete-time observations, IEEE Trans.
///      Inf. Theory 20 (1974) 591; several, one after the other and again: J. Li and P. Stoica, Efficient
///      mixed-spectrum estimation with applications to target feature extraction, IEEE Trans. Signal Process. 44 (1996)
///      281
class Sines {
 public:
  /// Given: values of the record [u]; NaN: missing.
  explicit Sines(std::span<const double> values);

  /// Fits the strongest sine within `width` of `frequency` [cycles a sample] beside the others.
  void add(double frequency, double width);
  void remove(std::size_t which);
  /// Each again beside the others, until they stay.
  void refine();

  const std::vector<Sine>& all() const { return sines_; }
  std::span<const double> rest() const { return rest_; }  ///< the record without the sines [u]

  /// Given     level  [u^2] of a frequency, where too few frequencies about the sine are free to measure it: below
  ///                  about 20 periods in the record
  SineQuality quality(std::size_t which, const std::function<double(double)>& level) const;

  /// Gives back to the bands of rest() what the fits took of their noise: mean squares are brought to what they would
  /// be, counts to what is left.
  ///
  /// Given     expected  [u^2] mean squares of the bands; level  as above
  void give_back(const std::vector<double>& expected, const std::function<double(double)>& level,
                 NoiseBands& bands) const;

 private:
  struct Turning;
  struct Support {
    std::size_t begin = 0, end = 0;
    double taper = 0.0;  ///< [samples] at either end
    double weight(std::size_t n) const;
    /// Weights of the samples from `first` on, at most a block of them.
    void weights(std::size_t first, const Turning& tapering, std::span<double> result) const;
  };
  /// Sums over blocks of samples turned down by a frequency.
  struct Baseband {
    std::vector<std::complex<double>> sum;
    std::vector<double> weight, square;  ///< sums of the weights and of their squares
    std::vector<double> time;            ///< [samples] from the middle, of the middle of each block
  };

  std::vector<Support> supports(double frequency) const;
  Baseband baseband(double frequency) const;
  void weigh(const Support& support, std::size_t block, const Turning& turning, const Turning& tapering,
             Baseband& result) const;
  void put(const Sine& sine, double sign);
  std::array<std::vector<double>, 3> directions(const Sine& sine, const NoiseBands& bands,
                                                const std::vector<double>& weight) const;
  void find_trend();
  double trend(std::size_t n) const;

  Room room_;
  std::span<double> rest_;
  std::vector<Support> gaps_;
  std::vector<Sine> sines_;
  std::size_t block_ = 1;
  double middle_ = 0.0, level_ = 0.0, slope_ = 0.0;
};

}  // namespace tumble
