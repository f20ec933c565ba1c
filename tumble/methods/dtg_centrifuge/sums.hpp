#pragma once

#include <array>
#include <cstddef>
#include <vector>

/// The sums that a least-squares fit of lines at known angles needs, over many samples.
namespace tumble::dtg_centrifuge {

/// Columns: 1, tau, cos and sin of theta, 2 theta, 3 theta, beta, and of beta + 2 theta, where an arm's axis that
/// wobbles twice a turn shows.
inline constexpr std::size_t columns = 12;
inline constexpr std::size_t most_signals = 3;

/// X'X (upper triangle by rows), X'y and y'y.
struct Sums {
  std::array<double, columns*(columns + 1) / 2> gram{};
  std::array<std::array<double, columns>, most_signals> moment{};
  std::array<double, most_signals> square{};
  double samples = 0.0;

  Sums& operator+=(const Sums& other);
};

/// Samples of signals that share a clock, with the angles in the middle of what each sample is the mean of.
struct Block {
  const double* arm = nullptr;                       ///< [rad]
  const double* table = nullptr;                     ///< [rad] of the table against the arm
  std::array<const double*, most_signals> signal{};  ///< NaN: missing
  std::size_t signals = 0;
  std::size_t samples = 0;
  double tau = 0.0, tau_step = 0.0;  ///< of the first sample, and from one to the next
};

/// theta = -table, beta = arm + table. A sample that any of the signals or angles lacks counts for none of them.
void add_to(Sums& sums, const Block& block);

}  // namespace tumble::dtg_centrifuge
