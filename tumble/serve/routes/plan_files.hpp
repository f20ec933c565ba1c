#pragma once

#include <string>
#include <vector>

#include "tumble/serve/routes/routes.hpp"

/// Files of the folder of the workbench, by the names that requests give.
namespace tumble::routes {

/// The file that a name means. Throws Error::unsupported where it is not there, Error::bad_input.
std::string existing(const Context& context, const std::string& name);

/// The file that a plan is or will be: in the folder or in one below it, "x.toml". Throws Error::bad_input.
std::string place_of_plan(const Context& context, const std::string& name);

/// How a file is to be read: the parameters set=key=value. Throws Error::bad_input for a key that is not about columns
/// and times of a file.
Sets sets_of(const std::vector<std::string>& texts);

}  // namespace tumble::routes
