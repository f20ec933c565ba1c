#include "tumble/methods/accelerometer_four_position/doubts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tumble/math/median.hpp"
#include "tumble/methods/accelerometer_four_position/set_points.hpp"

namespace tumble::accelerometer_four_position {
namespace {

/// [K] by which a thermometer may differ from the set point at one temperature more than at the others. Chosen: chambers hold
/// 2 K.
constexpr double off_at_one = 2.5;
/// [K] by which it may differ at all of them, beside what the unit is said to heat itself by. Chosen as above.
constexpr double off_at_all = 2.5;
constexpr double fewest_windows_at_level = 8.0;  ///< that count nothing: fewer may do so by chance

void about_set_points(const Bench& bench, Findings& findings) {
  const std::vector<double> off = off_set_points(bench);
  if (off.empty()) return;
  const double usual = median(off);
  std::size_t worst = 0;
  for (std::size_t g = 0; g < off.size(); ++g)
    if (std::abs(off[g] - usual) > std::abs(off[worst] - usual)) worst = g;
  if (std::abs(usual) <= off_at_all && std::abs(off[worst] - usual) <= off_at_one) return;
  findings.push_back({Finding::Severity::warning,
                      "temperature_off_set_point",
                      {{"measured", bench.group_temperature[worst], "degC"},
                       {"planned", bench.group_temperature[worst] - off[worst], "degC"},
                       {"usual", usual, "K"}}});
}

/// Whether every window of a position counts zero.
bool counts_nothing(const Bench& bench, std::size_t position) {
  double windows = 0.0;
  for (const double v : bench.evidence.test.stretches[bench.positions[position].stretch].values) {
    if (v != 0.0 && !std::isnan(v)) return false;
    windows += std::isnan(v) ? 0.0 : 1.0;
  }
  return windows >= fewest_windows_at_level;
}

/// Both level positions of a set count nothing: a bias and an angle that together are below one pulse in the whole position, in
/// both, are less probable than a converter with a dead band.
void about_level_positions(const Bench& bench, Findings& findings) {
  std::set<std::string> labels;
  for (const Cell& cell : bench.cells)
    if (bench.pulse > 0.0 && cell.second && cell.fourth && counts_nothing(bench, *cell.second) &&
        counts_nothing(bench, *cell.fourth))
      for (const std::size_t i : {*cell.second, *cell.fourth}) labels.insert("'" + bench.positions[i].label + "'");
  if (labels.empty()) return;
  findings.push_back({Finding::Severity::warning,
                      "level_positions_count_nothing",
                      {{"segments", fmt::format("{}", fmt::join(labels, ", "))}}});
}

}  // namespace

Findings doubts_about(const Bench& bench) {
  Findings findings;
  about_set_points(bench, findings);
  about_level_positions(bench, findings);
  return findings;
}

}  // namespace tumble::accelerometer_four_position
