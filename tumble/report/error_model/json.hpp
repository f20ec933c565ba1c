#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/report/json_node.hpp"

/// Error models in result files; numbers in SI.
namespace tumble::error_model {

nlohmann::ordered_json models_json(const std::vector<OutputModel>& models);

/// Complains of an index that is no parameter of the result.
std::vector<OutputModel> models_of(const Node& node, std::size_t parameters);

/// The error models that a result of before this member holds in its parameters, settings and tables. Empty: it has
/// none.
std::vector<OutputModel> legacy_models(const Estimate& estimate);

}  // namespace tumble::error_model
