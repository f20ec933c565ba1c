#pragma once

#include "tumble/core/estimate.hpp"
#include "tumble/methods/frequency_response/loop.hpp"
#include "tumble/methods/frequency_response/point.hpp"

namespace tumble::frequency_response {

/// Shifts of (ln gain 1..n, phase 1..n) by one standard deviation of a source: each column one independent error.
struct Source {
  std::string name;
  Matrix shifts;                           ///< 2n x m
  std::vector<double> degrees_of_freedom;  ///< m; empty: infinite
};

/// One point for each nominal frequency, ascending; repeats that differ by more than their noise widen its uncertainty.
std::vector<Point> combined(std::vector<Point> points, Findings& findings);

Measured measured_of(const std::vector<Point>& points);

/// Parameters, budget, tables and curves, with findings on the response but not on the points.
Estimate describe(const std::vector<Point>& points, const Data& data, const std::vector<Source>& sources);

}  // namespace tumble::frequency_response
