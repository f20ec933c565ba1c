#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tumble/math/matrix.hpp"

namespace tumble {

/// Something that may be observed, and the information that one unit of effort (a second, a repetition) spent on it
/// gives. With effort d its information about the p parameters is
///
///   I(d) = X' (1/d + N N')^-1 X
///
/// d X'X where nothing but white noise disturbs; what is drawn anew at every visit (the error of a position, the drift
/// since the last) sets a limit that no effort passes.
struct DesignPoint {
  Matrix rows;         ///< X, k x p: observations of one unit of effort, divided by the sd of their noise
  Matrix disturbance;  ///< N, k x m: effect on them of what each visit draws anew with sd 1; empty: none
  double setup = 0.0;  ///< effort that a visit costs before it gives information
  double least = 0.0;  ///< smallest effort of a visit, without the setup
};

/// One visit to a point.
struct DesignVisit {
  std::size_t point = 0;
  double effort = 0.0;  ///< without the setup
};

using Design = std::vector<DesignVisit>;

enum class DesignCriterion {
  D,  ///< the logarithm of the determinant of the covariance of the parameters of interest
  A   ///< sum over them of variance x weight
};

/// Problem to solve: find the visits that make the criterion smallest for a given effort.
struct DesignProblem {
  std::vector<DesignPoint> points;
  std::size_t parameters = 0;
  std::vector<double> weights;  ///< one a parameter, of its variance in A; 0: of no interest, in A and in D
  Matrix prior;                 ///< what is known beforehand, p x p information; empty: nothing
  double effort = 0.0;          ///< of all visits together, setups included
  double quantum = 1.0;         ///< efforts are whole multiples of this
  DesignCriterion criterion = DesignCriterion::A;
};

/// I(effort) of a point [p x p]; effort as of DesignPoint.
Matrix information(const DesignPoint& point, double effort);

/// Information of the visits together with the prior [p x p].
Matrix information(const DesignProblem& problem, const Design& design);

/// The criterion of a design, the smaller the better; +inf where a parameter of interest is not determined.
/// Returned: [1] for D, the weighted variance for A.
double criterion_of(const DesignProblem& problem, const Design& design);

/// The design with the smallest criterion that an exchange reaches: from a start that adds the most telling point time
/// and again, visits are exchanged for other points, dropped, split and given each other's effort until nothing of that
/// helps. The best of `starts` such searches, each of which sees its own random part of the points at first, and of one
/// from each design in `from`. The same seed gives the same design on any number of threads.
///
/// Returned  visits in order of their points; none where no point can be visited with the effort
/// Throws    Error::bad_input where rows, weights or the prior do not fit to the number of parameters
/// Accuracy  a local optimum; sensitivity() says how far from the best of all it can be
/// See       Fedorov, Theory of Optimal Experiments, 1972, ch. 3; Atkinson, Donev and Tobias, Optimum Experimental
///           Designs, with SAS, 2007, ch. 12
Design exchange(const DesignProblem& problem, std::uint64_t seed, int starts, const std::vector<Design>& from = {});

/// The equivalence theorem: what a unit of effort at each point would add to the criterion, relative to what a unit of
/// the design adds on average. Nowhere above 1, and 1 where the design observes, if and only if no design is better.
///
///   D: effort tr(X C X')/p          A: effort tr(X C W C X')/tr(W C)          C covariance, W weights
///
/// Returned  one value a point [1]; 1/max bounds the efficiency of the design from below
/// Valid     without disturbances, setups and prior, all weights above zero
/// See       Kiefer and Wolfowitz, The equivalence of two extremum problems, Canad. J. Math. 12, 1960
std::vector<double> sensitivity(const DesignProblem& problem, const Design& design);

}  // namespace tumble
