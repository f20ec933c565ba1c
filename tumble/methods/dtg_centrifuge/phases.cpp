#include "tumble/methods/dtg_centrifuge/phases.hpp"

#include <cmath>

namespace tumble::dtg_centrifuge {
namespace {

constexpr double turns_sd = 4.5;           ///< [sd] of the turn, from which on it is one: p = 7e-6
constexpr double least_turn = 1e-6;        ///< [1] of the table's rate: below what an encoder's scale may be off by
constexpr std::size_t fewest_of_line = 8;  ///< parts of a level

/// Phase of each part against the mean line, by its place in the level: slope [rad] over the whole level, by least squares.
TurnOfLine slope_of(const Lines& lines) {
  const Complex mean = lines.value.line[0];
  double weight = 0.0, place = 0.0, phase = 0.0, n = 0.0;
  const auto each = [&](const auto& use) {
    for (std::size_t k = 0; k < lines.part.size(); ++k)
      if (lines.weight[k] > 0.0)
        use(lines.weight[k], (static_cast<double>(k) + 0.5) / static_cast<double>(lines.part.size()),
            std::arg(lines.part[k].line[0] / mean));
  };
  each([&](double w, double t, double p) { weight += w, place += w * t, phase += w * p, ++n; });
  if (n < static_cast<double>(fewest_of_line)) return {};
  place /= weight;
  phase /= weight;
  double squares = 0.0, products = 0.0, left = 0.0;
  each([&](double w, double t, double p) {
    squares += w * (t - place) * (t - place);
    products += w * (t - place) * (p - phase);
  });
  const double slope = products / squares;
  each([&](double w, double t, double p) { left += w * std::pow(p - phase - slope * (t - place), 2); });
  return {slope, std::sqrt(left / (n - 2.0) / squares)};
}

}  // namespace

TurnOfLine turn_of_line(const std::vector<Measured>& measured) {
  double sum = 0.0, weight = 0.0;
  for (const Measured& m : measured)
    for (const Signal signal : {gyro, reference}) {
      const Lines& lines = m.of[signal];
      if (!lines.present || std::abs(lines.value.line[0]) == 0.0) continue;
      const TurnOfLine slope = slope_of(lines);
      const double turned = m.theta_rate() * (m.stretch->end - m.stretch->begin), sd = slope.sd / turned;
      if (!(slope.sd > 0.0)) continue;
      sum += slope.value / turned / (sd * sd);
      weight += 1.0 / (sd * sd);
    }
  if (!(weight > 0.0)) return {};
  return {sum / weight, 1.0 / std::sqrt(weight)};
}

void check_turn(const std::vector<Measured>& measured, Findings& findings) {
  const TurnOfLine turn = turn_of_line(measured);
  if (std::abs(turn.value) < std::max(turns_sd * turn.sd, least_turn) || turn.sd == 0.0) return;
  findings.push_back({Finding::Severity::error,
                      "line_turns_against_angle",
                      {{"turn", turn.value, "ppm"}, {"sd", turn.sd, "ppm"}},
                      "table_angle"});
}

}  // namespace tumble::dtg_centrifuge
