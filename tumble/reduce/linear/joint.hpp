#pragma once

#include <span>
#include <string>
#include <vector>

#include "tumble/math/regression/joint_model.hpp"
#include "tumble/reduce/linear/linear.hpp"

/// Several outputs of one test, identified together: the channels of an IMU, a gyro and accelerometers on one table.
///
/// Each output is first identified alone, which gives its noise. Then all are solved together, with the errors of the
/// rig drawn once for all of them: the level of a table as the accelerometers show it is subtracted from the gyros too.
namespace tumble::linear {

struct JointSolution {
  /// Columns, parameters, covariance, findings of all outputs, in their order; no segments.
  Solution all;
  std::vector<Solution> outputs;    ///< each as identified alone; `predicted` of their segments is that of all together
  std::vector<std::size_t> first;   ///< of each output's parameters among those of all
  std::vector<FoundEffect> errors;  ///< of the rig, as the outputs show them; empty where predicted
};

/// Given     problems   [outputs], at least one; names of columns unique over all of them
/// Throws    Error::bad_data, bad_input as identify() of one; the errors of all outputs at once
JointSolution identify(const Evidence& evidence, std::span<const Problem> problems);

/// Given: problems, truths [outputs].
JointSolution predict(const Plan& plan, std::span<const Problem> problems, std::span<const Truth> truths);

/// Table `rig_errors`: each error of the rig as the test itself shows it, in units of the uncertainty stated for it.
/// Errors of which it shows less than a tenth of their variance are omitted.
Table rig_errors(const JointSolution& solution);

}  // namespace tumble::linear
