#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "tumble/methods/accelerometer_centrifuge/report.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/rigs/capabilities.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer_centrifuge {
namespace {

using accelerometer::Normalised;

/// A length minus what the fit took it to be [m]; nothing where the evidence does not show it.
std::optional<double> longer_by(const Normalised& fit, const char* length) {
  const auto& columns = fit.solution.columns;
  const auto column = std::ranges::find(columns, length, &Term::name);
  if (column == columns.end()) return std::nullopt;
  return fit.solution.fit.parameters[static_cast<std::size_t>(column - columns.begin())];
}

Normalised fitted(const Evidence& evidence, double centre) {
  const auto& settings = evidence.plan.settings;
  auto problem = problem_of(settings, centre);
  if (!scale_factor_is_known(settings))
    return accelerometer::identify(evidence, std::move(problem), remove_constant_terms);
  return accelerometer::identify_with_known_scale_factor(evidence, std::move(problem), remove_constant_terms);
}

Normalised expected(const Plan& plan) {
  auto problem = problem_of(plan.settings);
  if (!scale_factor_is_known(plan.settings))
    return accelerometer::predict(plan, std::move(problem), remove_constant_terms);
  return accelerometer::predict_with_known_scale_factor(plan, std::move(problem), remove_constant_terms);
}

/// Where the radius is a parameter, its uncertainty is not an error too.
Evidence with_radius_to_find(Evidence evidence, double longer) {
  evidence.plan = accelerometer_centrifuge::with_radius_to_find(std::move(evidence.plan), longer);
  for (auto& plan : evidence.plans)
    if (plan && is_fixed_on_arm(*plan))
      plan = std::make_shared<const Plan>(accelerometer_centrifuge::with_radius_to_find(*plan, longer));
  return evidence;
}

/// The specific force of the other terms depends on the radius and on the effective centre, so that the fit is repeated
/// with those estimated until they converge.
Estimate identify(const Evidence& evidence, const Progress&) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording to identify from");
  constexpr int most = 5;
  constexpr double enough = 1e-7;  // [m], 1e-7 of K_2 on an arm of a metre
  Evidence used = accelerometer::at_one_rate(evidence);
  double centre = 0.0;
  auto fit = fitted(used, centre);
  auto longer = longer_by(fit, "effective_radius"), further = longer_by(fit, "centre_offset");
  const auto moves = [&] { return std::max(std::abs(longer.value_or(0.0)), std::abs(further.value_or(0.0))) > enough; };
  for (int i = 0; (longer || further) && i < most && (i == 0 || moves()); ++i) {
    if (longer) used = with_radius_to_find(std::move(used), *longer);
    centre += further.value_or(0.0);
    fit = fitted(used, centre);
    longer = longer_by(fit, "effective_radius");
    further = longer_by(fit, "centre_offset");
  }
  return answer_of(used, std::move(fit), centre);
}

Estimate predict(const Plan& plan) {
  auto fit = expected(plan);
  if (!longer_by(fit, "effective_radius")) return answer_of({plan, {}, {}}, std::move(fit));
  Plan free = accelerometer_centrifuge::with_radius_to_find(plan, 0.0);
  for (auto& entry : free.recordings)
    if (entry.plan)
      entry.plan = std::make_shared<const Plan>(accelerometer_centrifuge::with_radius_to_find(*entry.plan, 0.0));
  return answer_of({free, {}, {}}, expected(free));
}

}  // namespace

extern const Method accelerometer_centrifuge{
    .name = "accelerometer_centrifuge",
    .summary = "non-linearity of an accelerometer at many g in both senses, and the radius to its effective centre",
    .source =
        "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slide 47, the form of GJB 2504; the "
        "idea of both senses on a centrifuge as in IEEE Std 836",
    .needs_plan = true,
    .roles = accelerometer::roles,
    .options = options,
    .identify = identify,
    .compensates = true,
    .predict = predict,
    .takes_prior = true};

}  // namespace tumble::accelerometer_centrifuge
