#include "tumble/tasks/optimisation/standard.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tumble::optimisation {
namespace {

using Set = std::vector<std::size_t>;

constexpr double same_direction = 3.5e-3;  ///< [rad]: 0.2 deg
constexpr double seen_rate = 1e-6;         ///< [rad/s] of the Earth's rate across the vertical, to tell an azimuth

bool at_rest(const prediction::Candidate& one) { return one.approach.empty() && one.felt.size() == 1; }

std::optional<Vector3> direction(Vector3 v, double least) {
  const double size = norm(v);
  if (!(size > least)) return std::nullopt;
  return 1.0 / size * v;
}

bool same(Vector3 a, Vector3 b) { return norm(a - b) < same_direction; }

/// Directions with this many components: 1 faces, 2 edges, 3 corners.
std::vector<Vector3> cube(int components) {
  std::vector<Vector3> out;
  for (const int z : {1, 0, -1})
    for (const int y : {1, 0, -1})
      for (const int x : {1, 0, -1})
        if (std::abs(x) + std::abs(y) + std::abs(z) == components)
          out.push_back(1.0 / std::sqrt(components) * Vector3{1.0 * x, 1.0 * y, 1.0 * z});
  return out;
}

/// The first candidate at rest with each of the directions up; none where one is missing.
Set with_up(const std::vector<prediction::Candidate>& all, const std::vector<Vector3>& directions) {
  Set out;
  for (const auto& wanted : directions) {
    const auto found = std::ranges::find_if(all, [&](const prediction::Candidate& one) {
      if (!at_rest(one)) return false;
      const auto up = direction(one.felt.front().specific_force, 0.1);
      return up && same(*up, wanted);
    });
    if (found == all.end()) return {};
    out.push_back(static_cast<std::size_t>(found - all.begin()));
  }
  return out;
}

/// Instrument axes along the vertical and the meridian in all 24 ways.
Set orientations(const std::vector<prediction::Candidate>& all) {
  Set out;
  const auto faces = cube(1);
  for (const auto& up_wanted : faces)
    for (const auto& north_wanted : faces) {
      if (std::abs(dot(up_wanted, north_wanted)) > 0.5) continue;
      const auto found = std::ranges::find_if(all, [&](const prediction::Candidate& one) {
        if (!at_rest(one)) return false;
        const auto up = direction(one.felt.front().specific_force, 0.1);
        if (!up || !same(*up, up_wanted)) return false;
        const Vector3 rate = one.felt.front().rate;
        const auto north = direction(rate - dot(rate, *up) * *up, seen_rate);
        return north && same(*north, north_wanted);
      });
      if (found == all.end()) return {};
      out.push_back(static_cast<std::size_t>(found - all.begin()));
    }
  return out;
}

/// Rates of one axis at a time, the others where the first such candidate has them.
Set rates(const std::vector<prediction::Candidate>& all) {
  Set out;
  std::vector<std::pair<std::string, std::map<std::string, Motion>>> begun;
  const auto position = [](const std::map<std::string, Motion>& axes) {
    std::vector<double> values;
    for (const auto& [axis, motion] : axes) values.push_back(motion.value);
    return values;
  };
  for (std::size_t j = 0; j < all.size(); ++j) {
    std::string turning;
    int moving = 0;
    for (const auto& [axis, motion] : all[j].work) {
      if (motion.kind == Motion::Kind::rate) turning = axis, ++moving;
      if (motion.kind == Motion::Kind::sine) moving = 9;
    }
    if (moving != 1) continue;
    auto found = std::ranges::find(begun, turning, [](const auto& one) { return one.first; });
    if (found == begun.end()) found = begun.insert(begun.end(), {turning, all[j].approach});
    if (position(found->second) == position(all[j].approach)) out.push_back(j);
  }
  return out;
}

Set together(Set a, const Set& b) {
  if (a.empty() || b.empty()) return {};
  for (const auto j : b)
    if (std::ranges::find(a, j) == a.end()) a.push_back(j);
  return a;
}

}  // namespace

std::vector<StandardSet> standard_sets(const std::vector<prediction::Candidate>& all) {
  const Set faces = with_up(all, cube(1)), edges = with_up(all, cube(2)), corners = with_up(all, cube(3));
  const Set eighteen = together(faces, edges), cubes = orientations(all), turning = rates(all);
  const std::vector<StandardSet> known = {{"6 faces", faces},
                                          {"12 edges", edges},
                                          {"6 faces + 12 edges", eighteen},
                                          {"6 faces + 12 edges + 8 corners", together(eighteen, corners)},
                                          {"24 cube orientations", cubes},
                                          {"24 cube orientations + 12 edges", together(cubes, edges)},
                                          {"equal rates of each axis", turning},
                                          {"6 faces + equal rates", together(faces, turning)},
                                          {"6 faces + 12 edges + equal rates", together(eighteen, turning)}};
  std::vector<StandardSet> out;
  for (const auto& set : known)
    if (!set.candidates.empty()) out.push_back(set);
  return out;
}

}  // namespace tumble::optimisation
