#include "tumble/tasks/plausible.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tumble/earth/earth.hpp"
#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/reduce/mistaken_unit.hpp"
#include "tumble/rigs/capabilities.hpp"
#include "tumble/rigs/error_names.hpp"

namespace tumble {
namespace {

using Severity = Finding::Severity;

constexpr double greatest_scale_error = 0.2;
constexpr double sds_beyond_chance = 4.0;
const double greatest_misalignment = si(3.0, "deg");

/// Angles of the input axis of one output, by the models of instruments. Those of triads are not limited.
constexpr std::array<std::string_view, 7> misalignments{"misalignment",   "misalignment_o", "misalignment_p",
                                                        "misalignment_O", "misalignment_S", "misalignment_y",
                                                        "misalignment_z"};

/// Methods that report the sign themselves have more to say about its cause.
constexpr std::array<std::string_view, 12> about_sign{"gravity_inverted",
                                                      "gyro_axis_is_another",
                                                      "gyro_counts_down",
                                                      "gyro_gain_far_from_stated",
                                                      "gyro_reversed",
                                                      "rates_inverted",
                                                      "response_inverted",
                                                      "rest_inverted",
                                                      "scale_factor_negative",
                                                      "scale_factor_negative_in_set",
                                                      "scale_factor_of_other_sign",
                                                      "wrong_sign"};

/// Whether a parameter is the relative error of the scale factor of a channel of a triad, in one of the calibrations
/// that imu_channel_calibration compares or in the only one.
bool is_scale_factor_error_of_triad(const std::string& name) {
  for (const char* calibration : {"", "split.", "whole_minus_split."})
    for (const imu::Kind kind : imu::kinds)
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (name == calibration + imu::role_of(kind, axis) + "_scale_factor_error") return true;
  return false;
}

/// Output of a channel for an input of one, as a parameter shows it. A scale factor in pulses or volts may have any value.
struct Gain {
  double value = 1.0;
  bool of_rate = true, of_force = true;
  bool at_frequency = false;
};

std::optional<Gain> gain_by(const Parameter& parameter) {
  if (parameter.name == "scale_factor_error") return Gain{1.0 + parameter.value};
  if (parameter.unit.dimension() != Dimension{}) return std::nullopt;
  if (parameter.symbol == "|H|") return Gain{parameter.value, true, true, true};
  for (const imu::Kind kind : imu::kinds)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string role = imu::role_of(kind, axis);
      const bool gyro = kind == imu::Kind::gyro;
      if (parameter.name == role + "_scale_factor") return Gain{parameter.value, gyro, !gyro};
      for (const char* calibration : {"", "split."})
        if (parameter.name == calibration + role + "_scale_factor_error")
          return Gain{1.0 + parameter.value, gyro, !gyro};
    }
  return std::nullopt;
}

std::optional<MistakenUnit> mistaken_unit_of(const Gain& gain) {
  const auto rate = gain.of_rate ? mistaken_unit_of_rate(gain.value) : std::nullopt;
  return rate || !gain.of_force ? rate : mistaken_unit_of_force(gain.value);
}

/// Gains that are those of another unit. Of gains at several frequencies the first one tells.
void look_at_units(const Estimate& estimate, Findings& findings) {
  if (std::ranges::find(estimate.findings, std::string_view("unit_mistaken"), &Finding::code) !=
      estimate.findings.end())
    return;
  bool first = true;
  for (const Parameter& parameter : estimate.parameters) {
    const auto gain = gain_by(parameter);
    if (!gain || (gain->at_frequency && !first)) continue;
    first = first && !gain->at_frequency;
    const auto unit = mistaken_unit_of(*gain);
    if (!unit) continue;
    findings.push_back(
        {Severity::error,
         "gain_of_another_unit",
         {{"parameter", parameter.name}, {"gain", gain->value}, {"unit", unit->of}, {"read_as", unit->read_as}},
         parameter.name});
  }
}

bool is_about_sign(const Finding& finding) {
  return std::ranges::find(about_sign, std::string_view(finding.code)) != about_sign.end();
}

/// Findings of a channel on which all parameters depend.
bool is_about_everything(const Finding& finding) {
  return is_about_sign(finding) || finding.code == "temperature_sensor_stuck";
}

/// Indices of the parameters that a place concerns: the parameter of that name, or those that the samples of a channel
/// give. Empty: the place is neither (a file, a segment, a channel on which all depends, nothing).
std::vector<std::size_t> concerned(const std::string& where, const std::vector<Parameter>& all) {
  std::vector<std::size_t> indices;
  const auto is_of = [&](const Parameter& one) { return std::ranges::find(one.channels, where) != one.channels.end(); };
  const bool channel = std::ranges::any_of(all, is_of);
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].name == where || (channel && (all[i].channels.empty() || is_of(all[i])))) indices.push_back(i);
  return indices;
}

