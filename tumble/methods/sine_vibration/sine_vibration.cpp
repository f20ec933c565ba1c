#include <cmath>

#include "tumble/methods/method.hpp"
#include "tumble/methods/sine_vibration/describe.hpp"
#include "tumble/methods/sine_vibration/steady.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/units/error.hpp"

// Counts over windows of H seconds on a shaker at one frequency after the other:
//   N_j/(K_1 H) = a_0 + A sinc(fH) cos(2 pi f t_mid,j + p) + rounding                        (3.8)
//   |G(f)| = amplitude/(A_ref |sinc(fH)|)                                                    (3.15)
//   mean - mean at rest = (K_2 + 3 K_3 a_0) A^2/2                                            (3.12)

namespace tumble::sine_vibration {
namespace {

std::vector<Role> roles() {
  return {
      {"accelerometer", "", true,
       "units under test, one or several on one fixture: pulses of each counting window, or a specific force, mA, V",
       true},
      {"reference", "g", false,
       "acceleration of the fixture along the shake; without it, the level of the plan with its uncertainty is used"}};
}

std::vector<Option> options() {
  auto options = vibration::options();
  options.push_back(
      word("levels", {"auto", "square", "quartic"})
          .otherwise("auto")
          .says("terms of the mean shift: A^2 alone, or A^4 too; auto: A^4 too where the greatest level is "
                "more than 1.5 times the least"));
  options.push_back(quantity("third_order", "ug/g^3")
                        .at_least(0)
                        .otherwise("1 ug/g^3")
                        .says("size of K_3, which rectifies the second harmonic of the shake"));
  return options;
}

void require_points(const vibration::Data& data, const Measured& measured) {
  if (!measured.points.empty()) return;
  auto problems = errors_among(data.findings);
  for (auto& problem : errors_among(measured.findings)) problems.push_back(std::move(problem));
  if (problems.empty()) problems.emplace_back("no segment of the schedule has a sinusoidal vibration");
  throw Error(Error::Kind::bad_data, problems);
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  const Settings& settings = evidence.plan.settings;
  vibration::Data data = vibration::data_of(evidence);
  check_steadiness(data);
  report(progress, 0.2, "sine fits");
  const Measured measured = measure(data);
  require_points(data, measured);
  Findings findings = data.findings;
  findings.insert(findings.end(), measured.findings.begin(), measured.findings.end());
  report(progress, 0.7, "rectification");
  const auto rectified = rectify(data, measured, settings.word("levels"), findings);
  Estimate estimate = describe(evidence, data, measured, rectified);
  if (!measured.reference) findings.push_back({Finding::Severity::info, "level_from_plan", {}});
  add_tables(data, measured, rectified, estimate);
  compare_levels(evidence, data, measured, findings);
  report_rests(evidence, data, measured, estimate);
  report(progress, 1.0, "done");
  return finished(std::move(estimate), findings);
}

}  // namespace

extern const Method sine_vibration{
    .name = "sine_vibration",
    .summary = "accelerometers on a shaker, sine by sine: mean, sd and gain of the counts, vibration rectification",
    .source =
        "Lu Hanjie, Liu Yabin, Zhou Qiang, dynamic test of linear accelerometers based on INS pulse counting, 2019, "
        "sections 2.1-2.3",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify};

}  // namespace tumble::sine_vibration
