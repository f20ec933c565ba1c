#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/recording.hpp"

/// Facts by which a recording says of which unit it is, and of the run in which it was made: a run and a simulation write these
/// facts, and a result reads them.
namespace tumble {

/// "unit SLOT" of a run, "unit" of a simulation: the serial number.
inline constexpr std::string_view unit_fact = "unit";
/// "yes": no instrument was measured; and the seed of what was drawn in its place.
inline constexpr std::string_view simulated_fact = "simulated", seed_fact = "seed";
/// SHA-256 of the plan of the run.
inline constexpr std::string_view plan_fact = "plan_sha256";

/// The slots whose units the recording may be of; empty: it names none.
std::vector<std::string> recorded_slots(const Recording& recording);
/// The serial number of the unit in that slot, of any where `slot` is empty; empty: the recording does not say which one it is.
std::string recorded_serial(const Recording& recording, const std::string& slot);
/// Whether the run followed the plan with this SHA-256.
bool was_run_by(const Recording& recording, const std::string& sha256);

}  // namespace tumble
