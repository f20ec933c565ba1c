#include "tumble/core/settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "tumble/language/say.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {

namespace {

constexpr std::size_t longest_list = 10000;

template <class Map>
const auto& value_in(const Map& values, std::string_view name) {
  const auto found = values.find(name);
  if (found == values.end())
    throw Error(Error::Kind::internal, say("the setting '{}' was asked for but has no value", std::string(name)));
  return found->second;
}

std::optional<int> whole_number(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  return as_number<int>(text);
}

[[noreturn]] void refuse(Sentence problem) { throw Error(Error::Kind::bad_input, std::move(problem)); }

/// "1,2,5-8", with or without brackets around.
std::vector<int> integer_list(std::string_view text) {
  const Name shown{std::string(text)};
  text = trimmed(text);
  if (text.starts_with('[') && text.ends_with(']')) text = text.substr(1, text.size() - 2);
  std::vector<int> values;
  while (!trimmed(text).empty()) {
    const std::size_t comma = text.find(',');
    const std::string_view item = trimmed(text.substr(0, comma));
    text = comma == text.npos ? std::string_view{} : text.substr(comma + 1);
    const std::size_t dash = item.find('-', 1);
    const auto first = whole_number(item.substr(0, dash));
    const auto last = dash == item.npos ? first : whole_number(item.substr(dash + 1));
    if (!first || !last) refuse(say("'{}': integers expected, for example '1,2,5-8'", shown));
    if (*last < *first) refuse(say("'{}': the range '{}' runs backwards", shown, std::string(item)));
    if (static_cast<std::size_t>(static_cast<long>(*last) - *first) + values.size() >= longest_list)
      refuse(say("'{}': more than {} integers", shown, longest_list));
    for (int value = *first; value <= *last; ++value) values.push_back(value);
  }
  if (values.empty()) refuse(say("'{}': integers expected, for example '1,2,5-8'", shown));
  return values;
}

/// Whether a number [unit of the option] lies in the range; the last digit of a conversion between units is forgiven.
bool inside(const Range& range, double value) {
  const double rounding = 1e-12 * std::abs(value);
  return std::isfinite(value) && (range.least_open ? value > range.least : value >= range.least - rounding) &&
         (range.most_open ? value < range.most : value <= range.most + rounding);
}

void refuse_outside(const Option& option, double value, const Name& shown) {
  if (inside(option.range, value)) return;
  const Sentence wanted = std::isfinite(value) ? said_of(option.range, option.unit) : Sentence("finite");
  refuse(say("'{}': the value must be {}", shown, wanted));
}

double quantity_of(const Option& option, const Given& given) {
  const Unit unit = Unit::parse(option.unit);
  if (given.command_line && option.bare_on_command_line)
    if (const Quantity number = parse_quantity(given.text); number.bare) return unit.to_si(number.value);
  return parse_si(given.text, unit);
}

/// Reads one value into `settings`, or throws Error::bad_input.
void read_value(const Option& option, const Given& given, Settings& settings) {
  const Name shown{given.text};
  switch (option.type) {
    case Option::Type::quantity:
      settings.set_number(option.name, quantity_of(option, given), Unit::parse(option.unit));
      return refuse_outside(option, Unit::parse(option.unit).from_si(settings.number(option.name)), shown);
    case Option::Type::integer: {
      const auto value = whole_number(given.text);
      if (!value) refuse(say("'{}': an integer expected", shown));
      refuse_outside(option, *value, shown);
      return settings.set_integer(option.name, *value);
    }
    case Option::Type::flag:
      if (given.text != "true" && given.text != "false") refuse(say("'{}': true or false expected", shown));
      return settings.set_flag(option.name, given.text == "true");
    case Option::Type::integers:
      for (const int value : integer_list(given.text)) refuse_outside(option, value, shown);
      return settings.set_integers(option.name, integer_list(given.text));
    case Option::Type::word:
      if (std::find(option.words.begin(), option.words.end(), given.text) == option.words.end())
        refuse(say("'{}': expected one of {}{}", shown, fmt::join(option.words, ", "),
                   did_you_mean(given.text, option.words)));
      return settings.set_word(option.name, given.text);
    case Option::Type::text:
      return settings.set_word(option.name, given.text);
  }
}

Sentence unknown_key(const std::vector<Option>& options, const std::string& key) {
  std::vector<std::string> known;
  for (const Option& option : options) known.push_back(option.name);
  const Sentence advice = did_you_mean(key, known);
  if (!advice.empty()) return say("unknown key '{}'{}", key, advice);
  if (known.empty()) return say("unknown key '{}'; none is accepted", key);
  constexpr std::size_t most = 20;
  const std::size_t count = known.size();
  if (count <= most) return say("unknown key '{}'; known are {}", key, fmt::join(known, ", "));
  known.resize(most);
  return say("unknown key '{}'; known are {}, ... ({} in all: `tumble list`)", key, fmt::join(known, ", "), count);
}

}  // namespace

bool Settings::has(std::string_view name) const {
  return numbers_.contains(name) || integers_.contains(name) || words_.contains(name) || lists_.contains(name);
}
double Settings::number(std::string_view name) const { return value_in(numbers_, name); }
int Settings::integer(std::string_view name) const { return value_in(integers_, name); }
const std::string& Settings::word(std::string_view name) const { return value_in(words_, name); }
bool Settings::flag(std::string_view name) const { return value_in(integers_, name) != 0; }
const std::vector<int>& Settings::integers(std::string_view name) const { return value_in(lists_, name); }

void Settings::set_number(const std::string& name, double value_si, const Unit& shown_in) {
  numbers_[name] = value_si;
  texts_[name] = say_value(value_si, shown_in);
}

void Settings::set_integer(const std::string& name, int value) {
  integers_[name] = value;
  texts_[name] = std::to_string(value);
}

void Settings::set_word(const std::string& name, std::string value) {
  texts_[name] = value;
  words_[name] = std::move(value);
}

void Settings::set_flag(const std::string& name, bool value) {
  integers_[name] = value;
  texts_[name] = value ? "true" : "false";
}

void Settings::set_integers(const std::string& name, std::vector<int> values) {
  std::string text;
  for (const int value : values) text += (text.empty() ? "" : ",") + std::to_string(value);
  texts_[name] = text;
  lists_[name] = std::move(values);
}

Settings resolve(const std::vector<Option>& options, const std::vector<Given>& given, const Sentence& what,
                 Problems& problems) {
  Settings settings;
  const auto complain = [&](const Given& value, Problem problem) {
    problem = within(Where{.table = what.text(), .place = what}, std::move(problem));
    problems.push_back(within(value.where, std::move(problem)));
  };
  const auto read = [&](const Option& option, const Given& value) {
    try {
      read_value(option, value, settings);
    } catch (const Error& error) {
      for (const auto& problem : error.problems)
        complain(value, within(Where{.key = option.name, .place = say("{}", Name{option.name})}, problem));
    }
  };
  for (const Option& option : options)
    if (!option.fallback.empty()) read(option, {option.name, option.fallback, "default"});
  for (const Given& value : given) {
    const auto option =
        std::find_if(options.begin(), options.end(), [&](const Option& o) { return o.name == value.key; });
    if (option != options.end())
      read(*option, value);
    else
      complain(value, unknown_key(options, value.key));
  }
  return settings;
}

Settings defaults(const std::vector<Option>& options) {
  Problems problems;
  Settings settings = resolve(options, {}, "defaults", problems);
  if (!problems.empty()) throw Error(Error::Kind::internal, problems);
  return settings;
}

}  // namespace tumble
