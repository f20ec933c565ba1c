#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tumble/units/sentence.hpp"

namespace tumble {

/// The known name nearest to a mistyped one, or empty when none is near. Distance: insertions, deletions, substitutions
/// and swaps of neighbours, letters of either case being alike (optimal string alignment: Damerau 1964). Near: at most
/// one slip and one more for every four letters, and fewer slips than letters. The first of equals wins. Where none is
/// near, the shortest name that holds the whole word, if it has three letters.
std::string nearest(std::string_view name, const std::vector<std::string>& known);

/// "; did you mean 'x'?" or nothing, to be put behind a message about `name`.
Sentence did_you_mean(std::string_view name, const std::vector<std::string>& known);

}  // namespace tumble
