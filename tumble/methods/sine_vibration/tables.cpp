#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/say.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/sine_vibration/describe.hpp"

namespace tumble::sine_vibration {
namespace {

using Severity = Finding::Severity;

/// Standard uncertainty of the mean shift of a point; NaN where it has none.
double shift_sd(const Point& point, const std::vector<Rectification>& rectified) {
  for (const auto& r : rectified) {
    const auto found = r.shift_variance.find(point.series);
    if (found != r.shift_variance.end()) return std::sqrt(found->second);
  }
  return std::nan("");
}

double gain_sd(const Estimate& estimate, const vibration::Data& data, const Measured& measured, const Point& point) {
  std::size_t at = 0;
  for (const auto& parameter : estimate.parameters) {
    if (parameter.symbol == "|G|" && parameter.name.starts_with(data.units[point.unit].prefix + "gain_")) {
      std::vector<double> known;
      for (const auto& p : measured.points)
        if (p.unit == point.unit && (known.empty() || known.back() != p.nominal)) known.push_back(p.nominal);
      const auto k = static_cast<std::size_t>(std::ranges::find(known, point.nominal) - known.begin());
      return standard_uncertainty(estimate, at + k);
    }
    ++at;
  }
  return std::nan("");
}

Table response(const vibration::Data& data, const Measured& measured, const std::vector<Rectification>& rectified,
               const Estimate& estimate) {
  const auto unit = [](const char* text) { return Unit::parse(text); };
  Table table{
      "response",
      "counts over each frequency as mean specific force over their windows; mean and sd as they are, mean_shift "
      "by the sine fit against the unit at rest; sd_from_window is what the counting window alone lets expect",
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
          p.sd_from_window, p.line.sd / p.sd_from_window, p.gain, gain_sd(estimate, data, measured, p)})
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

void add_curves(const vibration::Data& data, const Measured& measured, const std::vector<Rectification>& rectified,
                Estimate& estimate) {
  double low = INFINITY, high = 0.0, level = 0.0;
  for (const Point& p : measured.points) {
    low = std::min(low, p.line.frequency);
    high = std::max(high, p.line.frequency);
    level += p.level / static_cast<double>(measured.points.size());
  }
  for (std::size_t u = 0; u < data.units.size(); ++u) {
    Curve shift = curve(curve_name(data, u), "mean over frequency", "mean shift", "ug", true);
    Curve plain = curve(curve_name(data, u) + ", plain mean", "mean over frequency", "mean shift", "ug", true);
    Curve sd = curve(curve_name(data, u), "standard deviation over frequency", "sd", "g", true);
    Curve gain = curve(curve_name(data, u), "gain over frequency", "gain", "1", true);
    shift.band = gain.band = "95 % confidence";
    for (const Point& p : measured.points) {
      if (p.unit != u) continue;
      const auto add = [&](Curve& to, double value, double uncertainty) {
        to.x.values.push_back(p.line.frequency);
        to.y.values.push_back(value);
        if (!to.band.empty()) {
          to.lower.push_back(value - 1.96 * uncertainty);
          to.upper.push_back(value + 1.96 * uncertainty);
        }
      };
      if (const double s = shift_sd(p, rectified); !std::isnan(s)) {
        add(shift, p.shift, s);
        add(plain, p.shift + p.cycles_effect, s);
      }
      add(sd, p.line.sd, 0.0);
      add(gain, p.gain, gain_sd(estimate, data, measured, p));
    }
    for (Curve* c : {&shift, &plain, &sd, &gain})
      if (!c->x.values.empty()) estimate.curves.push_back(std::move(*c));
  }
  Curve window = curve("the counting window alone", "standard deviation over frequency", "sd", "g", false);
  for (int i = 0; i <= 200; ++i) {
    const double f = low + (high - low) * i / 200.0;
    window.x.values.push_back(f);
    window.y.values.push_back(
        sd_from_window(level, f, measured.points.front().window, data.units[measured.points.front().unit].pulse));
  }
  if (high > low) estimate.curves.push_back(std::move(window));
}

/// What of the spread over frequency is the counter's, and what the instrument's.
void tell_parts(const vibration::Data& data, const Measured& measured, Findings& findings) {
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
    findings.push_back(
        {Severity::info,
         fmt::format("from {:.4g} to {:.4g} Hz the sd of the counts goes to {:.3g} of itself at the same "
                     "level: {:.3g} by the counting window, {:.3g} by the instrument and its mounting",
                     first->line.frequency, last->line.frequency, sd, window, sd / window),
         data.units[u].prefix.empty() ? "" : data.units[u].name});
  }
}

void tell_cycles(const vibration::Data& data, const Measured& measured, const std::vector<Rectification>& rectified,
                 Findings& findings) {
  const Unit ug = Unit::parse("ug");
  const Point* worst = nullptr;
  for (const Point& p : measured.points) {
    const double sd = shift_sd(p, rectified);
    if (std::abs(p.cycles_effect) < 3.0 * (std::isnan(sd) ? 0.0 : sd)) continue;
    if (worst == nullptr || std::abs(p.cycles_effect) > std::abs(worst->cycles_effect)) worst = &p;
  }
  if (worst == nullptr) return;
  const vibration::Series& series = data.series[worst->series];
  const bool whole = std::ranges::none_of(series.force, [](double v) { return std::isnan(v); });
  findings.push_back(
      {Severity::info,
       fmt::format("{:.7g} Hz is not a whole number of cycles in the {}: the plain mean of the counts is off by {}{}; "
                   "mean_shift is that of the sine fit, which is not",
                   worst->line.frequency, whole ? "time measured" : "windows that are not missed",
                   say_difference(worst->cycles_effect, ug),
                   whole ? fmt::format(" (bound {})", say_difference(worst->cycles_bound, ug)) : ""),
       (data.units[worst->unit].prefix.empty() ? "" : data.units[worst->unit].name + ", ") + series.label});
}

void tell_aliases(const Measured& measured, Findings& findings) {
  std::string list;
  double last = 0.0;
  for (const Point& p : measured.points) {
    if (p.aliased_to == 0.0 || p.nominal <= last) continue;
    last = p.nominal;
    list += fmt::format("{}{:.4g} Hz at {:.4g} Hz", list.empty() ? "" : ", ", p.line.frequency, p.aliased_to);
  }
  if (!list.empty())
    findings.push_back(
        {Severity::info,
         "above half of the windows a second tones show at another frequency (" + list + "): fitted at their true one",
         ""});
}

void tell_harmonics(const vibration::Data& data, const Measured& measured, Findings& findings) {
  double last = 0.0;
  for (const Point& p : measured.points) {
    if (p.hidden_harmonic == 0 || p.nominal <= last) continue;
    last = p.nominal;
    const double off = std::max(0.003 * p.nominal, 3.0 / p.line.span);
    findings.push_back(
        {Severity::warning,
         fmt::format("harmonic {} of {:.6g} Hz shows at the same frequency in {:.6g} windows a second: the "
                     "distortion of the shake is in the gain there, and in its uncertainty; use {:.6g} Hz "
                     "or {:.6g} Hz",
                     p.hidden_harmonic, p.line.frequency, 1.0 / data.series[p.series].interval, p.nominal - off,
                     p.nominal + off),
         data.series[p.series].label});
  }
}

void tell_rest(const vibration::Data& data, const Measured& measured, Findings& findings) {
  std::size_t one_side = 0;
  for (const Point& p : measured.points) one_side += !std::isnan(p.shift) && !p.both_sides ? 1 : 0;
  if (one_side > 0)
    findings.push_back(
        {Severity::warning,
         fmt::format("{} with a segment at rest on one side only: warming up in vibration is taken for a "
                     "shift of the mean; record the units at rest before and after",
                     say_count(one_side, "tone")),
         ""});
  if (measured.rests.size() < 4 * data.units.size() && !measured.rests.empty())
    findings.push_back(
        {Severity::info,
         "fewer than four segments at rest for each unit: what differs from frequency to frequency is taken "
         "for slow noise; more of them between the tones tell the two apart",
         ""});
}

}  // namespace

void add_tables(const vibration::Data& data, const Measured& measured, const std::vector<Rectification>& rectified,
                Estimate& estimate) {
  estimate.tables.push_back(response(data, measured, rectified, estimate));
  estimate.tables.push_back(units(data, measured, rectified));
  add_curves(data, measured, rectified, estimate);
  tell_parts(data, measured, estimate.findings);
  tell_cycles(data, measured, rectified, estimate.findings);
  tell_aliases(measured, estimate.findings);
  tell_harmonics(data, measured, estimate.findings);
  tell_rest(data, measured, estimate.findings);
}

}  // namespace tumble::sine_vibration
