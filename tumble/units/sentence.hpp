#pragma once

#include <fmt/core.h>

#include <array>
#include <concepts>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace tumble {

struct SentenceValue;

/// A sentence for people: its English pattern and its values. The text is made where it is shown, in the language of
/// the reader (language/said.hpp).
struct Sentence {
  std::string pattern;                ///< "cannot read '{}': {}", each value as {}: the key of the translation
  std::vector<SentenceValue> values;  ///< in the order of their places

  Sentence() = default;
  /// Words of the program without values.
  Sentence(const char* words);
  /// A text from elsewhere, which has no translation: what the program says itself is made by say().
  explicit Sentence(std::string text);

  bool empty() const { return pattern.empty(); }
  std::string text() const;  ///< in English
  operator std::string() const { return text(); }
  friend bool operator==(const Sentence& a, const Sentence& b) { return a.text() == b.text(); }
};

/// One value of a sentence: a name, a text of a file, a number, or a sentence in it.
struct SentenceValue {
  enum class Kind {
    name,     ///< of a file, a channel, a unit: never translated
    text,     ///< not known to be a name: where it reads like English words, the sentence stays English
    number,   ///< `number`, as `text` shows it
    sentence  ///< `nested`
  };
  Kind kind = Kind::text;
  std::string text;                     ///< as in the English sentence
  double number = 0.0;                  ///< as given, in no unit
  std::vector<Sentence> nested;         ///< one where kind is sentence
  std::vector<std::string> names = {};  ///< where it is a list of names, fmt::join(names, ", "), each of them
};

/// A value of a sentence that is never translated: a path, a name.
struct Name {
  std::string text;
};

/// Where a problem is. Each may be absent.
struct Where {
  std::string file = {};
  std::size_t line = 0;    ///< from 1 on; 0: absent
  std::size_t column = 0;  ///< of a table of text, from 1 on; 0: absent
  std::string table = {}, key = {}, channel = {};
  std::optional<double> time = {};  ///< [s] on the recording's clock
  Sentence place = {};              ///< how English says it before the colon: "plan.toml:7: [rig]"
};

/// One thing that is wrong, and where.
struct Problem {
  Where where;
  Sentence what;

  Problem() = default;
  Problem(Sentence said) : what(std::move(said)) {}
  Problem(Where place, Sentence said) : where(std::move(place)), what(std::move(said)) {}
  Problem(const char* words) : what(words) {}

  std::string text() const;  ///< in English: "plan.toml:7: [rig]: a table is expected"
  operator std::string() const { return text(); }
  friend bool operator==(const Problem& a, const Problem& b) { return a.text() == b.text(); }
};

using Problems = std::vector<Problem>;

/// The English texts of problems.
std::vector<std::string> texts_of(const Problems& problems);

/// The problem as seen from further outside: "--set rate=x: " before it. What `outer` says of the place is added to
/// what is known already.
Problem within(Where outer, Problem problem);
inline Problem within(Sentence place, Problem problem) {
  return within(Where{.place = std::move(place)}, std::move(problem));
}

/// The problem with its file before it; unchanged where the file has no name.
Problem in_file(const std::string& file, Problem problem);

/// In one sentence, the place before a colon: "plan.toml:7: [rig]: a table is expected". Pattern and values stay.
Sentence sentence_of(const Problem& problem);

/// The problem with other texts of its values and its place; words and patterns stay.
Problem with_values(Problem problem, const std::function<std::string(const std::string&)>& change);
/// The problem with names of files relative to a folder: the reader does not know where that folder lies.
Problem named_from(const std::string& folder, Problem problem);

/// Kind and number of an argument of `say`; its text comes from the format arguments.
struct SayArgument {
  SentenceValue::Kind kind = SentenceValue::Kind::text;
  double number = 0.0;
  const Sentence* sentence = nullptr;
  const Problem* problem = nullptr;
  const char* words = nullptr;  ///< of the program: a sentence without values
  const void* list = nullptr;   ///< of names, which `names_of` reads
  std::vector<std::string> (*names_of)(const void* list) = nullptr;
};

/// fmt::join(names, ", ")
template <class T>
concept JoinedNames = requires(const T& list) {
  list.begin != list.end, list.sep.size();
};

template <JoinedNames List>
std::vector<std::string> names_in(const void* list) {
  std::vector<std::string> names;
  const List& joined = *static_cast<const List*>(list);
  for (auto one = joined.begin; one != joined.end; ++one) names.push_back(fmt::format("{}", *one));
  return names;
}

