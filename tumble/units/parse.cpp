// The grammar of units, read by recursive descent:
//   unit     = power { ("/" | "*" | "·") power }             from left to right: deg/h/g = (deg/h)/g
//   power    = factor [ ("^" | "**") exponent | superscript | digit ]                  superscripts: ² ³ ⁻¹ ⁻²
//   factor   = word | "(" unit ")" | "sqrt" "(" unit ")" | "√" factor
//   exponent = ["-"] number | "(" ["-"] integer ["/" integer] ")"          in halves: 2, 0.5, -1.5, (1/2)
#include <cmath>
#include <cstdlib>
#include <string>

#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"
#include "tumble/units/unit.hpp"
#include "tumble/units/words.hpp"

namespace tumble {

namespace {

constexpr int deepest = 50, greatest_power = 60;

class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  Meaning whole() {
    Meaning meaning = unit(0);
    if (at_ < text_.size())
      fail(at_, peek(")") ? Sentence("')' without '('")
                          : say("'/' or '*' expected before '{}'", std::string(text_.substr(at_))));
    if (!alone_) meaning.offset = 0.0;
    return meaning;
  }

  [[noreturn]] void fail(std::size_t at, const Sentence& problem) const {
    std::size_t position = 1;  // in characters, not bytes
    for (const char c : text_.substr(0, at)) position += (static_cast<unsigned char>(c) & 0xC0) != 0x80;
    throw Error(Error::Kind::bad_input, say("unit '{}', position {}: {}", std::string(text_), position, problem));
  }

 private:
  void skip_blanks() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
  }
  bool peek(std::string_view token) const { return text_.substr(at_).starts_with(token); }
  bool take(std::string_view token) {
    skip_blanks();
    if (!peek(token)) return false;
    at_ += token.size();
    return true;
  }
  bool digit() const { return at_ < text_.size() && text_[at_] >= '0' && text_[at_] <= '9'; }

  Meaning unit(int depth) {
    if (depth > deepest) fail(at_, "too many parentheses");
    Meaning product = power(depth);
    for (;;) {
      const std::size_t begin = at_;
      int sign = 0;
      if (take("/"))
        sign = -1;
      else if (take("*") || take("·") || take("⋅"))
        sign = 1;
      if (sign == 0) break;
      alone_ = false;
      const Meaning next = power(depth);
      product = times(product, to_the(next, 2 * sign, begin), begin);
    }
    skip_blanks();
    return product;
  }

  Meaning power(int depth) {
    const Meaning base = factor(depth);
    const std::size_t begin = at_;
    int halves = 2;
    if (take("^") || take("**"))
      halves = exponent();
    else if (take("²"))
      halves = 4;
    else if (take("³"))
      halves = 6;
    else if (take("⁻¹"))
      halves = -2;
    else if (take("⁻²"))
      halves = -4;
    else if (digit())
      halves = 2 * (text_[at_++] - '0');
    else
      return base;
    alone_ = false;
    if (halves == 0) fail(begin, "a power of 0 is no unit (standard gravity is g, a plain number 1)");
    if (digit()) fail(at_, "one digit expected as a power without '^'");
    return to_the(base, halves, begin);
  }

  Meaning factor(int depth) {
    skip_blanks();
    const std::size_t begin = at_;
    if (take("√")) {
      alone_ = false;
      if (depth > deepest) fail(begin, "too many roots");
      return to_the(factor(depth + 1), 1, begin);
    }
    if (take("(")) {
      const Meaning inner = unit(depth + 1);
      if (!take(")")) fail(begin, "'(' without ')'");
      return inner;
    }
    const std::string_view found = word();
    if (found.empty())
      fail(begin, begin == text_.size() ? Sentence("a unit expected; write 1 for a plain number")
                                        : say("a unit expected before '{}'", std::string(text_.substr(begin))));
    if (found == "sqrt" && take("(")) {
      alone_ = false;
      const Meaning inner = unit(depth + 1);
      if (!take(")")) fail(begin, "'(' without ')'");
      return to_the(inner, 1, begin);
    }
    if (const auto meaning = meaning_of(found)) return *meaning;
    fail(begin, say("unknown unit '{}'{}", std::string(found), advice_on(found)));
  }

