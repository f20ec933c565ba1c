#pragma once

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"

namespace tumble {

/// Findings that the values of a result show a fault, for results of any method: an output that goes against its input
/// (`wrong_sign`: a scale factor error below -1, or a scale factor or a radius below 0), and errors too large for a
/// model that is linear in them (`beyond_linear_form`: a scale factor error of 20 %, a misalignment of 3 deg). Methods
/// for units of several axes estimate full matrices, in which large errors are no fault: only signs are looked at
/// there. A gain that is that of another unit (`gain_of_another_unit`: deg/s read as rad/s, g as m/s^2). And a radius that the plan does not allow (`radius_unlike_plan`: more than 4 standard uncertainties, of the
/// answer, of the plan's radius and of its lever together, from radius + lever_x).
///
/// Returned  findings of severity error; `where` is the parameter
Findings implausible(const Estimate& estimate, const Plan& plan);

/// Gravity that the plan states and that is not of its place: a warning beyond 0.06 % of normal gravity, which
/// anomalies on land reach nowhere, or beyond 0.14 % where no height is stated (4500 m).
Findings about_site(const Plan& plan);

/// Parameters of whose variance more than half comes from the site: from a latitude that no residual can show, or from
/// gravity by the formula. Each is one finding of severity info, with the worst parameter and what would mend it.
Findings ruled_by_site(const Plan& plan, const Estimate& estimate);

/// Gives each finding the parameters that it concerns (Finding::about), where whoever made it did not: the parameter
/// that is its place, or those that its channel gives. A wrong sign anywhere concerns all of them, and so does a
/// finding whose place is neither: nobody can say which numbers it leaves sound.
void settle_findings(Estimate& estimate);

/// Whether an error among the settled findings takes the ground from under a parameter of this name, which the data may
/// hide. Findings about limits of the plan do not. A parameter that only a prior gives is undermined by every error.
bool is_undermined(const Estimate& estimate, const std::string& parameter);

}  // namespace tumble
