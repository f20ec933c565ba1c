#include "tumble/methods/sine_vibration/measure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tumble/core/say.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/regression/sine_fit.hpp"
#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::sine_vibration {
namespace {

using Severity = Finding::Severity;
using vibration::Series;
using vibration::sinc;

/// What comes of one series: a point, the unit at rest, or nothing but findings.
struct Outcome {
  std::optional<Point> point;
  std::optional<Rest> rest;
  Findings findings;
};

struct Context {
  const vibration::Data& data;
  std::vector<std::size_t> motion;             ///< of each series: units on one fixture feel the same
  std::vector<std::optional<Line>> reference;  ///< of each motion
};

double three_digits(double f) { return std::stod(fmt::format("{:.2e}", f)); }

std::string where(const Context& context, const Series& series) {
  const auto& unit = context.data.units[series.unit];
  return unit.prefix.empty() ? series.label : unit.name + ", " + series.label;
}

/// sd over sqrt(2): the amplitude of a tone and nothing else.
double moving(const std::vector<double>& values) {
  double n = 0.0, sum = 0.0, squares = 0.0;
  for (const double v : values)
    if (!std::isnan(v)) ++n, sum += v;
  for (const double v : values)
    if (!std::isnan(v)) squares += (v - sum / n) * (v - sum / n);
  return n > 0.0 ? std::sqrt(2.0 * squares / n) : 0.0;
}

/// The line of these values: at the plan's frequency, else at their own strongest, unfolded to the plan's.
Line line_of(const Series& series, const std::vector<double>& values) {
  const double planned = series.shake.frequency, rate = 1.0 / series.interval, tone = moving(values);
  try {
    Line line = fit_line(series.time, values, series.interval, planned);
    if (line.amplitude > 0.5 * tone) return line;
  } catch (const Error&) {
    // no tone there: looked for below
  }
  const double seen = strongest_frequency(values, rate);
  double best = seen;
  for (int k = 0; k <= static_cast<int>(planned / rate) + 1; ++k)
    for (const double f : {k * rate + seen, k * rate - seen})
      if (f > 0.0 && std::abs(f - planned) < std::abs(best - planned)) best = f;
  return fit_line(series.time, values, series.interval, best);
}

/// The same extreme three windows running again and again, and harmonics to match: flat tops.
bool clipped(const Series& series, const Line& line, double pulse) {
  if (series.shake.frequency * series.interval > 0.13 || line.amplitude * series.window < 20.0 * pulse) return false;
  const auto& v = series.force;
  double low = INFINITY, high = -INFINITY;
  for (const double x : v)
    if (!std::isnan(x)) low = std::min(low, x), high = std::max(high, x);
  const double close = 1e-6 * (high - low) + 1.5 * pulse / series.window;
  std::size_t runs = 0;
  for (std::size_t i = 2; i < v.size(); ++i)
    for (const double end : {low, high})
      if (std::abs(v[i] - end) < close && std::abs(v[i - 1] - end) < close && std::abs(v[i - 2] - end) < close) ++runs;
  const double harmonics =
      std::hypot(std::isnan(line.second) ? 0.0 : line.second, std::isnan(line.third) ? 0.0 : line.third);
  return static_cast<double>(runs) > 0.02 * static_cast<double>(v.size()) && harmonics > 0.01 * line.amplitude;
}

/// (3.14): the rounding of the running total, 1/12 pulse^2, differenced, is 4 sin^2(pi f H) of it at f; over a raster
/// of P windows, after which tone and total repeat, only P of them are independent: 2/P of that on the square of the
/// amplitude. Where they do not repeat it is noise, and in the residuals.
double rounding_log_variance(const Line& line, double cycles_per_window, double pulse_force) {
  const double n = static_cast<double>(line.samples);
  const double p = raster(cycles_per_window, line.mean / pulse_force, n);
  if (p >= 0.25 * n) return 0.0;
  const double pulses = line.amplitude / pulse_force;
  return 2.0 / (3.0 * p) * std::pow(std::sin(pi * cycles_per_window), 2) / (pulses * pulses);
}

/// The motion itself: by the reference where there is one, else as planned.
void set_level(const Context& context, const Series& series, Point& point, Findings& findings) {
  point.level = series.shake.amplitude;
  point.distortion = std::nan("");
  point.motion = context.motion[point.series];
  if (!context.reference[point.motion]) return;
  const Line& reference = *context.reference[point.motion];
  const double window = context.data.reference_integrated ? std::abs(sinc(reference.frequency * series.window)) : 1.0;
  point.level = reference.amplitude / window;
  point.level_log_variance = reference.log_variance;
  point.level_degrees_of_freedom = reference.noise_degrees_of_freedom;
  point.distortion = reference.second / reference.amplitude;
  const double off = reference.frequency - point.line.frequency;
  if (std::abs(off) * point.line.span > 0.1)
    findings.push_back({Severity::warning,
                        fmt::format("unit and reference differ in frequency by {:.3g} mHz: their clocks disagree; each "
                                    "is fitted at its own",
                                    1e3 * off),
                        where(context, series)});
}

/// A tone that is not the one planned.
void compare_with_plan(const Context& context, const Series& series, const Point& point, Findings& findings) {
  const double planned = series.shake.frequency, found = point.line.frequency;
  if (std::abs(found - planned) * point.line.span > 2.0)
    findings.push_back(
        {Severity::warning,
         fmt::format("the plan says {:.6g} Hz, the unit is shaken at {:.6g} Hz, or a frequency that looks "
                     "the same at {:.6g} windows a second: correct the plan",
                     planned, found, 1.0 / series.interval),
         where(context, series)});
  const double planned_level = series.shake.amplitude;
  if (planned_level > 0.0 && context.reference[point.motion] && std::abs(std::log(point.level / planned_level)) > 0.1)
    findings.push_back(
        {Severity::warning,
         fmt::format("the plan says {}, the reference {}: the level of the reference is used",
                     say_value(planned_level, Unit::parse("g")), say_difference(point.level, Unit::parse("g"))),
         where(context, series)});
  if (point.gain < 0.5 || point.gain > 2.0)
    findings.push_back({Severity::warning,
                        fmt::format("the unit shows {:.3g} times the motion {}: a wrong level, scale factor or unit of "
                                    "the channel, or a resonance",
                                    point.gain, context.reference[point.motion] ? "of the reference" : "planned"),
                        where(context, series)});
}

void refuse_clipping(const Context& context, const Series& series, const Point& point) {
  const Unit g = Unit::parse("g");
  if (context.data.range) {
    const double peak =
        point.level * std::max(point.gain, 1.0) + (std::isnan(series.rest) ? 0.0 : std::abs(series.rest));
    if (peak > *context.data.range)
      throw Error(Error::Kind::bad_data,
                  fmt::format("{} of vibration on {} at rest go beyond the unit's range of {}: it clips, and clipping "
                              "shifts the mean; use less amplitude",
                              say_difference(point.level * std::max(point.gain, 1.0), g),
                              say_difference(std::isnan(series.rest) ? 0.0 : std::abs(series.rest), g),
                              say_difference(*context.data.range, g)));
  }
  if (clipped(series, point.line, context.data.units[series.unit].pulse))
    throw Error(Error::Kind::bad_data,
                "the unit is clipped: its extremes repeat window after window, with harmonics to match; use less "
                "amplitude or a unit of more range");
}

Point point_of(const Context& context, std::size_t index, Findings& findings) {
  const Series& series = context.data.series[index];
  const auto& unit = context.data.units[series.unit];
  const double length = series.end - series.begin;
  if (const auto why = objection(series.shake.frequency, series.averaging, series.interval, length); !why.empty())
    throw Error(Error::Kind::bad_data, why);
  Point point;
  point.series = index;
  point.unit = series.unit;
  point.window = series.averaging;
  point.nominal = three_digits(series.shake.frequency);
  point.line = line_of(series, series.force);
  const double f = point.line.frequency, pulse_force = unit.pulse / series.window;
  if (const auto why = objection(f, series.averaging, series.interval, length); !why.empty())
    throw Error(Error::Kind::bad_data, why);
  set_level(context, series, point, findings);
  const double window = std::abs(sinc(f * series.averaging));
  const double expected = (series.shake.amplitude > 0.0 ? series.shake.amplitude : point.level) * window;
  if (!(point.line.amplitude > 0.03 * expected) || point.line.log_variance > 0.04)
    throw Error(Error::Kind::bad_data,
                fmt::format("no tone of {:.6g} Hz rises above the noise: the shaker was not on, or "
                            "the unit is not connected",
                            series.shake.frequency));
  point.gain = point.line.amplitude / (point.level * window);
  refuse_clipping(context, series, point);
  compare_with_plan(context, series, point, findings);
  if (unit.pulse > 0.0)
    point.rounding_log_variance = rounding_log_variance(point.line, f * series.interval, pulse_force);
  point.sd_from_window = sd_from_window(point.level, f, series.averaging, unit.pulse);
  const double rate = 1.0 / series.interval;
  point.aliased_to = f > 0.5 * rate ? aliased_frequency(f, rate) : 0.0;
  point.hidden_harmonic = hidden_harmonic(f, series.interval, length);
  point.cycles_effect = point.line.plain_mean - point.line.mean;
  point.cycles_bound = point.line.amplitude / (window * pi * f * point.line.span);
  return point;
}

Outcome outcome_of(const Context& context, std::size_t index) {
  const Series& series = context.data.series[index];
  Outcome outcome;
  try {
    if (series.at_rest())
      outcome.rest = Rest{index, fit_rest(series.time, series.force, series.interval)};
    else if (series.shake.kind == Motion::Kind::sine)
      outcome.point = point_of(context, index, outcome.findings);
    else
      outcome.findings.push_back({Severity::info, "passed over: no sine", where(context, series)});
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    outcome.findings.push_back({Severity::error, fmt::format("left out: {}", error.what()), where(context, series)});
  }
  return outcome;
}

/// The reference of each motion, fitted once for all units.
Context context_of(const vibration::Data& data, Findings& findings) {
  Context context{data, {}, {}};
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < data.series.size(); ++i) {
    const auto same = std::ranges::find_if(first, [&](std::size_t k) {
      const Series &a = data.series[i], &b = data.series[k];
      return a.recording == b.recording && a.run == b.run && a.label == b.label;
    });
    context.motion.push_back(static_cast<std::size_t>(same - first.begin()));
    if (same == first.end()) first.push_back(i);
  }
  context.reference.resize(first.size());
  std::vector<std::string> trouble(first.size());
  parallel_for(first.size(), [&](std::size_t k) {
    const Series& series = data.series[first[k]];
    if (series.reference.empty() || series.shake.kind != Motion::Kind::sine) return;
    if (!objection(series.shake.frequency, series.averaging, series.interval, series.end - series.begin).empty())
      return;
    try {
      context.reference[k] = line_of(series, series.reference);
    } catch (const Error& error) {
      trouble[k] = error.what();
    }
  });
  for (std::size_t k = 0; k < first.size(); ++k)
    if (!trouble[k].empty())
      findings.push_back({Severity::warning, fmt::format("the reference cannot be used: {}", trouble[k]),
                          data.series[first[k]].label});
  return context;
}

