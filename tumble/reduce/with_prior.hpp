#pragma once

#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/units/sentence.hpp"

/// A result and the population of its unit's model.
namespace tumble {

/// Problems of a population as the prior of a result, each as a sentence; empty: it can be used.
Problems problems_of_prior(const Estimate& population, const std::string& model, const std::string& method);

/// The estimate of a unit from its own result and its population, as if the population were one more row of the fit for
/// every parameter:
///
///   theta = m + G (y - A m),   G = (P A' - K') (A P A' + C - A K' - K A')^-1
///
/// A parameter of the result whose value contains other terms (Parameter::contains) is a sum of them: the population
/// separates these. What it has and the result does not show is added. Parameters that it does not have stay, corrected
/// by what it says of the errors that they share with the others. Lines of one source and key are the same errors.
///
/// Given     result      parameters with a covariance and a signed budget
///           population  of the same model and method: means m, covariance P of a further unit, budget
///           certain     the values are assumed, not measured: it is not asked whether the unit belongs
/// Returned  prior, with the p-values and, unless the unit does not fit, the estimate with prior
/// Throws    Error::bad_data where a parameter is of another dimension in the population
/// See       docs/equations (8.13), (8.17), (8.33)
PriorUse with_population(const Estimate& result, const Estimate& population, bool certain = false);

/// Standard deviation [SI] of the units' true values of parameter k of a population.
double unit_to_unit_sd(const Estimate& population, std::size_t k);

/// Findings that belong to it: the unit does not fit, few units, the unit itself is among them.
Findings about_prior(const Estimate& result, const PriorUse& use);

/// Table `prior`: for each parameter of the population how wide it is beside the result's own uncertainty, how the unit
/// fits, and how often an interval with prior holds a unit so many spreads from the mean.
Table prior_table(const Estimate& result, const PriorUse& use);

/// Share [1] of intervals with prior that hold the truth of a unit `away` spreads from the mean, where the spread is
/// `ratio` times the uncertainty of the result [1], and both are known. See: docs/equations (8.34).
double conditional_coverage(double ratio, double away);

}  // namespace tumble
