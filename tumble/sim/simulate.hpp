#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "tumble/core/plan.hpp"
#include "tumble/core/progress.hpp"
#include "tumble/core/recording.hpp"

namespace tumble {

/// Carries a plan out on a rig and an instrument of known truth: every power-up of the schedule, one after the other on
/// one clock that starts at 0, with a mark for each segment. An output is its input, the sum of the model's terms
/// (coefficients from plan.truth), the turn-on bias of the run and the noise, passed through the instrument's
/// electronics. The rig's errors are drawn from their standard deviations. The same plan and seed give the same bytes
/// on any number of threads. Throws Error::bad_input that lists all the plan lacks: model, rig, sample rate, schedule.
Recording simulate(const Plan& plan, std::uint64_t seed, const Progress& progress);

/// Simulates in blocks of up to `samples` samples, for recordings larger than memory. Every block holds all channels;
/// the first carries the marks and the rest of what a recording says of itself.
void simulate(const Plan& plan, std::uint64_t seed, std::size_t samples,
              const std::function<void(const Recording& block)>& sink, const Progress& progress);

/// Bytes that the samples of the simulated recording will take.
std::size_t simulated_size(const Plan& plan);

}  // namespace tumble