/// What is said of several units alike, of the motion, is said once.
void add_finding(Finding finding, Findings& findings) {
  const auto label = [](const std::string& where) {
    const auto comma = where.find(", ");
    return comma == std::string::npos ? where : where.substr(comma + 2);
  };
  for (auto& known : findings) {
    if (known.message != finding.message || label(known.where) != label(finding.where)) continue;
    known.where = label(known.where);
    return;
  }
  findings.push_back(std::move(finding));
}

/// Mean against the unit at rest before and after.
void set_shifts(const vibration::Data& data, Measured& measured) {
  for (Point& point : measured.points) {
    const auto rest = vibration::at_rest(data, data.series[point.series]);
    point.shift = rest.parts.empty() ? std::nan("") : point.line.mean;
    point.both_sides = rest.both_sides;
    for (const auto& part : rest.parts) {
      const auto found = std::ranges::find(measured.rests, part.series, &Rest::series);
      point.shift -= found == measured.rests.end() ? std::nan("") : part.weight * found->line.mean;
    }
  }
}

/// A sound unit rectifies some 1e-5 g/g^2, far below a hundredth of a per cent of a few g. Parts in a thousand are
/// something else, above all clipping, which acts on one side first because of a_0.
void tell_large_shifts(const vibration::Data& data, Measured& measured) {
  for (const Point& point : measured.points) {
    if (!(std::abs(point.shift) > 2e-3 * point.level)) continue;
    const Series& series = data.series[point.series];
    const auto& unit = data.units[point.unit];
    measured.findings.push_back(
        {Severity::warning,
         fmt::format("the mean shifts by {}, {:.2g} % of the amplitude, far more than a sound unit rectifies: it clips "
                     "(set its range), strikes a stop or is loose; what rectifies goes with the square of the level: "
                     "repeat at less amplitude",
                     say_difference(point.shift, Unit::parse("mg")), 100.0 * std::abs(point.shift) / point.level),
         unit.prefix.empty() ? series.label : unit.name + ", " + series.label});
  }
}

}  // namespace