  std::string_view word() {
    const std::size_t begin = at_;
    if (digit()) {
      while (digit() || peek(".")) ++at_;
      if (text_.substr(begin, at_ - begin) != "1") fail(begin, "the only number in a unit is 1");
      return text_.substr(begin, 1);
    }
    constexpr std::string_view ends = " \t/*^()0123456789+-.,;[]";
    while (at_ < text_.size() && ends.find(text_[at_]) == ends.npos && !peek("·") && !peek("⋅") && !peek("²") &&
           !peek("³") && !peek("⁻") && !peek("√"))
      ++at_;
    return text_.substr(begin, at_ - begin);
  }

  int exponent() {
    skip_blanks();
    const std::size_t begin = at_;
    const bool parenthesis = take("(");
    const int sign = take("-") ? -1 : (take("+"), 1);
    int halves = 2 * integer(begin);
    if (!parenthesis && take(".")) {
      if (!take("5") && !take("0")) fail(begin, "a power in whole halves expected");
      if (text_[at_ - 1] == '5') ++halves;
    } else if (parenthesis && take("/")) {
      const int divisor = integer(begin);
      if (divisor == 0 || halves % divisor != 0) fail(begin, "a power in whole halves expected");
      halves /= divisor;
    }
    if (digit()) fail(begin, "a power in whole halves expected");
    if (parenthesis && !take(")")) fail(begin, "'(' without ')'");
    return sign * halves;
  }

  int integer(std::size_t begin) {
    skip_blanks();
    if (!digit()) fail(begin, "a power expected, for example 2, -1, 0.5 or (1/2)");
    int value = 0;
    for (; digit(); ++at_) {
      value = 10 * value + (text_[at_] - '0');
      if (value > greatest_power) fail(begin, "power too great");
    }
    return value;
  }

  Meaning to_the(const Meaning& base, int halves, std::size_t at) const {
    const auto power = [&](int exponent) {
      if (exponent * halves % 2 != 0) fail(at, "the result has a power that is not in whole halves");
      if (std::abs(exponent * halves / 2) > 2 * greatest_power) fail(at, "power too great");
      return exponent * halves / 2;
    };
    Meaning result = base;
    for (auto& exponent : result.dimension.halves) exponent = static_cast<signed char>(power(exponent));
    for (const int exponent : base.factor.halves)
      if (exponent * halves % 2 != 0) fail(at, "the result has a power that is not in whole halves");
    if (base.factor.pi_halves * halves % 2 != 0) fail(at, "the result has a power that is not in whole halves");
    result.factor = raised(base.factor, halves);
    return result;
  }

  Meaning times(Meaning a, const Meaning& b, std::size_t at) const {
    for (int i = 0; i < Dimension::bases; ++i) {
      const int sum = a.dimension.halves[i] + b.dimension.halves[i];
      if (std::abs(sum) > 2 * greatest_power) fail(at, "power too great");
      a.dimension.halves[i] = static_cast<signed char>(sum);
    }
    a.factor = a.factor * b.factor;
    return a;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  bool alone_ = true;  ///< one word and nothing else so far
};

}  // namespace

Unit Unit::parse(std::string_view text) {
  const std::string_view body = trimmed(text, " \t\r\n");
  if (body.size() > 200) throw Error(Error::Kind::bad_input, "a unit of more than 200 characters is not understood");
  Parser parser(body);
  const Meaning meaning = parser.whole();
  Unit unit;
  unit.text_ = body;
  unit.dimension_ = meaning.dimension;
  unit.factor_ = rounded(meaning.factor);
  unit.offset_ = meaning.offset;
  if (!std::isnormal(unit.factor_)) parser.fail(0, "the unit is too great or too small for a number");
  return unit;
}

}  // namespace tumble
