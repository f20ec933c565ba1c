#pragma once

#include <vector>

#include "tumble/tasks/validation/bench.hpp"

namespace tumble::validation {

/// How far a parameter moves.
struct Shift {
  double size = 0.0;          ///< [sd of the parameter]
  std::size_t parameter = 0;  ///< index in Bench::parameters
};

/// The shifts of parameters by a departure, from pairs of tests with and without it.
///
/// A pair has one seed. Where the departure leaves the noise as it is, all pairs show one shift, and two are enough. Where it draws
/// the noise anew (another order of positions, a counter that rounds elsewhere), or its own direction is drawn, pairs scatter: a shift
/// counts then where its mean is beyond its scatter, or where the results are further from the truth than the sound ones.
class Shifts {
 public:
  explicit Shifts(const Bench& bench) : bench_(bench), pairs_(bench.parameters.size()) {}

  void add(const Outcome& departed, const Outcome& sound);
  /// Whether further pairs would not change what is said.
  bool settled() const;
  /// The greatest; 0: none is shown.
  Shift worst() const;

 private:
  struct Pairs {
    std::vector<double> shifts;  ///< [sd that the departed result states]
    double squares = 0.0;        ///< [1] sum of the squared deviations from the truth, departed minus sound
  };

  double centre(std::size_t j) const;
  static double shift_of(const Pairs& pairs);

  const Bench& bench_;
  std::vector<Pairs> pairs_;  ///< by parameter
  std::size_t tests_ = 0;
};

}  // namespace tumble::validation
