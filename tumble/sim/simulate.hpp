#pragma once

#include <cstdint>

#include "tumble/core/plan.hpp"
#include "tumble/core/progress.hpp"
#include "tumble/core/recording.hpp"

namespace tumble {

/// Carries a plan out on a rig and an instrument of known truth: every power-up of the schedule, one after the other on
/// one clock that starts at 0, with a mark for each segment. The output is the sum of the model's terms (coefficients
/// from plan.truth), the turn-on bias of the run and the noise. The same plan and seed give the same bytes on any
/// number of threads. Throws Error::bad_input that lists all the plan lacks: model, rig, sample rate, schedule.
Recording simulate(const Plan& plan, std::uint64_t seed, const Progress& progress);

}  // namespace tumble
