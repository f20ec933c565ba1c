#include "tumble/core/said.hpp"

#include <fmt/args.h>
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "tumble/core/texts.hpp"

namespace tumble {

namespace {

/// Sentences within sentences, no deeper.
constexpr int deepest = 4;

/// An English sentence: what stands before, between and behind its values; two values side by side are one.
struct SaidPattern {
  std::vector<std::string> pieces{""};
  std::size_t letters = 0;  ///< of all pieces: the greater, the surer is a match
  std::string translation;  ///< with the values as {0}, {1}

  SaidPattern(std::string_view english, std::string in_language) : translation(std::move(in_language)) {
    for (std::size_t i = 0; i < english.size(); ++i) {
      const bool doubled = i + 1 < english.size() && english[i + 1] == english[i];
      if (english[i] == '{' && !doubled) {
        i = english.find('}', i);
        if (pieces.size() == 1 || !pieces.back().empty()) pieces.emplace_back();
        continue;
      }
      if (doubled && (english[i] == '{' || english[i] == '}')) ++i;
      pieces.back() += english[i];
      ++letters;
    }
  }

  /// The values in a sentence of this pattern. Each is as short as may be, which finds a match wherever there is one.
  std::optional<std::vector<std::string_view>> values_in(std::string_view text) const {
    if (pieces.size() == 1 && text != pieces[0]) return std::nullopt;
    if (pieces.size() == 1) return std::vector<std::string_view>();
    const std::string_view first = pieces.front(), last = pieces.back();
    if (text.size() < first.size() + last.size() || !text.starts_with(first) || !text.ends_with(last)) return {};
    text = text.substr(first.size(), text.size() - first.size() - last.size());
    std::vector<std::string_view> values;
    for (std::size_t i = 1; i + 1 < pieces.size(); ++i) {
      const auto found = text.find(pieces[i]);
      if (found == text.npos) return {};
      values.push_back(text.substr(0, found));
      text.remove_prefix(found + pieces[i].size());
    }
    values.push_back(text);
    return values;
  }
};

std::vector<SaidPattern> patterns_of(Language language) {
  std::vector<SaidPattern> patterns;
  for (const char* section : {"said", "said_by_libraries"})
    for (auto& [english, text] : texts_of(language, section)) patterns.emplace_back(english, text);
  return patterns;
}

std::optional<std::string> translated(std::string_view english, int depth);

/// A name in a sentence is said as it is, a sentence in it is translated.
std::string value_in_language(std::string_view value, int depth) {
  if (depth < deepest && value.find(' ') != value.npos)
    if (auto text = translated(value, depth + 1)) return *text;
  return std::string(value);
}

/// A sentence that has a pattern as a whole: that with the most letters.
std::optional<std::string> whole_translated(std::string_view english, int depth) {
  static const std::vector<SaidPattern> patterns = patterns_of(Language::chinese);
  const SaidPattern* best = nullptr;
  std::vector<std::string_view> values;
  for (const SaidPattern& pattern : patterns) {
    if (best && pattern.letters <= best->letters) continue;
    if (auto found = pattern.values_in(english)) best = &pattern, values = std::move(*found);
  }
  if (!best) return std::nullopt;
  fmt::dynamic_format_arg_store<fmt::format_context> store;
  for (const auto value : values) store.push_back(value_in_language(value, depth));
  return fmt::vformat(best->translation, store);
}

std::string with_full_colons(std::string text) {
  for (auto at = text.find(": "); at != text.npos; at = text.find(": ")) text.replace(at, 2, "：");
  return text;
}

/// "plan.toml:12: sentence": what stands before the sentence is kept.
std::optional<std::string> translated(std::string_view english, int depth) {
  if (auto text = whole_translated(english, depth)) return text;
  for (auto colon = english.find(": "); colon != english.npos; colon = english.find(": ", colon + 1))
    if (auto text = whole_translated(english.substr(colon + 2), depth))
      return with_full_colons(value_in_language(english.substr(0, colon), depth)) + "：" + *text;
  return std::nullopt;
}

}  // namespace

std::string said_in(Language language, std::string_view english) {
  if (language == Language::english) return std::string(english);
  std::string text;
  while (true) {  // line by line; what a line is set in by stays
    const auto end = std::min(english.find('\n'), english.size());
    const auto begin = std::min(english.find_first_not_of(' '), end);
    const auto line = english.substr(begin, end - begin);
    text += english.substr(0, begin);
    text += translated(line, 0).value_or(std::string(line));
    if (end == english.size()) return text;
    text += '\n';
    english.remove_prefix(end + 1);
  }
}

std::vector<std::string> said_in(Language language, std::vector<std::string> english) {
  for (auto& sentence : english) sentence = said_in(language, sentence);
  return english;
}

}  // namespace tumble
