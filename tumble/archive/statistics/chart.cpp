#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tumble/archive/statistics/answer.hpp"
#include "tumble/archive/statistics/occasions.hpp"
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
  const Unit& unit = charted.past.over.shown;
  Table table{"chart", "the points in order of time", {}, {}, true};
  for (const char* const name : {"time", "unit"}) table.columns.push_back(column(name));
  for (const char* const name : {"value", "private sd", "shared", "expected", "limit", "EWMA", "EWMA limit"})
    table.columns.push_back(column(name, unit));
  for (const char* const name : {"CUSUM up", "CUSUM down", "baseline", "alarm", "notes"})
    table.columns.push_back(column(name));
  for (std::size_t i = 0; i < charted.points.size(); ++i) {
    const auto& state = charted.chart.points[i];
    const auto& occasion = charted.occasions[i];
    table.rows.push_back({time_of(occasion.moment), name_of(charted.past.over.units[occasion.unit].second),
                          occasion.value, occasion.private_sd, charted.points[i].shared, charted.chart.baseline.mean,
                          state.limit, state.ewma, state.ewma_limit, state.up, state.down,
                          std::string(i < charted.baseline ? "yes" : ""), alarms_of(state),
                          fmt::format("{}", fmt::join(state.notes, ", "))});
  }
  return table;
}

/// For people: the points of a short chart, those with an alarm of a long one.
Table shown_table(const Charted& charted) {
  constexpr std::size_t most = 30, most_alarms = 1000;
  const bool all = charted.points.size() <= most;
  const Unit& unit = charted.past.over.shown;
  Table table{all ? "points" : "alarms",
              all ? "the points in order of time" : "points beyond a limit, the first 1000",
              {},
              {},
              false};
  table.columns = {column("time"),     column("unit"),       column("value", unit), column("from", unit),
                   column("to", unit), column("EWMA", unit), column("alarm"),       column("result")};
  for (std::size_t i = 0; i < charted.points.size(); ++i) {
    const auto& state = charted.chart.points[i];
    const std::string alarm = alarms_of(state);
    if (!all && alarm.empty()) continue;
    if (table.rows.size() == most_alarms) break;
    const auto& occasion = charted.occasions[i];
    const double expected = charted.chart.baseline.mean;
    table.rows.push_back({time_of(occasion.moment), name_of(charted.past.over.units[occasion.unit].second),
                          occasion.value, expected - state.limit, expected + state.limit, state.ewma, alarm,
                          first_digits(charted.past.read.sha256(occasion.result))});
  }
  return table;
}

std::vector<Curve> curves_of(const Charted& charted, Table& links) {
  const Unit& unit = charted.past.over.shown;
  const std::string& name = charted.past.over.parameter;
  const std::int64_t day = charted.first_day;
  Curve values = curve_over_time("result", "individuals", day, name, unit);
  Curve limits = curve_over_time("expected", "individuals", day, name, unit);
  Curve ewma = curve_over_time("EWMA about the expected value", "EWMA", day, name + " less expected", unit);
  Curve up = curve_over_time("CUSUM up", "CUSUM", day, "CUSUM", {}), down = up, limit = up;
  down.name = "CUSUM down", limit.name = "limit";
  values.points = true;
  limits.band = "limits", ewma.band = "limits";
  for (std::size_t i = 0; i < charted.points.size(); ++i) {
    const auto& state = charted.chart.points[i];
    const double moment = charted.occasions[i].moment, expected = charted.chart.baseline.mean;
    add_point(values, day, moment, charted.points[i].value);
    add_link(values, name_of(charted.past.over.units[charted.occasions[i].unit].second), charted.occasions[i].result,
             links);
    add_point(limits, day, moment, expected);
    add_band(limits, expected - state.limit, expected + state.limit);
    if (i < charted.baseline) continue;
    add_point(ewma, day, moment, state.ewma);
    add_band(ewma, -state.ewma_limit, state.ewma_limit);
    add_point(up, day, moment, state.up);
    add_point(down, day, moment, state.down);
    add_point(limit, day, moment, charted.chart.limits.cusum);
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
  if (auto table = shown_table(chart); !table.rows.empty()) estimate.tables.push_back(std::move(table));
  Table links = links_table(unit);
  estimate.curves = curves_of(chart, links);
  estimate.tables.push_back(std::move(links));
  add_findings(chart, estimate.findings);
  return estimate;
}

}  // namespace tumble
