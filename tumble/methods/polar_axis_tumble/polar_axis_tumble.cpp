#include <fmt/format.h>

#include "tumble/methods/linear_method.hpp"
#include "tumble/methods/polar_axis_tumble/harmonics.hpp"
#include "tumble/reduce/sdof_gyro_support/gyro.hpp"
#include "tumble/sim/simulate.hpp"

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
  Estimate estimate = linear::answer_of(solution, "polar_axis_tumble", "deg/h", {"I", "O", "S"});
  name_combinations(solution, estimate);
  add_harmonics(solution, estimate);
  sdof_gyro_support::add_repeats(solution, estimate);
  return estimate;
}

/// Sixteen angles in a mixed order about the Earth's axis, with O along it and against it.
Trial trial(std::uint64_t seed) {
  Plan plan = sdof_gyro_support::trial_plan("polar_axis_tumble", options(), "dividing_head", 1.0);
  plan.rig.set_number("axis_elevation", plan.site->latitude, Unit::parse("deg"));
  for (const double roll : {90.0, -90.0})
    for (int k = 0; k < 16; ++k) {
      const double angle = 22.5 * static_cast<double>((5 * k) % 16);
      plan.schedule.push_back({fmt::format("{} {:g}", roll > 0.0 ? "O north" : "O south", angle),
                               100.0,
                               1,
                               {{"head", {.kind = Motion::Kind::hold, .value = si(angle, "deg")}},
                                {"mount_roll", {.kind = Motion::Kind::hold, .value = si(roll, "deg")}}}});
    }
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  const auto d = [&](const char* name) { return plan.truth.number(name); };
  for (const char* name : {"D_I", "D_O", "D_S", "D_IO", "D_OS", "D_IS"}) trial.truth.emplace_back(name, d(name));
  trial.truth.emplace_back("D_SS_minus_D_II", d("D_SS") - d("D_II"));
  return trial;
}

}  // namespace

extern const Method polar_axis_tumble = linear_method<sdof_gyro_support::roles, problem_of, finished>({
    .name = "polar_axis_tumble",
    .summary = "drift of a single-degree-of-freedom gyro turned about the Earth's axis: harmonics and what they give",
    .source =
        "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 32-33, about the polar axis",
    .options = options,
    .trial = trial,
});

}  // namespace tumble::polar_axis_tumble
