#include "tumble/methods/frequency_response/data.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

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

/// The part of the plan's schedule that a mark stands for.
const Segment* segment_of(const Plan& plan, const Mark& mark) {
  for (const Segment& segment : plan.schedule)
    if (segment.run == mark.run && segment.label == mark.label) return &segment;
  return nullptr;
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
                           const RigShift* shift) {
  const Plan& plan = evidence.plan;
  const Rig& rig = find_rig(plan.rig_kind);
  const auto errors = rig.errors ? rig.errors(plan.rig) : std::vector<RigError>{};
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
  for (const Run& run : runs_of({recording})) {
    RigRun todo{{}, plan.rig, plan.site, 1.0 / step, {}, RandomStream{0}};
    for (const Segment& segment : plan.schedule)
      if (segment.run == run.number) todo.segments.push_back(segment);
    if (todo.segments.empty()) continue;
    todo.errors = Matrix(errors.size(), todo.segments.size());
    if (shift != nullptr)
      for (std::size_t c = 0; c < todo.segments.size(); ++c) todo.errors(shift->error, c) = errors[shift->error].sd;
    const Reference told = rig.reference(todo);
    const double begin = std::isfinite(run.begin) ? run.begin : output.time(0);
    std::vector<Felt> felt(1);
    for (std::size_t i = index_at(output, begin); i < output.values.size() && output.time(i) < run.end; ++i) {
      told.felt(output.time(i) - begin + 0.5 * step, step, felt);
      made.values[i] = rate ? felt[0].rate.x : felt[0].specific_force.x;
    }
  }
  to_the_middle(step, made.timeline);
  return made;
}

void add_stretches(const Evidence& evidence, const Recording& recording, const Channel& output,
                   const Channel& reference, Data& data) {
  constexpr double forever = std::numeric_limits<double>::infinity();
  if (recording.marks.empty()) {
    data.stretches.push_back({recording.origin.file, &output, &reference, -forever, forever, {}});
    return;
  }
  for (std::size_t m = 0; m < recording.marks.size(); ++m) {
    const Mark& mark = recording.marks[m];
    const double end = m + 1 < recording.marks.size() ? recording.marks[m + 1].begin : forever;
    const Segment* segment = segment_of(evidence.plan, mark);
    const auto motion = oscillation(segment);
    if (segment != nullptr && !motion) continue;  // the plan says that nothing oscillates here
    data.stretches.push_back({mark.label, &output, &reference, mark.begin, end, motion});
  }
}

}  // namespace

std::vector<std::pair<std::size_t, RigError>> rig_errors(const Evidence& evidence) {
  std::vector<std::pair<std::size_t, RigError>> found;
  if (evidence.plan.rig_kind.empty()) return found;
  const Rig& rig = find_rig(evidence.plan.rig_kind);
  const auto all = rig.errors ? rig.errors(evidence.plan.rig) : std::vector<RigError>{};
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].sd > 0.0) found.emplace_back(i, all[i]);
  return found;
}

Data data_of(const Evidence& evidence, const RigShift* shift) {
  Data data;
  if (evidence.recordings.empty())
    throw Error(Error::Kind::bad_data, "frequency_response needs at least one recording");
  bool first = true;
  for (const Recording& recording : evidence.recordings) {
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
      data.made.push_back(reference_from_rig(evidence, recording, output, shift));
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
    add_stretches(evidence, recording, output, *reference, data);
  }
  return data;
}

Samples samples_of(const Channel& channel, double begin, double end, double shift) {
  Samples s;
  s.rate = mean_rate(channel);
  for (std::size_t i = std::isfinite(begin) ? index_at(channel, begin) : 0; i < channel.values.size(); ++i) {
    const double t = channel.time(i);
    if (t >= end) break;
    s.time.push_back(t + shift);
    s.value.push_back(channel.values[i]);
    s.missing += std::isnan(channel.values[i]) ? 1 : 0;
  }
  return s;
}

}  // namespace tumble::frequency_response