int hidden_harmonic(double frequency, double interval, double span) {
  const double rate = 1.0 / interval, here = aliased_frequency(frequency, rate);
  for (const int k : {2, 3})
    if (std::abs(aliased_frequency(k * frequency, rate) - here) * span < 2.0) return k;
  return 0;
}

double sd_from_window(double amplitude, double frequency, double window, double pulse) {
  const double line = amplitude * sinc(frequency * window);
  return std::sqrt(0.5 * line * line + pulses::rounding_variance(pulse, window));
}

std::string objection(double frequency, double window, double interval, double span) {
  if (!(frequency > 0.0)) return "the plan gives no frequency above zero";
  const double turns = frequency * window;
  if (std::round(turns) > 0.0 && std::abs(turns - std::round(turns)) < 0.05)
    return fmt::format(
        "{:.6g} Hz lies within 5 % of a null of the counting window of {}, where it shows next to nothing and is never "
        "corrected for: use {:.6g} Hz or {:.6g} Hz, or another counting period",
        frequency, say_seconds(window), (std::round(turns) - 0.1) / window, (std::round(turns) + 0.1) / window);
  const double half = 0.5 / interval, nearest = half * std::round(frequency / half), off = frequency - nearest;
  if (nearest > 0.0 && std::abs(off) * span < 1.5)
    return fmt::format(
        "{:.6g} Hz is half of the {:.6g} windows a second, or a multiple: sine and cosine cannot be told apart, and "
        "the "
        "spread of the counts depends on the phase alone; use {:.6g} Hz or {:.6g} Hz",
        frequency, 1.0 / interval, nearest - std::max(0.003 * nearest, 3.0 / span),
        nearest + std::max(0.003 * nearest, 3.0 / span));
  if (frequency * span < 3.0)
    return fmt::format("{:.3g} s hold fewer than three cycles of {:.6g} Hz: measure longer", span, frequency);
  return "";
}

