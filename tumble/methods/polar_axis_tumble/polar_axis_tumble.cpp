#include <fmt/format.h>

#include <cmath>

#include "tumble/methods/linear_method.hpp"
#include "tumble/methods/polar_axis_tumble/harmonics.hpp"
#include "tumble/reduce/sdof_gyro_support/gyro.hpp"

namespace tumble::polar_axis_tumble {
namespace {

std::vector<Option> options() { return sdof_gyro_support::options("5 s", "10 s"); }

linear::Problem problem_of(const Settings& settings, const Channel* channel) {
  auto problem = sdof_gyro_support::problem_of(settings, channel);
  problem.columns = sdof_gyro_support::terms(sdof_gyro_support::drift_terms());
  problem.leave_out_first = {"D_OO", "D_II", "D_IO", "D_OS", "D_O"};
  problem.advice = {"distinguish_polar_axis"};
  return problem;
}

Estimate finished(const linear::Solution& solution, const Settings&) {
  Estimate estimate = linear::answer_of(solution, "deg/h", {"I", "O", "S"});
  name_combinations(solution, estimate);
  estimate.models.clear();  // its sums of coefficients hold for turns about the Earth's axis alone
  add_harmonics(solution, estimate);
  sdof_gyro_support::add_repeats(solution, estimate);
  return estimate;
}

}  // namespace

extern const Method polar_axis_tumble = linear_method<sdof_gyro_support::roles, problem_of, finished>({
    .name = "polar_axis_tumble",
    .summary = "drift of a single-degree-of-freedom gyro turned about the Earth's axis: harmonics and what they give",
    .source =
        "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 32-33, about the polar axis",
    .options = options,
});

}  // namespace tumble::polar_axis_tumble
