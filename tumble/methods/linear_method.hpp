#pragma once

#include "tumble/methods/method.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

/// A method that identifies one output by the engine reduce/linear: its descriptor with `identify` and `predict`.
///
/// Given     roles       of the method; the first is the output
///           problem_of  linear::Problem(settings, channel): terms and reading of the output; channel is null where the
///                       test is predicted
///           finished    Estimate(solution, settings): the answer with the method's own tables, curves and findings
///           method      the other members of the descriptor
template <auto roles, auto problem_of, auto finished>
constexpr Method linear_method(Method method) {
  method.needs_plan = true;
  method.roles = roles;
  method.identify = [](const Evidence& evidence, const Progress&) -> Estimate {
    if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording to identify from");
    const Settings& settings = evidence.plan.settings;
    const Channel& channel = require_channel(evidence, evidence.recordings.front(), roles().front().name);
    return finished(linear::identify(evidence, problem_of(settings, &channel)), settings);
  };
  method.predict = [](const Plan& plan) -> Estimate {
    const auto truth = linear::truth_of(plan, roles().front().name);
    return finished(linear::predict(plan, problem_of(plan.settings, nullptr), truth), plan.settings);
  };
  return method;
}

}  // namespace tumble
