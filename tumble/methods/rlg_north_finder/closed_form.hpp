#pragma once

#include <array>
#include <span>
#include <vector>

#include "tumble/methods/rlg_north_finder/outputs.hpp"
#include "tumble/methods/rlg_north_finder/path.hpp"
#include "tumble/reduce/linear/work.hpp"

/// The formulas of the path, position by position.
namespace tumble::rlg_north_finder {

/// Means of each output over its segments [pulse/s].
using Means = std::array<std::vector<double>, outputs>;
using Summaries = std::array<std::span<const linear::SegmentSummary>, outputs>;

Means measured(const Summaries& segments);

/// (2.1)-(2.7), in the order of wanted() [SI]. Positions are taken by the axis that stands upright, for any order of
/// the path and the senses of its turns; several of a kind are averaged, but z up is the last one and z down the first
/// one recorded between (positions 6 and 7). Of (2.5) all that the Earth gives at the four positions:
///
///   eps = eps' - mean(w_x + gamma_y w_y + gamma_z w_z)
///
/// Angles that were set by hand and recorded: what they make of the specific force beside that of axes that stand
/// exactly upright or level is subtracted first, and turns count as far as they went.
///
/// Given  gravity  [m/s^2] of the site
std::vector<double> closed_form(const Means& means, const Summaries& segments, double gravity);

/// Base tilts and non-orthogonality of the axes that the accelerometers show with z up and down [rad].
///
///   (2.19)  rho_X = (f_y6 + f_y7)/2g,  s = (f_y7 - f_y8)/g,  d = (f_x8 - f_x7)/g,
///           rho_Y = (s - d)/2,  eta = rho_X - (s + d)/2,  f_k = N_k/(K T) - b
struct Tilts {
  bool known = false;
  double rho_x = 0.0, rho_y = 0.0, eta = 0.0;
  double sd = 0.0;  ///< of each, by noise, drift and repeatability of the angles; about
};

/// Given  parameters  in the order of wanted()
///        drift       [m/s^2] by which means of the accelerometers differ from stay to stay, noise included
///        rig         its repeatability and wobble
Tilts tilts_of(const Means& means, const Summaries& segments, const std::vector<double>& parameters, double gravity,
               double drift, const Settings& rig);

/// The answer of the formulas with its covariance: the noise found in the stays and the errors of the table, carried
/// through the differences of the formulas. Given: gravity [m/s^2].
Estimate closed_form_estimate(const std::vector<linear::Work>& works, double gravity);

}  // namespace tumble::rlg_north_finder
