#include "tumble/units/sentence.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>

namespace tumble {

namespace {

std::string with_doubled_braces(std::string_view text) {
  std::string out;
  for (const char c : text) {
    out += c;
    if (c == '{' || c == '}') out += c;
  }
  return out;
}

/// One place of a value in a pattern: "{}", "{0}", "{:.3g}".
struct Field {
  std::size_t argument;
  std::string_view how;  ///< from the colon on
  std::size_t end;       ///< behind its brace
};

Field field_at(std::string_view pattern, std::size_t brace, std::size_t& next) {
  const std::size_t end = pattern.find('}', brace);
  const std::string_view inner = pattern.substr(brace + 1, end - brace - 1);
  const std::size_t colon = std::min(inner.find(':'), inner.size());
  std::size_t number = 0;
  if (colon == 0)
    number = next++;
  else
    std::from_chars(inner.data(), inner.data() + colon, number);
  return {number, inner.substr(colon), end + 1};
}

}  // namespace

Sentence::Sentence(const char* words) : pattern(with_doubled_braces(words)) {}

Sentence::Sentence(std::string text) {
  if (text.empty()) return;
  pattern = "{}";
  values.push_back({SentenceValue::Kind::text, std::move(text), 0.0, {}});
}

std::string Sentence::text() const {
  std::string out;
  auto value = values.begin();
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const bool doubled = i + 1 < pattern.size() && pattern[i + 1] == pattern[i];
    if (pattern[i] == '{' && !doubled) {
      if (value != values.end()) out += value->text, ++value;
      ++i;  // the other brace
    } else {
      out += pattern[i];
      if (doubled && (pattern[i] == '{' || pattern[i] == '}')) ++i;
    }
  }
  return out;
}

std::string Problem::text() const {
  return where.place.empty() ? what.text() : where.place.text() + ": " + what.text();
}

Problem in_file(const std::string& file, Problem problem) {
  return file.empty() ? problem : within(Where{.file = file, .place = say("{}", Name{file})}, std::move(problem));
}

Sentence sentence_of(const Problem& problem) {
  return problem.where.place.empty() ? problem.what : say("{}: {}", problem.where.place, problem.what);
}

std::vector<std::string> texts_of(const Problems& problems) {
  std::vector<std::string> texts;
  for (const Problem& problem : problems) texts.push_back(problem.text());
  return texts;
}

Problem within(Where outer, Problem problem) {
  Where& inner = problem.where;
  if (inner.file.empty()) {  // a line of one file is none of another
    inner.file = std::move(outer.file);
    if (inner.line == 0) inner.line = outer.line, inner.column = outer.column;
  }
  for (auto part : {&Where::table, &Where::key, &Where::channel})
    if ((inner.*part).empty()) inner.*part = std::move(outer.*part);
  if (!inner.time) inner.time = outer.time;
  if (inner.place.empty())
    inner.place = std::move(outer.place);
  else if (!outer.place.empty())
    inner.place = say("{}: {}", outer.place, inner.place);
  return problem;
}

namespace {

using Change = std::function<std::string(const std::string&)>;

void change_values(Sentence& said, const Change& change) {
  for (SentenceValue& value : said.values) {
    for (Sentence& nested : value.nested) {
      change_values(nested, change);
      value.text = nested.text();
    }
    for (std::string& one : value.names) one = change(one);
    if (value.nested.empty() && value.kind != SentenceValue::Kind::number) value.text = change(value.text);
  }
}

}  // namespace

Problem with_values(Problem problem, const Change& change) {
  change_values(problem.where.place, change);
  change_values(problem.what, change);
  problem.where.file = change(problem.where.file);
  return problem;
}

Problem named_from(const std::string& folder, Problem problem) {
  const std::string prefix = folder + "/";
  return with_values(std::move(problem), [&](std::string text) {
    for (auto at = text.find(prefix); at != std::string::npos; at = text.find(prefix)) text.erase(at, prefix.size());
    return text;
  });
}

namespace {

constexpr std::size_t most_bytes = 10'000;  ///< [bytes] chosen: no name and no remark is so long
constexpr std::size_t most_names = 200;     ///< [1] chosen: more than any catalogue has

bool continues(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }  // a character of UTF-8

/// Without its middle where it is too long to be read: a name of a file may have megabytes.
void shorten(std::string& text) {
  if (text.size() <= most_bytes) return;
  std::size_t begin = most_bytes / 2, end = text.size() - most_bytes / 2;
  while (begin > 0 && continues(text[begin])) --begin;
  while (end < text.size() && continues(text[end])) ++end;
  text.replace(begin, end - begin, " ... ");
}

void shorten(SentenceValue& value) {
  if (value.names.size() > most_names) {
    value.names.resize(most_names);
    value.names.emplace_back("...");
    for (std::string& one : value.names) shorten(one);
    value.text = fmt::format("{}", fmt::join(value.names, ", "));
  }
  if (value.nested.empty()) shorten(value.text);
}

}  // namespace

Sentence made_sentence(std::string_view pattern, fmt::format_args values, const SayArgument* arguments) {
  Sentence said;
  std::size_t next = 0;
  for (std::size_t i = 0; i < pattern.size();) {
    const bool doubled = i + 1 < pattern.size() && pattern[i + 1] == pattern[i];
    const bool brace = pattern[i] == '{' || pattern[i] == '}';
    if (!brace || doubled) {
      said.pattern.append(pattern.substr(i, brace ? 2 : 1));
      i += brace ? 2 : 1;
      continue;
    }
    const Field field = field_at(pattern, i, next);
    const SayArgument& argument = arguments[field.argument];
    SentenceValue value{argument.kind, "", argument.number, {}};
    if (value.kind == SentenceValue::Kind::text && in_quotes(pattern, i, field.end))
      value.kind = SentenceValue::Kind::name;
    value.text = fmt::vformat(fmt::format("{{{}{}}}", field.argument, field.how), values);
    if (argument.sentence) value.nested.push_back(*argument.sentence);
    if (argument.problem) value.nested.push_back(sentence_of(*argument.problem));
    if (argument.words) value.nested.emplace_back(argument.words);
    if (argument.list) value.names = argument.names_of(argument.list);
    shorten(value);
    said.pattern += "{}";
    said.values.push_back(std::move(value));
    i = field.end;
  }
  return said;
}

Sentence in_a_row(const std::vector<Sentence>& parts, std::string_view between) {
  Sentence said;
  for (const Sentence& part : parts) {
    if (!said.pattern.empty()) said.pattern += between;
    said.pattern += "{}";
    said.values.push_back({SentenceValue::Kind::sentence, part.text(), 0.0, {part}});
  }
  return said;
}

}  // namespace tumble
