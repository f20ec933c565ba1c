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

/// One point for each nominal frequency, ascending. Repeats are weighted by noise and scatter: the variance between
/// them beyond their noise, of all frequencies together (Paule and Mandel, 1982), which frequencies measured once have
/// too; a frequency whose repeats stand out has its own.
std::vector<Point> combined(std::vector<Point> points, Findings& findings);

/// Parameters, budget, tables and curves, with findings on the response but not on the points.
Estimate describe(const std::vector<Point>& points, const Data& data, const std::vector<Source>& sources);

}  // namespace tumble::frequency_response
