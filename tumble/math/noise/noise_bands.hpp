#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "tumble/math/stability/allan_covariance.hpp"

namespace tumble {

/// Terms whose power a band holds ready, in this order.
constexpr std::array<NoiseTerm, 4> power_law_terms{NoiseTerm::quantization, NoiseTerm::white, NoiseTerm::flicker,
                                                   NoiseTerm::random_walk};

/// Extra variance of block means caused by missing samples: a mean over the present samples has other weights than a
/// mean over all. Averaged over the record, by scale. Nothing is missing where there are no scales.
struct LostSamples {
  struct Scale {
    double unit = 1.0;             ///< [samples] of the values that are missing
    std::vector<double> products;  ///< sum_i w_i w_{i+h}, h = 0, 1, ..., less that of whole blocks; over all h: 0
  };
  std::vector<Scale> scales;

  double variance(NoiseTerm term) const;      ///< [1] of a unit power law
  double markov_variance(double time) const;  ///< [1] of a process of unit variance; time: T_c [samples]
  /// Variance [1] of white noise through a filter of this autocovariance [1]
  double filtered_variance(std::span<const double> autocovariance) const;
};

/// Contrasts of a rate record (weighted sums, weights adding up to zero) of nearly one frequency, and what is expected
/// of them.
struct NoiseBand {
  double frequency = 0.0;                                 ///< [cycles a sample]
  double count = 0.0;                                     ///< number of contrasts
  double mean_square = 0.0;                               ///< [u^2]
  double with_ramp = 0.0;                                 ///< mean of contrast times that of a ramp of 1 u a sample
  double ramp_square = 0.0;                               ///< mean square contrast of such a ramp
  std::array<double, power_law_terms.size()> expected{};  ///< mean square under each unit term
  // For the Gauss-Markov process: cosines within blocks of `radix` units, or sines over a run of differences of units.
  double unit = 1.0;  ///< [samples] averaged
  int radix = 0, order = 0;
  double shortness = 0.0;                   ///< 1/(n + 1) of a run of n differences
  std::vector<double> products;             ///< sum_i w_i w_{i+h} of cosines beside missing values; empty: none missing
  std::shared_ptr<const LostSamples> lost;  ///< of the values that the contrast is made of; null: nothing
};

/// One squared sine coefficient of the slow part, for what is narrower than a band.
struct NoiseOrdinate {
  double frequency = 0.0;  ///< [cycles a sample]
  double square = 0.0;     ///< [u^2]
  std::size_t band = 0;
};

/// Sums of squares of cosines over neighbouring blocks, order by order.
struct ContrastGroup {
  double contrasts = 0.0;         ///< independent ones of an order
  std::array<double, 16> square;  ///< [u^2] by order

  void add(const ContrastGroup& more);

  template <class State>
  void pass(State& state) {
    state(contrasts, square);
  }
};

/// How the power of the cosines of one scale scatters along the record.
struct PowerScatter {
  std::vector<NoiseBand> bands;       ///< one an order, from 1 on
  std::vector<ContrastGroup> groups;  ///< equally long parts of the record, one after the other
};

/// A record as mean squares of orthonormal contrasts, from fast to slow:
///
///   while more than 16384 values are left: blocks of p values (p = 16, the last 2 to 16), whose cosine transform
///     X_k = sqrt(2/p) sum_i y_i cos(pi k (i + 1/2)/p),   k = 1 .. p - 1
///   goes to the bands of that scale and whose means are the values of the next scale;
///   of the last values the differences d_1 .. d_n of every run without a gap, in sines that vanish beyond both ends:
///     X_k = sqrt(2/(n + 1)) sum_j d_j sin(pi j k/(n + 1)),   k = 1 .. n,
///   each a band of its own at the low end, else gathered in bands 3 % wide.
///
/// White noise and the random walk of the last values have a tridiagonal covariance of differences with constant
/// diagonals, which these sines diagonalise exactly; white noise has no covariance between the scales. So the mean
/// squares hold everything that the record says of these two (of the walk: as far as it is slower than a block). The
/// expectations are exact for every term; a little correlation between contrasts is left for flicker, quantization and
/// Gauss-Markov processes.
///
/// Missing values: a block that has half of its values or more gives the cosines of these less their mean, (k-1)/(p-1)
/// independent contrasts of k values, and the mean of the rest; expectations are those of the patterns that are there,
/// exact where the losses of different blocks are independent of each other. While gaps of up to 8 values remain and at
/// least 64 blocks do, blocks bridge them before the sines are taken.
class NoiseBands {
 public:
  /// Given: rate [u]; NaN: missing.
  /// Throws Error::bad_data if no two neighbouring values are left.
  explicit NoiseBands(std::span<const double> rate);
  /// Bands of fast scales, continued with the means [u] over `unit` [samples] that remain of them.
  NoiseBands(NoiseBands fast, std::span<const double> means, double unit);
  NoiseBands() = default;

  std::size_t samples = 0;
  std::vector<NoiseBand> bands;  ///< fast scales first, then the sines from low to high frequency
  std::vector<NoiseOrdinate> ordinates;
  std::vector<double> slow;  ///< what the sines are taken of: means over slow_unit samples
  double slow_unit = 1.0;
  std::shared_ptr<const LostSamples> lost;  ///< of `slow`; null: nothing
  /// Scatter of the power along the record: one entry for each fast scale, then one for cosines of `slow`.
  std::vector<std::shared_ptr<const PowerScatter>> scatter;
  /// Mean square of the fastest contrasts over each of `parts` equal parts of the record, and their number; empty where
  /// there is no fast scale.
  static constexpr std::size_t parts = 16;
  std::vector<double> part_mean_square, part_count;
  /// Adds a part, of blocks of `radix` values.
  void add_part(const ContrastGroup& sums, int radix);
};

/// Coefficients of the sines of differences of `values` (NaN: missing), in the order of NoiseBands::ordinates.
/// Given: values [u]. Returned: coefficients [u].
std::vector<double> slow_sines(std::span<const double> values);

/// Covariance at a lag of h units of means over `unit` samples under a unit power law; generalised (as far as weights
/// that add up to zero can show it) where there is no variance.
/// Given: unit [samples], h [units]. Returned: covariance [1], of a squared coefficient of one.
double unit_covariance(NoiseTerm term, double unit, int h);

/// Expected mean square [u^2] in a band of a Gauss-Markov process of unit variance, and its derivative by ln T_c.
/// time: T_c [samples], at most 1/20 of the record for an accuracy of 1e-6.
double expected_markov(const NoiseBand& band, double time);

}  // namespace tumble
