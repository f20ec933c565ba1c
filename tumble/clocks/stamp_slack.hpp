#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace tumble {

/// By how much a stamp and a time that follows from marks and durations may differ and still be the same instant [s]: a
/// millionth of a sample, or what the rounding of both leaves. A double of Unix time has steps of 2.4e-7 s, and a sum
/// of two is rounded once more.
///
/// Given     time   [s] of either, on the recording's clock
///           step   [s] between samples
inline double stamp_slack(double time, double step) {
  return std::max(1e-6 * step, 2.0 * std::numeric_limits<double>::epsilon() * std::abs(time));
}

}  // namespace tumble
