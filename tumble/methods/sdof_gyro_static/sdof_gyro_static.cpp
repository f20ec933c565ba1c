#include <string>
#include <utility>

#include "tumble/methods/linear_method.hpp"
#include "tumble/reduce/sdof_gyro_support/gyro.hpp"

namespace tumble::sdof_gyro_static {
namespace {

std::vector<Option> options() {
  auto options = sdof_gyro_support::options("5 s", "10 s");
  options.push_back(flag("misalignment")
                        .says("the angles of the input axis toward O and S are parameters too; take each position at "
                              "two opposite azimuths"));
  options.push_back(flag("drift").says("a drift linear in the time since power-on is a parameter too"));
  return options;
}

Term drift_rate() {
  return {"drift_rate", "dw/dt", "deg/h/h", "drift linear in the time since power-on", Input::since_power_on};
}

/// y - w_I = row(f) . D, docs/equations (4.6); Earth rate along the input axis is the known input.
linear::Problem problem_of(const Settings& settings, const Channel* channel) {
  auto problem = sdof_gyro_support::problem_of(settings, channel);
  auto names = sdof_gyro_support::drift_terms();
  problem.leave_out_first = {"D_OO"};
  if (settings.flag("misalignment"))
    for (const char* name : {"misalignment_O", "misalignment_S"}) {
      names.emplace_back(name);
      problem.leave_out_first.emplace_back(name);
    }
  problem.columns = sdof_gyro_support::terms(names);
  problem.condition_limit = linear::weakest_in_motion;  // on an arm, only its wobble tells D_S from D_F
  if (settings.flag("drift")) problem.columns.push_back(drift_rate());
  problem.advice = {"distinguish_static_drift"};
  return problem;
}

Estimate finished(const linear::Solution& solution, const Settings&) {
  Estimate estimate = linear::answer_of(solution, "deg/h", {"I", "O", "S"});
  sdof_gyro_support::add_repeats(solution, estimate);
  return estimate;
}

}  // namespace

extern const Method sdof_gyro_static = linear_method<sdof_gyro_support::roles, problem_of, finished>({
    .name = "sdof_gyro_static",
    .summary = "drift coefficients of a single-degree-of-freedom gyro over specific force, from positions",
    .source = "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 28-34",
    .options = options,
    .compensates = true,
    .takes_prior = true,
});

}  // namespace tumble::sdof_gyro_static
