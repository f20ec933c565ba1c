#include <algorithm>
#include <functional>
#include <map>

#include "tumble/core/said.hpp"
#include "tumble/core/said/pattern.hpp"
#include "tumble/core/texts.hpp"

namespace tumble {

using said::numbered;
using said::Pattern;

namespace {

/// Sentences within sentences, no deeper.
constexpr int deepest = 4;

/// Letters of a sentence that is not taken for another.
constexpr std::size_t sure = 16;
/// Findings that are the reason of a refusal: its problem is their sentence, whose code is not known any more.
void add_findings(std::vector<Pattern>& patterns, Language language) {
  const auto texts = texts_of(language, "finding");
  for (const auto& [code, english] : texts_of(Language::english, "finding")) {
    Pattern pattern(english, "");
    const auto text = texts.find(code);
    const bool counts = code.find('.') != std::string::npos;  // "3 samples" would stand in Chinese
    if (text == texts.end() || counts || pattern.letters < sure) continue;
    if (auto translation = numbered(text->second, pattern.names)) {
      pattern.translation = std::move(*translation);
      patterns.push_back(std::move(pattern));
    }
  }
}

/// A table of sentences: those without values by themselves, the others as patterns.
struct SaidTable {
  std::map<std::string, std::string, std::less<>> whole;
  std::vector<Pattern> patterns;
  bool words = false;  ///< of names: a value that is one word is looked up, too, and "_" is the same as a blank

  void add(const std::string& english, const std::string& text) {
    Pattern pattern(looked_up(english), text);
    if (pattern.pieces.size() == 1)
      whole.emplace(pattern.pieces.front(), text);
    else
      patterns.push_back(std::move(pattern));
  }

  /// As the table has it; the letters keep their places.
  std::string looked_up(std::string_view english) const {
    std::string text(english);
    if (words) std::ranges::replace(text, '_', ' ');
    return text;
  }
};

const SaidTable& said_table() {
  static const SaidTable table = [] {
    SaidTable all;
    for (const char* section : {"said", "said_by_libraries"})
      for (const auto& [english, text] : texts_of(Language::chinese, section)) all.add(english, text);
    add_findings(all.patterns, Language::chinese);
    return all;
  }();
  return table;
}

const SaidTable& result_table() {
  static const SaidTable table = [] {
    SaidTable all{.whole = {}, .patterns = {}, .words = true};
    for (const auto& [english, text] : texts_of(Language::chinese, "result")) all.add(english, text);
    return all;
  }();
  return table;
}

std::optional<std::string> translated(const SaidTable& table, std::string_view english, int depth);

/// A name in a sentence is said as it is, a sentence in it is translated.
std::string value_in_language(const SaidTable& table, std::string_view value, int depth) {
  if (depth < deepest && (table.words || value.find(' ') != value.npos))
    if (auto text = translated(table, value, depth + 1)) return *text;
  return std::string(value);
}

/// Whether a pattern is short and between two values, "{} over {}": it is taken for one only where the values have no
/// English words.
bool is_loose(const Pattern& pattern) {
  return pattern.letters < 7 && pattern.pieces.front().empty() && pattern.pieces.back().empty();
}

/// Whether a value that is no number has three small letters in a row.
bool is_english(std::string_view value) {
  const auto is_small = [](char c) { return c >= 'a' && c <= 'z'; };
  if (value.empty() || std::string_view("+-.0123456789").find(value[0]) != std::string_view::npos) return false;
  return std::ranges::search_n(value, 3, true, {}, is_small).size() == 3;
}

std::optional<std::string> whole_translated(const SaidTable& table, std::string_view english, int depth);

/// Two descriptions in one, "drift per f_S; means D_S + 2 D_SS".
std::optional<std::string> halves_translated(const SaidTable& table, std::string_view english, int depth) {
  const auto between = table.words ? english.find("; ") : english.npos;
  if (between == english.npos) return std::nullopt;
  auto first = whole_translated(table, english.substr(0, between), depth);
  auto second = first ? whole_translated(table, english.substr(between + 2), depth) : std::nullopt;
  if (!second) return std::nullopt;
  return *first + "；" + *second;
}

/// A sentence that has a pattern as a whole: that with the most letters.
std::optional<std::string> whole_translated(const SaidTable& table, std::string_view english, int depth) {
  const std::string looked = table.looked_up(english);
  if (const auto found = table.whole.find(looked); found != table.whole.end()) return said::filled(found->second, {});
  if (auto text = halves_translated(table, english, depth)) return text;
  const Pattern* best = nullptr;
  std::vector<std::string_view> values;
  for (const Pattern& pattern : table.patterns) {
    if (best && pattern.letters <= best->letters) continue;
    if (depth > 0 && !table.words && pattern.letters < sure) continue;  // a name may look like a short sentence
    if (auto found = pattern.values_in(looked)) best = &pattern, values = std::move(*found);
  }
  if (!best) return std::nullopt;
  std::vector<std::string> said;
  for (const auto value : values) {
    const auto begin = value.empty() ? 0 : static_cast<std::size_t>(value.data() - looked.data());
    said.push_back(value_in_language(table, english.substr(begin, value.size()), depth));
    if (table.words && is_loose(*best) && is_english(said.back())) return std::nullopt;
  }
  return said::filled(best->translation, said);
}

std::string with_full_colons(std::string text) {
  for (auto at = text.find(": "); at != text.npos; at = text.find(": ")) text.replace(at, 2, "：");
  return text;
}

/// "plan.toml:12: sentence": what stands before the sentence is kept.
std::optional<std::string> translated(const SaidTable& table, std::string_view english, int depth) {
  if (auto text = whole_translated(table, english, depth)) return text;
  for (auto colon = english.find(": "); colon != english.npos; colon = english.find(": ", colon + 1))
    if (auto text = whole_translated(table, english.substr(colon + 2), depth))
      return with_full_colons(value_in_language(table, english.substr(0, colon), depth)) + "：" + *text;
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
    text += translated(said_table(), line, 0).value_or(std::string(line));
    if (end == english.size()) return text;
    text += '\n';
    english.remove_prefix(end + 1);
  }
}

std::vector<std::string> said_in(Language language, std::vector<std::string> english) {
  for (auto& sentence : english) sentence = said_in(language, sentence);
  return english;
}

std::optional<std::string> result_words_in(Language language, std::string_view english) {
  if (language == Language::english) return std::nullopt;
  return translated(result_table(), english, 0);
}

}  // namespace tumble
