#pragma once

#include <vector>

#include "tumble/tasks/validation/bench.hpp"

namespace tumble::validation {

/// A share of tests and where it lies.
struct ShareInterval {
  double lower = 0.0, upper = 1.0;  ///< [1]
};
/// The interval of the share [1] of which `count` of `tests` were found.
///
/// Given     sd  [1] of the normal distribution on either side: 1.96 for 95 %
/// See       Wilson, J. Am. Stat. Assoc. 22 (1927) 209; docs/validate.md
ShareInterval share_interval(std::size_t count, std::size_t tests, double sd);

/// How the interval of each parameter of the bench held in its sound tests.
std::vector<ValidatedParameter> validated_parameters(const Bench& bench);

}  // namespace tumble::validation
