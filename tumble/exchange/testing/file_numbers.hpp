#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tumble/math/matrix3.hpp"

/// A small reader of numbers for the tests: YAML, JSON, MATLAB, parameter lists and XML all write a key and then
/// numbers. Comments are removed first.
namespace tumble::testing {

/// The text without what follows `mark` on each line.
std::string without_comments(const std::string& text, std::string_view mark);

/// `count` numbers after `key`, where brackets, commas, semicolons, quotes, tabs and dashes of lists are passed over.
/// A failure of the test, and no numbers, where the key is missing or a word comes first.
std::vector<double> numbers_after(const std::string& text, std::string_view key, std::size_t count);
double number_after(const std::string& text, std::string_view key);
Vector3 vector_after(const std::string& text, std::string_view key);
/// Row by row.
Matrix3 matrix_after(const std::string& text, std::string_view key);

}  // namespace tumble::testing
