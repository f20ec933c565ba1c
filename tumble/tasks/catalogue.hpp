#pragma once

#include <string>
#include <vector>

namespace tumble {

/// The kinds of things there are, in the order shown: methods, models, rigs, formats, checks.
const std::vector<std::string>& catalogue_kinds();

/// Every entry of one kind with all it says of itself, as an array of JSON: name, summary, source, options, roles,
/// axes, terms ...
std::string catalogue_json(const std::string& kind);

/// A declaration of a controller in a file of the user, read and checked, as an object of JSON. Throws
/// Error::bad_input with all problems.
std::string controller_json(const std::string& file);

}  // namespace tumble
