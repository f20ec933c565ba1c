#include "tumble/core/tables/document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "tumble/units/error.hpp"

namespace tumble::tables {
namespace {

/// A table lies in a table for each part of a dotted key, and the parser calls itself for each: the stack would end.
void refuse_deep_keys(const std::string& text, const std::string& file) {
  constexpr std::ptrdiff_t most = 1000;
  std::size_t line = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    ++line;
    const auto content = std::string_view(text).substr(begin, end - begin);
    const auto key = content.substr(0, content.find_first_of("=#"));
    if (std::ranges::count(key, '.') > most)
      throw Error(Error::Kind::bad_input,
                  within(Where{.file = file, .line = line, .place = say("{}:{}", Name{file}, line)},
                         say("a key of more than {} parts", most)));
    begin = end + 1;
  }
}

/// The parser takes 0.3 s for a megabyte.
void refuse_long_text(const std::string& text, const std::string& file) {
  constexpr std::size_t most = 16'000'000;
  if (text.size() > most)
    throw Error(Error::Kind::bad_input,
                say("{}: has {} MB; a plan or a declaration may have {} MB: is this a recording?", Name{file},
                    text.size() / 1'000'000, most / 1'000'000));
}

}  // namespace

toml::table document_of(const std::string& text, const std::string& file) {
  refuse_long_text(text, file);
  refuse_deep_keys(text, file);
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    const auto at = error.source().begin;
    throw Error(Error::Kind::bad_input, within(Where{.file = file,
                                                     .line = at.line,
                                                     .column = at.column,
                                                     .place = say("{}:{}:{}", Name{file}, at.line, at.column)},
                                               say("not TOML: {}", std::string(error.description()).c_str())));
  }
}

}  // namespace tumble::tables
