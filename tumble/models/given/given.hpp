#pragma once

#include <string>
#include <vector>

#include "tumble/core/settings.hpp"
#include "tumble/units/sentence.hpp"

/// Physical constants that a [truth] may give or omit.
namespace tumble::given {

/// An option without default.
Option physical(std::string name, std::string unit, std::string description);

/// A constant [SI] of the truth, or `fallback` [SI] where it is not given.
double number_or(const Settings& truth, std::string_view name, double fallback);

/// The names, of those given, whose constant has a value.
std::vector<std::string> given_of(const Settings& truth, const std::vector<std::string>& names);

/// "a, b, c"
std::string listed(const std::vector<std::string>& names);

/// A message for each of the names that is given and not positive.
void require_positive(const Settings& truth, const std::vector<std::string>& names, Problems& problems);

/// A message if any of `names` is given while `needed` are not all there.
void require_with(const Settings& truth, const std::vector<std::string>& names, const std::vector<std::string>& needed,
                  Problems& problems);

/// Throws Error::bad_input that lists the problems of [truth]; returns if the list is empty.
void refuse(Problems problems);

}  // namespace tumble::given
