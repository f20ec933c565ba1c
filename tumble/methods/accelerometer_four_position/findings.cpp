#include "tumble/methods/accelerometer_four_position/findings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/methods/accelerometer_four_position/doubts.hpp"
#include "tumble/methods/accelerometer_four_position/lag.hpp"
#include "tumble/reduce/pulses/rounding.hpp"

namespace tumble::accelerometer_four_position {
namespace {

using enum Finding::Severity;

constexpr double least_freedom_of_clipping = 3.0;  ///< samples beyond the first, which all are equal

constexpr double usual_lag = 600.0;     ///< [s] of a unit in its housing behind a thermometer outside
constexpr double fewest_windows = 8.0;  ///< of a position, which show that it counts one number throughout
constexpr double same_count = 1e-9;     ///< [1] rounding of a count that the file gives as a rate
/// Probability below which a count that does not move is the end of a register; of positions without a fault one test
/// in 1e5 is accused.
constexpr double stopped_p = 1e-5;
constexpr double least_range = 2.0;  ///< [pulses per window] that the offset must move a count over: more than rounding
constexpr double count_margin = 0.01;  ///< [pulses] rounding of the mean of counts
/// Standard deviations of a change within a position that still changes: noise and counting alone do not reach it
/// (1e-15).
constexpr double changing_sd = 8.0;
/// [1 g] change within a segment that holds more than one position: a turn by 8 degrees from the vertical. Chosen: far
/// above any drift, and doubled, turns by up to 11 degrees would be taken for one.
constexpr double other_position = 0.01;
/// Mean square of the changes of all positions over their variance, of `fewest_positions` and more: chi-square with 8
/// degrees of freedom exceeds 4 times its mean with p = 9e-5.
constexpr double mean_square_of_changes = 4.0;
constexpr std::size_t fewest_positions = 8;
/// [1] of the option same_temperature, by which the temperature may move in a position, and in a set of them.
constexpr double moves_in_position = 0.25, moves_in_set = 0.5;
/// [1] from the reference scale factor, beyond which a set used another reference. Chosen: a wrong unit,
/// a clipped output or another counting time err by more; doubled, counting windows that are 10 % longer pass.
constexpr double far_from_reference = 0.05;
constexpr double shown_sd = 3.0;  ///< standard deviations of an angle, and of the scale factor that it changes
/// [1] of the output at 1 g, and its standard deviations, beyond which the second order is a fault of the
/// test. Chosen: a clipped output and a counter that overflows make more.
constexpr double most_second_order = 0.005, second_order_sd = 10.0;

std::string name_of(const Position& position) { return fmt::format("'{}' (run {})", position.label, position.run); }

std::string name_of(const Bench& bench, const Cell& cell) {
  return fmt::format("run {}: {}", cell.run, in_words(bench.group_temperature[cell.group]));
}

/// Segments, or sets of positions, with one fault, and the one in which it is greatest.
struct Faulty {
  std::vector<std::string> names;
  std::string worst;
  double most = 0.0;

