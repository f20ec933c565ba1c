#include "tumble/core/finding.hpp"

#include <fmt/args.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <variant>

#include "tumble/core/message_in.hpp"
#include "tumble/language/said.hpp"
#include "tumble/language/say.hpp"
#include "tumble/language/text.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace {

std::string value_text(double value, const Unit& unit, std::string_view how) {
  if (how == "exact") return say_value(value, unit);
  if (how == "difference") return say_difference(value, unit);
  if (how == "duration") return say_seconds(value);
  if (how == "instant") return say_instant(value);
  const std::size_t space = how.find(' ');
  const std::string digits(space == 0 || how.empty() ? ".4g" : how.substr(0, space));
  const std::string_view other = space == how.npos ? std::string_view{} : how.substr(space + 1);
  const Unit shown = other.empty() || other == "-" ? unit : Unit::parse(other);
  std::string number = fmt::format(fmt::runtime("{:" + digits + "}"), shown.from_si(value));
  if (number.starts_with('-') && number.find_first_not_of("-0.") == number.npos) number.erase(0, 1);  // -0.0
  return shown.text() == "1" || other == "-" ? number : number + " " + shown.text();
}

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  for (auto at = text.find(from); at != text.npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

/// A list in the marks of Chinese, which text/zh.toml asks for by "{terms:list}": "a, b", or "'a', 'b'".
std::string chinese_list(const std::string& list) {
  if (!list.starts_with('\'') || !list.ends_with('\'') || list.size() < 2) return replaced(list, ", ", "、");
  return "“" + replaced(list.substr(1, list.size() - 2), "', '", "”、“") + "”";
}

struct Say {
  const Unit& unit;
  std::string_view how;
  Language language;

  std::string operator()(double value) const {
    std::string text = value_text(value, unit, how);
    if (language == Language::chinese && text.ends_with(" %")) text.erase(text.size() - 2, 1);  // 95% there
    return text;
  }
  std::string operator()(long long value) const {
    if (how == "bytes") return say_bytes(static_cast<std::size_t>(value));
    return how.empty() ? std::to_string(value) : say_count(static_cast<std::size_t>(value), std::string(how));
  }
  std::string operator()(const std::string& value) const {
    return how == "list" && language == Language::chinese ? chinese_list(value) : value;
  }
  std::string operator()(const Phrase& phrase) const {
    return phrase.english.empty() ? text_of(language, "phrase", phrase.key) : phrase.english;
  }
};

/// A value on its way into a sentence of this language.
struct SaidValue {
  FindingValue value;
  Language language;
};

FindingValue value_of(const char* name, const Place& place) {
  if (!place.label.empty()) return {name, place.label};
  return {name, say_instant(place.time)};
}

std::string filled(const std::string& sentence, const Finding& finding, Language language);

}  // namespace

}  // namespace tumble

/// What follows the colon is ours (see `sentence`).
template <>
struct fmt::formatter<tumble::SaidValue> {
  std::string_view how;

  constexpr auto parse(fmt::format_parse_context& context) {
    const auto* end = context.begin();
    while (end != context.end() && *end != '}') ++end;
    how = {context.begin(), static_cast<std::size_t>(end - context.begin())};
    return end;
  }
  auto format(const tumble::SaidValue& said, fmt::format_context& context) const {
    const auto& [value, language] = said;
    if (!value.words.empty()) return fmt::format_to(context.out(), "{}", tumble::in_language(language, value.words));
    return fmt::format_to(context.out(), "{}", std::visit(tumble::Say{value.unit, how, language}, value.value));
  }
};

