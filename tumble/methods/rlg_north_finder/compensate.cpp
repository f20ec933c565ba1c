#include "tumble/methods/rlg_north_finder/compensate.hpp"

#include <algorithm>

namespace tumble::rlg_north_finder {
namespace {

double& shown_rate(Felt& felt) { return felt.rate.x; }
double& shown_x(Felt& felt) { return felt.specific_force.x; }
double& shown_y(Felt& felt) { return felt.specific_force.y; }

/// Misalignments and bias: all but the scale factor.
std::vector<Term> terms_of(Which output) {
  std::vector<Term> all;
  for (std::size_t i = 1; i < per_output; ++i) {
    const Wanted& term = wanted()[output * per_output + i];
    all.push_back({term.name, term.symbol, term.unit, term.description, term.regressor});
  }
  return all;
}

}  // namespace

Table covered(const linear::JointSolution& solution) {
  std::vector<Term> terms;
  std::vector<double> least, greatest;
  for (const Which output : {gyro, accelerometer_x, accelerometer_y})
    for (const Term& term : terms_of(output)) {
      const linear::Solution& alone = solution.outputs[output];
      const auto column = std::ranges::find(alone.columns, term.name, &Term::name);
      if (column == alone.columns.end()) continue;
      const auto at = static_cast<std::size_t>(column - alone.columns.begin());
      terms.push_back(term);
      least.push_back(alone.least[at]);
      greatest.push_back(alone.greatest[at]);
    }
  return regressors_table(terms, least, greatest);
}

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan) {
  std::vector<ErrorModel> models;
  for (const Which output : {gyro, accelerometer_x, accelerometer_y}) {
    ErrorModel model;
    model.role = role_of(output);
    model.scale_factor = wanted()[output * per_output].name;
    model.unit = output == gyro ? "deg/h" : "g";
    model.shown = output == gyro ? shown_rate : output == accelerometer_x ? shown_x : shown_y;
    model.terms = terms_of(output);
    if (const Channel* channel = channel_of(estimate, recording, model.role)) model.scale = per_second(*channel);
    models.push_back(std::move(model));
  }
  return tumble::compensate(models, estimate, recording, plan);
}

}  // namespace tumble::rlg_north_finder
