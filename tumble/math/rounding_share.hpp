#pragma once

namespace tumble {

/// Part [1] of two values by which they may differ and be equal: what remains of rounding after long sums (4e6 units of
/// the last digit), and less than any instrument or plan distinguishes.
constexpr double rounding_share = 1e-9;

}  // namespace tumble
