#include "tumble/sim/power_up.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

/// Phases that one turn has: of gravity and of errors twice a turn, which must be small to the micro-g, and of the
/// ripple of the drive, which is small itself.
double harmonics_of(const Settings& rig) {
  constexpr double of_gravity = 3.0;
  const bool ripple = rig.has("rate_ripple_sd") && rig.number("rate_ripple_sd") > 0.0 && !rig.flag("ideal");
  return ripple ? std::max<double>(of_gravity, rig.integer("ripple_order")) : of_gravity;
}

/// How fast the phase of a motion goes on [rad/s]. Random motion is resolved by its steps: it needs two in the period
/// of its highest frequency.
double phase_rate(const Motion& motion, double harmonics) {
  using Kind = Motion::Kind;
  switch (motion.kind) {
    case Kind::rate:
      return harmonics * std::abs(motion.value);
    case Kind::sine:
      return two_pi * motion.frequency;
    case Kind::sweep:
      return two_pi * std::max(motion.frequency, motion.to_frequency);
    case Kind::random:
      return motion.psd_frequency.empty() ? 0.0 : 2.0 * motion.psd_frequency.back();
    default:
      return 0.0;
  }
}

}  // namespace

int oversampling_of(const Plan& plan) {
  if (const int stated = plan.truth.integer("oversampling"); stated > 0) return stated;
  const double harmonics = harmonics_of(plan.rig);
  double fastest = 0.0;
  for (const auto& segment : plan.schedule)
    for (const auto& [axis, motion] : segment.axes) fastest = std::max(fastest, phase_rate(motion, harmonics));
  return static_cast<int>(std::clamp(std::ceil(fastest / plan.sample_rate), 1.0, double{most_oversampling}));
}

std::vector<Participant> participants_of(const Plan& plan) {
  std::vector<Participant> all{{"", find_model(plan.instrument_model), plan.truth, {}}};
  for (const auto& one : plan.beside)
    all.push_back({one.name + ".", find_model(one.model), one.truth,
                   about_x(one.mount_roll) * about_y(one.mount_pitch) * about_z(one.mount_yaw)});
  return all;
}

std::vector<PlannedRun> power_ups(const Schedule& schedule, double sample_rate) {
  std::vector<PlannedRun> out;
  double now = 0.0;
  for (const auto& segment : schedule) {
    if (out.empty() || out.back().run != segment.run) out.push_back({segment.run, now, 0, {}});
    out.back().segments.push_back(segment);
    now += segment.duration;
    out.back().samples = static_cast<std::size_t>(std::llround((now - out.back().begin) * sample_rate));
  }
  return out;
}

Segment with_what_stands(const Schedule& schedule, std::size_t index) {
  Segment whole = schedule[index];
  for (std::size_t before = index; before-- > 0 && schedule[before].run == whole.run;)
    for (const auto& [axis, motion] : schedule[before].axes) {
      using Kind = Motion::Kind;
      const bool stays = motion.kind == Kind::hold || motion.kind == Kind::dwell;
      const bool goes = motion.kind == Kind::slew || motion.kind == Kind::ramp;
      if (stays || goes) whole.axes.try_emplace(axis, Motion{.value = stays ? motion.value : motion.to});
    }
  return whole;
}

Segment standing_alone(const Schedule& schedule, std::size_t index) {
  Segment alone = with_what_stands(schedule, index);
  // what goes somewhere was there from the first sample on, as far as the recording is concerned
  for (auto& [axis, motion] : alone.axes)
    if (motion.kind == Motion::Kind::slew) motion = {.value = motion.to};
  return alone;
}

bool recorded_one_by_one(const Plan& plan) {
  return std::ranges::all_of(plan.schedule, [&](const Segment& segment) {
    return std::ranges::any_of(plan.recordings, [&](const RecordingEntry& entry) {
      return !entry.plan && entry.segment == segment.label && (entry.run == 0 || entry.run == segment.run);
    });
  });
}

Matrix drawn_errors(const std::vector<RigError>& errors, std::size_t segments, const RandomStream& test,
                    const RandomStream& run) {
  if (errors.empty()) return {};
  Matrix drawn(errors.size(), segments);
  for (std::size_t e = 0; e < errors.size(); ++e) {
    const RandomStream whole = test.split(errors[e].name), each = run.split(errors[e].name);
    for (std::size_t s = 0; s < segments; ++s)
      drawn(e, s) = errors[e].sd * (errors[e].each_segment ? each.normal(s) : whole.normal(0));
  }
  return drawn;
}

Reference reference_of(const Plan& plan, const PlannedRun& run, const RandomStream& random) {
  const Rig& rig = find_rig(plan.rig_kind);
  const RandomStream own = random.split("run").split(static_cast<std::uint64_t>(run.run)).split("rig");
  Matrix errors = drawn_errors(rig.errors(plan.rig, plan.site), run.segments.size(), random.split("rig errors"),
                               own.split("errors"));
  return rig.reference(
      {run.segments, plan.rig, plan.site, plan.sample_rate * oversampling_of(plan), std::move(errors), own});
}

std::vector<Source> sensors_of(const Plan& plan, const Reference& reference, const PlannedRun& run) {
  constexpr std::size_t portion = 8192;
  const double step = 1.0 / plan.sample_rate;
  std::vector<Source> sources;
  for (const auto& sensor : reference.sensors) {
    Channel channel = sensor.channel;
    channel.timeline = {run.begin, plan.sample_rate, nullptr};
    sources.emplace_back(std::vector{std::move(channel)}, run.samples, portion,
                         [read = sensor.read, step](std::size_t first, const Samples& out) {
                           read((static_cast<double>(first) + 0.5) * step, step, out.front());
                         });
  }
  return sources;
}

}  // namespace tumble
