#pragma once

namespace tumble {

/// x^2, of unit [x^2].
constexpr double square(double x) { return x * x; }

}  // namespace tumble
