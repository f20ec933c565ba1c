#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tumble/math/stability/allan_phase.hpp"

namespace tumble {

/// Noise type alpha (S_y ~ f^alpha, 2 ... -4) that dominates at each averaging factor m, ascending.
///
/// From 30 phase points at stride m on: lag-1 autocorrelation r of the phase less its quadratic, differenced d times
/// until rho = r/(1 + r) < 0.25; alpha = 2 - round(2 (rho + d)). In a record with gaps all runs are pooled. Below 30
/// points: ratio B1 of the sample variance of the tau-averages to the Allan variance, and R(n) of the modified to the
/// plain Allan variance to distinguish white from flicker phase noise. Below 8 points the record cannot show the type:
/// it is that of the octave before. The octaves 1, 2, 4 ... of the record are always read: the type at a factor does not
/// depend on which others are asked for.
///
/// In a sum of power laws the types follow each other from 2 to -4 as tau grows, and rate noise taken for phase noise
/// would give limits that are far too narrow. So phase noise at longer tau than rate noise is believed only where the
/// exponent lies 2 sd beyond the boundary, and no whiter type at all below 30 points.
///
/// Given     phase [u samples]; factors m [samples]
/// See       Riley and Greenhall, "Power law noise identification using the lag 1 autocorrelation", EFTF 2004
std::vector<int> identify_noise_types(const Phase& phase, std::span<const std::size_t> factors);

}  // namespace tumble
