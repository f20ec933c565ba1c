#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"

/// Values that results of before hold as texts for people. Such texts are read here and nowhere else.
namespace tumble::legacy {

/// "<= 0.02 deg/h", ">= 1 g", "1 g to 2 g". Throws Error::bad_input with what cannot be read.
Limit limit_of(const std::string& text);

/// The parameters that are below the value `limit` of a finding, from its channels and its term, or the parameter.
std::vector<HiddenParameter> hidden_by(const Finding& finding);

/// Indices of the parameters that an error concerns, from its list of names or its place: a parameter, or a channel
/// with which their names begin. Empty: all.
std::vector<std::size_t> about_of(const Finding& finding, const std::vector<Parameter>& parameters);

/// Bytes of samples above which the recording was worked through in blocks. Absent: it was in memory as a whole.
std::optional<std::uintmax_t> memory_of(const Findings& findings);

}  // namespace tumble::legacy
