#pragma once

#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/models/model.hpp"

namespace tumble {

/// An error model subtracted from a recording.
struct Compensation {
  Recording recording;  ///< the compensated channels under their own names, and how far they can be trusted
  Findings findings;
  std::vector<Table> tables;
};

/// The channel that plays a role in a recording, as the result's provenance names it. Null where the recording has no
/// such channel.
const Channel* channel_of(const Estimate& estimate, const Recording& recording, const std::string& role);

/// Solves the models of a result for the u of all outputs that the recording holds, in every sample, with y for
/// (output - o)/K:
///
///   u_{n+1} = u_n - g/(1 + E'),   g = u_n + E(u_n) - y,   E = sum_j c_j x_j
///
/// until |g|/(1 - L) <= 1e-12 max(|u|, |y|), with L = |E'|: as long as |E'| stays below L the root lies within this
/// bound (mean value theorem). Samples with L above 1/2 become missing ones. Outputs whose terms depend on what others
/// show (misalignments, sensitivity to specific force) are solved in turn until no u changes by more than 1e-10 of its
/// size or its output's; where a term needs the angular acceleration of rates that are compensated too, all is repeated
/// with the slopes of these. The uncertainty of an output holds that of the others by dE/du of each, whose dependence
/// on each other is neglected there.
///
/// Where an input of a term is not known, from a channel of the recording or from `plan`, the term stays in: the
/// regressor is taken to lie anywhere between the limits a, b that the calibration covered, and
///
///   compensation_sd^2 = d' C d + s^2 + m^2 + sum_missing (c_j^2 + C_jj) ((a + b)^2/4 + (b - a)^2/12),
///   d = [-x_j, -y/K, -1/K]/(1 + E')
///
/// with the spread s from power-up to power-up and the misfit m of the model.
///
/// Given     estimate  with models; its covariance is that of all parameters
///           plan      says by schedule and rig what was felt; may be null
/// Returned  the recording with each channel replaced by u, and after all the channels
///           <channel>.compensation_sd  [as u] standard uncertainty of what was subtracted and of what stays in
///           <channel>.extrapolated     1 where a regressor lies outside of what the calibration covered, else 0
///           the table `subtracted` (of several outputs `subtracted_<role>`): each term's mean, sd and greatest size,
///           and where its inputs come from; findings of the checks of samples too
/// Throws    Error::unsupported where the result has no model; Error::bad_file where a parameter has no value;
///           Error::bad_data where the recording has no channel for a role, it is compensated already, or the channels
///           are not sampled together; Error::bad_input where the plan does not say what was felt
/// Accuracy  1e-12 relative against the model
Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan = nullptr);

}  // namespace tumble
