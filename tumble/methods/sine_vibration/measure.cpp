#include "tumble/methods/sine_vibration/measure.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "tumble/math/parallel.hpp"
#include "tumble/math/regression/sine_fit.hpp"
#include "tumble/methods/sine_vibration/screened.hpp"
#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/reduce/vibration/windows.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::sine_vibration {
namespace {

using Severity = Finding::Severity;
using vibration::Series;
using vibration::sinc;

/// Flat tops show in three windows in succession up to so many cycles in a window, and from so many pulses in it on.
constexpr double most_cycles_of_tops = 0.13, least_pulses_of_tops = 20.0;
/// [1] of the range, and [pulse], within which a window is at the top.
constexpr double at_top_share = 1e-6, at_top_pulses = 1.5;
constexpr double flat_share = 0.02, flat_harmonics = 0.01;  ///< [1] of the windows, and [1] of the amplitude
constexpr double frequency_apart = 0.1;                     ///< [cycles] over the tone between unit and reference
constexpr double level_apart = 0.1;                         ///< [1] in the logarithm: 10 % of the planned level
constexpr double other_frequency_bins = 2.0;  ///< [1/span] from the plan, from which on a tone may be another
constexpr double over_rounding = 1.5;         ///< [1] of the greatest line by rounding, that a tone must exceed
constexpr double improbable_shift = 2e-3;     ///< [1] of the level; a sound unit is a hundred times better
constexpr double fewest_cycles = 3.0;         ///< of a tone beside a mean and a drift

/// The result of one series: a point, the unit at rest, or findings alone.
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

/// The line of these values: at the plan's frequency, else at their own strongest, unfolded to the plan's.
Line line_of(const Series& series, const std::vector<double>& values) {
  const double planned = series.shake.frequency, rate = 1.0 / series.interval;
  try {
    Line line = fit_line(series.time, values, series.interval, planned);
    // The spread of a tone alone is its amplitude over sqrt(2).
    if (line.amplitude > std::numbers::sqrt2 / 2.0 * vibration::spread(values)) return line;
  } catch (const Error&) {
    // There is no tone at the plan's frequency.
  }
  const double strongest = strongest_frequency(values, rate);
  double best = strongest;
  for (int k = 0; k <= static_cast<int>(planned / rate) + 1; ++k)
    for (const double f : {k * rate + strongest, k * rate - strongest})
      if (f > 0.0 && std::abs(f - planned) < std::abs(best - planned)) best = f;
  return fit_line(series.time, values, series.interval, best);
}

/// Amplitude [u] of the harmonics that can be measured.
double harmonics_of(const Line& line) {
  return std::hypot(std::isnan(line.second) ? 0.0 : line.second, std::isnan(line.third) ? 0.0 : line.third);
}

/// Flat tops: one extreme in three windows in succession, again and again, and harmonics to match.
bool clipped(const Series& series, const Line& line, double pulse) {
  if (series.shake.frequency * series.interval > most_cycles_of_tops ||
      line.amplitude * series.window < least_pulses_of_tops * pulse)
    return false;
  const auto& v = series.force;
  double low = INFINITY, high = -INFINITY;
  for (const double x : v)
    if (!std::isnan(x)) low = std::min(low, x), high = std::max(high, x);
  const double close = at_top_share * (high - low) + at_top_pulses * pulse / series.window;
  std::size_t runs = 0;
  for (std::size_t i = 2; i < v.size(); ++i)
    for (const double end : {low, high})
      if (std::abs(v[i] - end) < close && std::abs(v[i - 1] - end) < close && std::abs(v[i - 2] - end) < close) ++runs;
  return static_cast<double>(runs) > flat_share * static_cast<double>(v.size()) &&
         harmonics_of(line) > flat_harmonics * line.amplitude;
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
  const double difference = reference.frequency - point.line.frequency;
  if (std::abs(difference) * point.line.span > frequency_apart)
    findings.push_back(
        {Severity::warning,
         "clocks_disagree",
         {{"difference", difference / point.line.frequency, "ppm"}, {"cycles", std::abs(difference) * point.line.span}},
         place_of(context.data, series)});
}

/// Findings where the tone differs from the plan.
void compare_with_plan(const Context& context, const Series& series, const Point& point, Findings& findings) {
  const std::string where = place_of(context.data, series);
  const bool reference = context.reference[point.motion].has_value();
  const double planned = series.shake.frequency, planned_level = series.shake.amplitude;
  if (std::abs(point.line.frequency - planned) * point.line.span > 2.0)
    findings.push_back(
        {Severity::warning,
         "frequency_differs_from_plan",
         {{"planned", planned, "Hz"}, {"measured", point.line.frequency, "Hz"}, {"rate", 1.0 / series.interval, "Hz"}},
         where});
  if (planned_level > 0.0 && reference && std::abs(std::log(point.level / planned_level)) > level_apart)
    findings.push_back({Severity::warning,
                        "level_differs_from_plan",
                        {{"planned", planned_level, "g"}, {"measured", point.level, "g"}},
                        where});
  if (point.gain < 0.5 || point.gain > 2.0)
    findings.push_back(
        {Severity::warning,
         "improbable_gain",
         {{"gain", point.gain}, {"motion", Phrase{reference ? "motion_of_reference" : "motion_of_plan"}}},
         where});
}

/// [m/s^2] that rounding to pulses alone can give a line where the shaker was off: it beats with the windows at any
/// frequency, with up to 2/pi |sin(pi f H)| pulses. At the planned frequency it can only where count and tone repeat.
double least_amplitude(const Context& context, const Series& series, const Line& line) {
  const double pulse = context.data.units[series.unit].pulse / series.window;
  if (!(pulse > 0.0)) return 0.0;
  if (std::abs(line.frequency - series.shake.frequency) * line.span > other_frequency_bins) return pulse;
  const double turns = line.frequency * series.interval, samples = static_cast<double>(line.samples);
  const bool repeats = vibration::raster(turns, line.mean / pulse, samples) < vibration::raster_within * samples;
  return repeats ? over_rounding * 2.0 / pi * std::abs(std::sin(pi * turns)) * pulse : 0.0;
}

/// Why the tone cannot be used: the shaker was off, or the unit clips. None: it can.
std::optional<Finding> fault_of(const Context& context, const Series& series, const Point& point) {
  const std::string where = place_of(context.data, series);
  const Line& line = point.line;
  if (!(line.amplitude > least_amplitude(context, series, line)) || line.log_variance > tone_below_noise)
    return Finding{Severity::error, "tone_below_noise", {{"frequency", series.shake.frequency, "Hz"}}, where};
  const double vibration = point.level * std::max(point.gain, 1.0);
  const double rest = std::isnan(series.rest) ? 0.0 : std::abs(series.rest);
  if (context.data.range && vibration + rest > *context.data.range)
    return Finding{Severity::error,
                   "tone_beyond_range",
                   {{"vibration", vibration, "g"}, {"rest", rest, "g"}, {"range", *context.data.range, "g"}},
                   where};
  if (clipped(series, line, context.data.units[series.unit].pulse))
    return Finding{Severity::error,
                   "tone_clipped",
                   {{"frequency", line.frequency, "Hz"}, {"harmonics", harmonics_of(line) / line.amplitude, "%"}},
                   where};
  return {};
}

/// The tone of a series; none, with a finding, where it cannot be used.
std::optional<Point> point_of(const Context& context, std::size_t index, Findings& findings) {
  const Series& series = context.data.series[index];
  const auto& unit = context.data.units[series.unit];
  const double length = series.end - series.begin;
  const auto unusable = [&](std::optional<Finding> fault) {
    if (fault) findings.push_back(*fault);
    return fault.has_value();
  };
  const std::string where = place_of(context.data, series);
  if (unusable(objection(series.shake.frequency, series.averaging, series.interval, length, where))) return {};
  Point point;
  point.series = index;
  point.unit = series.unit;
  point.window = series.averaging;
  point.nominal = vibration::three_digits(series.shake.frequency);
  point.line = screened(
      series, unit.pulse, [&](const std::vector<double>& values) { return line_of(series, values); }, point.skipped);
  const double f = point.line.frequency, rate = 1.0 / series.interval, pulse_force = unit.pulse / series.window;
  if (unusable(objection(f, series.averaging, series.interval, length, where))) return {};
  set_level(context, series, point, findings);
  const double window = std::abs(sinc(f * series.averaging));
  point.gain = point.line.amplitude / (point.level * window);
  if (unusable(fault_of(context, series, point))) return {};
  compare_with_plan(context, series, point, findings);
  if (unit.pulse > 0.0)
    point.rounding_log_variance =
        vibration::rounding_log_variance(point.line.amplitude / pulse_force, f * series.interval,
                                         point.line.mean / pulse_force, static_cast<double>(point.line.samples));
  point.sd_from_window = sd_from_window(point.level, f, series.averaging, unit.pulse);
  point.aliased_to = f > 0.5 * rate ? aliased_frequency(f, rate) : 0.0;
  point.hidden_harmonic = hidden_harmonic(f, series.interval, length);
  point.cycles_effect = point.line.plain_mean - point.line.mean;
  point.cycles_bound = point.line.amplitude / (window * pi * f * point.line.span);
  return point;
}

Rest rest_of(const Context& context, std::size_t index) {
  const Series& series = context.data.series[index];
  Rest rest;
  rest.series = index;
  rest.line = screened(
      series, context.data.units[series.unit].pulse,
      [&](const std::vector<double>& values) { return fit_rest(series.time, values, series.interval); }, rest.skipped);
  return rest;
}

Outcome outcome_of(const Context& context, std::size_t index) {
  const Series& series = context.data.series[index];
  Outcome outcome;
  try {
    if (series.at_rest())
      outcome.rest = rest_of(context, index);
    else if (series.shake.kind == Motion::Kind::sine)
      outcome.point = point_of(context, index, outcome.findings);
    else
      outcome.findings.push_back({Severity::info, "segment_without_sine", {}, place_of(context.data, series)});
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    outcome.findings.push_back(
        {Severity::error, "segment_not_measurable", {{"reason", reason_of(error)}}, place_of(context.data, series)});
  }
  return outcome;
}

/// The reference of each motion, fitted once for all units.
Context context_of(const vibration::Data& data, Findings& findings) {
  Context context{data, {}, {}};
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < data.series.size(); ++i) {
    const auto shared = std::ranges::find_if(first, [&](std::size_t k) {
      const Series &a = data.series[i], &b = data.series[k];
      return a.recording == b.recording && a.run == b.run && a.label == b.label;
    });
    context.motion.push_back(static_cast<std::size_t>(shared - first.begin()));
    if (shared == first.end()) first.push_back(i);
  }
  context.reference.resize(first.size());
  std::vector<std::string> reasons(first.size());
  parallel_for(first.size(), [&](std::size_t k) {
    const Series& series = data.series[first[k]];
    if (series.reference.empty() || series.shake.kind != Motion::Kind::sine) return;
    if (objection(series.shake.frequency, series.averaging, series.interval, series.end - series.begin, "")) return;
    try {
      context.reference[k] = line_of(series, series.reference);
    } catch (const Error& error) {
      reasons[k] = error.what();
    }
  });
  for (std::size_t k = 0; k < first.size(); ++k)
    if (!reasons[k].empty())
      findings.push_back(
          {Severity::warning, "reference_not_usable", {{"reason", reasons[k]}}, data.series[first[k]].label});
  return context;
}