Finding finding(std::string code, const Parameter& parameter, double limit) {
  return {Severity::error,
          std::move(code),
          {{"parameter", parameter.name}, {"value", parameter.value, parameter.unit}, {"limit", limit, parameter.unit}},
          parameter.name};
}

/// The plan with the arm, of the test or of one of its recordings; null where nothing turns on an arm.
const Plan* plan_of_arm(const Plan& plan) {
  if (is_fixed_on_arm(plan)) return &plan;
  for (const auto& recording : plan.recordings)
    if (recording.plan && is_fixed_on_arm(*recording.plan)) return recording.plan.get();
  return nullptr;
}

/// The distance to the effective centre, against the one that the plan states and how well it states it.
void look_at_radius(const Estimate& estimate, const Plan& plan, Findings& findings) {
  const Parameter* radius = find_parameter(estimate, "effective_radius");
  const Plan* arm = plan_of_arm(plan);
  if (radius == nullptr || arm == nullptr || radius->value < 0.0) return;
  const double nominal = arm->rig.number("radius") + arm->rig.number("lever_x");
  const double own = standard_uncertainty(estimate, static_cast<std::size_t>(radius - estimate.parameters.data()));
  const double stated = std::hypot(arm->rig.number("radius_sd"), arm->rig.number("lever_sd"));
  if (!(std::abs(radius->value - nominal) > sds_beyond_chance * std::hypot(own, stated))) return;
  findings.push_back({Severity::error,
                      "radius_unlike_plan",
                      {{"parameter", radius->name},
                       {"value", radius->value, radius->unit},
                       {"nominal", nominal, radius->unit},
                       {"sd", stated, radius->unit}},
                      radius->name});
}

/// Whether a number can be squared.
bool is_in_range(double value) {
  const double size = std::abs(value);
  return size == 0.0 || (size > 1e-150 && size < 1e150);
}

/// Values whose squares are beyond the range of numbers, and variances that went there.
void look_at_range(const Estimate& estimate, Findings& findings) {
  std::string names;
  std::vector<std::size_t> about;
  Occurrences parameters{0, {}, {}};
  for (std::size_t p = 0; p < estimate.parameters.size(); ++p) {
    const Parameter& parameter = estimate.parameters[p];
    if (is_in_range(parameter.value) && std::isfinite(estimate.covariance(p, p))) continue;
    if (parameters.count++ == 0) parameters.first = parameter.name;
    names += (names.empty() ? "" : " ") + parameter.name;
    about.push_back(p);
  }
  if (parameters.count == 0) return;
  findings.push_back({Severity::error, "out_of_range", {{"parameters", names}}, "", parameters});
  findings.back().about = std::move(about);
}

}  // namespace

