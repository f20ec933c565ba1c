#pragma once

#include <string>
#include <vector>

#include "tumble/language/text.hpp"

namespace tumble {

/// The kinds of things there are, in the order shown: methods, models, rigs, formats, checks, departures ...
const std::vector<std::string>& catalogue_kinds();

/// Every entry of one kind with all it says of itself, as an array of JSON: name, summary, source, options, roles,
/// axes, terms ...
std::string catalogue_json(const std::string& kind);

/// The catalogue as above, with the summaries of the entries and the descriptions of their options in a language, where
/// the language has them; names, units and defaults are alike in all.
std::string catalogue_json(const std::string& kind, Language language);

/// A declaration of a controller in a file of the user, read and checked, as an object of JSON. Throws
/// Error::bad_input with all problems.
std::string controller_json(const std::string& file);

}  // namespace tumble
