#include "tumble/methods/accelerometer_four_position/findings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace tumble::accelerometer_four_position {
namespace {

using enum Finding::Severity;

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
  if (position.place == Place::level || bench.pulse > 0.0 || position.freedom < 3.0 || position.squares > 0.0)
    return false;
  return std::ranges::any_of(bench.positions, [](const Position& p) { return p.squares > 0.0; });
}

void look_at_positions(const Bench& bench, const Settings& settings, Findings& findings) {
  Faulty steps, limits, drifts;
  for (const auto& position : bench.positions) {
    const double step = step_within(bench.evidence.test.stretches[position.stretch].values);
    if (std::abs(step) > 0.01 * position.gravity) steps.add(name_of(position), step);
    if (clipped(bench, position)) limits.add(name_of(position), position.output);
    if (std::abs(position.temperature_drift) > 0.25 * settings.number("same_temperature"))
      drifts.add(name_of(position), position.temperature_drift);
  }
  add(steps, error, "step_in_segment", "segments", "change", "g", findings);
  add(limits, error, "one_value_in_segment", "segments", "output", "g", findings);
  add(drifts, warning, "temperature_moves_in_segment", "segments", "change", "K", findings);
}

void look_at_cells(const Bench& bench, const Reduced& reduced, const Settings& settings, Findings& findings) {
  Faulty negative, far, moved;
  for (std::size_t c = 0; c < bench.cells.size(); ++c) {
    const Cell& cell = bench.cells[c];
    const double ratio = 1.0 / (1.0 + reduced.cells[c].value[scale_factor_error]);
    if (ratio < 0.0)
      negative.add(name_of(bench, cell), ratio);
    else if (std::abs(ratio - 1.0) > 0.05)
      far.add(name_of(bench, cell), ratio - 1.0);
    if (cell.spread > 0.5 * settings.number("same_temperature")) moved.add(name_of(bench, cell), cell.spread);
  }
  add(negative, error, "scale_factor_negative_in_set", "sets", "ratio", "1", findings);
  add(far, warning, "scale_factor_far_from_reference", "sets", "difference", "%", findings);
  add(moved, warning, "temperature_moves_in_set", "sets", "change", "K", findings);
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
    look_at_positions(bench, settings, findings);
    look_at_cells(bench, reduced, settings, findings);
  }
  look_at_temperatures(bench, reduced, settings, measured, findings);
  add_hidden_terms(bench, reduced, findings);
}

}  // namespace tumble::accelerometer_four_position
