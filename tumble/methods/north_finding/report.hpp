#pragma once

#include <optional>
#include <string>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/north_finding/solve.hpp"

namespace tumble::north_finding {

/// One reduction: what was known of the instrument, and the result.
struct Reduction {
  Instrument instrument;
  Setup setup;
  std::vector<Noise> noise;
  Solution solution;
};

/// Azimuths without the joint fit, corrected for gamma_y by (2.10).
struct ClosedForms {
  double uncorrected = 0.0;  ///< [rad] as if the base were level
  double first_order = 0.0;  ///< (2.9)
  double exact = 0.0;        ///< (2.12)
};
ClosedForms closed_forms(const Bench& bench, const Reduction& reduction);

/// The estimate of `reduction`; `nominal` is the same test without the calibration, or null.
Estimate described(const Bench& bench, const Reduction& reduction, const Reduction* nominal, bool predicted);

/// How the test may mislead, and what would mend it.
Findings findings_of(const Bench& bench, const Reduction& reduction, bool predicted);

/// Whether another channel shows the horizontal rate that the gyro does not: the two are exchanged.
std::optional<Finding> shown_by_another(const Bench& bench, const Reduction& reduction, const Bench& with_other,
                                        const std::string& other);

/// An angle [rad] brought to between 0 and 2 pi.
double wrapped(double angle);

}  // namespace tumble::north_finding
