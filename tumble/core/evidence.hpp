#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/core/recording.hpp"

namespace tumble {

/// All a method may look at: what was planned and what was measured.
struct Evidence {
  Plan plan;
  std::vector<Recording> recordings;
  /// The plan of each recording that has its own (another rig, another schedule); null or missing: `plan`.
  std::vector<std::shared_ptr<const Plan>> plans = {};
};

/// The plan that says how the rig moved in that recording.
const Plan& plan_of(const Evidence& evidence, std::size_t recording);

/// The channel that plays `role`: the one the plan's [channels] names, else the one called like the role.
/// Null when the recording has none.
const Channel* channel_for(const Evidence& evidence, const Recording& recording, const std::string& role);

/// All that play a role which takes several: those the plan names, else the one called like the role and those of
/// further instruments, "<name>.<role>". Of what the plan names, those that the recording has.
std::vector<const Channel*> channels_for(const Evidence& evidence, const Recording& recording, const std::string& role);

/// The first, or Error::bad_data that lists the recording's channels.
const Channel& require_channel(const Evidence& evidence, const Recording& recording, const std::string& role);

/// One power-up in one recording: from `begin` (inclusive) to `end` (exclusive) [s].
struct Run {
  std::size_t recording = 0;  ///< index in Evidence::recordings
  int number = 1;
  std::string label;  ///< of its first segment
  double begin = 0.0;
  double end = 0.0;
};

/// The power-ups of all recordings, in order. A recording without marks is one run, from -inf to +inf.
std::vector<Run> runs_of(const std::vector<Recording>& recordings);

}  // namespace tumble
