#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace tumble::cli {

/// The kinds of things there are, in the order shown: methods, models, rigs, formats, checks.
const std::vector<std::string>& catalogue_kinds();

/// Every entry of one kind with all it says of itself: name, summary, source, options, roles, axes, terms ...
nlohmann::ordered_json catalogue_json(const std::string& kind);

/// A declaration of a controller in a file of the user, read and checked. Throws Error::bad_input with all problems.
nlohmann::ordered_json controller_json(const std::string& file);

}  // namespace tumble::cli
