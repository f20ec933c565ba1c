#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tumble {

/// What users read, by section and key, from text/en.toml. A key with `one` and `other` has two texts, for a count of 1
/// and for every other count.
/// Throws Error::internal for a key that the table lacks.
std::string text_of(std::string_view section, std::string_view key, std::size_t count = 1);

}  // namespace tumble
