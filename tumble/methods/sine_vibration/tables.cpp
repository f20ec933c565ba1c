#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/sine_vibration/describe.hpp"

namespace tumble::sine_vibration {
namespace {

using Severity = Finding::Severity;

constexpr double cycles_sd = 3.0;  ///< [sd] of a shift, that the effect of broken cycles must reach to be a finding

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
  const auto aliased_to = [](const Point& p) { return p.aliased_to > 0.0 ? Table::Cell(p.aliased_to) : ""; };
  return tabulate(
      "response",
      "counts over each frequency as mean specific force over their windows; mean and sd of the windows themselves, "
      "mean_shift by the sine fit against the unit at rest; sd_from_window is the sd by the counting window alone",
      measured.points,
      {{"unit", [&](const Point& p) { return data.units[p.unit].name; }},
       {"segment", [&](const Point& p) { return data.series[p.series].label; }},
       {"frequency", "Hz", [](const Point& p) { return p.line.frequency; }},
       {"level", "g", &Point::level},
       {"mean", "g", [](const Point& p) { return p.line.plain_mean; }},
       {"cycles_effect", "ug", &Point::cycles_effect},
       {"mean_shift", "ug", &Point::shift},
       {"mean_shift_sd", "ug", [&](const Point& p) { return shift_sd(p, rectified); }},
       {"sd", "g", [](const Point& p) { return p.line.sd; }},
       {"sd_from_window", "g", &Point::sd_from_window},
       {"sd_ratio", [](const Point& p) { return p.line.sd / p.sd_from_window; }},
       {"gain", &Point::gain},
       {"gain_sd", [&](const Point& p) { return gain_sd(estimate, data, p); }},
       {"aliased_to", "Hz", aliased_to},
       {"K_2_effective", "ug/g^2", [](const Point& p) { return 2.0 * p.shift / (p.level * p.level); }}});
}

Table units(const vibration::Data& data, const Measured& measured, const std::vector<Rectification>& rectified) {
  const auto rest_drift = [&](std::size_t u) {
    std::vector<double> means;
    for (const auto& rest : measured.rests)
      if (data.series[rest.series].unit == u) means.push_back(rest.line.mean);
    return means.size() > 1 ? means.back() - means.front() : std::nan("");
  };
  const auto of = [&](double Rectification::*sd) {
    return [&, sd](std::size_t u) {
      const auto r = std::ranges::find(rectified, u, &Rectification::unit);
      return r != rectified.end() ? (*r).*sd : std::nan("");
    };
  };
  return tabulate(
      "units",
      "units under test: one pulse; drift at rest from the first to the last segment; by how much whole segments "
      "differ beyond white noise, and K_2,eff from frequency to frequency",
      data.units.size(),
      {{"unit", [&](std::size_t u) { return data.units[u].name; }},
       {"channel", [&](std::size_t u) { return data.units[u].channel; }},
       {"pulse", "g*s", [&](std::size_t u) { return data.units[u].pulse; }},
       {"scale_sd", "%", [&](std::size_t u) { return data.units[u].scale_relative_sd; }},
       {"rest_drift", "ug", rest_drift},
       {"segment_sd", "ug", of(&Rectification::slow_sd)},
       {"frequency_sd", "ug/g^2", of(&Rectification::between_sd)}});
}

std::string curve_name(const vibration::Data& data, std::size_t unit) {
  return data.units.size() > 1 ? data.units[unit].name : "measured";
}

Curve curve(const std::string& name, const std::string& figure, const char* quantity, const char* unit, bool points) {
  return {.name = name,
          .figure = figure,
          .x = {"frequency", Unit::parse("Hz")},
          .y = {quantity, Unit::parse(unit)},
          .points = points};
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
    const double f = p.line.frequency;
    if (const double s = shift_sd(p, rectified); !std::isnan(s)) {
      add_point(shift, f, p.shift, normal_two_sided_95 * s);
      add_point(plain, f, p.shift + p.cycles_effect);
    }
    add_point(sd, f, p.line.sd);
    add_point(gain, f, p.gain, normal_two_sided_95 * gain_sd(estimate, data, p));
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
    add_point(windows, p.line.frequency, p.line.residual_rms);
    if (r == rectified.end() || !r->fitted_shift.contains(p.series)) continue;
    add_point(shift, p.line.frequency, p.shift - r->fitted_shift.at(p.series),
              normal_two_sided_95 * shift_sd(p, rectified));
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
    add_point(window, f, sd_from_window(level, f, first.window, data.units[first.unit].pulse));
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
    if (std::abs(p.cycles_effect) < cycles_sd * (std::isnan(sd) ? 0.0 : sd)) continue;
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
        const double apart = vibration::next_frequency(p.nominal, p.line.span);
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
