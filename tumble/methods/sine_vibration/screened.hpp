#pragma once

#include <functional>
#include <vector>

#include "tumble/methods/sine_vibration/line.hpp"
#include "tumble/reduce/vibration/vibration.hpp"

namespace tumble::sine_vibration {

/// A fit without the windows that lie far off it, which are added to `skipped`. Their number grows from fit to fit,
/// since they bend the first. Given: pulse [m/s].
Line screened(const vibration::Series& series, double pulse, const std::function<Line(const std::vector<double>&)>& fit,
              vibration::Outliers& skipped);

}  // namespace tumble::sine_vibration
