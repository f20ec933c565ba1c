#include <algorithm>

#include "tumble/exchange/certificate/page.hpp"
#include "tumble/report/markup.hpp"
#include "tumble/report/names.hpp"
#include "tumble/report/typeset.hpp"
#include "tumble/report/utf8.hpp"

namespace tumble::certificate {
namespace {

struct Written {
  std::string_view word, alone, in_product;
};

/// GB 3101: in a product the degree stands in brackets; a part of g is a power of ten.
constexpr Written chinese_words[] = {{"deg", "°", "(°)"},
                                     {"arcsec", "″", "(″)"},
                                     {"arcmin", "′", "(′)"},
                                     {"g", "g<sub>n</sub>", "g<sub>n</sub>"},
                                     {"mg", "10<sup>−3</sup> g<sub>n</sub>", "10<sup>−3</sup> g<sub>n</sub>"},
                                     {"ug", "10<sup>−6</sup> g<sub>n</sub>", "10<sup>−6</sup> g<sub>n</sub>"},
                                     {"ppm", "10<sup>−6</sup>", "10<sup>−6</sup>"},
                                     {"degC", "℃", "℃"},
                                     {"pulse", "脉冲", "脉冲"}};

/// "deg", "g^2" or "sqrt(h)" as GB 3101 writes it.
std::string chinese_factor(std::string_view factor, bool alone) {
  if (factor.starts_with("sqrt(") && factor.ends_with(")"))
    return chinese_factor(factor.substr(5, factor.size() - 6), false) + "<sup>1/2</sup>";
  const auto power = factor.find('^');
  const std::string_view word = factor.substr(0, power);
  std::string text = escaped(word);
  for (const auto& written : chinese_words)
    if (written.word == word) text = alone ? written.alone : written.in_product;
  return power == factor.npos ? text : text + "<sup>" + escaped(factor.substr(power + 1)) + "</sup>";
}

/// One solidus: what stands after a second one goes into a bracket with what stands after the first.
std::string chinese_unit(std::string_view text) {
  std::vector<std::string_view> factors;
  for (std::size_t begin = 0; begin <= text.size();) {
    const auto end = std::min(text.find('/', begin), text.size());
    factors.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  std::string below;
  for (std::size_t i = 1; i < factors.size(); ++i) below += (i > 1 ? "·" : "") + chinese_factor(factors[i], false);
  const std::string above = chinese_factor(factors[0], factors.size() == 1);
  if (factors.size() == 1) return above;
  return above + "/" + (factors.size() > 2 ? "(" + below + ")" : below);
}

/// Whether the text is a quotient of plain factors: no product, no bracket but that of sqrt.
bool is_plain_quotient(std::string_view text) {
  const auto brackets = std::ranges::count(text, '(');
  std::ptrdiff_t roots = 0;
  for (auto at = text.find("sqrt("); at != text.npos; at = text.find("sqrt(", at + 1)) ++roots;
  return brackets == roots && text.find('*') == text.npos && text.find('/') != 0;
}

}  // namespace

std::string printable_text(std::string_view text) { return printable(text); }

std::string Words::date(const Date& day) const {
  if (language == Language::english) return iso_date(day);
  return fmt::format("{}年{}月{}日", static_cast<int>(day.year()), static_cast<unsigned>(day.month()),
                     static_cast<unsigned>(day.day()));
}

std::string Words::unit(const Unit& unit) const {
  if (unit.text() == "1") return {};
  if (language == Language::chinese && is_plain_quotient(unit.text())) return chinese_unit(unit.text());
  return unit.text() == "degC" ? "°C" : typeset_unit(unit);
}

std::string Words::name(std::string_view key, std::string_view method) const {
  std::string text = printable(key);
  if (language != Language::english) return escaped(readable_name(language, text, method));
  std::ranges::replace(text, '_', ' ');
  return escaped(text);
}

std::string Words::symbol(std::string_view text) const {
  constexpr std::pair<std::string_view, std::string_view> greek[] = {
      {"delta", "δ"}, {"omega", "ω"}, {"sigma", "σ"}, {"tau", "τ"}};
  for (const auto& [word, letter] : greek)
    if (text.starts_with(word) && (text.size() == word.size() || text[word.size()] == '_'))
      return typeset_symbol(std::string(letter) + std::string(text.substr(word.size())));
  return typeset_symbol(text);
}

}  // namespace tumble::certificate
