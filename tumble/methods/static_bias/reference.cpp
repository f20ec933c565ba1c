#include "tumble/methods/static_bias/reference.hpp"

#include "tumble/earth/earth.hpp"
#include "tumble/reduce/rig_effects.hpp"
#include "tumble/rigs/error_names.hpp"

namespace tumble::static_bias {
namespace {

/// Given: vertical, whether the input axis is upright, else along the meridian; direction +1 up or north, -1 else.
Reference earth_rate_along(bool vertical, double direction, const Site& site) {
  const Vector3 level = earth_rate_in_level(site);
  return {direction * (vertical ? level.z : level.y), error_names::latitude,
          direction * (vertical ? -level.y : level.z) * latitude_sd(site), latitude_key(site.latitude)};
}

/// Given: as above. The rig may state how well gravity is known.
Reference gravity_along(bool vertical, double direction, const Plan& plan, Findings& findings) {
  const double g = gravity(*plan.site);
  if (vertical)
    return {direction * g, error_names::gravity,
            -direction * rig_sd(plan, error_names::gravity).value_or(gravity_sd(plan.site)), gravity_key(g)};
  // A tilt by an angle a of the axis moves a gravity component by g a (level axis) or g a^2/2 (vertical axis).
  findings.push_back({Finding::Severity::info, "tilt_changes_bias", {{"shift", g * si(1.0, "arcsec"), "ug"}}});
  return {};
}

}  // namespace

Reference reference_of(const Evidence& evidence, QuantityKind kind, Findings& findings) {
  const std::string& axis = evidence.plan.settings.word("axis");
  const bool is_rate = kind == QuantityKind::angular_rate;
  if (axis == "none" || !evidence.plan.site) {
    findings.push_back({axis == "none" ? Finding::Severity::info : Finding::Severity::warning,
                        "bias_includes_input",
                        {{"input", Phrase{is_rate ? "earth_rate_along_axis" : "gravity_along_axis"}}}});
    return {};
  }
  const bool vertical = axis == "up" || axis == "down";
  const double direction = axis == "down" || axis == "south" || axis == "west" ? -1.0 : 1.0;
  if (!is_rate) return gravity_along(vertical, direction, evidence.plan, findings);
  if (axis == "east" || axis == "west") return {};
  return earth_rate_along(vertical, direction, *evidence.plan.site);
}

}  // namespace tumble::static_bias