  void add(const std::string& name, double size) {
    if (names.empty() || std::abs(size) > std::abs(most)) worst = name, most = size;
    names.push_back(name);
  }
};

/// Given: names in the sentence of the list and of the greatest value, and its unit.
void add(const Faulty& faulty, Finding::Severity severity, const char* code, const char* list, const char* value,
         const char* unit, Findings& findings) {
  if (faulty.names.empty()) return;
  const auto names = fmt::format("{}", fmt::join(faulty.names, ", "));
  findings.push_back({severity,
                      code,
                      {{list, names}, {value, faulty.most, unit}},
                      "",
                      {faulty.names.size(), faulty.names.front(), faulty.worst}});
}

/// Mean of the second half of the samples minus that of the first, in the unit of the output.
double step_within(const EvenValues& values) {
  double sum[2] = {0.0, 0.0}, count[2] = {0.0, 0.0};
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    const int half = i < values.size() / 2 ? 0 : 1;
    sum[half] += values[i];
    count[half] += 1.0;
  }
  return count[0] > 0.0 && count[1] > 0.0 ? sum[1] / count[1] - sum[0] / count[0] : 0.0;
}

/// Whether all samples are equal although those of other positions scatter: the output is at its limit.
bool clipped(const Bench& bench, const Position& position) {
  if (position.place == Place::level || bench.pulse > 0.0 || position.freedom < least_freedom_of_clipping ||
      position.squares > 0.0)
    return false;
  return std::ranges::any_of(bench.positions, [](const Position& p) { return p.squares > 0.0; });
}

/// A count in which positions stand throughout.
struct OneCount {
  std::vector<const Position*> positions;
  std::set<std::pair<std::size_t, Place>> places;  ///< temperature and direction; repeats of a unit are alike
  double least = INFINITY, most = -INFINITY;       ///< offset along the input axis [pulses per window]
  double windows = INFINITY;                       ///< the fewest in a position
};

/// Pulses in each window of a position that counts one number throughout, and its windows; 0: it does not.
std::pair<double, double> one_count(const Bench& bench, const Position& position) {
  const auto& stretch = bench.evidence.test.stretches[position.stretch];
  double low = INFINITY, high = -INFINITY, n = 0.0;
  for (std::size_t i = 0; i < stretch.values.size(); ++i)
    if (const double v = stretch.values[i]; std::isfinite(v)) low = std::min(low, v), high = std::max(high, v), ++n;
  if (n < fewest_windows || high - low > same_count * std::abs(high)) return {0.0, n};
  return {high * stretch.step / bench.pulse, n};
}

/// Chance that the greatest output is one number throughout, a rate within 1/n pulse of it, and those of the other
/// places are the same number, although the offset moves them over `range` pulses.
double chance_of(const OneCount& one) {
  const double range = one.most - one.least, share = 2.0 / one.windows;
  return share * std::pow(std::min(1.0, share / range), static_cast<double>(one.places.size()) - 1.0);
}

/// The greatest count of a window in the positions up and down, by their means.
double greatest_count(const Bench& bench) {
  double most = 0.0;
  for (const auto& cell : bench.cells)
    for (const std::size_t i : {cell.up, cell.down}) {
      const double step = bench.evidence.test.stretches[bench.positions[i].stretch].step;
      most = std::max(most, std::abs(bench.positions[i].output) * step / bench.pulse);
    }
  return most;
}

/// Positions up and down that count one number throughout, of one size in all and the greatest, although the offset
/// that the level positions of their sets show moves it by more than two pulses.
void look_for_one_count(const Bench& bench, Faulty& limits) {
  std::map<long, OneCount> by_count;
  for (const auto& cell : bench.cells) {
    if (!(bench.pulse > 0.0) || !cell.second || !cell.fourth) continue;
    const double offset = 0.5 * (bench.positions[*cell.second].output + bench.positions[*cell.fourth].output);
    for (const std::size_t i : {cell.up, cell.down}) {
      const Position& position = bench.positions[i];
      const auto [count, windows] = one_count(bench, position);
      if (count == 0.0) continue;
      const double step = bench.evidence.test.stretches[position.stretch].step;
      const double along = (position.place == Place::up ? offset : -offset) * step / bench.pulse;
      OneCount& one = by_count[std::lround(std::abs(count))];
      one.positions.push_back(&position);
      one.places.emplace(cell.group, position.place);
      one.least = std::min(one.least, along), one.most = std::max(one.most, along);
      one.windows = std::min(one.windows, windows);
    }
  }
  for (const auto& [count, one] : by_count)
    if (one.most - one.least > least_range && chance_of(one) < stopped_p &&
        greatest_count(bench) < static_cast<double>(count) + count_margin)
      for (const Position* position : one.positions) limits.add(name_of(*position), position->output);
}

/// Standard deviation of step_within() by noise and counting [m/s^2].
double sd_of_step(const Bench& bench, const Position& position) {
  const double half = 0.5 * position.seconds;
  return std::sqrt(2.0 * (bench.white / half + pulses::rounding_variance(bench.pulse, half)));
}

/// Positions whose output still changes: each by itself, as a unit would that follows the thermometer late, and all
/// together by little.
void look_at_drifts(const Bench& bench, const Reduced& reduced, Findings& findings) {
  Faulty drifting;
  std::vector<ChangeWithin> changes;
  double squares = 0.0;
  for (const auto& position : bench.positions) {
    const auto& values = bench.evidence.test.stretches[position.stretch].values;
    const double step = step_within(values), sd = sd_of_step(bench, position);
    if (!(sd > 0.0) || static_cast<double>(values.size()) < fewest_windows) return;
    changes.push_back({step, sd});
    squares += step * step / (sd * sd * static_cast<double>(bench.positions.size()));
    if (std::abs(step) > changing_sd * sd && std::abs(step) <= other_position * position.gravity)
      drifting.add(name_of(position), step);
  }
  add(drifting, warning, "segment_still_changes", "segments", "change", "g", findings);
  if (const auto late = late_unit(bench, reduced, changes, usual_lag))
    findings.push_back({warning,
                        late->shown ? "unit_follows_thermometer_late" : "soak_is_short",
                        {{"lag", usual_lag, "s"},
                         {"behind", late->behind, "K"},
                         {"worst", late->where},
                         {"parameter", late->quantity == bias ? "bias" : "scale_factor_error"},
                         {"shift", late->shift, late->quantity == bias ? "ug" : "ppm"}}});
  if (drifting.names.empty() && bench.positions.size() >= fewest_positions && squares > mean_square_of_changes)
    findings.push_back({warning, "positions_still_change", {{"times", std::sqrt(squares)}}});
}

void look_at_positions(const Bench& bench, const Reduced& reduced, const Settings& settings, Findings& findings) {
  Faulty steps, limits, drifts;
  for (const auto& position : bench.positions) {
    const double step = step_within(bench.evidence.test.stretches[position.stretch].values);
    if (std::abs(step) > other_position * position.gravity) steps.add(name_of(position), step);
    if (clipped(bench, position)) limits.add(name_of(position), position.output);
    if (std::abs(position.temperature_drift) > moves_in_position * settings.number("same_temperature"))
      drifts.add(name_of(position), position.temperature_drift);
  }
  look_for_one_count(bench, limits);
  add(steps, error, "step_in_segment", "segments", "change", "g", findings);
  add(limits, error, "one_value_in_segment", "segments", "output", "g", findings);
  add(drifts, warning, "temperature_moves_in_segment", "segments", "change", "K", findings);
  look_at_drifts(bench, reduced, findings);
}

void look_at_cells(const Bench& bench, const Reduced& reduced, const Settings& settings, Findings& findings) {
  Faulty negative, far, moved;
  for (std::size_t c = 0; c < bench.cells.size(); ++c) {
    const Cell& cell = bench.cells[c];
    const double ratio = 1.0 / (1.0 + reduced.cells[c].value[scale_factor_error]);
    if (ratio < 0.0)
      negative.add(name_of(bench, cell), ratio);
    else if (std::abs(ratio - 1.0) > far_from_reference)
      far.add(name_of(bench, cell), ratio - 1.0);
    if (cell.spread > moves_in_set * settings.number("same_temperature")) moved.add(name_of(bench, cell), cell.spread);
  }
  add(negative, error, "scale_factor_negative_in_set", "sets", "ratio", "1", findings);
  add(far, warning, "scale_factor_far_from_reference", "sets", "difference", "%", findings);
  add(moved, warning, "temperature_moves_in_set", "sets", "change", "K", findings);
}

/// Value and standard uncertainty of a quantity at the middle of the temperatures.
std::pair<double, double> in_the_middle(const Bench& bench, const Reduced& reduced, Quantity quantity) {
  const Polynomial& p = reduced.polynomial[quantity];
  const double middle = 0.5 * (bench.group_temperature.front() + bench.group_temperature.back());
  std::vector<double> weights(reduced.parameters.size());
  const auto t = powers(middle, p.count);
  for (std::size_t j = 0; j < p.count; ++j) weights[p.first + j] = t[j];
  return {dot(weights, reduced.parameters), std::sqrt(std::max(0.0, quadratic_form(weights, reduced.covariance)))};
}

/// Coefficients that no accelerometer has, and an angle whose square is missing in the scale factor.
void look_at_sizes(const Bench& bench, const Reduced& reduced, Findings& findings) {
  if (reduced.active.size() == 2) return;
  const auto [angle, angle_sd] = in_the_middle(bench, reduced, misalignment);
  const auto [square, square_sd] = in_the_middle(bench, reduced, second_order);
  const double scale_sd = in_the_middle(bench, reduced, scale_factor_error).second;
  const double lost = 0.5 * angle * angle;
  if (lost > shown_sd * scale_sd && std::abs(angle) > shown_sd * angle_sd)
    findings.push_back({error,
                        "misalignment_changes_scale_factor",
                        {{"parameter", "misalignment"}, {"angle", angle, "deg"}, {"lost", lost, "ppm"}},
                        "scale_factor_error"});
  const double share = square * bench.positions.front().gravity;
  if (std::abs(share) > most_second_order && std::abs(square) > second_order_sd * square_sd)
    findings.push_back({error,
                        "coefficient_too_large",
                        {{"parameter", "second_order_coefficient"}, {"share", share, "%"}},
                        "second_order_coefficient"});
}

/// Half the root of the sum of squares of the noise of four positions [m/s^2]: of K_2 G^2, and more than of theta G.
double noise_of(const Bench& bench, const Cell& cell) {
  double sum = 0.0;
  for (const std::size_t i : {cell.up, cell.down, *cell.second, *cell.fourth})
    sum +=
        bench.white / bench.positions[i].seconds + pulses::rounding_variance(bench.pulse, bench.positions[i].seconds);
  return 0.5 * std::sqrt(sum);
}

/// Sets in which K_2 or the angle is far from those of the others: one of their positions is another than planned.
void look_for_odd_sets(const Bench& bench, const Reduced& reduced, Findings& findings) {
  constexpr double far = 8.0;
  if (reduced.active.size() == 2 || reduced.cells.size() < 4) return;
  for (const auto& [quantity, name, unit] : {std::tuple{second_order, "second_order_coefficient", "ug/g^2"},
                                             std::tuple{misalignment, "misalignment", "arcsec"}}) {
    std::vector<double> values, distances;
    for (const auto& cell : reduced.cells) values.push_back(cell.value[quantity]);
    const double middle = median(values);
    for (const double value : values) distances.push_back(std::abs(value - middle));
    const double scatter = sd_of_median_size * median(distances);
    Faulty odd;
    for (std::size_t c = 0; c < values.size(); ++c) {
      const double noise = noise_of(bench, bench.cells[c]) / bench.positions[bench.cells[c].up].gravity *
                           (quantity == second_order ? 1.0 / bench.positions[bench.cells[c].up].gravity : 1.0);
      if (std::abs(values[c] - middle) > far * std::hypot(scatter, noise))
        odd.add(name_of(bench, bench.cells[c]), values[c] - middle);
    }
    if (odd.names.empty()) continue;
    const auto names = fmt::format("{}", fmt::join(odd.names, ", "));
    findings.push_back({warning,
                        "set_disagrees",
                        {{"sets", names}, {"parameter", name}, {"difference", odd.most, unit}},
                        "",
                        {odd.names.size(), odd.names.front(), odd.worst}});
  }
}

void look_at_misfits(const Reduced& reduced, Findings& findings) {
  for (const auto& [quantity, name, unit] :
       {std::tuple{bias, "bias", "ug"}, std::tuple{scale_factor_error, "scale_factor_error", "ppm"},
        std::tuple{second_order, "second_order_coefficient", "ug/g^2"},
        std::tuple{misalignment, "misalignment", "arcsec"}})
    if (reduced.misfit_ratio[quantity] > 0.0)
      findings.push_back({warning,
                          "polynomial_does_not_fit",
                          {{"parameter", name},
                           {"difference", reduced.misfit[quantity], unit},
                           {"times", std::sqrt(reduced.misfit_ratio[quantity])}}});
}

void look_at_temperatures(const Bench& bench, const Reduced& reduced, const Settings& settings, bool measured,
                          Findings& findings) {
  const std::size_t groups = bench.group_temperature.size(), order = reduced.polynomial[bias].count - 1;
  const auto& word = settings.word("order");
  const std::size_t wanted = word == "auto" ? 2 : static_cast<std::size_t>(word[0] - '0');
  if (groups > 1 && order < wanted)
    findings.push_back({warning,
                        "temperatures_limit_order",
                        {{"temperatures", groups}, {"order", order}, {"more", wanted - order}, {"wanted", wanted}}});
  if (groups > 1 && groups == order + 1)
    findings.push_back({info, "polynomial_not_checked", {{"temperatures", groups}, {"coefficients", order + 1}}});
  if (measured && !reduced.repeated)
    findings.push_back(
        {info, reduced.repeatability_known ? "repeatability_from_scatter" : "repeatability_not_known", {}});
  if (measured && !(bench.white_freedom > 0.0)) findings.push_back({warning, "noise_not_known", {}});
  if (!bench.measured_temperature && groups > 1) findings.push_back({info, "temperatures_of_schedule", {}});
}

void add_hidden_terms(const Bench& bench, const Reduced& reduced, Findings& findings) {
  const bool two = reduced.active.size() == 2;
  if (two) findings.push_back({info, "second_order_in_bias", {}});
  findings.push_back({info, "third_order_in_scale_factor", {}});
  if (!two)
    findings.push_back({info, bench.cells.front().o_level ? "second_order_oo_in_bias" : "second_order_pp_in_bias", {}});
}

}  // namespace

void add_findings(const Bench& bench, const Reduced& reduced, const Settings& settings, bool measured,
                  Findings& findings) {
  if (measured) {
    look_at_positions(bench, reduced, settings, findings);
    look_at_cells(bench, reduced, settings, findings);
    look_at_sizes(bench, reduced, findings);
    look_for_odd_sets(bench, reduced, findings);
    look_at_misfits(reduced, findings);
    for (auto& finding : doubts_about(bench)) findings.push_back(std::move(finding));
  }
  look_at_temperatures(bench, reduced, settings, measured, findings);
  add_hidden_terms(bench, reduced, findings);
}

}  // namespace tumble::accelerometer_four_position