namespace tumble {

Finding::Finding(Severity how_severe, Phrase what, std::vector<FindingValue> with, std::string place, Occurrences often)
    : severity(how_severe),
      code(std::move(what.key)),
      where(std::move(place)),
      values(std::move(with)),
      occurrences(std::move(often)) {
  message = what.english.empty() ? sentence(*this) : filled(what.english, *this);
}

Finding::Finding(Severity how_severe, std::string what, std::vector<FindingValue> with, std::string place,
                 Occurrences often)
    : Finding(how_severe, Phrase{std::move(what)}, std::move(with), std::move(place), std::move(often)) {}

std::string sentence(const Finding& finding) {
  return filled(text_of("finding", finding.code, finding.occurrences.count), finding);
}

std::string filled(const std::string& sentence, const Finding& finding) {
  return filled(sentence, finding, Language::english);
}

namespace {

std::string filled(const std::string& sentence, const Finding& finding, Language language) {
  const Occurrences& often = finding.occurrences;
  fmt::dynamic_format_arg_store<fmt::format_context> store;
  const auto add = [&](const char* name, const FindingValue& value) {
    store.push_back(fmt::arg(name, SaidValue{value, language}));
  };
  for (const FindingValue& value : finding.values) add(value.name.c_str(), value);
  add("count", FindingValue("count", often.count));
  add("first", value_of("first", often.first));  // of a stamp that is NaN: "nan s"
  add("worst", value_of("worst", often.worst));
  try {
    return fmt::vformat(sentence, store);
  } catch (const fmt::format_error& error) {
    throw Error(Error::Kind::internal, say("the sentence of the finding '{}': {}", finding.code, error.what()));
  }
}

}  // namespace

std::string message_in(Language language, const Finding& finding) {
  if (language == Language::english || finding.code.empty()) return finding.message;
  try {
    const auto text = filled(text_of(language, "finding", finding.code, finding.occurrences.count), finding, language);
    return replaced(replaced(text, " “", "“"), "” ", "”");  // a list of names in quotes brings its marks along
  } catch (const Error&) {
    return finding.message;
  }
}

std::string placed_message_in(Language language, const Finding& finding) {
  const std::string message = message_in(language, finding);
  if (finding.where.empty()) return message;
  return finding.where + (language == Language::chinese ? "：" : ": ") + message;
}

std::string severity_in(Language language, Finding::Severity severity) {
  constexpr std::array keys{"info", "warning", "error"};
  return text_of(language, "terminal", keys[static_cast<std::size_t>(severity)]);
}

namespace {

/// One value of a finding as its sentence has it, "{lost:sample}": a count with its noun is a sentence of its own.
SentenceValue said_value(const Finding& finding, std::string_view field) {
  using Kind = SentenceValue::Kind;
  const std::string text = filled(std::string(field), finding);
  const auto inner = field.substr(1, field.size() - 2);
  const auto colon = std::min(inner.find(':'), inner.size());
  const auto found = std::ranges::find(finding.values, inner.substr(0, colon), &FindingValue::name);
  const std::size_t blank = text.find(' ');
  const auto* count = found == finding.values.end() ? nullptr : std::get_if<long long>(&found->value);
  if (count && colon < inner.size() && !inner.ends_with(":bytes") && blank != text.npos) {
    Sentence nested;
    nested.pattern = "{}" + text.substr(blank);
    nested.values.push_back({Kind::number, text.substr(0, blank), static_cast<double>(*count), {}});
    return {Kind::sentence, text, 0.0, {nested}};
  }
  if (found != finding.values.end() && !found->words.empty()) return {Kind::sentence, text, 0.0, {found->words}};
  if (found != finding.values.end() && std::holds_alternative<Phrase>(found->value))
    return {Kind::sentence, text, 0.0, {Sentence(text.c_str())}};
  const auto* number = found == finding.values.end() ? nullptr : std::get_if<double>(&found->value);
  return {number ? Kind::number : Kind::name, text, number ? *number : 0.0, {}};
}

}  // namespace

Sentence said_of(const Finding& finding) try {
  const std::string pattern = text_of("finding", finding.code, finding.occurrences.count);
  Sentence said;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const bool doubled = i + 1 < pattern.size() && pattern[i + 1] == pattern[i];
    if (pattern[i] == '{' && !doubled) {
      const auto end = pattern.find('}', i);
      said.values.push_back(said_value(finding, std::string_view(pattern).substr(i, end + 1 - i)));
      said.pattern += "{}";
      i = end;
    } else {
      said.pattern += pattern[i];
      if (doubled && (pattern[i] == '{' || pattern[i] == '}')) said.pattern += pattern[++i];
    }
  }
  return said.text() == finding.message ? said : Sentence(finding.message.c_str());
} catch (const Error&) {  // of a method of one's own, whose sentence no table has
  return Sentence(finding.message.c_str());
}

bool is_about_limit(const Finding& finding) {
  return finding.code == "limit_without_parameter" || finding.code == "limit_near_parameter";
}

Problems errors_among(const Findings& findings) {
  Problems problems;
  for (const Finding& finding : findings)
    if (finding.severity == Finding::Severity::error) {
      const Problem problem = said_of(finding);
      problems.push_back(finding.where.empty() ? problem : within(say("{}", Name{finding.where}), problem));
    }
  return problems;
}

}  // namespace tumble
