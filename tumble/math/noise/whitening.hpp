#pragma once

#include <span>
#include <vector>

#include "tumble/math/matrix.hpp"
#include "tumble/math/noise_model.hpp"

namespace tumble {

/// The noise of evenly spaced averages of a rate signal: white noise, bias instability and a random walk that starts
/// at zero. Whitened by the innovations of a Kalman filter whose states are the Markov processes of flicker_bank() and
/// the walk, each discretised exactly for the average over an interval.
class Whitening {
 public:
  /// interval      [s] between averages
  /// longest       [s] record whose slowest flicker must be distinguished from a constant
  Whitening(const NoiseModel& noise, double interval, double longest);

  /// Replaces every column of a block by its innovations divided by their standard deviation, in place.
  ///
  /// Given     block  [n x c] averages [u], rows in time
  ///           share  [n] how much of each interval was measured: 1 all, 0 nothing; a row with share 0 becomes zero and
  ///                  only lets time pass
  /// Returned  log-determinant of the covariance of the rows with data
  double operator()(Matrix& block, std::span<const double> share) const;

 private:
  struct State {
    double keep;      ///< x(k+1) = keep x(k) + w
    double seen;      ///< average over the interval = seen x(k) + e
    double drive;     ///< var w
    double inside;    ///< var e
    double cross;     ///< cov(w, e)
    double variance;  ///< of x(0)
  };
  static State markov(const MarkovComponent& component, double interval);
  static State walk(double density, double interval);

  /// Gains of the rows with data, which are common to all columns.
  struct Gains {
    std::vector<double> scale;     ///< [n] 1/sd of each innovation; 0 where there are no data
    std::vector<double> of_state;  ///< [n x s] row by row: change of each state by an innovation
    double log_determinant = 0.0;
  };
  Gains gains_for(std::span<const double> share) const;

  std::vector<State> states_;
  double white_;  ///< variance of the white part of a whole interval
};

}  // namespace tumble
