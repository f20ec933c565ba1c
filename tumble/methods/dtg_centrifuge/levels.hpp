#pragma once

#include <vector>

#include "tumble/math/matrix.hpp"
#include "tumble/methods/dtg_centrifuge/describe.hpp"

namespace tumble::dtg_centrifuge {

/// A number and its derivatives by the level quantities.
struct Function {
  double value = 0.0;
  std::vector<double> gradient;
};

/// Unit of K for people.
Unit sensitivity();

/// K, zeta and what the polynomial makes of them, of an output that outlives this.
class Levels {
 public:
  Levels(const Outcome& outcome, const std::vector<Level>& levels);

  /// p or q of a level [rad/s/(m/s^2)].
  Function part(std::size_t level, std::size_t c) const;
  /// The lowest level with the same orientation.
  std::size_t first(std::size_t level) const;
  /// K_i [rad/s/(m/s^2)], less what noise adds to its square. See: docs/equations (1.14).
  Function K(std::size_t level) const;
  /// K of the polynomial, at a level of the test or between two.
  Function fitted(const Level& level) const;
  /// [1] K over that of the lowest level with the same orientation, less one.
  Function zeta(std::size_t level) const;
  /// zeta of the polynomial, where it may change over the levels; without number where it is constant.
  Function zeta_fitted(std::size_t level) const;
  Function zeta_fitted(const Level& level, std::size_t first) const;
  bool bends() const { return outcome_.polynomial.powers > 0; }

 private:
  std::size_t size() const { return outcome_.levels.value.size(); }
  std::size_t parts() const { return outcome_.polynomial.parts; }
  Function ratio_less_one(const Function& here, const Function& there) const;

  const Outcome& outcome_;
  const std::vector<Level>& levels_;
  Matrix rows_;  ///< the levels by the quantities
};

}  // namespace tumble::dtg_centrifuge
