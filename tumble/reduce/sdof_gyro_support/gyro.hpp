#pragma once

#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/core/role.hpp"
#include "tumble/reduce/linear/linear.hpp"

/// Parts that the methods for single-degree-of-freedom gyros share.
namespace tumble::sdof_gyro_support {

/// The output of the gyro.
std::vector<Role> roles();

/// `torquer_scale_factor`, `torquer_scale_factor_sd` and the options of the engine with these defaults of `settling`
/// and `averaging`.
std::vector<Option> options(const std::string& settling, const std::string& averaging);

/// The problem with the known input w_I [rad/s], the options of the engine, and the reading of the output: a rate
/// unchanged, a current times the torquer's scale factor, whose uncertainty is an error of the reading.
///
/// Given     channel  null where the test is predicted: the output is a rate
/// Throws    Error::bad_input, bad_data
linear::Problem problem_of(const Settings& settings, const Channel* channel);

/// Names of the drift terms over specific force, docs/equations (4.6), all ten or those up to the first order.
std::vector<std::string> first_order_terms();
std::vector<std::string> drift_terms();

/// Terms of the model sdof_gyro.
std::vector<Term> terms(const std::vector<std::string>& names);

/// Table `repeats` and a finding: scatter of the residuals of positions that were taken more than once.
void add_repeats(const linear::Solution& solution, Estimate& estimate);

}  // namespace tumble::sdof_gyro_support
