#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace tumble {

/// Phase points first, ..., last (both included) with no missing sample between them.
struct PhaseRun {
  std::size_t first = 0;
  std::size_t last = 0;

  std::size_t points() const { return last - first + 1; }
};

/// Running integral of a rate signal, in samples, after its mean has been taken off (no stability variance of second or
/// higher differences sees the mean, and rounding stays small). Constant across missing samples.
struct Phase {
  std::span<const double> values;     ///< [u], one more than the rate has samples
  std::vector<PhaseRun> runs;         ///< the whole, or what the gaps leave of it
  std::unique_ptr<double[]> storage;  ///< of the values, where they are not the caller's

  bool has_gaps() const { return runs.size() != 1 || runs.front().points() != values.size(); }
};

/// Given     rate  [u]; NaN: missing
/// Throws    Error::bad_data for infinite values, or fewer than `fewest` samples that are not missing
/// Accuracy  each phase value within one rounding of the exact sum: rounding does not add up along the record
Phase integrate_rate(std::span<const double> rate, std::size_t fewest);

/// Takes the least-squares quadratic off. Returned: its second-order coefficient, per sample squared.
double remove_quadratic(std::span<double> x);

/// sum_n (x_{n+2m} - 2 x_{n+m} + x_n)^2 over every run, one sum a factor. Works through the phase block by block, so
/// that a block serves many factors while it is in the cache; on all threads where the record is long.
std::vector<double> second_difference_sums(const Phase& phase, std::span<const std::size_t> factors);

/// The same of one run, added to `sums`.
void add_second_differences(std::span<const double> x, std::span<const std::size_t> factors, std::span<double> sums);

/// sum (x_{n+2m} - 2 x_{n+m} + x_n)^2 over n < count.
double second_difference_squares(const double* x, std::size_t factor, std::size_t count);

}  // namespace tumble
