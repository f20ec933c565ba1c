#pragma once

#include "tumble/methods/dtg_centrifuge/describe.hpp"

/// Whether the levels lie on their polynomial.
namespace tumble::dtg_centrifuge {

/// F test of lack of fit of the levels against the pure error, which is the scatter of the parts of each segment with
/// what is known of the rig: the residual square of the polynomial over its degrees of freedom. One sound test in 1e5
/// is accused.
struct LevelMisfit {
  double ratio = 0.0;        ///< F [1]; 0: no level remains to test
  double probability = 1.0;  ///< p-value [1] of this F
  std::size_t worst = 0;     ///< level that lies farthest off in its own uncertainty
  double off = 0.0;          ///< by how much [rad/s / (m/s^2)]
};

/// Given: levels as those of the reduction.
LevelMisfit level_misfit(const Outcome& outcome, const std::vector<Level>& levels);

/// An error where the p-value of the misfit is below 1e-5: the uncertainties do not include it.
void check_levels(const Outcome& outcome, const std::vector<Level>& levels, Findings& findings);

/// An error where the specific force that a level is reduced with is not that of the plan's rig at the rate of the arm
/// as recorded, (radius + stretch w^2) w^2: beyond a thousandth and six standard deviations of `radius_sd` and
/// `stretch_sd`. What the encoder shows decides, so that an arm at another rate than planned is no misfit.
void check_forces(const Test& test, const std::vector<Measured>& measured, const Reduction& reduction,
                  Findings& findings);

}  // namespace tumble::dtg_centrifuge