/// Whether the place of a value, from `begin` to behind its brace, stands in quotes.
constexpr bool in_quotes(std::string_view pattern, std::size_t begin, std::size_t end) {
  if (begin == 0 || end >= pattern.size() || pattern[begin - 1] != pattern[end]) return false;
  return pattern[end] == '\'' || pattern[end] == '"' || pattern[end] == '`';
}

/// The sentence that `say` returns, with one of `arguments` for each of `values`.
Sentence made_sentence(std::string_view pattern, fmt::format_args values, const SayArgument* arguments);

inline SayArgument say_argument(const Name&) { return {.kind = SentenceValue::Kind::name}; }
inline SayArgument say_argument(const Sentence& said) {
  return {.kind = SentenceValue::Kind::sentence, .sentence = &said};
}
inline SayArgument say_argument(const Problem& problem) {
  return {.kind = SentenceValue::Kind::sentence, .problem = &problem};
}
inline SayArgument say_argument(const char* words) { return {.kind = SentenceValue::Kind::sentence, .words = words}; }
template <class T>
constexpr bool is_say_text =
    std::same_as<T, std::string> || std::same_as<T, std::string_view> || std::same_as<T, char*>;
template <class T>
SayArgument say_argument(const T& value) {
  if constexpr (is_say_text<T>)
    return {.kind = SentenceValue::Kind::text};
  else if constexpr (JoinedNames<T>)
    return {.kind = SentenceValue::Kind::name,
            .list = std::string_view(value.sep.data(), value.sep.size()) == ", " ? &value : nullptr,
            .names_of = names_in<T>};
  else if constexpr (std::is_array_v<T>)
    return say_argument(static_cast<const char*>(value));
  else if constexpr (std::is_arithmetic_v<T> && !std::same_as<T, bool> && !std::same_as<T, char>)
    return {.kind = SentenceValue::Kind::number, .number = static_cast<double>(value)};
  else
    return {.kind = SentenceValue::Kind::name};
}

/// The English pattern of a sentence, checked when it is compiled: as fmt checks it, and each text (std::string) stands
/// in quotes. A text outside of quotes is a Name, or a Sentence where it has words: else nobody knows which. The kind
/// of a value follows from its type: a number, a Name, a Sentence, a Problem (a sentence with its place before it),
/// words of the program (const char*), a text.
template <class... Values>
struct SayPattern {
  std::string_view english;

  template <std::convertible_to<std::string_view> Literal>
  consteval SayPattern(const Literal& literal) : english(literal) {
    [[maybe_unused]] const fmt::format_string<Values...> checked(literal);
    constexpr std::array<bool, sizeof...(Values) + 1> is_text{is_say_text<Values>...};
    std::size_t next = 0;
    for (std::size_t i = 0; i < english.size(); ++i) {
      if (english[i] != '{') continue;
      const char first = english[i + 1];
      if (first == '{') {
        ++i;
        continue;
      }
      const std::size_t value = first >= '0' && first <= '9' ? static_cast<std::size_t>(first - '0') : next++;
      const std::size_t end = english.find('}', i);
      if (is_text[value] && !in_quotes(english, i, end + 1)) throw "this text is a Name or a Sentence";
      i = end;
    }
  }
};

/// A sentence from its English pattern: say("cannot read '{}': {}", path, reason). The kind of a value follows from its
/// type: a number, a Name, a Sentence, a Problem (a sentence with its place before it), words of the program
/// (const char*), a text, which stands in quotes and is a name.
template <class... Values>
Sentence say(SayPattern<std::type_identity_t<Values>...> pattern, const Values&... values) {
  const std::array<SayArgument, sizeof...(Values) + 1> arguments{say_argument(values)...};
  return made_sentence(pattern.english, fmt::make_format_args(values...), arguments.data());
}

/// Sentences one after the other with `between`, "; " or ", ", between them.
Sentence in_a_row(const std::vector<Sentence>& parts, std::string_view between);

inline std::string shown_text(const Sentence& said) { return said.text(); }
inline std::string shown_text(const Problem& problem) { return problem.text(); }
inline const std::string& shown_text(const Name& name) { return name.text; }

}  // namespace tumble

template <class Shown>
requires std::same_as<Shown, tumble::Sentence> || std::same_as<Shown, tumble::Problem> ||
    std::same_as<Shown, tumble::Name>
struct fmt::formatter<Shown, char> {
  constexpr auto parse(fmt::format_parse_context& context) { return context.begin(); }
  template <class Context>
  auto format(const Shown& shown, Context& context) const {
    auto out = context.out();
    for (const char c : tumble::shown_text(shown)) *out++ = c;
    return out;
  }
};
