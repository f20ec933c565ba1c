#pragma once

#include "tumble/core/estimate.hpp"
#include "tumble/methods/frequency_response/loop.hpp"
#include "tumble/methods/frequency_response/point.hpp"

namespace tumble::frequency_response {

/// Gain and phase at every frequency, with their origin.
Table bode_table(const std::vector<Point>& points, const Measured& measured, const Data& data,
                 const Estimate& estimate);
/// Gain and phase over frequency with their 95 % bands, and the response that was fitted (null: none).
std::vector<Curve> bode_curves(const std::vector<Point>& points, const Measured& measured, const Data& data,
                               const Estimate& estimate, const LoopFit* fit);

/// Gains and phases less the response that was fitted, or where none fits less the closest of those that were tried;
/// empty: fewer frequencies than any response needs. Bars: the noise with which it was fitted.
std::vector<Curve> residual_curves(const Measured& measured, const std::vector<LoopFit>& fits, const LoopFit* chosen);

}  // namespace tumble::frequency_response
