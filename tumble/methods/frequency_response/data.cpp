#include "tumble/methods/frequency_response/data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "tumble/units/error.hpp"

namespace tumble::frequency_response {
namespace {

void require_finite(const Channel& channel) {
  for (std::size_t i = 0; i < channel.values.size(); ++i)
    if (std::isinf(channel.values[i]))
      throw Error(Error::Kind::bad_data, fmt::format("'{}' is infinite at {:.6g} s", channel.name, channel.time(i)));
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

double window_of(const Settings& settings, const char* name, const Channel& channel, bool default_interval) {
  if (settings.has(name)) return settings.number(name);
  return default_interval ? 1.0 / mean_rate(channel) : 0.0;
}

/// From the stamp to the instant that a sample stands for.
double instant_of(const Settings& settings, double window, const Channel& channel) {
  if (window > 0.0) return 0.5 * window;
  return settings.word("stamps") == "begin" ? 0.5 / mean_rate(channel) : 0.0;
}

Scaling scaling_of(const Settings& settings, const Channel& output, const Channel& reference, bool from_rig,
                   Findings& findings) {
  Scaling s;
  Dimension out = output.unit.dimension(), in = reference.unit.dimension();
  const bool both_angles = output.kind == QuantityKind::angle && reference.kind == QuantityKind::angle;
  const bool increments = accumulates(output.kind) && !both_angles;
  if (increments) {
    s.output *= mean_rate(output);
    out = per_second(out);
  }
  if (reference.kind == QuantityKind::angle && !both_angles) {
    s.differentiate = true;
    in = per_second(in);
  }
  if (settings.has("scale_factor")) {
    const Quantity scale = parse_quantity(settings.word("scale_factor"));
    if (!(scale.unit.dimension() == quotient(out, in)))
      throw Error(Error::Kind::bad_input,
                  fmt::format("scale_factor = \"{}\" is {}, but the output over the reference is {}",
                              settings.word("scale_factor"), name(scale.unit.dimension()), name(quotient(out, in))));
    const double value = scale.unit.to_si(scale.value);
    if (!(std::abs(value) > 0.0) || !std::isfinite(value))
      throw Error(Error::Kind::bad_input, "scale_factor must not be zero");
    s.output /= value;
  } else if (!(out == in)) {
    s.relative = true;
    findings.push_back({Finding::Severity::info,
                        "the output and the reference are of unlike kinds and no scale_factor is set: gains are "
                        "relative to the one at the lowest frequency",
                        output.name});
  }
  s.output_window = window_of(settings, "averaging", output, increments || from_rig);
  s.reference_window = window_of(settings, "reference_averaging", reference, false);
  s.output_shift = instant_of(settings, s.output_window, output) - settings.number("clock_offset");
  s.reference_shift = from_rig ? 0.0 : instant_of(settings, s.reference_window, reference);
  return s;
}

std::optional<Motion> oscillation(const Segment* segment) {
  if (segment != nullptr)
    for (const auto& [axis, motion] : segment->axes)
      if (motion.kind == Motion::Kind::sine || motion.kind == Motion::Kind::sweep) return motion;
  return {};
}

/// The stamps half a step later: from the beginning of what is averaged to its middle.
void to_the_middle(double step, Timeline& timeline) {
  if (timeline.uniform()) {
    timeline.start += 0.5 * step;
    return;
  }
  auto stamps = *timeline.stamps;
  for (double& t : stamps) t += 0.5 * step;
  timeline.stamps = std::make_shared<const std::vector<double>>(std::move(stamps));
}

/// What the plan's rig made the input axis feel, at the middle of every sample of the output.
Channel reference_from_rig(const Evidence& evidence, const Recording& recording, const Channel& output,
                           const PlanError* error) {
  const bool rate = output.kind == QuantityKind::angular_rate || output.kind == QuantityKind::angle;
  if (!rate && output.kind != QuantityKind::specific_force && output.kind != QuantityKind::velocity)
    throw Error(
        Error::Kind::bad_data,
        fmt::format("no reference is recorded, and {} does not say whether '{}' shows a rate or a force: record "
                    "a reference channel",
                    output.unit.text(), output.name));
  Channel made{"reference",
               rate ? QuantityKind::angular_rate : QuantityKind::specific_force,
               Unit::parse(rate ? "deg/s" : "m/s^2"),
               output.timeline,
               {}};
  made.values.assign(output.values.size(), std::nan(""));
  const double step = 1.0 / mean_rate(output);
  const auto power_ups = power_ups_of(evidence.plan, 1.0 / step);
  for (const Run& run : runs_of({recording})) {
    const auto power_up =
        std::ranges::find_if(power_ups, [&](const PowerUp& one) { return one.rig.segments.front().run == run.number; });
    if (power_up == power_ups.end()) continue;
    const Reference told =
        error == nullptr ? power_up->reference : reference_with(*power_up, *error, [](std::size_t) { return true; });
    const double begin = std::isfinite(run.begin) ? run.begin : output.time(0);
    const SampleRange range = samples_between(output, begin, run.end);
    Felt felt;
    for (std::size_t i = range.begin; i < range.end; ++i) {
      told.felt(output.time(i) - begin + 0.5 * step, step, std::span(&felt, 1));
      made.values[i] = rate ? felt.rate.x : felt.specific_force.x;
    }
  }
  to_the_middle(step, made.timeline);
  return made;
}

void add_parts(const std::vector<MarkedSegment>& marks, const Recording& recording, const Channel& output,
               const Channel& reference, Data& data) {
  constexpr double forever = std::numeric_limits<double>::infinity();
  if (marks.empty()) data.parts.push_back({recording.origin.file, &output, &reference, -forever, forever, {}});
  for (const auto& marked : marks) {
    const auto motion = oscillation(marked.planned);
    if (marked.planned != nullptr && !motion) continue;  // the plan says that nothing oscillates here
    data.parts.push_back({marked.label, &output, &reference, marked.begin, marked.end, motion});
  }
}

}  // namespace

std::vector<PlanError> errors_of_rig(const Evidence& evidence) {
  if (evidence.plan.rig_kind.empty() || evidence.plan.schedule.empty()) return {};
  return rig_errors({power_ups_of(evidence.plan, 1.0)});
}

Data data_of(const Evidence& evidence, const PlanError* error) {
  Data data;
  if (evidence.recordings.empty())
    throw Error(Error::Kind::bad_data, "frequency_response needs at least one recording");
  const auto marks = marked_segments(evidence);
  bool first = true;
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    const Recording& recording = evidence.recordings[r];
    const Channel* reference = channel_for(evidence, recording, "reference");
    const Channel& output = output_of(evidence, recording, reference);
    if (output.values.size() < 16)
      throw Error(Error::Kind::bad_data, fmt::format("'{}' has {} samples: too few for a frequency response",
                                                     output.name, output.values.size()));
    if (reference == nullptr) {
      if (evidence.plan.rig_kind.empty() || evidence.plan.schedule.empty())
        throw Error(Error::Kind::bad_data,
                    "there is no channel 'reference' to hold the output against: record one (and name it with "
                    "[channels] reference = \"...\"), or give a plan whose [rig] and [[schedule]] say how it moved");
      data.made.push_back(reference_from_rig(evidence, recording, output, error));
      reference = &data.made.back();
      data.from_rig = true;
    }
    require_finite(output);
    require_finite(*reference);
    Findings unused;
    const Scaling scaling =
        scaling_of(evidence.plan.settings, output, *reference, data.from_rig, first ? data.findings : unused);
    if (first) {
      data.scaling = scaling;
      data.output_name = output.name;
      data.reference_unit = reference->unit;
      data.output_unit = output.unit;
    } else if (!(output.unit.dimension() == data.output_unit.dimension())) {
      throw Error(Error::Kind::bad_data,
                  fmt::format("the recordings hold unlike outputs: '{}' in {} and '{}' in {}", data.output_name,
                              data.output_unit.text(), output.name, output.unit.text()));
    }
    first = false;
    add_parts(marks[r], recording, output, *reference, data);
  }
  return data;
}

Samples samples_of(const Channel& channel, double begin, double end, double shift) {
  Samples s;
  s.rate = mean_rate(channel);
  const SampleRange range = samples_between(channel, begin, end);
  for (std::size_t i = range.begin; i < range.end; ++i) {
    s.time.push_back(channel.time(i) + shift);
    s.value.push_back(channel.values[i]);
    s.missing += std::isnan(channel.values[i]) ? 1 : 0;
  }
  return s;
}

}  // namespace tumble::frequency_response
