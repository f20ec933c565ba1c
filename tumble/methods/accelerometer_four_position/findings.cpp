#include "tumble/methods/accelerometer_four_position/findings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/say.hpp"

namespace tumble::accelerometer_four_position {
namespace {

using Severity = Finding::Severity;

std::string name_of(const Position& position) { return fmt::format("'{}' of run {}", position.label, position.run); }

std::string name_of(const Bench& bench, const Cell& cell) {
  return fmt::format("run {} at {}", cell.run, in_words(bench.group_temperature[cell.group]));
}

/// Several names in one finding, the first few of them.
void say(const std::vector<std::string>& names, Severity severity, const std::string& what, Findings& findings) {
  if (names.empty()) return;
  const std::size_t shown = std::min<std::size_t>(4, names.size());
  const auto list =
      fmt::format("{}", fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "));
  findings.push_back(
      {severity,
       (names.size() > shown ? fmt::format("{} and {} more", list, names.size() - shown) : list) + ": " + what, ""});
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

/// Every sample the same although others scatter: the output stands at its end.
bool clipped(const Bench& bench, const Position& position) {
  if (position.place == Place::level || bench.pulse > 0.0 || position.freedom < 3.0 || position.squares > 0.0)
    return false;
  return std::ranges::any_of(bench.positions, [](const Position& p) { return p.squares > 0.0; });
}

void look_at_positions(const Bench& bench, const Settings& settings, Findings& findings) {
  std::vector<std::string> steps, ends, warm;
  for (const auto& position : bench.positions) {
    if (std::abs(step_within(bench.evidence.test.stretches[position.stretch].values)) > 0.01 * position.gravity)
      steps.push_back(name_of(position));
    if (clipped(bench, position)) ends.push_back(name_of(position));
    if (std::abs(position.temperature_drift) > 0.25 * settings.number("same_temperature"))
      warm.push_back(name_of(position));
  }
  say(steps, Severity::error,
      "the output changes by more than 0.01 g within the segment: it may hold two positions, or the head was still "
      "moving; give each position a segment of its own",
      findings);
  say(ends, Severity::error, "the output is one and the same number throughout: it is clipped, or the channel hangs",
      findings);
  say(warm, Severity::warning, "the temperature moves within the segment: let the instrument soak for longer",
      findings);
}

void look_at_cells(const Bench& bench, const Reduced& reduced, const Settings& settings, Findings& findings) {
  std::vector<std::string> exchanged, far, moved;
  for (std::size_t c = 0; c < bench.cells.size(); ++c) {
    const Cell& cell = bench.cells[c];
    const double scale = 1.0 / (1.0 + reduced.cells[c].value[scale_factor_error]);
    if (scale < 0.0)
      exchanged.push_back(name_of(bench, cell));
    else if (std::abs(scale - 1.0) > 0.05)
      far.push_back(fmt::format("{} ({:+.1f} %)", name_of(bench, cell), 100.0 * (scale - 1.0)));
    if (cell.spread > 0.5 * settings.number("same_temperature"))
      moved.push_back(fmt::format("{} (by {:.2g} K)", name_of(bench, cell), cell.spread));
  }
  say(exchanged, Severity::error,
      "the scale factor is negative: positions 1 and 3 are exchanged, the head counts the other way, or K_m has the "
      "wrong sign",
      findings);
  say(far, Severity::warning,
      "the scale factor is far from the reference: is K_m right, its unit too, is the output clipped or counted over "
      "another time than the rate says?",
      findings);
  say(moved, Severity::warning,
      "the temperature moved between the positions of one set: bias and scale factor are those of different "
      "temperatures; let the instrument soak for longer",
      findings);
}

void look_at_temperatures(const Bench& bench, const Reduced& reduced, const Settings& settings, bool measured,
                          Findings& findings) {
  const std::size_t groups = bench.group_temperature.size(), order = reduced.polynomial[bias].count - 1;
  const auto note = [&](Severity severity, const std::string& text) { findings.push_back({severity, text, ""}); };
  const auto& word = settings.word("order");
  const std::size_t wanted = word == "auto" ? 2 : static_cast<std::size_t>(word[0] - '0');
  if (groups > 1 && order < wanted)
    note(Severity::warning, fmt::format("{} temperatures carry polynomials of order {}: {} more {} needed for order {}",
                                        groups, order, wanted - order, wanted - order == 1 ? "is" : "are", wanted));
  if (groups > 1 && groups == order + 1)
    note(Severity::info, fmt::format("{} temperatures for {} coefficients: nothing shows whether the polynomial fits",
                                     groups, order + 1));
  if (measured && !reduced.repeated)
    note(Severity::info,
         reduced.repeatability_known
             ? "no temperature was taken twice: repeatability is judged by the scatter about the polynomial"
             : "no temperature was taken twice: repeatability is not in the uncertainties; repeat the "
               "positions, best after another power-up");
  if (measured && !(bench.white_freedom > 0.0))
    note(Severity::warning,
         "one average in each position: the noise of the output cannot be told and is not in the uncertainties");
  if (!bench.measured_temperature && groups > 1)
    note(Severity::info, "temperatures are those of the schedule: not every recording has a channel temperature");
}

void say_what_is_hidden(const Bench& bench, const Reduced& reduced, Findings& findings) {
  const auto note = [&](const char* text) { findings.push_back({Severity::info, text, ""}); };
  if (reduced.active.size() == 2)
    note(
        "positions 1 and 3 alone: the bias holds K_2 G^2, and K_2 and the misalignment do not show; estimator = "
        "\"four_positions\" tells them apart");
  note("K_3 does not show in four positions: the scale factor is K_1 (1 + K_3 G^2)");
  if (reduced.active.size() > 2)
    note(bench.cells.front().o_level
             ? "at 1 g K_oo hides: the bias is K_0 + K_oo G^2, the second-order coefficient K_2 - K_oo"
             : "at 1 g K_pp hides: the bias is K_0 + K_pp G^2, the second-order coefficient K_2 - K_pp");
}

}  // namespace

void add_findings(const Bench& bench, const Reduced& reduced, const Settings& settings, bool measured,
                  Findings& findings) {
  if (measured) {
    look_at_positions(bench, settings, findings);
    look_at_cells(bench, reduced, settings, findings);
  }
  look_at_temperatures(bench, reduced, settings, measured, findings);
  say_what_is_hidden(bench, reduced, findings);
}

}  // namespace tumble::accelerometer_four_position
