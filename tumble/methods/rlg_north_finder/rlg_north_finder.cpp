#include <cmath>

#include "tumble/earth/earth.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/rlg_north_finder/closed_form.hpp"
#include "tumble/methods/rlg_north_finder/faults.hpp"
#include "tumble/methods/rlg_north_finder/outputs.hpp"
#include "tumble/methods/rlg_north_finder/predict.hpp"
#include "tumble/methods/rlg_north_finder/report.hpp"
#include "tumble/methods/rlg_north_finder/solve.hpp"
#include "tumble/reduce/output_model.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

// One ring laser gyro and two accelerometers on a manual two-axis table: eight positions, and whole turns about each
// body axis. Table at angles (o, i), o about the horizontal outer axis, i about the inner one = body z:
//   1 (0, 0)  2 (-90, 0)  3 (-90, 90)  4 (-90, 180)  5 (-90, 270)  6 (0, 360)  7 (180, 0)  8 (180, 90)
// with whole turns about z at 6, about y at 7 and about x at 8, both ways.

namespace tumble::rlg_north_finder {
namespace {

Summaries summaries_of(const linear::JointSolution& solution) {
  Summaries segments;
  for (std::size_t i = 0; i < outputs; ++i) segments[i] = solution.outputs[i].segments;
  return segments;
}

bool by_formulas(const Settings& settings) { return settings.word("estimator") == "closed_form"; }

void append(const Findings& some, Findings& all) { all.insert(all.end(), some.begin(), some.end()); }

std::vector<double> values_of(const Estimate& estimate) {
  std::vector<double> values;
  for (const auto& parameter : estimate.parameters) values.push_back(parameter.value);
  return values;
}

/// Scatter of the means of the accelerometers from stay to stay, the larger of both [m/s^2]; without drift by noise.
double scatter_of(const linear::JointSolution& solution, const std::vector<double>& parameters, bool with_drift) {
  double scatter = 0.0;
  for (const Which output : {accelerometer_x, accelerometer_y}) {
    double noise = 0.0;
    for (const auto& segment : solution.outputs[output].segments) noise = std::max(noise, segment.sd);
    const double scale = std::abs(parameters[output * per_output]);
    scatter = std::max(scatter, std::hypot(noise, with_drift ? solution.outputs[output].drift_sd : 0.0) / scale);
  }
  return scatter;
}

/// Tilts of the table. Tilts far beyond what the rig states give residuals that look like drift, which hides the tilts:
/// the fit is then repeated with a table that may be tilted so far.
Tilts tilts_by(const Prepared& prepared, const std::array<linear::Problem, outputs>& problems,
               const linear::JointSolution& solution, const std::vector<double>& parameters, double gravity) {
  const Settings& rig = prepared.evidence.plan.rig;
  const auto tilts = [&](const linear::JointSolution& by, const std::vector<double>& b, bool with_drift) {
    const Summaries segments = summaries_of(by);
    return tilts_of(measured(segments), segments, b, gravity, scatter_of(by, b, with_drift), rig);
  };
  const Tilts by_noise = tilts(solution, parameters, false);
  if (tilt_faults(by_noise, rig).empty()) return tilts(solution, parameters, true);
  Evidence tilted = prepared.evidence;
  const double largest = std::max({std::abs(by_noise.rho_x), std::abs(by_noise.rho_y), std::abs(by_noise.eta)});
  for (const char* name : {"level_sd", "orthogonality_sd"})
    tilted.plan.rig.set_number(name, std::max(rig.number(name), largest), Unit::parse("arcsec"));
  const auto again = linear::identify(tilted, problems);
  return tilts(again, values_of(least_squares_estimate(again)), true);
}

/// Faults of the path: the formulas are then refused, least squares uses what else shows a parameter.
void judge_path(const Summaries& segments, const Settings& settings, Findings& findings) {
  const std::vector<linear::SegmentSummary> of_gyro(segments[gyro].begin(), segments[gyro].end());
  const Path path = path_of(of_gyro);
  Findings faults = missing(path, Finding::Severity::error);
  append(not_whole(path, of_gyro), faults);
  if (by_formulas(settings) && !faults.empty()) throw Error(Error::Kind::bad_input, errors_among(faults));
  append(faults, findings);
}

/// Estimate by the chosen estimator. Where it fails, the order of the positions or rotations may be the reason.
Estimate estimate_of(const Evidence& evidence, const std::array<linear::Problem, outputs>& problems,
                     const linear::JointSolution& solution, const Findings& order, double gravity) {
  try {
    if (!by_formulas(evidence.plan.settings)) return least_squares_estimate(solution);
    return closed_form_estimate(linear::worked_out(evidence, problems), gravity);
  } catch (const Error& error) {
    auto all = errors_among(order);
    all.insert(all.end(), error.problems.begin(), error.problems.end());
    throw Error(error.kind, all);
  }
}

/// Counts become the angular rate about x and the specific forces along x and y.
std::vector<OutputModel> models_of(const Estimate& estimate, const linear::JointSolution& solution) {
  std::vector<OutputModel> models;
  for (const Which output : {gyro, accelerometer_x, accelerometer_y}) {
    const linear::Solution& alone = solution.outputs[output];
    const Wanted& scale = wanted()[output * per_output];
    models.push_back(output_model(estimate, role_of(output), *scale.input, output == gyro ? "deg/h" : "g",
                                  {alone.columns, alone.least, alone.greatest}));
    set_scale(estimate, scale.name, models.back());
  }
  return models;
}

Estimate answer(const Prepared& prepared) {
  const Plan& plan = prepared.evidence.plan;
  const auto problems = problems_of(plan);
  const double local_gravity = plan.site ? gravity(*plan.site) : standard_gravity;
  Findings findings = prepared.angles.findings;
  const linear::JointSolution solution = linear::identify(prepared.evidence, problems);
  const Summaries segments = summaries_of(solution);
  judge_path(segments, plan.settings, findings);
  const Means means = measured(segments);
  Findings order = order_faults(segments);
  if (order.empty()) order = turn_faults(prepared.evidence, segments);  // the accelerometers fit the plan
  Estimate estimate = estimate_of(prepared.evidence, problems, solution, order, local_gravity);
  append(findings, estimate.findings);
  append(order, estimate.findings);
  append(rotation_faults(plan, segments, estimate, prepared.angles.axes.size() > 1), estimate.findings);
  append(count_faults(prepared.evidence, segments, estimate), estimate.findings);
  const Tilts tilts = tilts_by(prepared, problems, solution, values_of(estimate), local_gravity);
  append(tilt_faults(tilts, plan.rig), estimate.findings);
  append(mounting_faults(estimate), estimate.findings);
  estimate.tables.push_back(positions_table(plan, segments));
  if (missing(path_of({segments[gyro].begin(), segments[gyro].end()}), Finding::Severity::error).empty()) {
    const auto squares = by_formulas(plan.settings) ? values_of(least_squares_estimate(solution)) : values_of(estimate);
    estimate.tables.push_back(estimators_table(squares, closed_form(means, segments, local_gravity), estimate));
  }
  estimate.tables.push_back(tilts_table(tilts, plan.rig));
  estimate.tables.push_back(linear::rig_errors(solution));
  estimate.models = models_of(estimate, solution);
  if (!prepared.angles.stands.empty()) estimate.tables.push_back(table::angles_table(prepared.angles));
  return estimate;
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  report(progress, 0.0, "north finder");
  Estimate estimate = answer(prepared(evidence));
  report(progress, 1.0, "done");
  return estimate;
}

Estimate predict(const Plan& plan) {
  const auto problems = problems_of(plan);
  const auto truths = truths_of(plan);
  const linear::JointSolution solution = linear::predict(plan, problems, truths);
  Estimate estimate = least_squares_estimate(solution);
  const Summaries segments = summaries_of(solution);
  append(missing(path_of({segments[gyro].begin(), segments[gyro].end()}), Finding::Severity::warning),
         estimate.findings);
  estimate.tables.push_back(positions_table(plan, segments));
  return estimate;
}

}  // namespace

extern const Method rlg_north_finder{
    .name = "rlg_north_finder",
    .summary = "ring laser gyro and two accelerometers of a north finder from eight positions and three rotations",
    .source =
        "CN113175941B (Xi'an University of Technology, 2023): the eight-position path, eq. (1); the other estimators "
        "are derived",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify,
    .compensates = true,
    .predict = predict,
    .takes_prior = true};

}  // namespace tumble::rlg_north_finder
