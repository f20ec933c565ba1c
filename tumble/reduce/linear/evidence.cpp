#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <span>

#include "tumble/core/clock.hpp"
#include "tumble/core/say.hpp"
#include "tumble/reduce/linear/rows.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/units/error.hpp"

namespace tumble::linear {
namespace {

void require(const Plan& plan, double rate, const Problem& problem, std::vector<std::string>& problems) {
  const std::string where = plan.file.empty() ? "" : plan.file + ": ";
  if (plan.rig_kind.empty()) problems.push_back(where + "the plan needs [rig] kind = \"...\" that says what was felt");
  if (plan.schedule.empty()) problems.push_back(where + "the plan needs at least one [[schedule]]");
  if (problem.needs_site && !plan.site)
    problems.push_back(
        where +
        "the plan needs [site] latitude = \"34.25 deg\" or the like: the Earth's rate and gravity are part "
        "of what the instrument feels");
  if (!(rate > 0.0)) problems.push_back(where + "the plan needs [instrument] rate = \"1 Hz\" or the like");
}

PowerUp power_up_of(const Plan& plan, std::size_t number, Schedule segments, double rate, const Problem& problem) {
  PowerUp one;
  one.plan = &plan;
  one.plan_number = number;
  one.step = 1.0 / (rate * problem.oversampling);
  one.begins = {0.0};
  for (const auto& segment : segments) one.begins.push_back(one.begins.back() + segment.duration);
  one.rig = {std::move(segments), plan.rig, plan.site, 1.0 / one.step, {}, RandomStream(0)};
  one.reference = find_rig(plan.rig_kind).reference(one.rig);
  return one;
}

/// The power-ups of a plan, as its schedule says; returns the index of the first.
std::size_t add_power_ups(const Plan& plan, std::size_t number, double rate, const Problem& problem, Evidences& out) {
  const std::size_t first = out.power_ups.size();
  for (auto& run : sim::power_ups(plan.schedule, rate))
    out.power_ups.push_back(power_up_of(plan, number, std::move(run.segments), rate, problem));
  return first;
}

/// The segments of a plan each by itself, where it was recorded in a file of its own; returns the index of the first.
std::size_t add_segments(const Plan& plan, std::size_t number, double rate, const Problem& problem, Evidences& out) {
  const std::size_t first = out.power_ups.size();
  double begin = 0.0;
  for (std::size_t s = 0; s < plan.schedule.size(); ++s) {
    if (s > 0 && plan.schedule[s].run != plan.schedule[s - 1].run) begin = 0.0;
    out.power_ups.push_back(power_up_of(plan, number, {sim::standing_alone(plan.schedule, s)}, rate, problem));
    out.power_ups.back().offset = begin;
    begin += plan.schedule[s].duration;
  }
  return first;
}

/// Greatest frequency [Hz] at which what is felt repeats: oscillations, and turns of the axes in gravity.
double quickest(const Segment& segment) {
  double quickest = 0.0;
  for (const auto& [name, motion] : segment.axes) {
    quickest = std::max({quickest, motion.frequency, motion.to_frequency});
    if (motion.kind == Motion::Kind::rate || motion.kind == Motion::Kind::slew)
      quickest = std::max(quickest, std::abs(motion.value) / (2.0 * M_PI));
    for (const double f : motion.psd_frequency) quickest = std::max(quickest, f);
  }
  return quickest;
}

/// Whether the segment is one that Problem::whole_moves speaks of, by the kind of motion.
bool moves(const Segment& segment, Motion::Kind kind) {
  return std::ranges::any_of(segment.axes,
                             [&](const auto& axis) { return axis.second.kind == kind && axis.second.value != 0.0; });
}

bool used_whole(const Problem& problem, const Segment& segment) {
  return problem.whole_moves && moves(segment, Motion::Kind::slew);
}

/// From when the segment's samples are used.
double use_from(const PowerUp& power_up, std::size_t segment, const Problem& problem) {
  const auto& settled = power_up.reference.settled;
  const double begin = power_up.begins[segment];
  if (used_whole(problem, power_up.rig.segments[segment])) return begin;
  return (segment < settled.size() ? std::max(begin, settled[segment]) : begin) + problem.settling;
}

/// So many blocks of a steady stretch are needed at least to show its noise, and are enough to tell white noise from
/// the rounding to whole pulses.
constexpr std::size_t least_blocks = 4, counted_blocks = 32;

/// Whether what is felt stays within 1e-4 of its mean while the rig turns: on the arm of a centrifuge.
bool hardly_changes(const PowerUp& power_up, const Stretch& stretch) {
  constexpr std::size_t instants = 16;
  constexpr double golden = 0.6180339887498949;
  const double length = static_cast<double>(stretch.samples) * stretch.step;
  Felt first;
  for (std::size_t k = 0; k < instants; ++k) {
    Felt felt;
    const double share = std::fmod(golden * static_cast<double>(k) + 0.5, 1.0);
    power_up.reference.felt(stretch.first + share * length, stretch.step, std::span(&felt, 1));
    if (k == 0) first = felt;
    if (norm(felt.specific_force - first.specific_force) > 1e-4 * norm(first.specific_force) ||
        norm(felt.rate - first.rate) > 1e-4 * norm(first.rate))
      return false;
  }
  return true;
}

/// Whether the rig stands still or turns evenly over these samples, and how many samples make a block.
void set_blocks(const PowerUp& power_up, const Problem& problem, Stretch& stretch) {
  const double from = stretch.first + 0.5 * power_up.step;
  const double last = stretch.first + (static_cast<double>(stretch.samples) - 0.5) * stretch.step;
  const auto& until = power_up.reference.steady_until;
  stretch.steady = !until || until(from) >= last;
  stretch.even = (problem.even_averages || problem.pulse > 0.0) && !stretch.steady && hardly_changes(power_up, stretch);
  double length = problem.averaging;
  if (!stretch.steady && !stretch.even)
    if (const double f = quickest(power_up.rig.segments[stretch.segment]); f > 0.0) length = std::min(length, 0.1 / f);
  const auto wanted = std::max<std::size_t>(1, static_cast<std::size_t>(std::llround(length / stretch.step)));
  std::size_t blocks = std::max<std::size_t>(1, stretch.samples / wanted);
  if (problem.pulse > 0.0 && (stretch.steady || stretch.even)) blocks = std::min(blocks, counted_blocks);
  if (stretch.steady) blocks = std::max(blocks, std::min(least_blocks, stretch.samples));
  stretch.per_block = (stretch.samples + blocks - 1) / blocks;
}

/// Where the rate is kept, as many whole turns as the samples hold.
void trim_to_turns(const Segment& segment, Stretch& stretch) {
  double turn = 0.0;
  for (const auto& [name, motion] : segment.axes)
    if (motion.kind == Motion::Kind::rate && motion.value != 0.0)
      turn = std::max(turn, 2.0 * M_PI / std::abs(motion.value));
  const double turns = std::floor(static_cast<double>(stretch.samples) * stretch.step / turn + 1e-9);
  const auto samples = static_cast<std::size_t>(std::llround(turns * turn / stretch.step));
  stretch.samples = std::min(stretch.samples, samples);
  if (!stretch.values.empty()) stretch.values.resize(stretch.samples);
}

/// Makes one block of a move that is used whole; says why it cannot be.
std::string make_whole(const PowerUp& power_up, const Problem& problem, Stretch& stretch) {
  const Segment& segment = power_up.rig.segments[stretch.segment];
  const bool slew = used_whole(problem, segment);
  if (!slew && !(problem.whole_moves && moves(segment, Motion::Kind::rate))) return "";
  if (!slew) trim_to_turns(segment, stretch);
  if (stretch.samples == 0) return "it holds less than one turn";
  const double end = stretch.first + static_cast<double>(stretch.samples) * stretch.step;
  const auto rests_at = [&](double time) {
    const auto& until = power_up.reference.steady_until;
    return time <= 0.0 || !until || until(time) > time;
  };
  const double slack = 1e-6 * stretch.step;
  if (slew && (!rests_at(stretch.first - slack) || power_up.reference.settled[stretch.segment] > end + slack))
    return "its move does not go from rest to rest, so that its total says nothing of an angle";
  if (std::ranges::any_of(stretch.values, [](double v) { return std::isnan(v); }))
    return "samples are missing in its move, so that the total is not known";
  stretch.whole = instants_of(power_up.reference, stretch.first, end, quickest(segment));
  stretch.steady = stretch.even = false;
  stretch.per_block = stretch.samples;
  return "";
}

Finding unused(const std::string& label, int run, const std::string& why) {
  return {Finding::Severity::warning, fmt::format("segment '{}' is not used: {}", label, why),
          fmt::format("run {}", run)};
}

void add_stretch(const PowerUp& power_up, const Problem& problem, Stretch stretch, Evidences& out) {
  set_blocks(power_up, problem, stretch);
  const auto why = make_whole(power_up, problem, stretch);
  if (why.empty())
    out.stretches.push_back(std::move(stretch));
  else
    out.findings.push_back(unused(stretch.label, stretch.run, why));
}

/// Whether a problem that uses rests alone passes over the segment.
bool passed_over(const Problem& problem, const Segment& segment) {
  if (!problem.rests_only) return false;
  return std::ranges::any_of(segment.axes, [](const auto& axis) {
    return axis.second.kind != Motion::Kind::hold && axis.second.kind != Motion::Kind::dwell;
  });
}

/// Where each mark of a recording stands in the schedule of its plan: power-up and segment. A label that occurs several
/// times in a power-up is taken in order.
struct Place {
  std::size_t power_up = 0, segment = 0;
  bool found = false;
};

Place place_of(const Evidences& out, std::size_t first, const Mark& mark,
               std::set<std::pair<std::size_t, std::size_t>>& taken) {
  Place elsewhere;
  for (std::size_t u = first; u < out.power_ups.size(); ++u) {
    const auto& segments = out.power_ups[u].rig.segments;
    for (std::size_t s = 0; s < segments.size(); ++s) {
      if (segments[s].label != mark.label || taken.contains({u, s})) continue;
      if (segments[s].run == mark.run) {
        taken.insert({u, s});
        return {u, s, true};
      }
      if (!elsewhere.found) elsewhere = {u, s, true};
    }
  }
  return elsewhere;  // a repetition of a power-up that the schedule states once
}

/// How the samples of a channel lie on its clock.
struct Sampling {
  double rate = 0.0;
  double first = 0.0;
};

Sampling sampling_of(const Channel& channel) {
  if (channel.values.empty()) return {};
  return {channel.timeline.uniform() ? channel.timeline.rate : clock_of(channel).rate, channel.time(0)};
}

/// Whether any sample was taken from `begin` to `end` [s, recording's clock].
bool has_samples(const Channel& channel, double begin, double end) {
  for (std::size_t i = index_at(channel, begin); i < channel.values.size() && channel.time(i) < end; ++i)
    if (!std::isnan(channel.values[i])) return true;
  return false;
}

/// `scale` is one for all recordings: a rate here and a current there would be taken for the same.
void refuse_unlike_units(const Evidence& evidence, const Problem& problem) {
  const Channel& first = require_channel(evidence, evidence.recordings.front(), problem.role);
  std::vector<std::string> problems;
  for (const auto& recording : evidence.recordings) {
    const Channel& channel = require_channel(evidence, recording, problem.role);
    if (channel.unit.dimension() == first.unit.dimension()) continue;
    problems.push_back(
        fmt::format("{}: channel '{}' is in {}, but in {} it is in {}: recordings of one fit must hold "
                    "the same quantity",
                    recording.origin.file, channel.name, channel.unit.text(), evidence.recordings.front().origin.file,
                    first.unit.text()));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

/// A unit that is dead, or not connected. A single position may well give the same count in every sample.
void refuse_constant(const Evidence& evidence, const Problem& problem) {
  double some = std::nan("");
  for (const auto& recording : evidence.recordings)
    for (const double v : require_channel(evidence, recording, problem.role).values) {
      if (std::isnan(v) || v == some) continue;
      if (!std::isnan(some)) return;
      some = v;
    }
  if (std::isnan(some)) return;
  const auto& first = evidence.recordings.front();
  throw Error(Error::Kind::bad_data, fmt::format("{}channel '{}' holds the same value throughout",
                                                 first.origin.file.empty() ? "" : first.origin.file + ": ",
                                                 require_channel(evidence, first, problem.role).name));
}

/// Whether a recording is the file of one segment, as [[recording]] says.
bool stands_alone(const Evidence& evidence, std::size_t recording) {
  const auto& entries = evidence.plan.recordings;
  return recording < entries.size() && !entries[recording].segment.empty();
}

/// The samples whose interval lies from `begin` to `end` [s, recording's clock], on an even grid.
void take_samples(const Channel& channel, double rate, double begin, double end, double scale, Stretch& stretch) {
  const double step = 1.0 / rate, slack = 1e-6 * step;
  std::size_t i = index_at(channel, begin - slack);
  stretch.step = step;
  stretch.samples = 0;
  if (i >= channel.values.size() || channel.time(i) + step > end + slack) return;
  const double first = channel.time(i);
  stretch.first = first;
  // index_at looks up stamps; the end of the last interval may stand for a sample that was not taken
  stretch.samples = static_cast<std::size_t>(
      std::floor((std::min(end, channel.time(channel.values.size() - 1) + step) - first + slack) * rate));
  stretch.values.assign(stretch.samples, std::numeric_limits<double>::quiet_NaN());
  for (const std::size_t origin = i; i < channel.values.size(); ++i) {
    const double position =
        channel.timeline.uniform() ? static_cast<double>(i - origin) : std::round((channel.time(i) - first) * rate);
    if (position >= static_cast<double>(stretch.samples)) break;
    if (position >= 0.0) stretch.values[static_cast<std::size_t>(position)] = scale * channel.values[i];
  }
}

}  // namespace

Evidences evidence_of(const Plan& plan, const Problem& problem) {
  std::vector<const Plan*> plans{&plan};
  for (const auto& entry : plan.recordings)
    if (entry.plan && std::ranges::find(plans, entry.plan.get()) == plans.end()) plans.push_back(entry.plan.get());
  std::vector<std::string> problems;
  for (const Plan* one : plans) require(*one, one->sample_rate, problem, problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  Evidences out;
  for (const Plan* one : plans) {
    const bool alone = sim::recorded_one_by_one(*one);
    const std::size_t begin = (alone ? add_segments : add_power_ups)(*one, out.plans++, one->sample_rate, problem, out);
    for (std::size_t u = begin; u < out.power_ups.size(); ++u) {
      const PowerUp& power_up = out.power_ups[u];
      for (std::size_t s = 0; s < power_up.rig.segments.size(); ++s) {
        const auto& segment = power_up.rig.segments[s];
        if (passed_over(problem, segment)) continue;
        Stretch stretch{.power_up = u, .segment = s, .label = segment.label, .run = segment.run};
        stretch.step = 1.0 / one->sample_rate;
        const double from = std::ceil(use_from(power_up, s, problem) / stretch.step - 1e-6) * stretch.step;
        const double length = power_up.begins[s + 1] - from + 1e-6 * stretch.step;
        stretch.first = from;
        stretch.samples = length > 0.0 ? static_cast<std::size_t>(length / stretch.step) : 0;
        if (stretch.samples == 0) {
          out.findings.push_back(unused(segment.label, segment.run, "no sample is left after settling"));
          continue;
        }
        add_stretch(power_up, problem, std::move(stretch), out);
      }
    }
  }
  if (out.stretches.empty()) throw Error(Error::Kind::bad_input, "no segment has samples left after settling");
  return out;
}

namespace {

/// The channel of one recording cut at its marks.
void add_recording(const Evidence& evidence, std::size_t r, std::size_t first_power_up, const Channel& channel,
                   const Problem& problem, std::set<std::pair<std::size_t, std::size_t>>& taken, Evidences& out) {
  const Recording& recording = evidence.recordings[r];
  const Sampling sampling = sampling_of(channel);
  for (std::size_t m = 0; m < recording.marks.size(); ++m) {
    const Mark& mark = recording.marks[m];
    const Place place = place_of(out, first_power_up, mark, taken);
    if (!place.found) {
      out.findings.push_back(unused(mark.label, mark.run, "the schedule has no segment of that name"));
      continue;
    }
    const PowerUp& power_up = out.power_ups[place.power_up];
    if (passed_over(problem, power_up.rig.segments[place.segment])) continue;
    const double power_on = mark.begin - power_up.begins[place.segment];
    const double next =
        m + 1 < recording.marks.size() ? recording.marks[m + 1].begin : std::numeric_limits<double>::infinity();
    Stretch stretch{.power_up = place.power_up, .segment = place.segment, .label = mark.label, .run = mark.run};
    take_samples(channel, sampling.rate, power_on + use_from(power_up, place.segment, problem),
                 std::min(next, power_on + power_up.begins[place.segment + 1]), problem.scale, stretch);
    stretch.first -= power_on;
    stretch.recording = r;
    stretch.power_on = power_on;
    const auto present = std::ranges::count_if(stretch.values, [](double v) { return !std::isnan(v); });
    if (present == 0) {
      const bool any = has_samples(channel, mark.begin, std::min(next, power_on + power_up.begins[place.segment + 1]));
      out.findings.push_back(unused(mark.label, mark.run,
                                    any ? "no sample is left after settling" : "the recording holds no samples of it"));
      continue;
    }
    add_stretch(power_up, problem, std::move(stretch), out);
  }
}

}  // namespace

Evidences evidence_of(const Evidence& evidence, const Problem& problem) {
  std::vector<std::string> problems;
  Evidences out;
  std::map<const Plan*, std::size_t> numbers;
  std::map<std::pair<const Plan*, bool>, std::size_t> first;  // of the power-ups, or of the segments standing alone
  std::set<std::pair<std::size_t, std::size_t>> taken;
  if (!evidence.recordings.empty()) refuse_unlike_units(evidence, problem);
  refuse_constant(evidence, problem);
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    const Plan& plan = plan_of(evidence, r);
    const Channel& channel = require_channel(evidence, evidence.recordings[r], problem.role);
    const auto& name = evidence.recordings[r].origin.file;
    const double rate = sampling_of(channel).rate;
    const auto finite = [](double v) { return std::isfinite(v); };
    if (!(rate > 0.0) || !std::isfinite(rate) || channel.values.size() < 2 ||
        std::ranges::none_of(channel.values, finite))
      throw Error(Error::Kind::bad_data, fmt::format("{}channel '{}' holds no evenly timed samples",
                                                     name.empty() ? "" : name + ": ", channel.name));
    require(plan, rate, problem, problems);
    if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
    const bool alone = stands_alone(evidence, r);
    if (numbers.try_emplace(&plan, out.plans).second) ++out.plans;
    if (!first.contains({&plan, alone}))
      first[{&plan, alone}] = (alone ? add_segments : add_power_ups)(plan, numbers[&plan], rate, problem, out);
    if (evidence.recordings[r].marks.empty())
      throw Error(Error::Kind::bad_data,
                  "the recording does not say when its segments begin, and the plan has no schedule");
    add_recording(evidence, r, first[{&plan, alone}], channel, problem, taken, out);
  }
  if (out.stretches.empty()) {
    std::vector<std::string> why;
    for (const auto& finding : out.findings) why.push_back(finding.message);
    why.push_back("no segment of the schedule has usable samples");
    throw Error(Error::Kind::bad_data, why);
  }
  return out;
}

}  // namespace tumble::linear
