#include <cmath>

#include "tumble/methods/accelerometer_tumble/report.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer_tumble {
namespace {

Estimate identify(const Evidence& evidence, const Progress&) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording to identify from");
  const auto& settings = evidence.plan.settings;
  const Evidence used = accelerometer::at_one_rate(evidence);
  return answer_of(used, accelerometer::identify(used, problem_of(settings), refine_of(settings)));
}

Estimate predict(const Plan& plan) {
  return answer_of({plan, {}, {}}, accelerometer::predict(plan, problem_of(plan.settings), refine_of(plan.settings)));
}

}  // namespace

extern const Method accelerometer_tumble{
    .name = "accelerometer_tumble",
    .summary = "static model of an accelerometer from positions in gravity: any number of them, one mount or both",
    .source =
        "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slide 47, the form of GJB 2504; Lu "
        "Hanjie, Liu Yabin, Zhou Qiang, 2019, eq. (1), (4)-(6)",
    .needs_plan = true,
    .roles = accelerometer::roles,
    .options = options,
    .identify = identify,
    .compensates = true,
    .predict = predict,
    .takes_prior = true};

}  // namespace tumble::accelerometer_tumble
