#include "tumble/core/evidence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "tumble/core/roles.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace {

const std::string& channel_name(const Evidence& evidence, const std::string& role) {
  const auto choice = evidence.plan.channels.find(role);
  return choice == evidence.plan.channels.end() ? role : choice->second.front().channel;
}

std::vector<Run> marked_runs(const Recording& recording, std::size_t index) {
  constexpr double forever = std::numeric_limits<double>::infinity();
  std::vector<Run> runs;
  for (const Mark& mark : recording.marks) {
    if (!runs.empty() && runs.back().number == mark.run) continue;
    if (!runs.empty()) runs.back().end = mark.begin;
    runs.push_back({index, mark.run, mark.label, mark.begin, forever});
  }
  return runs;
}

}  // namespace

const Plan& plan_of(const Evidence& evidence, std::size_t recording) {
  const bool own = recording < evidence.plans.size() && evidence.plans[recording] != nullptr;
  return own ? *evidence.plans[recording] : evidence.plan;
}

const Channel* channel_for(const Evidence& evidence, const Recording& recording, const std::string& role) {
  if (!evidence.plan.channels.contains(role)) return find_role(recording, role);
  return find_channel(recording, channel_name(evidence, role));
}

std::vector<const Channel*> channels_for(const Evidence& evidence, const Recording& recording,
                                         const std::string& role) {
  std::vector<const Channel*> found;
  if (const auto choice = evidence.plan.channels.find(role); choice != evidence.plan.channels.end()) {
    for (const auto& one : choice->second)
      if (const Channel* channel = find_channel(recording, one.channel)) found.push_back(channel);
    return found;
  }
  for (const Channel& channel : recording.channels)
    if (channel.name == role || channel.name.ends_with("." + role)) found.push_back(&channel);
  return found;
}

const Channel& require_channel(const Evidence& evidence, const Recording& recording, const std::string& role) {
  if (const Channel* channel = channel_for(evidence, recording, role)) return *channel;
  const std::string& wanted = channel_name(evidence, role);
  const std::string& file = recording.origin.file;
  std::vector<std::string> present;
  for (const Channel& channel : recording.channels) present.push_back(channel.name);
  const Sentence owner = file.empty() ? Sentence("the recording") : say("{}", Name{file});
  const Sentence named = wanted == role ? Sentence() : say(", which [channels] names for the role '{}'", role);
  const Sentence channels = present.empty() ? Sentence("none") : say("{}", fmt::join(present, ", "));
  const Sentence advice =
      wanted == role ? say("; name the one that plays this role with [channels] {} = \"...\" in the plan", Name{role})
                     : Sentence();
  const Sentence message = say("{} has no channel '{}'{}{} (channels: {}){}", owner, wanted, named,
                               did_you_mean(wanted, present), channels, advice);
  throw Error(Error::Kind::bad_data, message);
}

std::vector<Run> runs_of(const std::vector<Recording>& recordings) {
  constexpr double forever = std::numeric_limits<double>::infinity();
  std::vector<Run> runs;
  int highest = 0;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    std::vector<Run> found = marked_runs(recordings[i], i);
    if (found.empty()) found.push_back({i, highest + 1, "", -forever, forever});
    for (Run& run : found) {
      highest = std::max(highest, run.number);
      runs.push_back(std::move(run));
    }
  }
  return runs;
}

}  // namespace tumble
