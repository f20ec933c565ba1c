#include "tumble/station/requirement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {
namespace {

using Compare = Requirement::Compare;
using Step = Requirement::Step;

constexpr std::size_t deepest = 50;  ///< of parentheses and `not`

constexpr std::pair<std::string_view, Compare> signs[] = {{"<=", Compare::at_most}, {">=", Compare::at_least},
                                                          {"==", Compare::equal},   {"!=", Compare::unequal},
                                                          {"<", Compare::less},     {">", Compare::greater}};

constexpr std::pair<std::string_view, const char*> units_by_ending[] = {
    {".temperature", "degC"}, {".position", "deg"}, {".rate", "deg/s"}, {".voltage", "V"}, {".current", "A"}};

bool is_name_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
}

bool begins_number(std::string_view text) {
  if (text.empty()) return false;
  const char c = text.front() == '-' || text.front() == '+' ? (text.size() > 1 ? text[1] : 'x') : text.front();
  return (c >= '0' && c <= '9') || c == '.';
}

/// The value of a quantity that is compared with this channel.
double quantity_for(const std::string& channel, std::string_view text) {
  for (const auto& [ending, unit] : units_by_ending)
    if (channel.ends_with(ending)) return parse_si(text, Unit::parse(unit));
  const Quantity quantity = parse_quantity(text);
  return quantity.unit.to_si(quantity.value);
}

/// Reads by descent; each function leaves the text behind what it read.
class RequirementParser {
 public:
  explicit RequirementParser(std::string_view text) : rest_(text) { requirement_.text = text; }

  Requirement whole() {
    either(0);
    skip();
    if (!rest_.empty()) refuse("'and', 'or' or the end is expected");
    return std::move(requirement_);
  }

 private:
  void either(std::size_t depth) {
    both(depth);
    while (word("or")) {
      both(depth);
      requirement_.steps.push_back({Step::Kind::either, 0});
    }
  }

  void both(std::size_t depth) {
    single(depth);
    while (word("and")) {
      single(depth);
      requirement_.steps.push_back({Step::Kind::both, 0});
    }
  }

  void single(std::size_t depth) {
    if (depth > deepest) refuse("it is nested too deeply");
    if (word("not")) {
      single(depth + 1);
      requirement_.steps.push_back({Step::Kind::negate, 0});
    } else if (sign("(")) {
      either(depth + 1);
      if (!sign(")")) refuse("')' is expected");
    } else {
      comparison();
    }
  }

  void comparison() {
    Requirement::Term term;
    term.channel = name();
    if (term.channel == "abs" && sign("(")) {
      term.magnitude = true;
      term.channel = name();
      if (!sign(")")) refuse("')' is expected");
    }
    for (const auto& [text, compare] : signs)
      if (sign(text)) {
        term.compare = compare;
        right_side(term);
        break;
      }
    if (term.magnitude && term.compare == Compare::itself) refuse("a comparison is expected, for example < 1 deg/s");
    requirement_.steps.push_back({Step::Kind::term, requirement_.terms.size()});
    requirement_.terms.push_back(std::move(term));
  }

  /// A quantity, which extends to the next `and`, `or` or parenthesis that was not opened in it; or one word.
  void right_side(Requirement::Term& term) {
    skip();
    if (!begins_number(rest_)) {
      if (term.compare != Compare::equal && term.compare != Compare::unequal)
        refuse("a quantity with its unit is expected, for example 90 degC");
      if (term.magnitude) refuse("abs() is compared with a quantity");
      term.right = name();
      return;
    }
    std::size_t end = 0, open = 0;
    for (; end < rest_.size(); ++end) {
      if (rest_[end] == '(') ++open;
      if (rest_[end] == ')' && open-- == 0) break;
      const auto ahead = rest_.substr(end);
      if (ahead.starts_with(" and ") || ahead.starts_with(" or ")) break;
    }
    term.right = quantity_for(term.channel, trimmed(rest_.substr(0, end), " "));
    rest_.remove_prefix(end);
  }

