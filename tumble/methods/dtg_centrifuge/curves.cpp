#include "tumble/methods/dtg_centrifuge/curves.hpp"

#include <cmath>
#include <string>

#include "tumble/core/columns.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/dtg_centrifuge/levels.hpp"

namespace tumble::dtg_centrifuge {
namespace {

/// A point of a curve with its 95 % limits.
void add_function(const Function& f, double force, std::size_t group, const Ledger& ledger, Curve& curve) {
  const Ledger::Gradient gradient{{group, f.gradient}};
  const double v = ledger.variance(gradient);
  add_point(curve, force, f.value,
            v > 0.0 ? student_quantile(two_sided_95, ledger.degrees_of_freedom(gradient)) * std::sqrt(v) : 0.0);
}

/// Levels of one orientation of the spin axis, from the lowest force to the highest.
struct Side {
  std::size_t first, last;
  std::string name;  ///< behind that of a curve; empty: there is one orientation
};

std::vector<Side> sides_of(const Outcome& outcome, const std::vector<Level>& levels) {
  std::vector<Side> sides;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const bool up = levels[l].spin_up > 0.0;
    if (!sides.empty() && levels[l - 1].spin_up == levels[l].spin_up)
      sides.back().last = l;
    else
      sides.push_back({l, l, outcome.polynomial.both_orientations ? (up ? ", spin axis up" : ", spin axis down") : ""});
  }
  return sides;
}

}  // namespace

void add_curves(const Outcome& outcome, const std::vector<Level>& levels, std::size_t group, const Ledger& ledger,
                Estimate& estimate) {
  constexpr int steps = 60;
  const Levels of(outcome, levels);
  for (const Side& side : sides_of(outcome, levels))
    for (const bool of_zeta : {false, true}) {
      const std::string what = of_zeta ? "nonlinearity" : "sensitive term";
      Curve line{.name = what + ", polynomial" + side.name,
                 .figure = what + " over specific force",
                 .x = {"specific force", Unit::parse("g")},
                 .y = {of_zeta ? "zeta" : "K", of_zeta ? Unit::parse("%") : sensitivity()},
                 .band = "95 % confidence"};
      Curve points = line;
      points.name = what + ", measured" + side.name;
      points.points = true;
      for (std::size_t l = side.first; l <= side.last; ++l)
        add_function(of_zeta ? of.zeta(l) : of.K(l), levels[l].force, group, ledger, points);
      estimate.curves.push_back(std::move(points));
      if (!outcome.corrected || (of_zeta && !of.bends()) || side.first == side.last) continue;
      const Level &lowest = levels[side.first], &highest = levels[side.last];
      for (int i = 0; i <= steps; ++i) {
        Level between = lowest;
        between.force += (highest.force - lowest.force) * i / steps;
        add_function(of_zeta ? of.zeta_fitted(between, side.first) : of.fitted(between), between.force, group, ledger,
                     line);
      }
      estimate.curves.push_back(std::move(line));
    }
}

}  // namespace tumble::dtg_centrifuge
