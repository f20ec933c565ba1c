#include "tumble/language/said.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "tumble/language/said/pattern.hpp"
#include "tumble/language/texts.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {

using said::numbered;
using said::Pattern;

namespace {

using Values = std::vector<const SentenceValue*>;

/// A pattern with its values as a table of translations knows it: values side by side are one.
struct Shape {
  std::string key;
  std::vector<Values> values;
};

Shape shape_of(std::string_view pattern, const std::vector<SentenceValue>& values) {
  Shape shape;
  std::size_t value = 0;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const bool place = pattern.substr(i).starts_with("{}");
    if (!place) {
      shape.key += pattern[i];
      if ((pattern[i] == '{' || pattern[i] == '}') && i + 1 < pattern.size()) shape.key += pattern[++i];
      continue;
    }
    if (!shape.key.ends_with("{}") || shape.values.empty() || shape.key.ends_with("{{}}"))
      shape.key += "{}", shape.values.emplace_back();
    if (value < values.size()) shape.values.back().push_back(&values[value++]);
    ++i;
  }
  return shape;
}

/// The key of a table, "{:.3g} of {0}", with all its places as {}.
std::string plain_key(std::string_view english) {
  std::string key;
  for (std::size_t i = 0; i < english.size(); ++i) {
    key += english[i];
    const bool doubled = i + 1 < english.size() && english[i + 1] == english[i];
    if ((english[i] == '{' || english[i] == '}') && doubled)
      key += english[++i];
    else if (english[i] == '{')
      i = english.find('}', i) - 1;
  }
  return shape_of(key, {}).key;
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// "sample" of "{lost:sample}", or of said_count(): Chinese has its counting word in the sentence, and the number alone
/// as value.
std::set<std::string> nouns_of_findings() {
  std::set<std::string> nouns{"column", "count", "stamp", "step"};  // of refusals
  for (const auto& [code, english] : texts_of(Language::english, "finding"))
    for (auto colon = english.find(':'); colon != english.npos; colon = english.find(':', colon + 1)) {
      const auto end = english.find_first_not_of("abcdefghijklmnopqrstuvwxyz ", colon + 1);
      if (end != english.npos && end > colon + 1 && english[end] == '}')
        nouns.insert(english.substr(colon + 1, end - colon - 1));
    }
  return nouns;
}

/// The Chinese text of a finding, "gap.one": Chinese may have one for both.
std::optional<std::string> chinese_of_finding(const std::string& code) {
  static const auto texts = texts_of(Language::chinese, "finding");
  auto found = texts.find(code);
  if (found == texts.end()) found = texts.find(code.substr(0, code.find('.')));
  return found == texts.end() ? std::nullopt : std::optional(found->second);
}

using Translations = std::map<std::string, std::string, std::less<>>;

const Translations& translations() {
  static const Translations table = [] {
    Translations all;
    for (const char* section : {"said", "said_by_libraries"})
      for (const auto& [english, text] : texts_of(Language::chinese, section)) all.emplace(plain_key(english), text);
    for (const auto& [code, english] : texts_of(Language::english, "finding"))
      if (const auto text = chinese_of_finding(code); text && std::ranges::any_of(plain_key(english), is_letter))
        if (auto in_order = numbered(*text, Pattern(english, "").names))
          all.emplace(plain_key(english), std::move(*in_order));
    for (const auto& noun : nouns_of_findings())
      all.emplace("{} " + noun, "{0}"), all.emplace("{} " + noun + "s", "{0}");
    const auto phrases = texts_of(Language::chinese, "phrase");
    for (const auto& [key, english] : texts_of(Language::english, "phrase"))
      if (const auto text = phrases.find(key); text != phrases.end()) all.emplace(plain_key(english), text->second);
    return all;
  }();
  return table;
}

/// Whether a text that nobody has called a name has two plain words side by side. A list, "gyro, time", has none.
bool reads_like_english(std::string_view text) {
  std::size_t words = 0;
  while (!text.empty()) {
    const auto end = std::min(text.find(' '), text.size());
    auto word = text.substr(0, end);
    const bool last = !word.empty() && std::string_view(",;:.?!").find(word.back()) != word.npos;
    if (last) word.remove_suffix(1);
    const bool plain = word.size() > 1 && std::ranges::all_of(word, [](char c) { return c >= 'a' && c <= 'z'; });
    if (plain && ++words == 2) return true;
    if (!plain || last) words = 0;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return false;
}

std::optional<std::string> chinese(std::string_view pattern, const std::vector<Values>& values);

std::optional<std::string> chinese(const Sentence& said) {
  const Shape shape = shape_of(said.pattern, said.values);
  return chinese(shape.key, shape.values);
}

std::optional<std::string> chinese(const Values& side_by_side, bool quoted) {
  std::string text;
  for (const SentenceValue* value : side_by_side) {
    if (value->kind == SentenceValue::Kind::text && !quoted && reads_like_english(value->text)) return std::nullopt;
    if (value->kind != SentenceValue::Kind::sentence || value->nested.empty()) {
      text += value->names.empty() ? value->text : joined(value->names, "、");
      continue;
    }
    const auto nested = chinese(value->nested.front());
    if (!nested && !quoted) return std::nullopt;  // in quotes a word of the program is a name
    text += nested ? *nested : value->text;
  }
  return text;
}

/// Whether each place of a pattern stands in quotes, in order.
std::vector<bool> quoted_places(std::string_view pattern) {
  std::vector<bool> quoted;
  for (auto at = pattern.find("{}"); at != pattern.npos; at = pattern.find("{}", at + 2)) {
    const char before = at > 0 ? pattern[at - 1] : ' ', behind = at + 2 < pattern.size() ? pattern[at + 2] : ' ';
    quoted.push_back(before == behind && (before == '\'' || before == '"'));
  }
  return quoted;
}

/// The values at the places that the translation has; nothing where one of these has no Chinese.
std::optional<std::string> with_values_in(const std::string& translation, std::string_view pattern,
                                          const std::vector<Values>& values) {
  const auto quoted = quoted_places(pattern);
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < values.size(); ++i) {
    auto text = chinese(values[i], i < quoted.size() && quoted[i]);
    if (!text && translation.find("{" + std::to_string(i) + "}") != std::string::npos) return std::nullopt;
    texts.push_back(text.value_or(""));
  }
  return said::filled(translation, texts);
}

/// Whether a pattern has a word of English: letters alone, and marks behind them. An option or a key of a file, "--set
/// channels.{}", "[certificate]", has more.
bool has_words(std::string_view pattern) {
  while (!pattern.empty()) {
    const auto end = std::min(pattern.find(' '), pattern.size());
    auto word = pattern.substr(0, end);
    while (!word.empty() && std::string_view(",;:.?!").find(word.back()) != word.npos) word.remove_suffix(1);
    if (!word.empty() && std::ranges::all_of(word, is_letter)) return true;
    pattern.remove_prefix(std::min(end + 1, pattern.size()));
  }
  return false;
}

/// A pattern without words says the same in every language, in the marks of Chinese.
std::optional<std::string> wordless(std::string_view pattern) {
  if (has_words(pattern)) return std::nullopt;
  std::string text;
  std::size_t place = 0;
  bool open = false;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (pattern.substr(i).starts_with("{}"))
      text += "{" + std::to_string(place++) + "}", ++i;
    else if (pattern[i] == '\'')
      text += (open = !open) ? "“" : "”";
    else if (pattern.substr(i).starts_with(": "))
      text += "：", ++i;
    else if (text.ends_with('}') && pattern.substr(i).starts_with("; {}"))
      text += "；", ++i;
    else if (text.ends_with('}') && pattern.substr(i).starts_with(", {}"))
      text += "、", ++i;
    else
      text += pattern[i];
  }
  return text;
}

