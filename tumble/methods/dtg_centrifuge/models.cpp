#include <algorithm>
#include <cmath>

#include "tumble/methods/dtg_centrifuge/describe.hpp"
#include "tumble/reduce/output_model.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::dtg_centrifuge {
namespace {

using Input::w_x, Input::w_y, Input::f_x, Input::f_y, Input::f_z;

constexpr double along_slack =
    0.1;  ///< [g] of the specific force along the spin axis, where one orientation was tested

/// A quintic's f_X a^4 and f_Y a^4, a^2 = f_X^2 + f_Y^2, as the lines at the table's angle show them.
void add_quintic(const std::string& prefix, std::vector<Term>& terms) {
  const Regressor square = power(f_x, 2) + power(f_y, 2), fourth = square * square;
  terms.push_back({prefix + "p_4", "p_4", "deg/h/g^5", "", f_x * fourth});
  terms.push_back({prefix + "q_4", "q_4", "deg/h/g^5", "", f_y * fourth});
}

/// Specific force that the test covered.
std::vector<Covered> covered(const std::vector<Level>& levels) {
  double force = 0.0, low = standard_gravity, high = -standard_gravity;
  for (const Level& level : levels) {
    force = std::max(force, level.force);
    low = std::min(low, level.spin_up * standard_gravity);
    high = std::max(high, level.spin_up * standard_gravity);
  }
  const double slack = low < high ? 0.0 : along_slack * standard_gravity;
  return {{{{f_x, 1.0}}, -force, force}, {{{f_y, 1.0}}, -force, force}, {{{f_z, 1.0}}, low - slack, high + slack}};
}

/// What acted at the levels: across the spin axis in every direction, gravity along it.
std::vector<Felt> felt_at(const std::vector<Level>& levels) {
  constexpr int directions = 72;  // of a fifth-order term the greatest between two of them is 1 % above
  std::vector<Felt> all;
  for (const Level& level : levels)
    for (int k = 0; k < directions; ++k) {
      const double angle = two_pi * k / directions;
      Felt felt;
      felt.specific_force = {level.force * std::cos(angle), level.force * std::sin(angle),
                             level.spin_up * standard_gravity};
      all.push_back(felt);
    }
  return all;
}

}  // namespace

std::vector<OutputModel> models_of(const Estimate& estimate, const std::vector<Level>& levels) {
  std::vector<OutputModel> models;
  const Settings constants = defaults(truth_options(find_model("dynamically_tuned_gyro")));
  const auto outputs = find_model("dynamically_tuned_gyro").outputs(constants);
  for (const Output& output : outputs) {
    const bool first = output.channel == "gyro";
    const std::string prefix = first ? "" : "y_";
    if (!find_parameter(estimate, prefix + "D_x") || !find_parameter(estimate, prefix + "D_y")) continue;
    auto terms = output.terms;
    std::erase_if(terms, [&](const Term& term) { return term.name == prefix + "D_xy"; });
    add_quintic(prefix, terms);
    models.push_back(
        output_model(estimate, output.channel, first ? w_x : w_y, "deg/h", ranges_over(terms, felt_at(levels))));
    models.back().covered = covered(levels);
    models.back().in_region = true;
    models.back().caveats = {"even_drift_terms_remain"};
  }
  return models;
}

}  // namespace tumble::dtg_centrifuge
