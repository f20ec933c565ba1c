#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tumble::said {

/// An English sentence: what stands before, between and behind its values; two values side by side are one.
struct Pattern {
  std::vector<std::string> pieces{""};
  std::size_t letters = 0;         ///< of all pieces: the greater, the surer is a match
  std::vector<std::string> names;  ///< of the values: what stands in their braces, up to a colon
  std::string translation;         ///< with the values as {0}, {1}

  Pattern(std::string_view english, std::string in_language);

  /// The values in a sentence of this pattern. Each is as short as may be, which finds a match wherever there is one.
  std::optional<std::vector<std::string_view>> values_in(std::string_view text) const;
};

/// "{lost} ... {first:instant}" as "{0} ... {1}", by the names of the values in English; none where one has no place
/// there.
std::optional<std::string> numbered(const std::string& named, const std::vector<std::string>& names);

/// A translation with the values at {0}, {1}, ... A blank stands between Chinese and Latin letters alone.
std::string filled(std::string_view translation, const std::vector<std::string>& values);

}  // namespace tumble::said
