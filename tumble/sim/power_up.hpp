#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/math/rotation.hpp"
#include "tumble/models/model.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/source.hpp"

namespace tumble {

/// The segments between one switching-on and the next.
struct PlannedRun {
  int run = 1;
  double begin = 0.0;       ///< [s] on the recording's clock
  std::size_t samples = 0;  ///< recorded
  Schedule segments;
};

/// The power-ups of a schedule. Given: sample_rate [Hz].
std::vector<PlannedRun> power_ups(const Schedule& schedule, double sample_rate);

/// Segment `index`, and where the segments of its power-up before it left the axes that it does not mention. An axis that
/// turned last stands, for it, where it stood before.
Segment with_what_stands(const Schedule& schedule, std::size_t index);

/// Segment `index` where it is all that was recorded, without the way to it: axes that it does not mention stand where
/// the segments of its power-up before it left them.
Segment standing_alone(const Schedule& schedule, std::size_t index);

/// Whether every segment has a file of its own: then nobody asks how the rig went from one to the next.
bool recorded_one_by_one(const Plan& plan);

/// One value of every error of the rig (row) in every segment (column), drawn from their standard deviations: those of
/// the whole test from `test`, those of each segment from `run`. Empty where the rig has none.
/// Returned: [errors x segments] in SI.
Matrix drawn_errors(const std::vector<RigError>& errors, std::size_t segments, const RandomStream& test,
                    const RandomStream& run);

/// Motion and temperature that the rig gives with this plan in this power-up, at the rate of the simulation's steps.
Reference reference_of(const Plan& plan, const PlannedRun& run, const RandomStream& random);

/// One instrument of a plan: the first, or one of Plan::beside.
struct Participant {
  std::string prefix;  ///< of its channels: "" or "S2."
  const Model& model;
  const Settings& truth;
  Rotation own_from_first;  ///< its axes, from those in which the rig says what is felt
};

/// The first and all beside it. They live as long as the plan.
std::vector<Participant> participants_of(const Plan& plan);

/// The outputs of all instruments: one source, since all feel the same.
Source outputs_of(const Plan& plan, const Reference& reference, const PlannedRun& run, const RandomStream& random);
/// The rig's sensors.
std::vector<Source> sensors_of(const Plan& plan, const Reference& reference, const PlannedRun& run);

/// Steps of the simulation per recorded sample: what [truth] says, else so many that no motion goes on by more than 1
/// rad in one of them. The ripple of a turning axis counts as one: a step that holds whole ripples would make them a
/// constant.
int oversampling_of(const Plan& plan);

}  // namespace tumble
