#pragma once

#include "tumble/core/plan.hpp"
#include "tumble/station/station_file.hpp"

namespace tumble {

/// A station for a rehearsal where none is named: a controller for each axis of the plan's rig, a supply for the
/// instruments, one slot with their stream. What a person moves (how the instrument is mounted) is asked of a person.
/// Throws Error::bad_input where the plan names no rig.
Station station_for(const Plan& plan);

/// The declaration of the stream of that station (frames_for), beside the station file.
inline constexpr std::string_view made_frames_name = "frames.toml";

}  // namespace tumble
