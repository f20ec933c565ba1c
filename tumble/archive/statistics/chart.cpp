#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tumble/archive/statistics/answer.hpp"
#include "tumble/archive/statistics/occasions.hpp"
#include "tumble/core/columns.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {

namespace {

using namespace statistics;
using Severity = Finding::Severity;

constexpr std::size_t usual_baseline = 30, short_baseline = 20, fewest_points = 4;

/// The points of a chart and where they come from.
struct Charted {
  PastResults past;
  std::vector<Occasion> occasions;
  std::vector<ChartPoint> points;
  ControlChart chart;
  std::size_t baseline = 0, sources = 0;
  std::int64_t first_day = 0;
};

std::string what_is_charted(const ChartRequest& request) {
  const auto& what = request.what;
  const std::string of = !what.unit.serial.empty() ? name_of(what.unit)
                         : what.model.empty()      ? "all units"
                                                   : "units of the model " + what.model;
  return fmt::format("Control chart of {} of {}", what.parameter, of);
}

/// [SI] What changed since the baseline of the errors that all share: root sum of squares, over the errors, of the
/// factor of the point minus the mean factor of the baseline.
void take_shared(Charted& charted) {
  const auto errors = shared_errors(charted.past, charted.occasions);
  charted.sources = errors.size();
  const Matrix factors = shared_factors(charted.occasions, errors);
  std::vector<double> variance(charted.points.size());
  for (std::size_t k = 0; k < factors.columns; ++k) {
    double mean = 0.0;
    for (std::size_t i = 0; i < charted.baseline; ++i) mean += factors(i, k) / static_cast<double>(charted.baseline);
    for (std::size_t i = 0; i < variance.size(); ++i) variance[i] += square(factors(i, k) - mean);
  }
  for (std::size_t i = 0; i < variance.size(); ++i) {
    const double rounding = 1e-9 * square(charted.points[i].sd);
    charted.points[i].shared = variance[i] > rounding ? std::sqrt(variance[i]) : 0.0;
  }
}

Charted charted(PastResults results, const ChartRequest& request, Findings& findings) {
  const auto& what = request.what;
  Charted out{.past = std::move(results), .occasions = {}, .points = {}, .chart = {}};
  if (!what.unit.serial.empty())
    if (const auto adjusted = begin_at_adjustment(out.past); !adjusted.empty())
      findings.push_back({Severity::info, "history_since_adjustment", {{"time", adjusted}}});
  note_same_recordings(out.past, findings);
  std::size_t unused = 0;
  out.occasions = occasions_of(out.past.over, &unused);
  if (unused > 0) findings.push_back({Severity::info, "archived_values_not_used", {{"values", unused}}});
  if (what.unit.serial.empty() && !request.every_day)
    out.occasions = first_of_each_unit(out.occasions, out.past.over.units.size());
  const std::size_t count = out.occasions.size();
  const char* const points = what.unit.serial.empty() && !request.every_day ? "units" : "days";
  if (count < fewest_points)
    throw Error(Error::Kind::bad_data, say("a chart of {} needs {} {} with a result or more, and the archive "
                                           "has {}",
                                           Name{what.parameter}, fewest_points, points, count));
  out.baseline = request.settings.baseline;
  if (out.baseline == 0) out.baseline = std::clamp<std::size_t>(count / 2, 3, usual_baseline);
  for (const auto& occasion : out.occasions) out.points.push_back({occasion.value, occasion.private_sd, 0.0});
  if (out.baseline < count) take_shared(out);
  ChartSettings settings = request.settings;
  settings.baseline = out.baseline;
  out.chart = control_chart(out.points, settings, chart_limits(settings));
  out.first_day = out.occasions.front().day;
  return out;
}

std::string alarms_of(const ChartState& state) {
  std::vector<const char*> words;
  if (state.beyond) words.push_back("beyond the limit");
  if (state.drifting) words.push_back("EWMA");
  if (state.shifted) words.push_back("CUSUM");
  return fmt::format("{}", fmt::join(words, ", "));
}

/// All that is known of each point, for programs.
Table points_table(const Charted& charted) {
  const auto& over = charted.past.over;
  const auto value = [&](auto of) { return [&, of](std::size_t i) { return charted.occasions[i].*of; }; };
  const auto state = [&](auto of) { return [&, of](std::size_t i) { return charted.chart.points[i].*of; }; };
  const auto notes = [&](std::size_t i) { return fmt::format("{}", fmt::join(charted.chart.points[i].notes, ", ")); };
  return for_programs(
      tabulate("chart", "the points in order of time", charted.points.size(),
               {{"time", [&](std::size_t i) { return time_of(charted.occasions[i].moment); }},
                {"unit", [&](std::size_t i) { return name_of(over.units[charted.occasions[i].unit].second); }},
                {"value", over.shown, value(&Occasion::value)},
                {"private sd", over.shown, value(&Occasion::private_sd)},
                {"shared", over.shown, [&](std::size_t i) { return charted.points[i].shared; }},
                {"expected", over.shown, [&](std::size_t) { return charted.chart.baseline.mean; }},
                {"limit", over.shown, state(&ChartState::limit)},
                {"EWMA", over.shown, state(&ChartState::ewma)},
                {"EWMA limit", over.shown, state(&ChartState::ewma_limit)},
                {"CUSUM up", state(&ChartState::up)},
                {"CUSUM down", state(&ChartState::down)},
                {"baseline", [&](std::size_t i) { return i < charted.baseline ? "yes" : ""; }},
                {"alarm", [&](std::size_t i) { return alarms_of(charted.chart.points[i]); }},
                {"notes", notes}}));
}

/// For people: the points of a short chart, those with an alarm of a long one.
Table shown_table(const Charted& charted) {
  constexpr std::size_t most = 30, most_alarms = 1000;
  const auto& over = charted.past.over;
  const bool all = charted.points.size() <= most;
  const double expected = charted.chart.baseline.mean;
  struct Row {
    const Occasion& occasion;
    const ChartState& state;
  };
  std::vector<Row> rows;
  for (std::size_t i = 0; i < charted.points.size() && rows.size() < most_alarms; ++i)
    if (all || !alarms_of(charted.chart.points[i]).empty())
      rows.push_back({charted.occasions[i], charted.chart.points[i]});
  const auto result = [&](const Row& r) { return first_digits(charted.past.read.sha256(r.occasion.result)); };
  return tabulate(all ? "points" : "alarms",
                  all ? "the points in order of time" : "points beyond a limit, the first 1000", rows,
                  {{"time", [](const Row& r) { return time_of(r.occasion.moment); }},
                   {"unit", [&](const Row& r) { return name_of(over.units[r.occasion.unit].second); }},
                   {"value", over.shown, [](const Row& r) { return r.occasion.value; }},
                   {"from", over.shown, [&](const Row& r) { return expected - r.state.limit; }},
                   {"to", over.shown, [&](const Row& r) { return expected + r.state.limit; }},
                   {"EWMA", over.shown, [](const Row& r) { return r.state.ewma; }},
                   {"alarm", [](const Row& r) { return alarms_of(r.state); }},
                   {"result", result}});
}

std::vector<Curve> curves_of(const Charted& charted, std::vector<Link>& links) {
  const auto& over = charted.past.over;
  const std::string& name = over.parameter;
  const std::int64_t day = charted.first_day;
  Curve values = curve_over_time("result", "individuals", day, name, over.shown);
  Curve limits = curve_over_time("expected", "individuals", day, name, over.shown);
  Curve ewma = curve_over_time("EWMA about the expected value", "EWMA", day, name + " less expected", over.shown);
  Curve up = curve_over_time("CUSUM up", "CUSUM", day, "CUSUM", {}), down = up, limit = up;
  down.name = "CUSUM down", limit.name = "limit";
  values.points = true;
  limits.band = "limits", ewma.band = "limits";
  for (std::size_t i = 0; i < charted.points.size(); ++i) {
    const auto& state = charted.chart.points[i];
    const double time = since(day, charted.occasions[i].moment);
    add_point(values, time, charted.points[i].value);
    links.push_back(
        link_of(values, name_of(over.units[charted.occasions[i].unit].second), charted.occasions[i].result));
    add_point(limits, time, charted.chart.baseline.mean, state.limit);
    if (i < charted.baseline) continue;
    add_point(ewma, time, state.ewma, -state.ewma_limit, state.ewma_limit);
    add_point(up, time, state.up);
    add_point(down, time, state.down);
    add_point(limit, time, charted.chart.limits.cusum);
  }
  return {values, limits, ewma, up, down, limit};
}

void add_findings(const Charted& charted, Findings& findings) {
  const auto& points = charted.chart.points;
  const auto count = [&](auto member, std::size_t from, std::size_t to) {
    std::size_t number = 0;
    for (std::size_t i = from; i < to; ++i) number += points[i].*member ? 1 : 0;
    return number;
  };
  if (charted.baseline < short_baseline)
    findings.push_back({Severity::info, "chart_baseline_short", {{"points", charted.baseline}}});
  if (charted.chart.baseline.below_stated) findings.push_back({Severity::warning, "chart_below_stated", {}});
  if (const auto own = count(&ChartState::beyond, 0, charted.baseline); own > 0)
    findings.push_back({Severity::warning, "chart_baseline_alarms", {{"points", own}}});
  if (const auto beyond = count(&ChartState::beyond, charted.baseline, points.size()); beyond > 0)
    findings.push_back({Severity::warning, "chart_points_beyond", {{"points", beyond}}});
  if (const auto drifting = count(&ChartState::drifting, 0, points.size()); drifting > 0)
    findings.push_back({Severity::warning, "chart_drifts", {{"points", drifting}}});
  if (const auto shifted = count(&ChartState::shifted, 0, points.size()); shifted > 0)
    findings.push_back({Severity::warning, "chart_shifted", {{"points", shifted}}});
  if (charted.sources > 1) findings.push_back({Severity::info, "chart_sources_changed", {{"sets", charted.sources}}});
}

}  // namespace

