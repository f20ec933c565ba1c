#include "tumble/reduce/terms.hpp"

#include "tumble/reduce/linear/linear.hpp"

namespace tumble {
namespace {

linear::Problem problem_of(const TermProblem& terms) {
  linear::Problem problem;
  problem.role = terms.channel;
  problem.input = terms.input;
  problem.columns = terms.columns;
  problem.leave_out_first = terms.leave_out_first;
  problem.oversampling = terms.oversampling;
  problem.settling = terms.settling;
  problem.averaging = terms.averaging;
  problem.needs_site = false;  // an uncertainty hardly depends on it
  return problem;
}

}  // namespace

Estimate predict_terms(const Plan& plan, const TermProblem& problem) {
  return linear::estimate_of(linear::predict(plan, problem_of(problem), linear::truth_of(plan, problem.channel)));
}

Estimate identify_terms(const Evidence& evidence, const TermProblem& problem) {
  return linear::estimate_of(linear::identify(evidence, problem_of(problem)));
}

TermInformation information_of_terms(const Plan& plan, const TermProblem& problem) {
  auto information = linear::information(plan, problem_of(problem), linear::truth_of(plan, problem.channel));
  return {std::move(information.errors), std::move(information.of_segment)};
}

}  // namespace tumble
