#include "tumble/core/finding.hpp"

#include <fmt/args.h>
#include <fmt/format.h>

#include <array>

#include "tumble/core/message_in.hpp"
#include "tumble/core/say.hpp"
#include "tumble/core/text.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace {

std::string say(double value, const Unit& unit, std::string_view how) {
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

struct Say {
  const Unit& unit;
  std::string_view how;
  Language language;

  std::string operator()(double value) const {
    std::string text = say(value, unit, how);
    if (language == Language::chinese && text.ends_with(" %")) text.erase(text.size() - 2, 1);  // 95% there
    return text;
  }
  std::string operator()(long long value) const {
    if (how == "bytes") return say_bytes(static_cast<std::size_t>(value));
    return how.empty() ? std::to_string(value) : say_count(static_cast<std::size_t>(value), std::string(how));
  }
  std::string operator()(const std::string& value) const { return value; }
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
    throw Error(Error::Kind::internal, "the sentence of the finding '" + finding.code + "': " + error.what());
  }
}

}  // namespace

std::string message_in(Language language, const Finding& finding) {
  if (language == Language::english || finding.code.empty()) return finding.message;
  try {
    return filled(text_of(language, "finding", finding.code, finding.occurrences.count), finding, language);
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

std::vector<std::string> errors_among(const Findings& findings) {
  std::vector<std::string> problems;
  for (const Finding& finding : findings)
    if (finding.severity == Finding::Severity::error)
      problems.push_back(finding.where.empty() ? finding.message : finding.where + ": " + finding.message);
  return problems;
}

}  // namespace tumble
