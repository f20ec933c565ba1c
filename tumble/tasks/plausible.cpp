#include "tumble/tasks/plausible.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

#include "tumble/earth/earth.hpp"

namespace tumble {
namespace {

using Severity = Finding::Severity;

constexpr double greatest_scale_error = 0.2;
const double greatest_misalignment = si(3.0, "deg");

/// Methods that report the sign themselves have more to say about its cause.
bool is_about_sign(const Finding& finding) {
  return finding.code == "scale_factor_of_other_sign" || finding.code == "scale_factor_negative" ||
         finding.code == "scale_factor_negative_in_set" || finding.code == "gravity_inverted" ||
         finding.code == "rates_inverted" || finding.code == "wrong_sign" || finding.code == "rest_inverted" ||
         finding.code == "response_inverted";
}

/// Whether a finding lists the parameter among its `parameters`, a text of names between blanks.
bool lists(const Finding& finding, const std::string& parameter) {
  const auto list = std::ranges::find(finding.values, "parameters", &FindingValue::name);
  if (list == finding.values.end()) return false;
  const auto* names = std::get_if<std::string>(&list->value);
  return names != nullptr && (" " + *names + " ").find(" " + parameter + " ") != std::string::npos;
}

Finding finding(std::string code, const Parameter& parameter, double limit) {
  return {Severity::error,
          std::move(code),
          {{"parameter", parameter.name}, {"value", parameter.value, parameter.unit}, {"limit", limit, parameter.unit}},
          parameter.name};
}

}  // namespace

Findings implausible(const Estimate& estimate) {
  Findings findings;
  const bool said = std::ranges::any_of(estimate.findings, is_about_sign);
  for (const Parameter& parameter : estimate.parameters) {
    const bool relative = parameter.name.ends_with("scale_factor_error"),
               alone = parameter.name == "scale_factor_error";
    const bool positive = parameter.name == "scale_factor" || parameter.name == "effective_radius";
    if ((relative && parameter.value < -1.0) || (positive && parameter.value < 0.0)) {
      if (!said) findings.push_back(finding("wrong_sign", parameter, relative ? -1.0 : 0.0));
    } else if (alone && std::abs(parameter.value) > greatest_scale_error) {
      findings.push_back(finding("beyond_linear_form", parameter, greatest_scale_error));
    } else if (parameter.name.starts_with("misalignment") &&
               parameter.unit.dimension() == Unit::parse("deg").dimension() &&
               std::abs(parameter.value) > greatest_misalignment) {
      findings.push_back(finding("beyond_linear_form", parameter, greatest_misalignment));
    }
  }
  return findings;
}

Findings about_site(const Plan& plan) {
  constexpr double with_height = 6e-4, without_height = 1.4e-3;
  if (!plan.site || !plan.site->gravity) return {};
  const double normal = normal_gravity(plan.site->latitude, plan.site->height);
  const double difference = *plan.site->gravity / normal - 1.0;
  if (std::abs(difference) <= (plan.site->height == 0.0 ? without_height : with_height)) return {};
  return {{Severity::warning,
           "gravity_of_another_place",
           {{"gravity", *plan.site->gravity, "m/s^2"}, {"normal", normal, "m/s^2"}, {"difference", difference, "%"}}}};
}

bool is_undermined(const std::string& parameter, const Findings& findings) {
  return std::ranges::any_of(findings, [&](const Finding& one) {
    return one.severity == Severity::error && (is_about_sign(one) || one.where == parameter || lists(one, parameter));
  });
}

}  // namespace tumble