Estimate chart_of_archive(const Archive& archive, const ChartRequest& request) {
  const auto& what = request.what;
  const bool of_one_unit = !what.unit.serial.empty();
  return chart_of_results(past_results(archive, what.parameter, what.model, what.unit, of_one_unit), request);
}

Estimate chart_of_results(PastResults results, const ChartRequest& request) {
  Estimate estimate = answer_of("archive_chart", what_is_charted(request), request.what);
  const Charted chart = charted(std::move(results), request, estimate.findings);
  const auto& spread = chart.chart.baseline;
  const Unit& unit = chart.past.over.shown;
  const std::string& name = request.what.parameter;
  state(estimate, {{name + "_expected", "mean of the baseline, without the errors that all results share", unit,
                    spread.mean, spread.mean_sd, spread.mean_lower, spread.mean_upper},
                   {name + "_scatter", "spread of the points of the baseline, stated uncertainties removed", unit,
                    spread.sd, std::nan(""), spread.sd_lower, spread.sd_upper}});
  auto& settings = estimate.provenance.settings;
  settings["baseline"] = fmt::format("{}", chart.baseline);
  settings["lambda"] = fmt::format("{}", request.settings.lambda);
  settings["reference"] = fmt::format("{}", request.settings.reference);
  settings["run_length"] = fmt::format("{}", request.settings.run_length);
  estimate.tables = {points_table(chart)};
  add_unless_empty(estimate.tables, shown_table(chart));
  std::vector<Link> links;
  estimate.curves = curves_of(chart, links);
  estimate.tables.push_back(links_table(links, unit));
  add_findings(chart, estimate.findings);
  return estimate;
}

}  // namespace tumble
