#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/core/recording.hpp"

/// The plans with which the trials of the methods begin.
namespace tumble {

/// An instrument of that model without errors, on a rig with all its errors, in a laboratory; no schedule. Given: rate
/// [Hz].
Plan trial_plan(const std::string& method, const std::vector<Option>& options, const std::string& model,
                const std::string& rig, double rate);

/// `value` [unit] as the truth of the trial.
void set_truth(Plan& plan, const char* name, double value, const char* unit);

/// One value of the truth of a trial.
struct TruthValue {
  const char* name;
  double value;  ///< [unit]
  const char* unit;
};
/// Several values [unit of each] as the truth of the trial.
void set_truth(Plan& plan, std::span<const TruthValue> values);

/// `value` [unit] as a setting of the method.
void set_setting(Plan& plan, const char* name, double value, const char* unit);

/// Makes samples missing [1 in `every`, at random], and one gap of ten in a row in the middle of the recording.
void lose_samples(Recording& recording, std::uint64_t seed, std::uint64_t every);

}  // namespace tumble
