#pragma once

#include "tumble/tasks/optimise.hpp"

namespace tumble {

/// The shortest test that reaches the uncertainties of the plan as it is, by the choice of the motions alone and with
/// the plan's prior as well, and by how much each is shorter.
///
/// Every time that is tried has the schedule of optimise() and the plan's own with shorter segments. A test is never
/// shortened so far that its own result, without prior, could not show a unit six spreads from the mean in nine of ten
/// cases (8.35): u <= max(1.19 tau, u of the plan as it is).
///
/// Given     plan  with a prior; its schedule determines the terms that are compared
/// Returned  as optimise(), for the shortest test with prior, with the table `shorter_tests` and a finding that says by
/// how
///           much it is shorter
/// Throws    as optimise(); Error::bad_input for a plan without a prior
/// See       docs/equations (8.35)
Optimised shorten(const Plan& plan, const OptimiseOptions& options, const Progress& progress);

}  // namespace tumble
