#pragma once

#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/math/matrix.hpp"
#include "tumble/math/population/capability.hpp"
#include "tumble/math/tolerance.hpp"

namespace tumble {

/// A measured value and how well it is known, for a statement of conformity. All [u] in one unit.
struct Measured {
  double value = 0.0;
  double sd = 0.0;  ///< standard uncertainty
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
  /// Ends of the 95 % interval where it is not symmetric; NaN: value -+ t sd.
  double lower = std::numeric_limits<double>::quiet_NaN(), upper = std::numeric_limits<double>::quiet_NaN();
};

/// How a statement of conformity follows from a measured value and its uncertainty.
///
/// See ILAC-G8:09/2019; JCGM 106:2012, 8.3; Dobbert, NCSL International Workshop 2008 (Method 6 of ANSI/NCSL Z540.3)
struct DecisionRule {
  enum class Kind {
    simple,     ///< accepted within the tolerance
    guarded,    ///< accepted within the tolerance less `amount` expanded uncertainties
    risk,       ///< accepted where the probability of being out of tolerance is at most `amount`
    method6,    ///< accepted within the guard band that keeps the risk at 2 % for every population
    non_binary  ///< guard band of one expanded uncertainty to both sides: four statements
  };
  Kind kind = Kind::simple;
  double amount = 0.0;
};

/// "simple", "guarded:0.83", "risk:0.025", "method6", "non-binary"; "guarded" alone is one expanded uncertainty.
/// Throws Error::bad_input that says what would be accepted.
DecisionRule parse_decision_rule(std::string_view text);
/// The text that parse_decision_rule() reads.
std::string name(const DecisionRule& rule);

/// A statement of conformity.
struct Decision {
  enum class Outcome { pass, conditional_pass, conditional_fail, fail, undecided };
  /// undecided: the uncertainty is too large for the rule, no value would be accepted
  Outcome outcome = Outcome::undecided;
  Tolerance acceptance;        ///< [u] what the rule accepts as pass
  double conformance = 0.0;    ///< [1] probability that the true value is within the tolerance
  double specific_risk = 0.0;  ///< [1] probability that the statement is wrong: 1 - conformance, or that of a rejection
  double test_uncertainty_ratio = std::numeric_limits<double>::quiet_NaN();  ///< [1] NaN for a limit to one side
};

/// Half the width of the 95 % interval towards larger and towards smaller values [u].
///
/// See JCGM 100:2008 (GUM), G.6.4
struct ExpandedUncertainty {
  double below, above;
};
ExpandedUncertainty expanded_uncertainty(const Measured& measured);

/// Probability [1] that the true value is outside of the tolerance. Student's t at the degrees of freedom; an interval
/// that is not symmetric is that of a normal distribution of two widths with the value as median.
///
/// Given     measured, tolerance [u]
/// Accuracy  relative also where the risk is small
/// See       JCGM 106:2012, 7.2
double specific_risk(const Measured& measured, const Tolerance& tolerance);

/// Values that the rule accepts as pass [u]; empty where the uncertainty leaves nothing to accept.
/// Throws Error::bad_input for method6 with a limit to one side.
Tolerance acceptance_of(const Measured& measured, const Tolerance& tolerance, const DecisionRule& rule);

/// The statement of conformity by a rule. Throws as acceptance_of().
Decision decide(const Measured& measured, const Tolerance& tolerance, const DecisionRule& rule);

/// (T_U - T_L)/(2 U) [1], U the expanded uncertainty (95 %); NaN for a limit to one side.
double test_uncertainty_ratio(const Measured& measured, const Tolerance& tolerance);

/// Guard band of Method 6 in expanded uncertainties [1]: 1.04 - exp(0.38 ln TUR - 0.54), not below 0.
double method6_guard_band(double test_uncertainty_ratio);

/// The value after the measurement where the production is known: the two weighted by their variances.
///
/// Given     measured, its uncertainty normal; population [u]
/// See       JCGM 106:2012, 7.3
Measured posterior(const Measured& measured, const Population& population);

/// Risks over many instruments [1].
struct GlobalRisk {
  double consumer;  ///< of all instruments, the part that is accepted and out of tolerance
  double producer;  ///< of all instruments, the part that is rejected and within the tolerance
};

/// Integral over the production of the probability to accept what is out of tolerance, and to reject what is not.
///
/// Given     population [u]; sd  [u] standard uncertainty of the measurement, normal
///           tolerance, acceptance [u]
/// Accuracy  1e-10
/// See       JCGM 106:2012, 9.5
GlobalRisk global_risk(const Population& population, double sd, const Tolerance& tolerance,
                       const Tolerance& acceptance);

/// The mean risk [1] over what the production may be [u]: draws of possible_populations() where few units are known.
GlobalRisk global_risk(std::span<const Population> populations, double sd, const Tolerance& tolerance,
                       const Tolerance& acceptance);

/// The widest acceptance limits [u], moved alike at both ends of the tolerance, at which at most `target` [1] of all
/// instruments are accepted and out of tolerance: the guard band that follows from the fleet itself. They lie outside
/// of the tolerance where none is needed, and have no width where no limits keep the target.
///
/// Given     populations, sd [u], as of global_risk(); a target in (0, 1)
/// Returned  infinite limits where fewer instruments than that are out of tolerance
/// Accuracy  1e-9 of the width of the production
/// See       docs/equations (8.28)
Tolerance acceptance_of_fleet(std::span<const Population> populations, double sd, const Tolerance& tolerance,
                              double target);

/// Probability [1] that all true values are within their tolerances, by their joint distribution: each as in
/// specific_risk(), and dependent as the correlation says (Gaussian copula). It is not the product of the single
/// probabilities where they are correlated.
///
/// Given     measured, tolerances  n each [u]
///           correlation  [1] n x n, positive semidefinite
/// Returned  by a lattice of 8 x 8192 points with fixed shifts: the same bytes for the same input
/// Accuracy  2e-4 for 20 correlated parameters, better for fewer
/// See       Genz, J. Comput. Graph. Statist. 1 (1992) 141
double joint_conformance(const std::vector<Measured>& measured, const std::vector<Tolerance>& tolerances,
                         const Matrix& correlation);

}  // namespace tumble
