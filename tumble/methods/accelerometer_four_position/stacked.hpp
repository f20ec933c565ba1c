#pragma once

#include <Eigen/Core>
#include <vector>

#include "tumble/methods/accelerometer_four_position/estimator.hpp"
#include "tumble/methods/accelerometer_four_position/positions.hpp"

namespace tumble::accelerometer_four_position {

/// Results of all cells in one vector z, quantity after quantity, and d z/d (output of each stretch).
struct Stacked {
  std::vector<Quantity> active;
  std::size_t cells = 0;
  Eigen::VectorXd z;
  Eigen::MatrixXd slope;

  Eigen::Index index(std::size_t block, std::size_t cell) const {
    return static_cast<Eigen::Index>(block * cells + cell);
  }
};

/// Every cell by (3.5); `two`: the source's estimator, positions 1 and 3 alone. Throws Error::bad_data where a cell
/// shows no scale factor.
Stacked stacked_of(const Bench& bench, bool two);

}  // namespace tumble::accelerometer_four_position
