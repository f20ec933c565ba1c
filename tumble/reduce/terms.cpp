#include "tumble/reduce/terms.hpp"

#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/linear/work.hpp"

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

std::vector<Estimate> predict_terms(const Plan& plan, const std::vector<TermProblem>& problems) {
  std::vector<linear::Problem> each;
  std::vector<linear::Truth> truths;
  for (const auto& problem : problems) {
    each.push_back(problem_of(problem));
    truths.push_back(linear::truth_of(plan, problem.channel));
  }
  std::vector<Estimate> estimates;
  for (const auto& work : linear::worked_out(plan, each, truths))
    estimates.push_back(linear::estimate_of(work.solution));
  return estimates;
}

Estimate identify_terms(const Evidence& evidence, const TermProblem& problem) {
  return linear::estimate_of(linear::identify(evidence, problem_of(problem)));
}

TermInformation information_of_terms(const Plan& plan, const TermProblem& problem) {
  auto information = linear::information(plan, problem_of(problem), linear::truth_of(plan, problem.channel));
  return {std::move(information.errors), std::move(information.of_segment)};
}

}  // namespace tumble
