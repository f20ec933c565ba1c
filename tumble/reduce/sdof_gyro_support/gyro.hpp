#pragma once

#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/core/role.hpp"
#include "tumble/reduce/compensate.hpp"
#include "tumble/reduce/linear/linear.hpp"

/// What the methods for single-degree-of-freedom gyros share.
namespace tumble::sdof_gyro_support {

Role gyro_role();

/// `torquer_scale_factor` and `torquer_scale_factor_sd`.
std::vector<Option> reading_options();

/// The gyro's channel in the first recording. Throws Error::bad_data.
const Channel* channel(const Evidence& evidence);

/// Input, scale and scale error of the output: a rate as it is, a current through the torquer's scale factor.
/// Without a channel (prediction) it is a rate. Throws Error::bad_input, bad_data.
void set_reading(const Settings& settings, const Channel* channel, linear::Problem& problem);

/// Terms of the model sdof_gyro.
std::vector<Term> terms(const std::vector<std::string>& names);

/// The output as the rate about the input axis, with what terms of the model sdof_gyro give subtracted: those that the
/// result of a method with these options has, and `more` of the method's own. See tumble::compensate, which says what
/// is thrown.
Compensation compensated(const Estimate& estimate, const Recording& recording, const Plan* plan,
                         const std::vector<Option>& options, const std::vector<Term>& more = {});

/// Positions that were taken more than once: how far their residuals scatter. Table `repeats` and a finding.
void add_repeats(const linear::Solution& solution, Estimate& estimate);

/// A plan for trials: an sdof_gyro of known drift and noise on a rig with all its errors, no schedule. Given: rate
/// [Hz].
Plan trial_plan(const std::string& method, const std::vector<Option>& options, const std::string& rig, double rate);

/// A position of a two-axis table.
struct Position {
  std::string label;
  double outer = 0.0, inner = 0.0;  ///< [rad]
};

/// Specific force along the 6 faces, 12 edges and 8 corners of a cube in the instrument, in a mixed order.
std::vector<Position> cube_positions();
/// A segment that holds a position. Given: duration [s].
Segment at(const Position& position, double duration);

}  // namespace tumble::sdof_gyro_support
