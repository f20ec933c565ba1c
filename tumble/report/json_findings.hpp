#pragma once

#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/report/json_node.hpp"

namespace tumble {

/// A finding of a document. The sentence is taken without changes: another version may say it in other words, or know
/// other codes.
Finding finding_of(const Node& node);

/// A finding of a result: which of its parameters it concerns.
Finding finding_of(const Node& node, const std::vector<Parameter>& parameters);

/// A verdict with its limit: lower and upper, and the text that says the same. A result of before has the text alone.
Verdict verdict_of(const Node& node);

}  // namespace tumble