Findings implausible(const Estimate& estimate, const Plan& plan) {
  Findings findings;
  const bool said = std::ranges::any_of(estimate.findings, is_about_sign);
  for (const Parameter& parameter : estimate.parameters) {
    const bool alone = parameter.name == "scale_factor_error",
               relative = alone || is_scale_factor_error_of_triad(parameter.name);
    const bool positive = parameter.name == "scale_factor" || parameter.name == "effective_radius";
    if ((relative && parameter.value < -1.0) || (positive && parameter.value < 0.0)) {
      if (!said) findings.push_back(finding("wrong_sign", parameter, relative ? -1.0 : 0.0));
    } else if (alone && std::abs(parameter.value) > greatest_scale_error) {
      findings.push_back(finding("beyond_linear_form", parameter, greatest_scale_error));
    } else if (std::ranges::find(misalignments, parameter.name) != misalignments.end() &&
               parameter.unit.dimension() == Unit::parse("deg").dimension() &&
               std::abs(parameter.value) > greatest_misalignment) {
      findings.push_back(finding("beyond_linear_form", parameter, greatest_misalignment));
    }
  }
  look_at_units(estimate, findings);
  look_at_radius(estimate, plan, findings);
  look_at_range(estimate, findings);
  return findings;
}

Findings about_site(const Plan& plan) {
  constexpr double with_height = 6e-4, without_height = 1.4e-3;
  if (!plan.site || !plan.site->gravity) return {};
  const double normal = normal_gravity(plan.site->latitude, plan.site->height.value_or(0.0));
  const double difference = *plan.site->gravity / normal - 1.0;
  if (std::abs(difference) <= (plan.site->height ? with_height : without_height)) return {};
  return {{Severity::warning,
           "gravity_of_another_place",
           {{"gravity", *plan.site->gravity, "m/s^2"}, {"normal", normal, "m/s^2"}, {"difference", difference, "%"}}}};
}

namespace {

/// One finding for all parameters of whose variance more than half is in this line of the budget.
void add_ruled(const Estimate& estimate, const char* source, const char* code, FindingValue sd, Findings& findings) {
  const auto line = std::ranges::find(estimate.budget, source, &Contribution::source);
  if (line == estimate.budget.end()) return;
  Occurrences parameters{0, {}, {}};
  double most = 0.5;
  for (std::size_t p = 0; p < estimate.parameters.size(); ++p) {
    const double total = estimate.covariance(p, p), share = total > 0.0 ? line->variance(p) / total : 0.0;
    if (!(share > 0.5)) continue;
    if (parameters.count++ == 0) parameters.first = estimate.parameters[p].name;
    if (share > most) most = share, parameters.worst = estimate.parameters[p].name;
  }
  if (parameters.count > 0)
    findings.push_back({Severity::info, code, {{"share", most, "%"}, std::move(sd)}, "", parameters});
}

}  // namespace

Findings ruled_by_site(const Plan& plan, const Estimate& estimate) {
  Findings findings;
  if (!plan.site) return findings;
  add_ruled(estimate, error_names::latitude, "latitude_rules", {"sd", latitude_sd(*plan.site), "arcsec"}, findings);
  if (!plan.site->gravity)
    add_ruled(estimate, error_names::gravity, "gravity_by_formula_rules", {"sd", gravity_sd(plan.site), "ug"},
              findings);
  return findings;
}

void settle_findings(Estimate& estimate) {
  for (Finding& finding : estimate.findings) {
    if (is_about_everything(finding))
      finding.about.clear();
    else if (finding.about.empty())
      finding.about = concerned(finding.where, estimate.parameters);
  }
}

bool is_undermined(const Estimate& estimate, const std::string& parameter) {
  const auto place = std::ranges::find(estimate.parameters, parameter, &Parameter::name);
  const auto index = static_cast<std::size_t>(place - estimate.parameters.begin());
  bool known = place != estimate.parameters.end();
  std::vector<std::string> hidden_in;  // channels
  for (const Finding& finding : estimate.findings)
    for (const HiddenParameter& hidden : finding.hidden)
      if (hidden.name == parameter) known = true, hidden_in.push_back(hidden.channel);
  return std::ranges::any_of(estimate.findings, [&](const Finding& one) {
    if (one.severity != Severity::error || is_about_limit(one)) return false;
    return !known || one.about.empty() || std::ranges::find(one.about, index) != one.about.end() ||
           (!one.where.empty() && std::ranges::find(hidden_in, one.where) != hidden_in.end());
  });
}

}  // namespace tumble