/// Adds a finding; where several units have it alike in one segment, it is of the motion and stands once.
void add_finding(const vibration::Data& data, const std::string& label, Finding finding, Findings& findings) {
  const auto is_here = [&](const std::string& where) {
    return where == label || std::ranges::any_of(data.series, [&](const Series& series) {
             return series.label == label && place_of(data, series) == where;
           });
  };
  for (auto& earlier : findings) {
    if (!vibration::same_matter(earlier, finding) || !is_here(earlier.where)) continue;
    earlier.where = label;
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
      const auto at_rest = std::ranges::find(measured.rests, part.series, &Rest::series);
      point.shift -= at_rest == measured.rests.end() ? std::nan("") : part.weight * at_rest->line.mean;
    }
  }
}

/// A sound unit rectifies some 1e-5 g/g^2, far below a hundredth of a per cent of a few g. Parts in a thousand are
/// something else, above all clipping, which acts on one side first because of a_0.
void report_large_shifts(const vibration::Data& data, Measured& measured) {
  for (const Point& point : measured.points)
    if (std::abs(point.shift) > improbable_shift * point.level)
      measured.findings.push_back({Severity::warning,
                                   "improbable_mean_shift",
                                   {{"shift", point.shift, "mg"}, {"share", std::abs(point.shift) / point.level, "%"}},
                                   place_of(data, data.series[point.series])});
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

std::optional<Finding> objection(double frequency, double window, double interval, double span,
                                 const std::string& where) {
  if (!(frequency > 0.0)) return Finding{Severity::error, "no_planned_frequency", {}, where};
  if (auto hidden = vibration::hidden_tone(frequency, window, interval, span, where)) return hidden;
  if (frequency * span < fewest_cycles)
    return Finding{Severity::error, "too_few_cycles", {{"span", span, "s"}, {"frequency", frequency, "Hz"}}, where};
  return {};
}

Measured measure(const vibration::Data& data) {
  Measured measured;
  const Context context = context_of(data, measured.findings);
  std::vector<Outcome> outcomes(data.series.size());
  parallel_for(outcomes.size(), [&](std::size_t i) { outcomes[i] = outcome_of(context, i); });
  std::size_t with = 0;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    Outcome& outcome = outcomes[i];
    for (auto& finding : outcome.findings)
      add_finding(data, data.series[i].label, std::move(finding), measured.findings);
    const auto add_skipped = [&](std::size_t series, const vibration::Outliers& skipped) {
      vibration::add_outliers(data, data.series[series], skipped, measured.findings);
    };
    if (outcome.rest) {
      add_skipped(outcome.rest->series, outcome.rest->skipped);
      measured.rests.push_back(std::move(*outcome.rest));
    }
    if (!outcome.point) continue;
    add_skipped(outcome.point->series, outcome.point->skipped);
    with += context.reference[outcome.point->motion] ? 1 : 0;
    measured.points.push_back(std::move(*outcome.point));
  }
  measured.reference = with > 0;
  if (with > 0 && with < measured.points.size())
    measured.findings.push_back({Severity::warning, "reference_missing", {{"tones", measured.points.size() - with}}});
  set_shifts(data, measured);
  report_large_shifts(data, measured);
  std::ranges::stable_sort(measured.points, [&](const Point& a, const Point& b) {
    if (a.unit != b.unit) return a.unit < b.unit;
    if (a.nominal != b.nominal) return a.nominal < b.nominal;
    return data.series[a.series].shake.amplitude < data.series[b.series].shake.amplitude;
  });
  return measured;
}

}  // namespace tumble::sine_vibration
