#include <cmath>

#include "tumble/methods/method.hpp"
#include "tumble/methods/random_vibration/describe.hpp"
#include "tumble/methods/random_vibration/measure.hpp"
#include "tumble/methods/random_vibration/screen.hpp"
#include "tumble/methods/random_vibration/statistics.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/units/error.hpp"

// Windows of H in random vibration against those at rest:
//   e_j = N_j - Nbar_static,  mean, s = sqrt(sum (e - mean e)^2/(n - 1))                        (3.7)
//   sigma^2 = INT S sinc^2(f H) df                                                              (3.13)
//   dMean/g_rms^2 = K_2 + 3 K_3 a_0                                                             (3.12)

namespace tumble::random_vibration {
namespace {

std::vector<Role> roles() {
  return {
      {"accelerometer", "", true,
       "the units under test, side by side on the fixture: pulses per window, or a current, voltage or specific "
       "force",
       true},
      {"reference", "g", false,
       "reference accelerometer, without gravity: subtracted from the units where it is the mean over each window"}};
}

std::vector<Option> options() {
  std::vector<Option> options = vibration::options();
  const std::vector<Option> own{
      text("types").says("units to be compared as one, \"quartz: Q1 Q2; wire: S1 S2\"; absent: each unit by itself"),
      quantity("level", "g")
          .above(0)
          .says("root mean square of the vibration as measured; absent: the level of the plan"),
      word("level_from", {"plan", "reference"})
          .otherwise("plan")
          .says("what gives the level that the mean shift is divided by the square of: the plan (or `level`), or the "
                "reference"),
      quantity("level_sd", "%")
          .at_least(0)
          .says("standard uncertainty of the level of the plan; absent: amplitude_sd of the rig"),
      integer("reference_lags")
          .between(0, 20)
          .otherwise("2")
          .says("windows of the reference before and after each window that are subtracted with it: a unit slower than "
                "the reference needs them")};
  options.insert(options.end(), own.begin(), own.end());
  return options;
}

void refuse_impossible(const Settings& settings) {
  if (settings.has("level") && settings.word("level_from") == "reference")
    throw Error(Error::Kind::bad_input, "[settings] level and level_from = \"reference\" exclude each other");
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  const Settings& settings = evidence.plan.settings;
  refuse_impossible(settings);
  report(progress, 0.0, "reading windows");
  vibration::Data data = vibration::data_of(evidence);
  skip_outliers(settings.integer("reference_lags"), data);
  const auto types = types_of(settings.has("types") ? settings.word("types") : "", data.units);
  Estimate estimate;
  estimate.findings = data.findings;
  const auto exposures = exposures_of(evidence, data, estimate.findings);
  for (const Exposure& exposure : exposures) {
    append(exposure, data, statistics_of(exposure, data, types, estimate.findings), estimate);
    report_faults(exposure, data, estimate, estimate.findings);
    for (auto& curve : error_curves(exposure, data)) estimate.curves.push_back(std::move(curve));
    for (const auto& unit : exposure.units) estimate.fit.observations += unit.windows;
  }
  append_orders(exposures, data, estimate);
  report_rests(exposures, data, estimate);
  report_wander(data, estimate.findings);
  forget_shared(estimate);
  estimate.fit.degrees_of_freedom = static_cast<double>(estimate.fit.observations);
  estimate.fit.chi_square = std::nan("");  // nothing is fitted to the windows
  estimate.tables.push_back(units_table(exposures, data, types, estimate));
  report(progress, 1.0, "done");
  return estimate;
}

}  // namespace

extern const Method random_vibration{
    .name = "random_vibration",
    .summary = "pulse error of accelerometers in random vibration, rectification, comparison of units and types",
    .source =
        "Lu Hanjie, Liu Yabin, Zhou Qiang, dynamic test of linear accelerometers based on INS pulse counting, 2019, "
        "section 2.4; density at zero frequency after Whittle, 1953",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify};

}  // namespace tumble::random_vibration
