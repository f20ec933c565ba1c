#pragma once

#include <cstddef>
#include <vector>

#include "tumble/rigs/rig.hpp"

/// Moves that are used whole: the total of an output from rest to rest, or over whole turns.
namespace tumble::linear {

/// Instants of an interval and the share of it that each represents: the mean over the interval is the weighted sum.
struct Instants {
  std::vector<double> time;   ///< [s]
  std::vector<double> share;  ///< their sum is 1

  bool empty() const { return time.empty(); }
};

/// The weighted mean of `value`, called with what is felt at each instant. Returned: [unit of value].
template <class Value>
double mean_over(const Reference& reference, const Instants& instants, const Value& value) {
  double sum = 0.0;
  Felt felt;
  for (std::size_t k = 0; k < instants.time.size(); ++k) {
    reference.felt(instants.time[k], 1.0, std::span(&felt, 1));
    sum += instants.share[k] * value(felt);
  }
  return sum;
}

/// Gauss points of five, in parts that are halved until the means of rate and specific force stay: a drive changes its
/// acceleration from one instant to the next, so that evenly spaced instants miss some of the angle.
///
/// Given     frequency   greatest at which what is felt repeats [Hz]; 0: never
/// Accuracy  1e-11 of the greatest rate and specific force
Instants instants_of(const Reference& reference, double begin, double end, double frequency);

}  // namespace tumble::linear
