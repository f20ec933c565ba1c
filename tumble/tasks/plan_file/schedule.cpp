#include "tumble/tasks/plan_file/schedule.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tumble/rigs/rig.hpp"
#include "tumble/units/error.hpp"

namespace tumble::plan_file {
namespace {

constexpr double longest_segment = 1e8;  ///< [s]

using Kind = Motion::Kind;

constexpr std::pair<const char*, Kind> kinds[] = {{"hold", Kind::hold},   {"dwell", Kind::dwell},  {"rate", Kind::rate},
                                                  {"ramp", Kind::ramp},   {"slew", Kind::slew},    {"sine", Kind::sine},
                                                  {"sweep", Kind::sweep}, {"random", Kind::random}};

const char* word(Kind kind) {
  for (const auto& [name, value] : kinds)
    if (value == kind) return name;
  return "";
}

/// The units in which an axis is moved.
struct AxisUnits {
  explicit AxisUnits(const Axis& axis)
      : position(Unit::parse(axis.unit)),
        // degC is a point on a scale; amplitudes and speeds need its interval
        interval(position.offset() == 0.0 ? position : Unit::parse(tumble::name(position.dimension()))),
        speed(Unit::parse("(" + interval.text() + ")/s")),
        psd(Unit::parse("(" + interval.text() + ")^2/Hz")) {}
  Unit position, interval, speed, psd;
};

void read_sine(Section& sine, const AxisUnits& units, Motion& motion) {
  const auto amplitude = sine.quantity("amplitude", units.interval);
  const auto frequency = sine.quantity("frequency", Unit::parse("Hz"));
  motion.phase = sine.quantity("phase", Unit::parse("deg")).value_or(0.0);
  if (!sine.find("amplitude")) sine.missing("amplitude", "\"1 " + units.interval.text() + "\"");
  if (!sine.find("frequency")) sine.missing("frequency", "\"10 Hz\"");
  if (frequency && *frequency <= 0.0) sine.problem_at("frequency", "must be above zero");
  motion.amplitude = amplitude.value_or(0.0);
  motion.frequency = frequency.value_or(1.0);
  sine.close();
}

void read_sweep(Section& sweep, const AxisUnits& units, Motion& motion) {
  const auto amplitude = sweep.quantity("amplitude", units.interval);
  const auto from = sweep.quantity("from", Unit::parse("Hz")), to = sweep.quantity("to", Unit::parse("Hz"));
  if (!sweep.find("amplitude")) sweep.missing("amplitude", "\"1 " + units.interval.text() + "\"");
  if (!sweep.find("from")) sweep.missing("from", "\"10 Hz\"");
  if (!sweep.find("to")) sweep.missing("to", "\"1 kHz\"");
  if (from && *from <= 0.0) sweep.problem_at("from", "must be above zero");
  if (to && *to <= 0.0) sweep.problem_at("to", "must be above zero");
  motion.amplitude = amplitude.value_or(0.0);
  motion.frequency = from.value_or(1.0);
  motion.to_frequency = to.value_or(1.0);
  sweep.close();
}

void read_random(Section& random, const AxisUnits& units, Motion& motion) {
  motion.psd_frequency = random.quantities("frequency", Unit::parse("Hz"));
  motion.psd = random.quantities("psd", units.psd);
  const auto& f = motion.psd_frequency;
  if (f.size() != motion.psd.size() || f.size() < 2)
    random.problem("needs as many values of psd as of frequency, two or more of each");
  else if (f.front() <= 0.0 || std::adjacent_find(f.begin(), f.end(), std::greater_equal<>()) != f.end())
    random.problem_at("frequency", "must be above zero and rise");
  if (std::any_of(motion.psd.begin(), motion.psd.end(), [](double s) { return s < 0.0; }))
    random.problem_at("psd", "must not be negative");
  random.close();
}

void read_values(Section& section, Kind kind, const AxisUnits& units, FileProblems& problems, Motion& motion) {
  const char* key = word(kind);
  switch (kind) {
    case Kind::hold:
    case Kind::dwell:
      motion.value = section.quantity(key, units.position).value_or(0.0);
      break;
    case Kind::rate:
      motion.value = section.quantity(key, units.speed).value_or(0.0);
      break;
    case Kind::ramp:
    case Kind::slew: {
      const auto speed = section.quantity(key, units.speed);
      const auto to = section.quantity("to", units.position);
      if (!section.find("to")) section.missing("to", "\"1 " + units.position.text() + "\"");
      if (speed && *speed <= 0.0) section.problem_at(key, "the speed must be above zero; `to` gives the direction");
      motion.value = speed.value_or(1.0);
      motion.to = to.value_or(0.0);
      break;
    }
    case Kind::sine:
    case Kind::sweep:
    case Kind::random:
      if (const auto* table = section.table(key)) {
        Section inner(*table, section.name() + " " + key, problems);
        const auto read = kind == Kind::sine ? read_sine : kind == Kind::sweep ? read_sweep : read_random;
        read(inner, units, motion);
      }
      break;
  }
}

std::vector<std::string> words_of(const std::vector<Kind>& motions) {
  std::vector<std::string> words;
  for (const auto kind : motions) words.emplace_back(word(kind));
  return words;
}

/// The inline table of one axis, {ramp = "1 K/min", to = "60 degC"}. False when it holds no motion the axis can do.
bool read_motion(const toml::table& table, const std::string& name, const Axis& axis, FileProblems& problems,
                 Motion& motion) {
  Section section(table, name, problems);
  const auto accepted = words_of(axis.motions);
  int found = 0;
  for (const auto& [key, kind] : kinds) {
    if (!table.contains(key)) continue;
    ++found;
    if (std::find(axis.motions.begin(), axis.motions.end(), kind) == axis.motions.end())
      section.problem(say("cannot {}: this axis accepts {}", key, fmt::join(accepted, ", ")));
    motion.kind = kind;
    read_values(section, kind, AxisUnits(axis), problems, motion);
  }
  if (found > 1) section.problem("one motion for each axis of a segment");
  if (found == 0) {
    for (const auto& key : accepted) section.find(key);
    if (section.unread().empty()) section.problem(say("needs one of {}", fmt::join(accepted, ", ")));
  }
  section.close();
  return found == 1;
}

/// A segment as written, with the table it stands in.
struct Draft {
  Segment segment;
  std::optional<double> duration;
  const toml::table* table;
};

void read_axes(Section& section, const Rig* rig, FileProblems& problems, Segment& segment) {
  std::vector<Axis> axes;
  if (rig) axes = rig->axes();
  for (const auto& axis : axes) {
    if (const auto* table = section.table(axis.name)) {
      Motion motion;
      if (read_motion(*table, section.name() + " " + axis.name, axis, problems, motion))
        segment.axes.emplace(axis.name, motion);
    }
  }
  if (!rig && !section.unread().empty())
    section.problem(
        say("moves {}, but the plan names no rig: [rig] kind = \"...\"", fmt::join(section.unread(), ", ")));
  else
    section.close();
}

std::vector<Draft> read_drafts(const toml::array& tables, const Rig* rig, FileProblems& problems) {
  std::vector<Draft> drafts;
  for (const auto& node : tables) {
    const auto* table = node.as_table();
    if (!table) {
      problems.add(node.source(), "each segment is a table: [[schedule]]");
      continue;
    }
    Section section(*table, "[[schedule]]", problems);
    Draft draft{{}, {}, table};
    draft.segment.label = section.text("label").value_or("");
    if (!section.find("label"))
      section.missing("label", "\"static\"");
    else if (draft.segment.label.empty() && table->get("label")->is_string())
      section.problem_at("label", "must not be empty");
    draft.duration = section.quantity("duration", Unit::parse("s"));
    if (draft.duration && *draft.duration <= 0.0) section.problem_at("duration", "must be above zero");
    if (draft.duration && *draft.duration > longest_segment)
      section.problem_at("duration", "must be at most 1e8 s, which is three years");
    auto runs = section.integers("run");
    if (std::count(runs.begin(), runs.end(), 0)) section.problem_at("run", "power-ups count from 1");
    if (runs.empty()) runs.push_back(1);
    read_stopping_rule(section, draft.duration);  // for the station: tasks/stopping_rule.hpp
    read_axes(section, rig, problems, draft.segment);
    for (const int run : runs) {
      drafts.push_back(draft);
      drafts.back().segment.run = run;
    }
  }
  return drafts;
}

/// Where each axis stands, as far as the plan says.
using Positions = std::map<std::string, double>;

/// The time that the ramps and slews of a segment take; none when it has none, or when their start is not known.
std::optional<double> duration_of(const Draft& draft, const Positions& positions, FileProblems& problems) {
  if (draft.duration) return draft.duration;
  if (draft.table->contains("duration")) return std::nullopt;  // said already what is wrong with it
  std::optional<double> duration;
  for (const auto& [axis, motion] : draft.segment.axes) {
    if (motion.kind != Kind::ramp && motion.kind != Kind::slew) continue;
    const auto start = positions.find(axis);
    if (start == positions.end()) {
      problems.add(draft.table->source(),
                   say("[[schedule]] \"{}\": duration is missing, and nothing before it in run {} says where "
                       "{} starts",
                       draft.segment.label, draft.segment.run, Name{axis}));
      return std::nullopt;
    }
    duration = std::max(duration.value_or(0.0), std::abs(motion.to - start->second) / motion.value);
  }
  if (!duration || *duration == 0.0)
    problems.add(draft.table->source(), say("[[schedule]] \"{}\": duration {}", draft.segment.label,
                                            duration ? "would be zero: the axis is already there"
                                                     : "is missing, for example duration = \"5 min\""));
  return duration;
}

void advance(Positions& positions, const Segment& segment) {
  for (const auto& [axis, motion] : segment.axes) {
    const auto at = positions.find(axis);
    switch (motion.kind) {
      case Kind::hold:
      case Kind::dwell:
        positions[axis] = motion.value;
        break;
      case Kind::ramp:
      case Kind::slew: {
        if (at == positions.end() || std::abs(motion.to - at->second) <= motion.value * segment.duration)
          positions[axis] = motion.to;
        else
          at->second += std::copysign(motion.value * segment.duration, motion.to - at->second);
        break;
      }
      case Kind::rate:
        if (at != positions.end()) at->second += motion.value * segment.duration;
        break;
      case Kind::sine:
      case Kind::sweep:
      case Kind::random:
        break;
    }
  }
}

}  // namespace

std::optional<StoppingRule> read_stopping_rule(Section& section, std::optional<double> duration) {
  const auto text = section.text("until");
  const auto at_least = section.quantity("at_least", Unit::parse("s"));
  if (at_least && *at_least <= 0.0) section.problem_at("at_least", "must be above zero");
  if (!section.find("until")) {
    if (section.find("at_least")) section.problem_at("at_least", "is for a segment with `until`");
    return std::nullopt;
  }
  if (!section.find("at_least"))
    section.missing("at_least", "\"10 min\": before that time, the estimate is too poor to judge by");
  if (at_least && duration && *at_least >= *duration)
    section.problem_at("at_least", "must be shorter than the duration, in which the segment ends in any case");
  if (!text) return std::nullopt;
  try {
    return parse_stopping_rule(*text, at_least.value_or(0.0));
  } catch (const Error& error) {
    for (const auto& problem : error.problems) section.problem_at("until", problem);
    return std::nullopt;
  }
}

Schedule read_schedule(const toml::array& tables, const Rig* rig, FileProblems& problems) {
  auto drafts = read_drafts(tables, rig, problems);
  std::stable_sort(drafts.begin(), drafts.end(),
                   [](const Draft& a, const Draft& b) { return a.segment.run < b.segment.run; });
  Schedule schedule;
  Positions positions;
  for (auto& draft : drafts) {
    if (!schedule.empty() && schedule.back().run != draft.segment.run) positions.clear();
    draft.segment.duration = duration_of(draft, positions, problems).value_or(0.0);
    advance(positions, draft.segment);
    schedule.push_back(std::move(draft.segment));
  }
  return schedule;
}

}  // namespace tumble::plan_file
