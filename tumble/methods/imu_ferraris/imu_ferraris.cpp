#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tumble/methods/imu_ferraris/compensate.hpp"
#include "tumble/methods/imu_ferraris/report.hpp"
#include "tumble/methods/imu_ferraris/trial.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/units/error.hpp"

// Symbols of the source: K scale factors, R direction cosines, b biases of the accelerometers (a) and gyros (g), K_ga
// response of the gyros to specific force.

namespace tumble::imu_ferraris {
namespace {

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
  using Type = Option::Type;
  return {
      {"gravity", Type::quantity, "m/s^2", "", {}, "where the test was made; without it that of the plan's [site]"},
      {"gravity_sd", Type::quantity, "m/s^2", "", {}, "its standard uncertainty"},
      {"pose_sd",
       Type::quantity,
       "deg",
       "",
       {},
       "how squarely the unit was laid, about each level axis; without it the poses show it"},
      {"rotation_angle", Type::quantity, "deg", "360 deg", {}, "of each turn, right-handed about the axis"},
      {"rotation_angle_sd", Type::quantity, "deg", "1 deg", {}, "its standard uncertainty, from turn to turn"},
      {"rotation_axis_sd",
       Type::quantity,
       "deg",
       "",
       {},
       "how far the axis of a turn leans toward each other axis; without it as a pose does"},
      {"axes",
       Type::word,
       "1",
       "named",
       {"named", "any"},
       "any: outputs may be exchanged or reversed against the sections' labels, which R then says"},
      {"labels", Type::text, "1", "", {}, "of the sections, where they differ: \"x_p=face 1, x_a=face 2\""},
  };
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

/// "x_p" and so on of what an output nearly at its greatest and the others in their middle mean; empty: not clear.
std::string pose_shown(Vector3 force, Vector3 middle, Vector3 half) {
  std::string shown;
  for (std::size_t i = 0; i < 3; ++i) {
    const double share = (imu::component(force, i) - imu::component(middle, i)) / imu::component(half, i);
    if (std::abs(share) > 0.8) shown += fmt::format("{}_{}", imu::letters[i], share > 0.0 ? "p" : "a");
  }
  return shown.size() == 3 ? shown : "";
}

/// Which pose shows what another label says, where each of the six directions is there once.
std::string exchanged_labels(const Means& means) {
  Vector3 low = means.force[0], high = low;
  for (const auto& f : means.force) {
    low = {std::min(low.x, f.x), std::min(low.y, f.y), std::min(low.z, f.z)};
    high = {std::max(high.x, f.x), std::max(high.y, f.y), std::max(high.z, f.z)};
  }
  std::set<std::string> all;
  std::string text;
  for (std::size_t p = 0; p < poses; ++p) {
    const auto shown = pose_shown(means.force[p], 0.5 * (low + high), 0.5 * (high - low));
    all.insert(shown);
    if (shown != labels()[p]) text += fmt::format("{}{} is {}", text.empty() ? "" : ", ", labels()[p], shown);
  }
  return all.size() == poses && !all.contains("") ? text : "";
}

/// Labels of poses about different axes exchanged leave no three axes to solve for.
Calibration calibrated(const Means& means) {
  try {
    return closed_form(means);
  } catch (const Error& error) {
    const auto text = exchanged_labels(means);
    if (text.empty()) throw;
    throw Error(error.kind, fmt::format("the labels of poses look exchanged: by the accelerometers {}; put the labels "
                                        "right, or say which is which: labels = \"x_p=...\"",
                                        text));
  }
}

void check_settings(const Settings& settings) {
  std::vector<std::string> problems;
  if (std::abs(settings.number("rotation_angle")) < si(10.0, "deg"))
    problems.push_back("rotation_angle must be 10 deg at least, of either sign");
  for (const char* name : {"gravity_sd", "pose_sd", "rotation_angle_sd", "rotation_axis_sd"})
    if (settings.has(name) && settings.number(name) < 0.0)
      problems.push_back(std::string(name) + " must not be negative");
  for (const char* name : {"pose_sd", "rotation_axis_sd"})
    if (settings.has(name) && settings.number(name) > si(20.0, "deg"))
      problems.push_back(std::string(name) + " must be below 20 deg: the six poses would not be six directions");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

/// Covariance, budget and degrees of freedom (Welch and Satterthwaite).
void add_uncertainty(const std::vector<Cause>& causes, const Means& means, Estimate& estimate) {
  const std::size_t n = estimate.parameters.size();
  estimate.covariance = Matrix(n, n);
  std::vector<double> spread(n, 0.0);
  for (const auto& cause : causes) {
    const Matrix moments = second_moments(cause, means);
    Contribution line{cause.name, std::vector<double>(n)};
    for (std::size_t i = 0; i < n * n; ++i) estimate.covariance.values[i] += moments.values[i];
    for (std::size_t i = 0; i < n; ++i) {
      line.variance[i] = moments(i, i);
      if (std::isfinite(cause.freedom)) spread[i] += moments(i, i) * moments(i, i) / cause.freedom;
    }
    estimate.budget.push_back(std::move(line));
  }
  for (std::size_t i = 0; i < n; ++i)
    if (spread[i] > 0.0)
      estimate.parameters[i].degrees_of_freedom = estimate.covariance(i, i) * estimate.covariance(i, i) / spread[i];
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  const Plan& plan = evidence.plan;
  check_settings(plan.settings);
  Recorded data = recorded(evidence);
  report(progress, 0.5, "calibrating");
  const Means means = means_of(plan, data);
  const Calibration calibration = calibrated(means);
  Estimate estimate;
  estimate.method = "imu_ferraris";
  estimate.findings = faults(plan, means, calibration, data);
  if (auto problems = errors_among(estimate.findings); !problems.empty())
    throw Error(Error::Kind::bad_data, std::move(problems));
  for (auto& finding : data.findings) estimate.findings.push_back(std::move(finding));
  const auto known = gravity_of(plan);
  estimate.findings.push_back({Finding::Severity::info,
                               "gravity " + format_in(known.value, Unit::parse("m/s^2")) + " m/s^2, " + known.origin,
                               ""});
  estimate.parameters = named_parameters(data);
  const auto values = parameters_of(calibration);
  for (std::size_t i = 0; i < values.size(); ++i) estimate.parameters[i].value = values[i];
  add_uncertainty(causes(plan, means, calibration, data, estimate.findings), means, estimate);
  estimate.fit.observations = data.gyros ? 45 : 18;  // means of sections, three outputs each
  estimate.tables = {matrices(calibration, data), pose_table(means, calibration, data)};
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
    .trial = trial,
    .compensate = compensate,
    .predict = nullptr};

}  // namespace tumble::imu_ferraris
