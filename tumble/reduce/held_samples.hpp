#pragma once

#include <string>

#include "tumble/reduce/even_signal.hpp"

namespace tumble {

/// Keeps one of each k samples where a record holds every value of a slower sensor k times, from the first change to its end:
/// noise is then that of the sensor, at its rate.
/// Returned: a finding, or nothing.
Findings take_repeats_out(EvenSignal& signal, const std::string& label);

}  // namespace tumble
