#include <algorithm>
#include <cmath>

#include "tumble/language/say.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/sine_vibration/describe.hpp"

namespace tumble::sine_vibration {
namespace {

using Severity = Finding::Severity;

/// Standard uncertainty of the mean shift of a point; NaN where it has none.
double shift_sd(const Point& point, const std::vector<Rectification>& rectified) {
  for (const auto& r : rectified) {
    const auto variance = r.shift_variance.find(point.series);
    if (variance != r.shift_variance.end()) return std::sqrt(variance->second);
  }
  return std::nan("");
}

double gain_sd(const Estimate& estimate, const vibration::Data& data, const Point& point) {
  const auto* gain = find_parameter(estimate, data.units[point.unit].prefix + "gain_" + frequency_label(point.nominal));
  return standard_uncertainty(estimate, static_cast<std::size_t>(gain - estimate.parameters.data()));
}

Table response(const vibration::Data& data, const Measured& measured, const std::vector<Rectification>& rectified,
               const Estimate& estimate) {
  const auto unit = [](const char* text) { return Unit::parse(text); };
  Table table{
      "response",
      "counts over each frequency as mean specific force over their windows; mean and sd of the windows themselves, "
      "mean_shift by the sine fit against the unit at rest; sd_from_window is the sd by the counting window alone",
      {{"unit", Unit()},
       {"segment", Unit()},
       {"frequency", unit("Hz")},
       {"level", unit("g")},
       {"mean", unit("g")},
       {"cycles_effect", unit("ug")},
       {"mean_shift", unit("ug")},
       {"mean_shift_sd", unit("ug")},
       {"sd", unit("g")},
       {"sd_from_window", unit("g")},
       {"sd_ratio", Unit()},
       {"gain", Unit()},
       {"gain_sd", Unit()},
       {"aliased_to", unit("Hz")},
       {"K_2_effective", unit("ug/g^2")}},
      {}};
  for (const Point& p : measured.points) {
    std::vector<Table::Cell> row{data.units[p.unit].name, data.series[p.series].label};
    for (const double v :
         {p.line.frequency, p.level, p.line.plain_mean, p.cycles_effect, p.shift, shift_sd(p, rectified), p.line.sd,
          p.sd_from_window, p.line.sd / p.sd_from_window, p.gain, gain_sd(estimate, data, p)})
      row.emplace_back(v);
    if (p.aliased_to > 0.0)
      row.emplace_back(p.aliased_to);
    else
      row.emplace_back("");
    row.emplace_back(2.0 * p.shift / (p.level * p.level));
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table units(const vibration::Data& data, const Measured& measured, const std::vector<Rectification>& rectified) {
  const auto unit = [](const char* text) { return Unit::parse(text); };
  Table table{
      "units",
      "units under test: one pulse; drift at rest from the first to the last segment; by how much whole segments "
      "differ beyond white noise, and K_2,eff from frequency to frequency",
      {{"unit", Unit()},
       {"channel", Unit()},
       {"pulse", unit("g*s")},
       {"scale_sd", unit("%")},
       {"rest_drift", unit("ug")},
       {"segment_sd", unit("ug")},
       {"frequency_sd", unit("ug/g^2")}},
      {}};
  for (std::size_t u = 0; u < data.units.size(); ++u) {
    std::vector<double> means;
    for (const auto& rest : measured.rests)
      if (data.series[rest.series].unit == u) means.push_back(rest.line.mean);
    const auto r = std::ranges::find(rectified, u, &Rectification::unit);
    const bool known = r != rectified.end();
    table.rows.push_back({data.units[u].name, data.units[u].channel, data.units[u].pulse,
                          data.units[u].scale_relative_sd,
                          means.size() > 1 ? means.back() - means.front() : std::nan(""),
                          known ? r->slow_sd : std::nan(""), known ? r->between_sd : std::nan("")});
  }
  return table;
}

std::string curve_name(const vibration::Data& data, std::size_t unit) {
  return data.units.size() > 1 ? data.units[unit].name : "measured";
}

Curve curve(const std::string& name, const std::string& figure, const char* quantity, const char* unit, bool points) {
  Curve c;
  c.name = name;
  c.figure = figure;
  c.x = {"frequency", Unit::parse("Hz"), {}};
  c.y = {quantity, Unit::parse(unit), {}};
  c.points = points;
  return c;
}

/// Mean, spread and gain of one unit over frequency.
void add_unit_curves(const vibration::Data& data, const Measured& measured, std::size_t unit,
                     const std::vector<Rectification>& rectified, Estimate& estimate) {
  const std::string name = curve_name(data, unit);
  Curve shift = curve(name, "mean over frequency", "mean shift", "ug", true);
  Curve plain = curve(name + ", plain mean", "mean over frequency", "mean shift", "ug", true);
  Curve sd = curve(name, "standard deviation over frequency", "sd", "g", true);
  Curve gain = curve(name, "gain over frequency", "gain", "1", true);
  shift.band = gain.band = "95 % confidence";
  for (const Point& p : measured.points) {
    if (p.unit != unit) continue;
    const auto add = [&](Curve& to, double value, double uncertainty) {
      to.x.values.push_back(p.line.frequency);
      to.y.values.push_back(value);
      if (to.band.empty()) return;
      to.lower.push_back(value - 1.96 * uncertainty);
      to.upper.push_back(value + 1.96 * uncertainty);
    };
    if (const double s = shift_sd(p, rectified); !std::isnan(s)) {
      add(shift, p.shift, s);
      add(plain, p.shift + p.cycles_effect, s);
    }
    add(sd, p.line.sd, 0.0);
    add(gain, p.gain, gain_sd(estimate, data, p));
  }
  for (Curve* c : {&shift, &plain, &sd, &gain})
    if (!c->x.values.empty()) estimate.curves.push_back(std::move(*c));
}

/// What each tone departs from the model by: its mean shift from K_2,eff A^2/2, or where no segment at rest shows the
/// shift, its windows from the fitted sine.
void add_residuals(const vibration::Data& data, const Measured& measured, std::size_t unit,
                   const std::vector<Rectification>& rectified, Estimate& estimate) {
  const std::string name = curve_name(data, unit);
  Curve shift = curve(name, "residuals of the mean shift", "residual", "ug", true);
  Curve windows = curve(name, "residuals about the fitted sine", "rms residual", "ug", true);
  shift.band = "95 % confidence of the mean shift";
  const auto r = std::ranges::find(rectified, unit, &Rectification::unit);
  for (const Point& p : measured.points) {
    if (p.unit != unit) continue;
    windows.x.values.push_back(p.line.frequency);
    windows.y.values.push_back(p.line.residual_rms);
    if (r == rectified.end() || !r->fitted_shift.contains(p.series)) continue;
    const double residual = p.shift - r->fitted_shift.at(p.series), half = 1.96 * shift_sd(p, rectified);
    shift.x.values.push_back(p.line.frequency);
    shift.y.values.push_back(residual);
    shift.lower.push_back(residual - half);
    shift.upper.push_back(residual + half);
  }
  Curve& shown = shift.x.values.empty() ? windows : shift;
  if (!shown.x.values.empty()) estimate.curves.push_back(std::move(shown));
}

void add_curves(const vibration::Data& data, const Measured& measured, const std::vector<Rectification>& rectified,
                Estimate& estimate) {
  double low = INFINITY, high = 0.0, level = 0.0;
  for (const Point& p : measured.points) {
    low = std::min(low, p.line.frequency);
    high = std::max(high, p.line.frequency);
    level += p.level / static_cast<double>(measured.points.size());
  }
  for (std::size_t u = 0; u < data.units.size(); ++u) add_unit_curves(data, measured, u, rectified, estimate);
  for (std::size_t u = 0; u < data.units.size(); ++u) add_residuals(data, measured, u, rectified, estimate);
  if (!(high > low)) return;
  const Point& first = measured.points.front();
  Curve window = curve("the counting window alone", "standard deviation over frequency", "sd", "g", false);
  for (int i = 0; i <= 200; ++i) {
    const double f = low + (high - low) * i / 200.0;
    window.x.values.push_back(f);
    window.y.values.push_back(sd_from_window(level, f, first.window, data.units[first.unit].pulse));
  }
  estimate.curves.push_back(std::move(window));
}

/// Which part of the spread over frequency comes from the counter, and which from the instrument.
void report_spread(const vibration::Data& data, const Measured& measured, Findings& findings) {
  for (std::size_t u = 0; u < data.units.size(); ++u) {
    const Point *first = nullptr, *last = nullptr;
    for (const Point& p : measured.points) {
      if (p.unit != u) continue;
      if (first == nullptr) first = &p;
      last = &p;
    }
    if (first == nullptr || last->nominal <= first->nominal) continue;
    const double sd = (last->line.sd / last->level) / (first->line.sd / first->level);
    const double window = std::abs(vibration::sinc(last->line.frequency * last->window) /
                                   vibration::sinc(first->line.frequency * first->window));
    findings.push_back({Severity::info,
                        "spread_over_frequency",
                        {{"lowest", first->line.frequency, "Hz"},
                         {"highest", last->line.frequency, "Hz"},
                         {"ratio", sd},
                         {"window", window},
                         {"instrument", sd / window}},
                        data.units[u].prefix.empty() ? "" : data.units[u].name});
  }
}

/// The tone whose plain mean differs most from that of the fit because its cycles are not complete.
void report_broken_cycles(const vibration::Data& data, const Measured& measured,
                          const std::vector<Rectification>& rectified, Findings& findings) {
  const Point* worst = nullptr;
  for (const Point& p : measured.points) {
    const double sd = shift_sd(p, rectified);
    if (std::abs(p.cycles_effect) < 3.0 * (std::isnan(sd) ? 0.0 : sd)) continue;
    if (worst == nullptr || std::abs(p.cycles_effect) > std::abs(worst->cycles_effect)) worst = &p;
  }
  if (worst == nullptr) return;
  const vibration::Series& series = data.series[worst->series];
  const bool complete = std::ranges::none_of(series.force, [](double v) { return std::isnan(v); });
  findings.push_back({Severity::info,
                      complete ? "broken_cycles" : "broken_cycles_with_gaps",
                      {{"frequency", worst->line.frequency, "Hz"},
                       {"effect", worst->cycles_effect, "ug"},
                       {"bound", worst->cycles_bound, "ug"}},
                      place_of(data, series)});
}

/// Calls `report` with the first point of each frequency at which `applies` is true.
template <class Applies, class Report>
void for_each_frequency(const Measured& measured, Applies applies, Report report) {
  double last = 0.0;
  for (const Point& p : measured.points) {
    if (!applies(p) || p.nominal <= last) continue;
    last = p.nominal;
    report(p);
  }
}

void report_aliases(const vibration::Data& data, const Measured& measured, Findings& findings) {
  std::vector<const Point*> aliased;
  for_each_frequency(
      measured, [](const Point& p) { return p.aliased_to > 0.0; }, [&](const Point& p) { aliased.push_back(&p); });
  if (aliased.empty()) return;
  const Point& first = *aliased.front();
  const vibration::Series& series = data.series[first.series];
  findings.push_back({Severity::info,
                      "tone_aliased",
                      {{"frequency", first.line.frequency, "Hz"},
                       {"rate", 1.0 / series.interval, "Hz"},
                       {"image", first.aliased_to, "Hz"}},
                      "",
                      {aliased.size(), Place(series.label)}});
}

void report_harmonics(const vibration::Data& data, const Measured& measured, Findings& findings) {
  for_each_frequency(
      measured, [](const Point& p) { return p.hidden_harmonic > 0; },
      [&](const Point& p) {
        const vibration::Series& series = data.series[p.series];
        const double apart = std::max(0.003 * p.nominal, 3.0 / p.line.span);
        findings.push_back({Severity::info,
                            "harmonic_on_tone",
                            {{"harmonic", p.hidden_harmonic},
                             {"frequency", p.line.frequency, "Hz"},
                             {"rate", 1.0 / series.interval, "Hz"},
                             {"lower", p.nominal - apart, "Hz"},
                             {"upper", p.nominal + apart, "Hz"}},
                            series.label});
      });
}

void report_rest(const vibration::Data& data, const Measured& measured, Findings& findings) {
  const auto one_side = static_cast<std::size_t>(
      std::ranges::count_if(measured.points, [](const Point& p) { return !std::isnan(p.shift) && !p.both_sides; }));
  if (one_side > 0) findings.push_back({Severity::warning, "rest_on_one_side", {}, "", {one_side}});
  if (measured.rests.size() < 4 * data.units.size() && !measured.rests.empty())
    findings.push_back({Severity::info, "few_rests_between_tones", {}});
}

}  // namespace

void add_tables(const vibration::Data& data, const Measured& measured, const std::vector<Rectification>& rectified,
                Estimate& estimate) {
  estimate.tables.push_back(response(data, measured, rectified, estimate));
  estimate.tables.push_back(units(data, measured, rectified));
  add_curves(data, measured, rectified, estimate);
  report_spread(data, measured, estimate.findings);
  report_broken_cycles(data, measured, rectified, estimate.findings);
  report_aliases(data, measured, estimate.findings);
  report_harmonics(data, measured, estimate.findings);
  report_rest(data, measured, estimate.findings);
}

}  // namespace tumble::sine_vibration
