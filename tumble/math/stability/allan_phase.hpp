#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tumble/math/room.hpp"

namespace tumble {

/// Phase points first, ..., last (both included) with no missing sample between them.
struct PhaseRun {
  std::size_t first = 0;
  std::size_t last = 0;

  std::size_t points() const { return last - first + 1; }
};

/// Running integral of a rate signal, in samples, after its mean has been subtracted (no stability variance of second
/// or higher differences sees the mean, and rounding stays small). Constant across missing samples.
struct Phase {
  std::span<const double> values;  ///< [u], one more than the rate has samples
  std::vector<PhaseRun> runs;      ///< the whole, or what the gaps leave of it
  Room storage;                    ///< of the values, where they are not the caller's

  bool has_gaps() const { return runs.size() != 1 || runs.front().points() != values.size(); }
};

/// Given     rate  [u]; NaN: missing
/// Throws    Error::bad_data for infinite values, or fewer than `fewest` samples that are not missing
/// Accuracy  each phase value within one rounding of the exact sum: rounding does not add up along the record
Phase integrate_rate(std::span<const double> rate, std::size_t fewest);

/// Running integral of a rate that is read once. Where the record is long the mean of a few hundred places is
/// subtracted in place of the mean, so that a part of it remains: for differences of second or higher order, which do
/// not see it.
///
/// Given     rate  [u]; NaN: missing; fewest, as for integrate_rate
/// Returned  phase [u samples]
Phase integrate_rate_once(std::span<const double> rate, std::size_t fewest);

/// Subtracts the least-squares quadratic from x [u], in place. Returned: its second-order coefficient [u/sample^2].
double remove_quadratic(std::span<double> x);

}  // namespace tumble
