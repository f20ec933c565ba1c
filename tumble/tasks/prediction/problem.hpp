#pragma once

#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/reduce/terms.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::prediction {

/// One output of a plan's instrument, to be predicted without a method: the terms of its table that the schedule
/// excites.
struct OutputProblem {
  TermProblem problem;
  std::vector<Term> not_excited;
};

/// Throws Error::bad_input with all that a plan lacks to be predicted: model, rig, sample rate, schedule, noise.
void refuse_unpredictable(const Plan& plan);

/// Quantities that the instrument feels, nominally, at instants all over the schedule.
std::vector<Felt> felt_over(const Plan& plan);

/// Whether a term is excited by any of `felt`: a regressor below 1e-8 of what 1 rad/s, 1 rad/s^2, 10 m/s^2 and 10 K
/// give is not. Products of two rates of the Earth (5e-9) are therefore no excitation; the Earth's rate itself is.
bool excited(const Term& term, const std::vector<Felt>& felt);

/// A sentence for each name that is no term of the plan's model.
Problems problems_of_terms(const Plan& plan, const std::vector<std::string>& names);

/// The outputs with the terms that `felt` excites. `only` limits the terms to these names; empty: all.
std::vector<OutputProblem> output_problems(const Plan& plan, const std::vector<Felt>& felt,
                                           const std::vector<std::string>& only);

/// The estimate from the outputs' problems: truth as values, covariance and budget as predicted.
Estimate predict_outputs(const Plan& plan, const std::vector<OutputProblem>& outputs);

}  // namespace tumble::prediction
