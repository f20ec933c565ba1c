#pragma once

#include <string_view>

namespace tumble {

/// The sensor, position or reference that a test needs to show a departure which it does not show. In English, as
/// result_words_in() translates it.
/// Throws Error::internal for a departure of the catalogue that the list lacks.
std::string_view remedy_of(std::string_view departure);

}  // namespace tumble