  void skip() {
    while (!rest_.empty() && rest_.front() == ' ') rest_.remove_prefix(1);
  }

  bool sign(std::string_view text) {
    skip();
    if (!rest_.starts_with(text)) return false;
    rest_.remove_prefix(text.size());
    return true;
  }

  bool word(std::string_view text) {
    skip();
    if (!rest_.starts_with(text) || (rest_.size() > text.size() && is_name_letter(rest_[text.size()]))) return false;
    rest_.remove_prefix(text.size());
    return true;
  }

  std::string name() {
    skip();
    std::size_t size = 0;
    while (size < rest_.size() && is_name_letter(rest_[size])) ++size;
    const std::string text(rest_.substr(0, size));
    if (text.empty() || text == "and" || text == "or" || text == "not")
      refuse("a channel or a word is expected, for example chamber.temperature");
    rest_.remove_prefix(size);
    return text;
  }

  [[noreturn]] void refuse(const Sentence& why) const {
    throw Error(Error::Kind::bad_input,
                say("'{}': at character {}: {}", requirement_.text, requirement_.text.size() - rest_.size() + 1, why));
  }

  Requirement requirement_;
  std::string_view rest_;
};

Holds holds(bool yes) { return yes ? Holds::yes : Holds::no; }

Holds compare_numbers(Compare compare, double left, double right) {
  if (std::isnan(left)) return Holds::unknown;
  switch (compare) {
    case Compare::less:
      return holds(left < right);
    case Compare::at_most:
      return holds(left <= right);
    case Compare::greater:
      return holds(left > right);
    case Compare::at_least:
      return holds(left >= right);
    case Compare::equal:
      return holds(left == right);
    case Compare::unequal:
      return holds(left != right);
    case Compare::itself:
      break;
  }
  return holds(left != 0.0);
}

bool is_good_word(const std::string& word) {
  constexpr std::array<std::string_view, 5> good{"ok", "true", "yes", "on", "1"};
  return std::find(good.begin(), good.end(), word) != good.end();
}

Holds holds_term(const Requirement::Term& term, const ChannelReading& reading) {
  const auto* wanted = std::get_if<std::string>(&term.right);
  if (const auto* word = std::get_if<std::string>(&reading)) {
    if (term.compare == Compare::itself) return holds(is_good_word(*word));
    if (!wanted) return Holds::unknown;
    return holds((*word == *wanted) == (term.compare == Compare::equal));
  }
  const auto* value = std::get_if<double>(&reading);
  if (!value || wanted) return Holds::unknown;
  return compare_numbers(term.compare, term.magnitude ? std::abs(*value) : *value, std::get<double>(term.right));
}

Holds negated(Holds value) { return value == Holds::unknown ? value : holds(value == Holds::no); }

/// Kleene's logic: unknown only where the unknown part decides.
Holds both_of(Holds a, Holds b) {
  if (a == Holds::no || b == Holds::no) return Holds::no;
  return a == Holds::yes && b == Holds::yes ? Holds::yes : Holds::unknown;
}

}  // namespace

Requirement parse_requirement(std::string_view text) { return RequirementParser(text).whole(); }

Holds evaluate(const Requirement& requirement,
               const std::function<ChannelReading(const std::string& channel)>& observe) {
  std::vector<Holds> stack;
  const auto pop = [&] {
    const Holds value = stack.back();
    stack.pop_back();
    return value;
  };
  for (const auto& step : requirement.steps) {
    if (step.kind == Step::Kind::term) {
      const auto& term = requirement.terms[step.term];
      stack.push_back(holds_term(term, observe(term.channel)));
      continue;
    }
    const Holds last = pop();
    if (step.kind == Step::Kind::negate)
      stack.push_back(negated(last));
    else if (step.kind == Step::Kind::both)
      stack.push_back(both_of(pop(), last));
    else
      stack.push_back(negated(both_of(negated(pop()), negated(last))));
  }
  return stack.empty() ? Holds::unknown : stack.back();
}

}  // namespace tumble
