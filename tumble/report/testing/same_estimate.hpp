#pragma once

#include "tumble/core/estimate.hpp"

namespace tumble::testing {

/// For tests: `b` is `a` written as a result and read back. A number that no double of the displayed unit hits exactly
/// moves by at most 2 ulp.
void expect_same(const Estimate& a, const Estimate& b);

}  // namespace tumble::testing
