#include <fmt/format.h>

#include <algorithm>

#include "tumble/methods/imu_channel_calibration/calibration.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_channel_calibration {
namespace {

const char* noun_of(Kind kind) { return kind == Kind::gyro ? "gyro" : "accelerometer"; }

/// The recordings with the marks that a predicate selects; a segment ends by the schedule's durations.
template <class Selected>
Evidence with_marks(const Evidence& evidence, Selected selected) {
  Evidence out;
  out.plan = evidence.plan;
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    Recording recording = evidence.recordings[r];
    std::erase_if(recording.marks, [&](const Mark& mark) { return !selected(plan_of(evidence, r), mark); });
    if (recording.marks.empty()) continue;
    out.recordings.push_back(std::move(recording));
    out.plans.push_back(r < evidence.plans.size() ? evidence.plans[r] : nullptr);
  }
  return out;
}

bool is_check(const Plan& plan, const Mark& mark) {
  const auto& prefix = plan.settings.word("check");
  return !prefix.empty() && mark.label.starts_with(prefix);
}

/// Adds a recording of channels that were tested alone.
void add_alone(const Evidence& evidence, std::size_t r, Sorted& out) {
  const auto& plan = evidence.plans[r];
  for (const Kind kind : kinds)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto choice = plan->channels.find(role_of(kind, axis));
      if (choice == plan->channels.end()) continue;
      Evidence& alone = out.alone[choice->first];
      if (alone.recordings.empty()) {
        alone.plan = *plan;
        alone.plan.channels = {{noun_of(kind), choice->second}};
        if (const auto t = plan->channels.find("temperature"); t != plan->channels.end())
          alone.plan.channels.insert(*t);
        alone.plan.settings = evidence.plan.settings;
      }
      alone.recordings.push_back(evidence.recordings[r]);
      alone.plans.push_back(plan);
    }
}

bool has(const Evidence& evidence, const std::string& role) {
  return !evidence.recordings.empty() && std::ranges::all_of(evidence.recordings, [&](const Recording& recording) {
    return channel_for(evidence, recording, role) != nullptr;
  });
}

void refuse_incomplete(const Sorted& sorted) {
  Problems problems;
  if (sorted.whole.recordings.empty())
    problems.push_back("there is no recording of the whole unit: one without a plan of its own");
  for (const Kind kind : kinds) {
    if (kind == Kind::gyro && !sorted.gyros) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto role = role_of(kind, axis);
      if (!sorted.whole.recordings.empty() && !has(sorted.whole, role))
        problems.push_back(say("the recordings of the whole unit have no channel {}", Name{role}));
      if (!sorted.alone.contains(role))
        problems.push_back(say(
            "no recording is of {0} alone: [[recording]] with a plan whose [channels] say {0} = \"...\"", Name{role}));
    }
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

}  // namespace

Sorted sorted(const Evidence& evidence) {
  Sorted out;
  Evidence whole;
  whole.plan = evidence.plan;
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    if (r < evidence.plans.size() && evidence.plans[r] && !evidence.plans[r]->channels.empty()) {
      add_alone(evidence, r, out);
    } else {
      whole.recordings.push_back(evidence.recordings[r]);
      whole.plans.push_back(r < evidence.plans.size() ? evidence.plans[r] : nullptr);
    }
  }
  bool some_alone = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto role = role_of(Kind::gyro, axis);
    some_alone = some_alone || out.alone.contains(role);
    out.gyros = out.gyros || out.alone.contains(role) || has(whole, role);
  }
  out.whole = with_marks(whole, [&](const Plan&, const Mark& mark) { return !is_check(evidence.plan, mark); });
  out.check = with_marks(whole, [&](const Plan&, const Mark& mark) { return is_check(evidence.plan, mark); });
  if (out.gyros && !some_alone) {
    out.gyros = false;
    out.findings.push_back({Finding::Severity::info, "no_gyro_tested_alone", {}});
  }
  refuse_incomplete(out);
  return out;
}

Evidence at_rest(const Evidence& evidence) {
  return with_marks(evidence, [](const Plan& plan, const Mark& mark) {
    const auto segment = std::ranges::find(plan.schedule, mark.label, &Segment::label);
    return segment == plan.schedule.end() || std::ranges::all_of(segment->axes, [](const auto& axis) {
             using Motion = tumble::Motion;
             return axis.second.kind == Motion::Kind::hold || axis.second.kind == Motion::Kind::dwell;
           });
  });
}

}  // namespace tumble::imu_channel_calibration
