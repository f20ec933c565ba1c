#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/core/estimate.hpp"
#include "tumble/models/model.hpp"

/// The error model of an output as a method puts it into its result.
namespace tumble {

/// Ranges [SI] of regressors over the data of a test, one for each term.
struct TermRanges {
  std::vector<Term> terms;
  std::vector<double> least, greatest;
};

/// Index of a parameter; absent where the result has none of that name.
std::optional<std::size_t> parameter_index(const Estimate& estimate, std::string_view name);

/// The model of an output whose coefficients are the parameters called like the terms; others of `ranges` are not used,
/// and a term whose regressor is a function is not either. `unit`: of what it shows.
OutputModel output_model(const Estimate& estimate, const std::string& role, Input shows, const std::string& unit,
                         const TermRanges& ranges);

/// The parameter of this name is the scale factor K; without it nothing changes.
void set_scale(const Estimate& estimate, const std::string& name, OutputModel& model);

/// The model reads its channel as this one was read. Given: scale [SI of K u for one SI unit of the channel].
void set_reading(const Channel& channel, double scale, OutputModel& model);

/// The range of each regressor over what was felt.
TermRanges ranges_over(std::vector<Term> terms, const std::vector<Felt>& felt);

}  // namespace tumble
