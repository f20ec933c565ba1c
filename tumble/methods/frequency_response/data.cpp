#include "tumble/methods/frequency_response/data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "tumble/units/error.hpp"

namespace tumble::frequency_response {
namespace {

/// [samples] that a stamp may be off the even clock: a sample is then where the clock has it, and the stamp is rounded or late.
constexpr double most_off_clock = 0.5;
constexpr std::size_t fewest_of_recording = 16;  ///< samples, twice the coefficients of a tone with its harmonics

void require_finite(const Channel& channel) {
  constexpr double least = 1e-60, most = 1e60;  // [SI] squares and variances remain numbers
  double size = 0.0;
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    if (std::isinf(channel.values[i]))
      throw Error(Error::Kind::bad_data, say("'{}' is infinite at {:.6g} s", channel.name, channel.time(i)));
    if (!std::isnan(channel.values[i])) size = std::max(size, std::abs(channel.values[i]));
  }
  if (size != 0.0 && (size < least || size > most))
    throw Error(Error::Kind::bad_data,
                say("'{}' shows {:.3g} [SI] at most, which is no measurement: check its unit", channel.name, size));
}

bool accumulates(QuantityKind kind) {
  return kind == QuantityKind::count || kind == QuantityKind::angle || kind == QuantityKind::velocity;
}

/// The channel under test: by its role, else the one called like an instrument, else the only one that can be meant.
const Channel& output_of(const Evidence& evidence, const Recording& recording, const Channel* reference) {
  if (const Channel* named = channel_for(evidence, recording, "output")) return *named;
  if (!evidence.plan.channels.contains("output")) {
    std::vector<const Channel*> possible;
    for (const Channel& channel : recording.channels) {
      if (&channel == reference || channel.kind == QuantityKind::temperature || channel.kind == QuantityKind::time)
        continue;
      if (channel.name == "gyro" || channel.name == "accelerometer") return channel;
      possible.push_back(&channel);
    }
    if (possible.size() == 1) return *possible.front();
  }
  return require_channel(evidence, recording, "output");
}

Dimension per_second(Dimension d) {
  d.halves[Dimension::second] = static_cast<signed char>(d.halves[Dimension::second] - 2);
  return d;
}

Dimension quotient(Dimension a, const Dimension& b) {
  for (std::size_t i = 0; i < a.halves.size(); ++i) a.halves[i] = static_cast<signed char>(a.halves[i] - b.halves[i]);
  return a;
}

/// The even clock through the stamps: in the mean they are neither early nor late.
double start_of(const Channel& channel, double rate) {
  double sum = 0.0;
  for (std::size_t i = 0; i < channel.values.size(); ++i) sum += channel.time(i) - static_cast<double>(i) / rate;
  return sum / static_cast<double>(channel.values.size());
}

/// The rate of the clock: a pause of the recording does not change it, as it changes the mean rate.
Signal signal_of(const Channel& channel) {
  if (channel.timeline.uniform()) return {&channel, channel.timeline.rate, {}};
  Clock clock = clock_of(channel);
  const double rate = clock.rate > 0.0 ? clock.rate : mean_rate(channel);
  Signal signal{&channel, rate, std::move(clock.gaps)};
  if (clock.even && clock.duplicates == 0 && clock.worst * rate < most_off_clock)
    signal.start = start_of(channel, rate);
  return signal;
}

double window_of(const Settings& settings, const char* name, double rate, bool default_interval) {
  if (settings.has(name)) return settings.number(name);
  return default_interval ? 1.0 / rate : 0.0;
}

/// From the stamp to the instant of the sample.
double instant_of(const Settings& settings, double window, double rate) {
  if (window > 0.0) return 0.5 * window;
  return settings.word("stamps") == "begin" ? 0.5 / rate : 0.0;
}

/// Output for one unit of the reference, as set; it must have this dimension.
double scale_factor_of(const Settings& settings, const Dimension& dimension) {
  const std::string& text = settings.word("scale_factor");
  const Quantity scale = parse_quantity(text);
  if (!(scale.unit.dimension() == dimension))
    throw Error(Error::Kind::bad_input, say("scale_factor = \"{}\" is {}, but the output over the reference is {}",
                                            text, Name{name(scale.unit.dimension())}, Name{name(dimension)}));
  const double value = scale.unit.to_si(scale.value);
  if (!(std::abs(value) > 0.0) || !std::isfinite(value))
    throw Error(Error::Kind::bad_input, "scale_factor must be finite and not zero");
  return value;
}

Scaling scaling_of(const Settings& settings, const Signal& output, const Signal& reference, bool from_rig) {
  Scaling s;
  const QuantityKind output_kind = output.channel->kind, reference_kind = reference.channel->kind;
  Dimension out = output.channel->unit.dimension(), in = reference.channel->unit.dimension();
  const bool both_angles = output_kind == QuantityKind::angle && reference_kind == QuantityKind::angle;
  const bool increments = accumulates(output_kind) && !both_angles;
  if (increments) {
    s.output *= output.rate;
    out = per_second(out);
  }
  if (reference_kind == QuantityKind::angle && !both_angles) {
    s.differentiate = true;
    in = per_second(in);
  }
  if (settings.has("scale_factor"))
    s.output /= scale_factor_of(settings, quotient(out, in));
  else
    s.relative = !(out == in);
  s.output_window = window_of(settings, "averaging", output.rate, increments || from_rig);
  s.reference_window = window_of(settings, "reference_averaging", reference.rate, false);
  s.output_shift = instant_of(settings, s.output_window, output.rate) - settings.number("clock_offset");
  s.reference_shift = from_rig ? 0.0 : instant_of(settings, s.reference_window, reference.rate);
  return s;
}

std::optional<Motion> oscillation(const Segment* segment) {
  if (segment != nullptr)
    for (const auto& [axis, motion] : segment->axes)
      if (motion.kind == Motion::Kind::sine || motion.kind == Motion::Kind::sweep) return motion;
  return {};
}

/// The stamps half a step later: from the beginning of the average to its middle.
void to_the_middle(double step, Timeline& timeline) {
  if (timeline.uniform()) {
    timeline.start += 0.5 * step;
    return;
  }
  auto stamps = *timeline.stamps;
  for (double& t : stamps) t += 0.5 * step;
  timeline.stamps = std::make_shared<const std::vector<double>>(std::move(stamps));
}

/// A part of a recording during which the plan's rig moves: from `begin` to `end` [s, recording's clock], `since` [s]
/// after power-on by the plan.
struct Moved {
  double begin, end, since;
};

/// How long the motion of a segment is known: as long as it was carried out, and as the plan has it.
double end_of_motion(const MarkedSegment& marked) {
  return marked.planned == nullptr ? marked.end : std::min(marked.end, marked.begin + marked.planned->duration);
}

/// Each segment of a run from its mark on: one that took longer than planned delays those that follow.
std::vector<Moved> moved_in(const Plan& plan, const PowerUp& power_up, const Run& run, double begin,
                            const std::vector<MarkedSegment>& marks) {
  std::vector<Moved> out;
  for (const auto& marked : marks) {
    if (marked.run != run.number || marked.planned == nullptr) continue;
    const auto before = static_cast<std::size_t>(
        std::count_if(plan.schedule.begin(), plan.schedule.begin() + static_cast<std::ptrdiff_t>(marked.index),
                      [&](const Segment& segment) { return segment.run == run.number; }));
    if (before < power_up.begins.size()) out.push_back({marked.begin, end_of_motion(marked), power_up.begins[before]});
  }
  if (out.empty()) out.push_back({begin, run.end, 0.0});
  return out;
}

/// Motion along the input axis by the plan's rig, in the middle of every sample of the output. NaN where it is not
/// known.
Channel reference_from_rig(const Evidence& evidence, const Recording& recording,
                           const std::vector<MarkedSegment>& marks, const Signal& signal, const PlanError* error) {
  const Channel& output = *signal.channel;
  const bool rate = output.kind == QuantityKind::angular_rate || output.kind == QuantityKind::angle;
  if (!rate && output.kind != QuantityKind::specific_force && output.kind != QuantityKind::velocity)
    throw Error(
        Error::Kind::bad_data,
        say("no reference is recorded, and the unit {} does not determine whether '{}' is a rate or a force: record "
            "a reference channel",
            Name{output.unit.text()}, output.name));
  Channel made{"reference",
               rate ? QuantityKind::angular_rate : QuantityKind::specific_force,
               Unit::parse(rate ? "deg/s" : "m/s^2"),
               output.timeline,
               {}};
  made.values.assign(output.values.size(), std::nan(""));
  const double step = 1.0 / signal.rate;
  const auto power_ups = power_ups_of(evidence.plan, 1.0 / step);
  for (const Run& run : runs_of({recording})) {
    const auto power_up =
        std::ranges::find_if(power_ups, [&](const PowerUp& p) { return p.rig.segments.front().run == run.number; });
    if (power_up == power_ups.end()) continue;
    const Reference motion =
        error == nullptr ? power_up->reference : reference_with(*power_up, *error, [](std::size_t) { return true; });
    const double begin = std::isfinite(run.begin) ? run.begin : output.time(0);
    for (const Moved& moved : moved_in(evidence.plan, *power_up, run, begin, marks)) {
      const SampleRange range = samples_between(output, moved.begin, moved.end - 0.5 * step);
      Felt felt;
      for (std::size_t i = range.begin; i < range.end; ++i) {
        motion.felt(moved.since + output.time(i) - moved.begin + 0.5 * step, step, std::span(&felt, 1));
        made.values[i] = rate ? felt.rate.x : felt.specific_force.x;
      }
    }
  }
  to_the_middle(step, made.timeline);
  return made;
}

void add_parts(const std::vector<MarkedSegment>& marks, const Recording& recording, const Signal& output,
               const Signal& reference, Data& data) {
  constexpr double forever = std::numeric_limits<double>::infinity();
  if (marks.empty()) data.parts.push_back({recording.origin.file, output, reference, -forever, forever, {}});
  for (const auto& marked : marks) {
    const auto motion = oscillation(marked.planned);
    if (marked.planned != nullptr && !motion) continue;  // the plan has no oscillation here
    const double end = data.from_rig ? end_of_motion(marked) - 0.5 / output.rate : marked.end;
    data.parts.push_back({marked.label, output, reference, marked.begin, end, motion});
  }
}

/// Recorded, else by the plan's rig.
const Channel& reference_of(const Evidence& evidence, const Recording& recording,
                            const std::vector<MarkedSegment>& marks, const Channel* recorded, const Signal& output,
                            const PlanError* error, Data& data) {
  if (recorded != nullptr) return *recorded;
  if (evidence.plan.rig_kind.empty() || evidence.plan.schedule.empty())
    throw Error(Error::Kind::bad_data,
                "there is no channel 'reference' to compare the output with: record one (and name it with "
                "[channels] reference = \"...\"), or give a plan whose [rig] and [[schedule]] describe the motion");
  data.from_rig = true;
  return data.made.emplace_back(reference_from_rig(evidence, recording, marks, output, error));
}

void add_recording(const Evidence& evidence, const Recording& recording, const std::vector<MarkedSegment>& marks,
                   const PlanError* error, Data& data) {
  const bool first = data.output_name.empty();
  const Channel* recorded = channel_for(evidence, recording, "reference");
  const Channel& output = output_of(evidence, recording, recorded);
  if (output.values.size() < fewest_of_recording)
    throw Error(Error::Kind::bad_data,
                say("'{}' has {} samples: too few for a frequency response", output.name, output.values.size()));
  const Signal of_output = signal_of(output);
  const Channel& reference = reference_of(evidence, recording, marks, recorded, of_output, error, data);
  const Signal of_reference = signal_of(reference);
  require_finite(output);
  require_finite(reference);
  const Scaling scaling = scaling_of(evidence.plan.settings, of_output, of_reference, data.from_rig);
  if (first) {
    data.scaling = scaling;
    data.output_name = output.name;
    data.reference_unit = reference.unit;
    data.output_unit = output.unit;
    if (scaling.relative) data.findings.push_back({Finding::Severity::info, "gains_relative", {}, output.name});
  } else if (!(output.unit.dimension() == data.output_unit.dimension())) {
    throw Error(Error::Kind::bad_data,
                say("the recordings hold different kinds of output: '{}' in {} and '{}' in {}", data.output_name,
                    Name{data.output_unit.text()}, output.name, Name{output.unit.text()}));
  }
  add_parts(marks, recording, of_output, of_reference, data);
}

}  // namespace

