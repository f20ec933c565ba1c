#include <cmath>

#include "tumble/methods/accelerometer_tumble/report.hpp"
#include "tumble/methods/accelerometer_tumble/trial.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/units/error.hpp"

namespace tumble::methods {
namespace {

std::vector<Role> roles() { return {accelerometer::role()}; }

Estimate identify(const Evidence& evidence, const Progress&) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording to identify from");
  const auto& settings = evidence.plan.settings;
  const Evidence used = accelerometer::at_one_rate(evidence);
  auto found = accelerometer::identify(used, multi_position::problem_of(settings), multi_position::refine_of(settings));
  return multi_position::answer_of(used, std::move(found));
}

Estimate predict(const Plan& plan) {
  auto found =
      accelerometer::predict(plan, multi_position::problem_of(plan.settings), multi_position::refine_of(plan.settings));
  return multi_position::answer_of({plan, {}, {}}, std::move(found));
}

}  // namespace

extern const Method accelerometer_tumble{
    .name = "accelerometer_tumble",
    .summary = "static model of an accelerometer from positions in gravity: any number of them, one mount or both",
    .source =
        "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slide 47, eq. (4.19), the form of "
        "GJB 2504; Lu Hanjie, Liu Yabin, Zhou Qiang, 2019, eq. (3.1), (3.5)",
    .needs_plan = true,
    .roles = roles,
    .options = multi_position::options,
    .identify = identify,
    .trial = multi_position::trial,
    .compensate = nullptr,
    .predict = predict};

}  // namespace tumble::methods
