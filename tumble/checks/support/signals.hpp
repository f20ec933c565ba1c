#pragma once

#include "tumble/core/plan.hpp"
#include "tumble/core/recording.hpp"

namespace tumble::support {

/// Whether a channel is the signal of an inertial sensor: a rate, a specific force, an increment of velocity, counts, and
/// what its name or the plan says is the output of one, in volts, milliamperes or increments of an angle. Other angles,
/// temperatures and set points are no signals: an encoder at rest shows one value, and so it should.
///
/// Given     plan   may be null
bool is_signal(const Channel& channel, const Plan* plan);

}  // namespace tumble::support