std::vector<PlanError> errors_of_rig(const Evidence& evidence) {
  if (evidence.plan.rig_kind.empty() || evidence.plan.schedule.empty()) return {};
  return rig_errors({power_ups_of(evidence.plan, 1.0)});
}

Data data_of(const Evidence& evidence, const PlanError* error) {
  if (evidence.recordings.empty())
    throw Error(Error::Kind::bad_data, "frequency_response needs at least one recording");
  Data data;
  const auto marks = marked_segments(evidence);
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r)
    add_recording(evidence, evidence.recordings[r], marks[r], error, data);
  return data;
}

Samples samples_of(const Signal& signal, double begin, double end, double shift) {
  Samples s;
  s.rate = signal.rate;
  const Channel& channel = *signal.channel;
  const SampleRange range = samples_between(channel, begin, end);
  auto gap = std::ranges::lower_bound(signal.gaps, range.begin, {}, &Clock::Gap::after);
  for (std::size_t i = range.begin; i < range.end; ++i) {
    s.time.push_back(signal.time(i) + shift);
    s.value.push_back(channel.values[i]);
    if (gap == signal.gaps.end() || gap->after != i || i + 1 == range.end) continue;
    for (std::size_t k = 1; k <= gap->lost; ++k) {
      s.time.push_back(signal.time(i) + shift + static_cast<double>(k) / signal.rate);
      s.value.push_back(std::nan(""));
    }
    ++gap;
  }
  s.missing = static_cast<std::size_t>(std::ranges::count_if(s.value, [](double v) { return std::isnan(v); }));
  return s;
}

}  // namespace tumble::frequency_response
