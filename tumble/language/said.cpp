#include "tumble/language/said.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <set>

#include "tumble/language/texts.hpp"

namespace tumble {

namespace {

/// Sentences within sentences, no deeper.
constexpr int deepest = 4;

/// Letters of a sentence that is not taken for another.
constexpr std::size_t sure = 16;

/// An English sentence: what stands before, between and behind its values; two values side by side are one.
struct SaidPattern {
  std::vector<std::string> pieces{""};
  std::size_t letters = 0;         ///< of all pieces: the greater, the surer is a match
  std::vector<std::string> names;  ///< of the values: what stands in their braces, up to a colon
  std::string translation;         ///< with the values as {0}, {1}

  SaidPattern(std::string_view english, std::string in_language) : translation(std::move(in_language)) {
    for (std::size_t i = 0; i < english.size(); ++i) {
      const bool doubled = i + 1 < english.size() && english[i + 1] == english[i];
      if (english[i] == '{' && !doubled) {
        const auto name = english.substr(i + 1, english.find_first_of(":}", i) - i - 1);
        i = english.find('}', i);
        if (pieces.size() == 1 || !pieces.back().empty()) names.emplace_back(name);
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

/// "{lost} ... {first:instant}" as "{0} ... {1}", by the names of the values in English; none where one has no place
/// there.
std::optional<std::string> numbered(const std::string& named, const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < named.size(); ++i) {
    text += named[i];
    if (named[i] != '{') continue;
    const auto name = named.substr(i + 1, named.find_first_of(":}", i) - i - 1);
    const auto found = std::ranges::find(names, name);
    if (name.empty() || found == names.end()) return std::nullopt;
    text += std::to_string(found - names.begin()) + "}";
    i = named.find('}', i);
  }
  return text;
}

/// Findings that are the reason of a refusal: its problem is their sentence, whose code is not known any more.
void add_findings(std::vector<SaidPattern>& patterns, Language language) {
  const auto texts = texts_of(language, "finding");
  for (const auto& [code, english] : texts_of(Language::english, "finding")) {
    SaidPattern pattern(english, "");
    const auto text = texts.find(code);
    if (text == texts.end() || pattern.letters < sure) continue;
    if (auto translation = numbered(text->second, pattern.names)) {
      pattern.translation = std::move(*translation);
      patterns.push_back(std::move(pattern));
    }
  }
}

/// A table of sentences: those without values by themselves, the others as patterns.
struct SaidTable {
  std::map<std::string, std::string, std::less<>> whole;
  std::vector<SaidPattern> patterns;
  bool words = false;  ///< of names: a value that is one word is looked up, too, and "_" is the same as a blank

  void add(const std::string& english, const std::string& text) {
    SaidPattern pattern(looked_up(english), text);
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

bool is_han(std::string_view letter) {
  return letter.size() == 3 && static_cast<unsigned char>(letter[0]) >= 0xe3 &&
         static_cast<unsigned char>(letter[0]) <= 0xe9;
}

std::string_view last_letter(std::string_view text) {
  auto begin = text.size();
  while (begin > 0 && (static_cast<unsigned char>(text[--begin]) & 0xc0) == 0x80) {
  }
  return text.substr(begin);
}

/// Appends what follows. A blank stands between Chinese and Latin letters alone: where a value turned out to be
/// Chinese, it goes.
void append(std::string& text, std::string_view more) {
  const bool ends = text.ends_with(' ') && is_han(last_letter(std::string_view(text).substr(0, text.size() - 1)));
  if (ends && is_han(more.substr(0, 3))) text.pop_back();
  if (more.starts_with(' ') && is_han(more.substr(1, 3)) && is_han(last_letter(text))) more.remove_prefix(1);
  text += more;
}

/// The values at {0}, {1}, ...
std::string filled(std::string_view translation, const std::vector<std::string>& values) {
  std::string text;
  for (std::size_t begin = 0; begin < translation.size();) {
    const auto brace = std::min(translation.find_first_of("{}", begin), translation.size());
    if (brace > begin) append(text, translation.substr(begin, brace - begin));
    if (brace == translation.size()) break;
    const auto end = translation[brace] == '{' ? translation.find('}', brace) : translation.npos;
    const auto number = end == translation.npos ? "" : translation.substr(brace + 1, end - brace - 1);
    if (!number.empty() && number.find_first_not_of("0123456789") == number.npos) {
      const auto index = std::stoul(std::string(number));
      if (index < values.size() && !values[index].empty()) append(text, values[index]);
      begin = end + 1;
    } else {  // a brace that is written twice
      text += translation[brace];
      begin = brace + 2;
    }
  }
  return text;
}

/// Whether a pattern is short and between two values, "{} over {}": it is taken for one only where the values have no
/// English words.
bool is_loose(const SaidPattern& pattern) {
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
  if (const auto found = table.whole.find(looked); found != table.whole.end()) return filled(found->second, {});
  if (auto text = halves_translated(table, english, depth)) return text;
  const SaidPattern* best = nullptr;
  std::vector<std::string_view> values;
  for (const SaidPattern& pattern : table.patterns) {
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
  return filled(best->translation, said);
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

/// "sample" of "{lost:sample}", or of said_count(): Chinese has its counting word in the sentence, and the number alone
/// as value.
std::set<std::string> nouns_of_findings() {
  std::set<std::string> nouns{"count", "stamp", "step"};  // of refusals
  for (const auto& [code, english] : texts_of(Language::english, "finding"))
    for (auto colon = english.find(':'); colon != english.npos; colon = english.find(':', colon + 1)) {
      const auto end = english.find_first_not_of("abcdefghijklmnopqrstuvwxyz ", colon + 1);
      if (end != english.npos && end > colon + 1 && english[end] == '}')
        nouns.insert(english.substr(colon + 1, end - colon - 1));
    }
  return nouns;
}

using Translations = std::map<std::string, std::string, std::less<>>;

const Translations& translations() {
  static const Translations table = [] {
    Translations all;
    for (const char* section : {"said", "said_by_libraries"})
      for (const auto& [english, text] : texts_of(Language::chinese, section)) all.emplace(plain_key(english), text);
    const auto texts = texts_of(Language::chinese, "finding");
    for (const auto& [code, english] : texts_of(Language::english, "finding"))
      if (const auto text = texts.find(code); text != texts.end())
        if (auto in_order = numbered(text->second, SaidPattern(english, "").names))
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

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

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
    if (value->kind == SentenceValue::Kind::text && !quoted && reads_like_english(value->text)) {
      const auto found = translations().find(Sentence(value->text.c_str()).pattern);  // of a library: "File too large"
      if (found == translations().end()) return std::nullopt;
      text += filled(found->second, {});
      continue;
    }
    if (value->kind != SentenceValue::Kind::sentence || value->nested.empty()) {
      text += value->text;
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
  return filled(translation, texts);
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