std::optional<std::string> chinese(std::string_view pattern, const std::vector<Values>& values) {
  if (pattern.empty()) return "";
  if (const auto found = translations().find(pattern); found != translations().end())
    return with_values_in(found->second, pattern, values);
  if (const auto text = wordless(pattern)) return with_values_in(*text, pattern, values);
  for (auto colon = pattern.find(": "); colon != pattern.npos; colon = pattern.find(": ", colon + 1)) {
    const auto left = pattern.substr(0, colon), right = pattern.substr(colon + 2);
    const auto places = static_cast<std::ptrdiff_t>(quoted_places(left).size());
    const auto split = values.begin() + std::min(places, std::ssize(values));
    const auto before = chinese(left, {values.begin(), split}), behind = chinese(right, {split, values.end()});
    if (before && behind) return *before + "：" + *behind;
  }
  return std::nullopt;
}

std::optional<std::string> chinese(const Problem& problem) {
  auto what = chinese(problem.what);
  if (!what || problem.where.place.empty()) return what;
  const auto place = chinese(problem.where.place);
  if (!place) return std::nullopt;
  return *place + "：" + *what;
}

}  // namespace

Sentence said_by_library(const std::string& text) {
  static const std::vector<Pattern> patterns = [] {
    std::vector<Pattern> all;
    for (const auto& [english, chinese] : texts_of(Language::chinese, "said_by_libraries"))
      all.emplace_back(english, plain_key(english));
    return all;
  }();
  const Pattern* best = nullptr;
  std::vector<std::string_view> values;
  for (const Pattern& pattern : patterns)
    if (!best || pattern.letters > best->letters)
      if (auto found = pattern.values_in(text)) best = &pattern, values = std::move(*found);
  if (!best) return Sentence(text.c_str());
  Sentence said;
  said.pattern = best->translation;
  for (const auto value : values) said.values.push_back({SentenceValue::Kind::name, std::string(value), 0.0, {}});
  return said;
}

std::string in_language(Language language, const Sentence& said) {
  if (language == Language::english) return said.text();
  if (said.pattern.find('\n') == std::string::npos) return chinese(said).value_or(said.text());
  std::string text;
  auto value = said.values.begin();
  for (std::size_t begin = 0; begin <= said.pattern.size();) {  // line by line; what a line is set in by stays
    const auto end = std::min(said.pattern.find('\n', begin), said.pattern.size());
    const auto first = std::min(said.pattern.find_first_not_of(' ', begin), end);
    Sentence line;
    line.pattern = said.pattern.substr(first, end - first);
    const auto count = std::min(std::ssize(quoted_places(line.pattern)), said.values.end() - value);
    line.values.assign(value, value + count);
    value += count;
    text += said.pattern.substr(begin, first - begin) + chinese(line).value_or(line.text());
    if (end < said.pattern.size()) text += '\n';
    begin = end + 1;
  }
  return text;
}

std::string in_language(Language language, const Problem& problem) {
  if (language == Language::english) return problem.text();
  if (problem.where.place.empty()) return in_language(language, problem.what);
  return chinese(problem).value_or(problem.text());
}

std::vector<std::string> in_language(Language language, const Problems& problems) {
  std::vector<std::string> texts;
  for (const Problem& problem : problems) texts.push_back(in_language(language, problem));
  return texts;
}

}  // namespace tumble
