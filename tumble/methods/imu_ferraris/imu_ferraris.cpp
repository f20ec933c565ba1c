#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/imu_ferraris/report.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/units/error.hpp"

// Symbols of the source: K scale factors, R direction cosines, b biases of the accelerometers (a) and gyros (g), K_ga
// response of the gyros to specific force.

namespace tumble::imu_ferraris {
namespace {

/// [1] of half the range of an output, beyond which its axis is vertical: 37 deg.
constexpr double nearly_greatest = 0.8;
constexpr double least_turn = 10.0;  ///< [deg] of the rotations: a smaller one shows scale factors ten times worse

std::vector<Role> roles() {
  std::vector<Role> all;
  for (const char* letter : {"x", "y", "z"})
    all.push_back({std::string("accelerometer_") + letter, "", true,
                   std::string("accelerometer along ") + letter + ": specific force, or raw counts or voltage"});
  for (const char* letter : {"x", "y", "z"})
    all.push_back({std::string("gyro_") + letter, "", false,
                   std::string("gyro along ") + letter + ": angular rate, or raw counts or voltage"});
  return all;
}

std::vector<Option> options() {
  return {
      quantity("gravity", "m/s^2").above(0).says("gravity where the test was made; absent: that of the plan's [site]"),
      quantity("gravity_sd", "m/s^2").at_least(0).says("standard uncertainty of gravity; absent: by its origin"),
      linear::bias_instability_option("deg/h", "gyro_"),
      linear::bias_instability_option("ug", "accelerometer_"),
      quantity("pose_sd", "deg")
          .between(0, 20)
          .says("standard uncertainty of a pose about each level axis; absent: it is estimated from the poses"),
      quantity("rotation_angle", "deg").otherwise("360 deg").says("angle of each turn, right-handed about the axis"),
      quantity("rotation_angle_sd", "deg")
          .at_least(0)
          .otherwise("1 deg")
          .says("standard uncertainty of the angle, from turn to turn"),
      quantity("rotation_axis_sd", "deg")
          .between(0, 20)
          .says("standard uncertainty of the axis of a turn toward each other axis; absent: as of a pose"),
      word("axes", {"named", "any"})
          .otherwise("named")
          .says("any: outputs may be exchanged or reversed against the labels of the sections, and R states how"),
      text("labels").says("labels of the sections, where they differ: \"x_p=face 1, x_a=face 2\"")};
}

Vector3 three(const std::array<double, outputs>& values, std::size_t first) {
  return {values[first], values[first + 1], values[first + 2]};
}

Means means_of(const Plan& plan, const Recorded& recorded) {
  Means means;
  means.gyros = recorded.gyros;
  means.gravity = gravity_of(plan).value;
  for (std::size_t p = 0; p < poses; ++p) {
    const auto& section = recorded.section[p];
    means.force[p] = three(section.mean, 0);
    means.rate[p] = three(section.mean, 3);
    means.samples[p] = static_cast<double>(section.samples);
  }
  for (std::size_t t = 0; recorded.gyros && t < turns; ++t) {
    const auto& section = recorded.section[poses + t];
    const double share = 1.0 / static_cast<double>(section.parts);
    means.turned[t] = share * three(section.total, 3);
    means.turn_time[t] = share * section.time;
    means.turn_force[t] = (1.0 / section.time) * three(section.total, 0);
    means.angle[t] = plan.settings.number("rotation_angle");
  }
  return means;
}

/// "x_p" and so on where one output is nearly at its greatest or least and the others are in their middle; else empty.
std::string pose_shown(Vector3 force, Vector3 middle, Vector3 half) {
  std::string shown;
  for (std::size_t i = 0; i < 3; ++i) {
    const double share = (force[i] - middle[i]) / half[i];
    if (std::abs(share) > nearly_greatest) shown += fmt::format("{}_{}", imu::letters[i], share > 0.0 ? "p" : "a");
  }
  return shown.size() == 3 ? shown : "";
}

/// The poses that show the direction of another label, where each of the six directions occurs once; else empty.
Sentence exchanged_labels(const Means& means) {
  Vector3 low = means.force[0], high = low;
  for (const auto& f : means.force) {
    low = {std::min(low.x, f.x), std::min(low.y, f.y), std::min(low.z, f.z)};
    high = {std::max(high.x, f.x), std::max(high.y, f.y), std::max(high.z, f.z)};
  }
  std::set<std::string> all;
  std::vector<Sentence> text;
  for (std::size_t p = 0; p < poses; ++p) {
    const auto shown = pose_shown(means.force[p], 0.5 * (low + high), 0.5 * (high - low));
    all.insert(shown);
    if (shown != labels()[p]) text.push_back(say("{} is {}", Name{labels()[p]}, Name{shown}));
  }
  return all.size() == poses && !all.contains("") ? in_a_row(text, ", ") : Sentence();
}

/// Labels of poses about different axes exchanged leave no three axes to solve for.
Calibration calibrated(const Means& means) {
  try {
    return closed_form(means);
  } catch (const Error& error) {
    const auto text = exchanged_labels(means);
    if (text.empty()) throw;
    throw Error(error.kind, say("the labels of poses look exchanged: by the accelerometers {}; correct the "
                                "labels, or state them: labels = \"x_p=...\"",
                                text));
  }
}

void check_settings(const Settings& settings) {
  if (std::abs(settings.number("rotation_angle")) < si(least_turn, "deg"))
    throw Error(Error::Kind::bad_input, "[settings] rotation_angle must be at least 10 deg, of either sign");
}

/// Covariance, budget and degrees of freedom (Welch and Satterthwaite); values without the mean of the errors, which
/// is that of the cosine of the tilts.
void add_uncertainty(const std::vector<Cause>& causes, const Means& means, Estimate& estimate) {
  std::vector<ErrorLine> lines;
  for (const auto& cause : causes) {
    if (cause.key.empty()) {
      const Moments moments = moments_of(cause, means);
      lines.push_back(from_covariance(cause.name, moments.covariance));
      for (std::size_t p = 0; p < moments.shift.size(); ++p) estimate.parameters[p].value -= moments.shift[p];
    } else {
      lines.push_back(from_shifts(cause.name, as_column(signed_shift(cause, means)), cause.key));
    }
    lines.back().degrees_of_freedom.assign(estimate.parameters.size(), cause.freedom);
  }
  settle(estimate, lines);
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  const Plan& plan = evidence.plan;
  check_settings(plan.settings);
  Recorded data = recorded(evidence);
  report(progress, 0.5, "calibrating");
  const Means means = means_of(plan, data);
  const Calibration calibration = calibrated(means);
  Estimate estimate;
  estimate.findings = faults(plan, means, calibration, data);
  for (auto& finding : data.findings) estimate.findings.push_back(std::move(finding));
  const auto known = gravity_of(plan);
  estimate.findings.push_back(
      {Finding::Severity::info, "gravity_and_origin", {{"gravity", known.value, "m/s^2"}, {"origin", known.origin}}});
  estimate.parameters = named_parameters(data);
  const auto values = parameters_of(calibration);
  for (std::size_t i = 0; i < values.size(); ++i) estimate.parameters[i].value = values[i];
  add_uncertainty(causes(plan, means, calibration, data, estimate.findings), means, estimate);
  estimate.fit.observations = data.gyros ? 45 : 18;  // means of sections, three outputs each
  estimate.tables = {matrices(calibration, data), pose_table(means, calibration, data), covered(calibration, data)};
  estimate.models = models_of(estimate, calibration, data);
  return estimate;
}

}  // namespace

extern const Method imu_ferraris{
    .name = "imu_ferraris",
    .summary = "accelerometers and gyros of an IMU from six labelled poses and three turns by a known angle",
    .source =
        "F. Ferraris, U. Grimaldi, M. Parvis, Procedure for effortless in-field calibration of three-axis rate gyros "
        "and accelerometers, Sensors and Materials 7, 1995",
    .needs_plan = false,
    .roles = roles,
    .options = options,
    .identify = identify,
    .compensates = true};

}  // namespace tumble::imu_ferraris
