#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tumble/math/stability/allan.hpp"

namespace tumble {

/// Overlapping Allan deviation of a rate signal that arrives piece by piece or does not fit into memory. It holds about
/// 0.1 MB a stage, for records of any length.
///
/// Factors up to `exact_to` have all their terms, those that overlapping_allan sums. Longer ones are kept by stages,
/// each of which sees every 16th phase point of the one before: a factor has a term every 16, 256, ... samples, at
/// least 64 of them in each tau. The variance of such a mean of terms that overlap by 63/64 exceeds that of all terms
/// by less than 0.1 % (tested); in a finite record it is a slightly different estimate of the same deviation.
///
/// Parts of a record can be worked through apart, at the same time, and joined: the result is that of the whole, to
/// rounding. A part may begin at any sample. Terms across missing samples (NaN) are skipped.
class StreamingAllan {
 public:
  static constexpr std::size_t exact_to = 1024;
  static constexpr std::size_t decimation = 16;

  /// Given  longest            longest averaging factor wanted [samples]; points_per_decade [1]  as in AllanOptions
  ///        start              index in the whole record of the first sample that will be pushed
  /// Throws Error::bad_input   for points per decade that are negative
  StreamingAllan(std::size_t longest, double points_per_decade, std::size_t start = 0);
  StreamingAllan() = default;  ///< for pass()

  /// The next samples [u]. The result does not depend on how the record is cut into calls.
  void push(std::span<const double> rate);

  /// Joins the part that follows. Throws Error::bad_input where it does not: other options, or other samples between.
  void append(const StreamingAllan& next);

  /// Deviations of what has come so far, with limits: noise type by the slope of the curve over about an octave (phase
  /// noise: of white and flicker the one with fewer edf). Given sample_rate [Hz], confidence (two-sided).
  std::vector<DeviationPoint> points(double sample_rate, double confidence) const;

  std::size_t samples() const { return samples_; }

  template <class State>
  void pass(State& state) {
    state(stages_, start_, samples_);
  }

 private:
  /// One step of decimation. An increment is the phase from one of its points to the next.
  struct Stage {
    std::vector<std::size_t> factors;  ///< in steps of the stage
    std::vector<long double> sums;
    std::vector<std::size_t> terms;
    std::vector<double> head;     ///< first increments, for `append`
    bool head_open = true;        ///< `head` holds all there have been, and no gap
    std::vector<double> tail;     ///< last increments since the last gap
    std::vector<double> pending;  ///< increments not yet worked through
    double carry = 0.0;           ///< increment of the next stage, in the making ...
    std::size_t carried = 0;      ///< ... from so many of this one
    std::size_t skip = 0;         ///< increments to pass before the next stage may start: of a part, or after a gap
    double lead = 0.0;            ///< of a part: sum of the increments before its first point of the next stage ...
    std::size_t leading = 0;      ///< ... their number
    bool lead_open = true;        ///< no gap was among them

    template <class State>
    void pass(State& state) {
      state(factors, sums, terms, head, head_open, tail, pending, carry, carried, skip, lead, leading, lead_open);
    }
  };

  void feed(std::size_t stage, double increment);
  void work_through(std::size_t stage);
  void flush();
  void break_off();
  static void add_terms(Stage& stage, std::span<const double> increments, std::size_t old, std::size_t fresh);
  static void join(Stage& stage, const Stage& other);
  void join_lead(std::size_t stage, const Stage& other);

  std::vector<Stage> stages_;
  std::size_t start_ = 0;
  std::size_t samples_ = 0;
};

}  // namespace tumble
