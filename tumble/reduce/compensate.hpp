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
  Recording recording;  ///< the compensated channel under its own name, and what says how far it can be trusted
  Findings findings;
  std::vector<Table> tables;
};

/// How one output shows the quantity u that it measures, with terms whose coefficients c are parameters of a result:
///
///   y = o + K (u + sum_j c_j x_j(felt))
///
/// u is one of the numbers felt, so that terms may depend on it (scale factor, second order).
struct ErrorModel {
  std::string role;          ///< of the channel
  double scale = 1.0;        ///< y [SI] for one SI unit of the channel, before K
  std::string scale_factor;  ///< name of the parameter that is K; empty: K = 1
  std::string offset = {};   ///< name of the parameter that is o, in the unit of y; empty: o = 0
  /// Name of the parameter by which u differs from power-up to power-up (a standard deviation, in the unit of u): it
  /// belongs to what is not known of another recording. Empty, or not in the result: nothing.
  std::string spread = {};
  /// The terms depend on outputs instead of what was felt: u = y - sum_j c_j x_j(y), with every output in the place of
  /// what it shows.
  bool by_output = false;
  std::string unit;                        ///< of u as shown
  double& (*shown)(Felt& felt) = nullptr;  ///< u
  std::vector<Term> terms;                 ///< those whose name a parameter has are used
};

/// The settings with which a result was made. Throws Error::bad_file where its provenance does not hold them.
Settings settings_of(const Estimate& estimate, const std::vector<Option>& options);

/// The channel that plays a role in a recording, as the result's provenance names it. Null where there is none.
const Channel* channel_of(const Estimate& estimate, const Recording& recording, const std::string& role);

/// Name of the table of a result that says which regressors its test covered; see regressors_table.
inline constexpr const char* regressors_name = "regressors";

/// The range of each term's regressor [SI] (`terms` of them) over the data of a calibration, for `compensate`.
Table regressors_table(const std::vector<Term>& terms, const std::vector<double>& least,
                       const std::vector<double>& greatest);

/// Solves the model for u in every sample, with y for (y - o)/K:
///
///   u_{n+1} = u_n - g/(1 + E'),   g = u_n + E(u_n) - y,   E = sum_j c_j x_j
///
/// until |g|/(1 - L) <= 1e-12 max(|u|, |y|), with L = |E'|: as long as |E'| stays below L the root lies within this
/// bound (mean value theorem). Samples with L above 1/2 become missing ones.
///
/// Where an input of a term is not known, from a channel of the recording or from `plan`, the term stays in: the
/// regressor is taken to lie anywhere between the limits a, b that the calibration covered, and
///
///   compensation_sd^2 = d' C d + s^2 + sum_missing (c_j^2 + C_jj) ((a + b)^2/4 + (b - a)^2/12),
///   d = [-x_j, -y/K, -1/K]/(1 + E')
///
/// with the spread s from power-up to power-up.
///
/// Given     estimate   with a table `regressors`; its covariance is that of all parameters
///           plan       says by schedule and rig what was felt; may be null
/// Returned  the recording with the channel replaced by u, and after it the channels
///           <channel>.compensation_sd  [as u] standard uncertainty of what was subtracted and of what stays in
///           <channel>.extrapolated     1 where a regressor lies outside of what the calibration covered, else 0
///           the table `subtracted`: each term's mean, sd and greatest size, and where its inputs come from
/// Throws    Error::bad_file where the result lacks what is needed; Error::bad_data where the recording has no channel
///           for the role, or it is compensated already; Error::bad_input where the plan does not say what was felt
/// Accuracy  1e-12 relative against the model
Compensation compensate(const ErrorModel& model, const Estimate& estimate, const Recording& recording,
                        const Plan* plan);

/// Several outputs whose terms depend on what the others show (misalignments, sensitivity to specific force): solved in
/// turn until no u changes by more than 1e-10 of its size or its output's. The uncertainty of an output holds that of
/// the others by dE/du of each, whose dependence on each other is neglected there.
///
/// Given     models  of channels that are sampled together, at least one; by_output equal in all
/// Returned  as of one output; the tables are `subtracted_<role>`
/// Throws    as of one output; Error::bad_data where the channels are not sampled together
Compensation compensate(const std::vector<ErrorModel>& models, const Estimate& estimate, const Recording& recording,
                        const Plan* plan);

}  // namespace tumble
