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

}  // namespace tumble::frequency_response
