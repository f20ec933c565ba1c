#include <algorithm>
#include <cmath>

#include "tumble/math/parallel.hpp"
#include "tumble/math/rounding_share.hpp"
#include "tumble/methods/north_finding/bench.hpp"
#include "tumble/reduce/rig_effects.hpp"
#include "tumble/rigs/error_names.hpp"

namespace tumble::north_finding {
namespace {

constexpr double turn_rounding = 1e-13;  ///< [1] and [rad] rounding of a rotation
constexpr double same_turn = 1e-5;       ///< [1] of the largest, within which the turns by one disturbance are equal

/// Rotation vector [rad] of a small passive rotation.
Vector3 vector_of(const Rotation& r) { return {0.5 * (r.y.z - r.z.y), 0.5 * (r.z.x - r.x.z), 0.5 * (r.x.y - r.y.x)}; }

Rotation small_rotation(Vector3 v) {
  const double angle = norm(v);
  return angle > 0.0 ? about((1.0 / angle) * v, angle) : Rotation{};
}

bool same(const View& a, const View& b) {
  const auto near = [](Vector3 p, Vector3 q, double scale) { return norm(p - q) <= turn_rounding * scale; };
  return near(a.turn.x, b.turn.x, 1.0) && near(a.turn.y, b.turn.y, 1.0) && near(a.turn.z, b.turn.z, 1.0) &&
         near(a.force, b.force, 10.0) && near(a.spin, b.spin, 1e-3);
}

/// The rows that the error moves.
void move_rows(const Bench& bench, const ErrorDraw& draw, std::size_t power_up, std::vector<std::vector<Move>>& moves) {
  const auto& base = bench.index.base_from_level;
  const auto& conducted = bench.signals.front().evidence.test.power_ups[power_up];
  const Matrix errors = error_values(conducted, draw.error,
                                     [&](std::size_t segment) { return !draw.only || draw.only->segment == segment; });
  const Attitude nominal(conducted, {}), disturbed(conducted, errors);
  for (std::size_t c = 0; c < bench.signals.size(); ++c)
    for (std::size_t r = 0; r < bench.signals[c].rows.size(); ++r) {
      const Row& row = bench.signals[c].rows[r];
      if (row.power_up != power_up || (draw.only && row.start != draw.only->start)) continue;
      const View before = nominal.at(row.at, base), after = disturbed.at(row.at, base);
      if (!same(before, after)) moves[c].push_back({r, before, after});
    }
}

/// Remove the turn of the base as a whole, as far as its attitude is estimated.
void remove_turn_of_base(const std::vector<bool>& estimated, std::size_t rows, Disturbance& out) {
  std::vector<Vector3> turns;
  double largest = 0.0;
  for (const auto& moves : out.moves)
    for (const auto& move : moves) {
      turns.push_back(vector_of(inverse(move.before.turn) * move.after.turn));
      largest = std::max(largest, norm(turns.back()));
    }
  if (turns.size() != rows || largest < turn_rounding) return;
  for (const auto& turn : turns)
    if (norm(turn - turns.front()) > same_turn * largest + turn_rounding) return;
  const Vector3 remaining{estimated[0] ? 0.0 : turns.front().x, estimated[1] ? 0.0 : turns.front().y, 0.0};
  const bool any = norm(remaining) > rounding_share * largest;
  for (auto& moves : out.moves) {
    if (!any) moves.clear();
    for (auto& move : moves) {
      move.after = move.before;
      move.after.turn = move.before.turn * small_rotation(remaining);
    }
  }
}

}  // namespace

std::vector<Disturbance> disturbances_of(const Bench& bench, bool estimates_pitch, bool estimates_roll) {
  std::vector<const ConductedTest*> channels;
  for (const auto& signal : bench.signals) channels.push_back(&signal.evidence.test);
  auto draws = draws_of(channels);
  // the latitude is one of the quantities of the model
  std::erase_if(draws, [](const ErrorDraw& draw) { return draw.error.error.name == error_names::latitude; });
  std::size_t rows = 0;
  for (const auto& signal : bench.signals) rows += signal.rows.size();
  std::vector<Disturbance> disturbances(draws.size());
  parallel_for(draws.size(), [&](std::size_t k) {
    const ErrorDraw& draw = draws[k];
    disturbances[k] = {draw.error.error.name, draw.only ? "" : key_of(*channels.front(), draw.error),
                       std::vector<std::vector<Move>>(bench.signals.size())};
    const auto& power_ups = bench.signals.front().evidence.test.power_ups;
    for (std::size_t u = 0; u < power_ups.size(); ++u)
      if (draw.only ? draw.only->power_up == u : power_ups[u].plan_number == draw.error.plan)
        move_rows(bench, draw, u, disturbances[k].moves);
    if (!draw.only) remove_turn_of_base({estimates_roll, estimates_pitch}, rows, disturbances[k]);
  });
  std::erase_if(disturbances, [](const Disturbance& disturbance) {
    return std::ranges::all_of(disturbance.moves, [](const auto& moves) { return moves.empty(); });
  });
  return disturbances;
}

}  // namespace tumble::north_finding
