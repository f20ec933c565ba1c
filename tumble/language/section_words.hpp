#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "tumble/language/text.hpp"

namespace tumble {

/// The texts of one section of text/<language>.toml.
struct SectionWords {
  Language language = Language::english;
  const char* section = "terminal";

  std::string operator()(std::string_view key) const { return text_of(language, section, key); }
  /// A sentence with values at {0}, {1}, ...
  template <class... Values>
  std::string with(std::string_view key, const Values&... values) const {
    return fmt::format(fmt::runtime((*this)(key)), values...);
  }
};

}  // namespace tumble