Measured measure(const vibration::Data& data) {
  Measured measured;
  const Context context = context_of(data, measured.findings);
  std::vector<Outcome> outcomes(data.series.size());
  parallel_for(outcomes.size(), [&](std::size_t i) { outcomes[i] = outcome_of(context, i); });
  std::size_t with = 0;
  for (auto& outcome : outcomes) {
    for (auto& finding : outcome.findings) add_finding(std::move(finding), measured.findings);
    if (outcome.rest) measured.rests.push_back(std::move(*outcome.rest));
    if (!outcome.point) continue;
    with += context.reference[outcome.point->motion] ? 1 : 0;
    measured.points.push_back(std::move(*outcome.point));
  }
  measured.reference = with > 0;
  if (with > 0 && with < measured.points.size())
    measured.findings.push_back({Severity::warning,
                                 fmt::format("the reference is missing in {}: the plan's level stands for it there",
                                             say_count(measured.points.size() - with, "tone")),
                                 ""});
  set_shifts(data, measured);
  tell_large_shifts(data, measured);
  std::ranges::stable_sort(measured.points, [&](const Point& a, const Point& b) {
    if (a.unit != b.unit) return a.unit < b.unit;
    if (a.nominal != b.nominal) return a.nominal < b.nominal;
    return data.series[a.series].shake.amplitude < data.series[b.series].shake.amplitude;
  });
  return measured;
}

}  // namespace tumble::sine_vibration
