#include "tumble/report/rounding.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "tumble/language/said.hpp"
#include "tumble/language/section_words.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/utf8.hpp"

namespace tumble {
namespace {

constexpr int digits_of_double = 15;

/// Power of ten of the first digit of |x| after rounding to `digits` significant digits: 99.6 to two digits is 1.0e2.
int leading_place(double x, int digits) {
  const auto text = fmt::format("{:.{}e}", x, digits - 1);
  int exponent = 0;
  auto first = text.data() + text.find('e') + 1;
  if (*first == '+') ++first;
  std::from_chars(first, text.data() + text.size(), exponent);
  return exponent;
}

/// "e-05" and "e+05" as people write them: "e-5", "e5".
std::string short_exponent(std::string text) {
  const auto e = text.find('e');
  if (e == std::string::npos) return text;
  auto digits = e + 1;
  if (text[digits] == '+') text.erase(digits, 1);
  if (text[digits] == '-') ++digits;
  while (digits + 1 < text.size() && text[digits] == '0') text.erase(digits, 1);
  return text;
}

std::string without_negative_zero(std::string text) {
  if (text.starts_with('-') && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
}

std::string suffix(int exponent) { return exponent == 0 ? "" : fmt::format("e{}", exponent); }

}  // namespace

Rounding rounding_for(double value, double sd) {
  if (!std::isfinite(value) || !std::isfinite(sd) || sd <= 0.0) return {.significant = false};
  const int first_of_sd = leading_place(sd, 2);
  const int first = value == 0.0 ? first_of_sd : std::max(leading_place(value, digits_of_double), first_of_sd);
  const int place = first_of_sd - 1;
  if (first - place >= digits_of_double) return {.significant = false};
  const bool plain = first >= -3 && first <= 6;
  return {.place = place, .exponent = plain ? 0 : first, .significant = true};
}

std::string mantissa(double value, const Rounding& rounding) {
  if (!rounding.significant || !std::isfinite(value)) return general(value);
  // Long double: 10^308 and the reciprocal of the smallest double stay in range.
  long double scaled = static_cast<long double>(value) / std::pow(10.0L, rounding.exponent);
  const int place = rounding.place - rounding.exponent;
  if (place > 0) {
    const long double unit = std::pow(10.0L, place);
    scaled = std::round(scaled / unit) * unit;
  }
  return without_negative_zero(fmt::format("{:.{}f}", static_cast<double>(scaled), std::max(0, -place)));
}

std::string rounded(double value, const Rounding& rounding) {
  const bool bare = !rounding.significant || !std::isfinite(value);
  return mantissa(value, rounding) + (bare ? "" : suffix(rounding.exponent));
}

std::string general(double value, int digits) {
  if (std::isnan(value)) return "unknown";
  return without_negative_zero(short_exponent(fmt::format("{:.{}g}", value, digits)));
}

std::string with_uncertainty(double value, double sd) {
  const auto rounding = rounding_for(value, sd);
  if (rounding.significant && rounding.exponent != 0)
    return fmt::format("({} ± {}){}", mantissa(value, rounding), mantissa(sd, rounding), suffix(rounding.exponent));
  const auto halves = value_and_sd(value, sd);
  return halves.sd.empty() ? halves.value : halves.value + " ± " + halves.sd;
}

std::vector<std::string> lined_up(const std::vector<double>& values, const std::string& pad, const std::string& point) {
  std::vector<std::string> texts;
  std::size_t decimals = 0;
  const auto after_point = [](const std::string& text) {
    const auto dot = text.find('.');
    return dot == std::string::npos ? std::size_t{0} : text.size() - dot - 1;
  };
  for (const double value : values) {
    texts.push_back(std::isnan(value) ? "–" : general(value));
    if (std::isfinite(value)) decimals = std::max(decimals, after_point(texts.back()));
  }
  for (auto& text : texts) {
    const auto own = after_point(text);
    if (own == 0 && decimals > 0) text += point;
    for (auto i = own; i < decimals; ++i) text += pad;
  }
  return texts;
}

ShownParameter shown(const Estimate& estimate, std::size_t index) {
  const auto& parameter = estimate.parameters[index];
  return {parameter.unit.from_si(parameter.value),
          parameter.unit.difference_from_si(standard_uncertainty(estimate, index))};
}

Interval interval95(double value, double sd, double degrees_of_freedom) {
  if (!std::isfinite(value) || !std::isfinite(sd) || !(degrees_of_freedom > 0.0)) return {NAN, NAN};
  const double half = student_quantile(0.975, degrees_of_freedom) * sd;
  return {value - half, value + half};
}

Interval interval95(const Estimate& estimate, std::size_t index) {
  const auto& parameter = estimate.parameters[index];
  if (std::isfinite(parameter.value) && std::isfinite(parameter.lower) && std::isfinite(parameter.upper))
    return {parameter.lower, parameter.upper};
  return interval95(parameter.value, standard_uncertainty(estimate, index), parameter.degrees_of_freedom);
}

std::string interval_text(const Estimate& estimate, std::size_t index) {
  const auto [value, sd] = shown(estimate, index);
  const auto& unit = estimate.parameters[index].unit;
  const auto interval = interval95(estimate, index);
  const double lower = unit.from_si(interval.lower), upper = unit.from_si(interval.upper);
  if (std::isnan(lower)) return "–";
  const auto rounding = rounding_for(value, sd);
  return fmt::format("[{}, {}]{}", mantissa(lower, rounding), mantissa(upper, rounding), suffix(rounding.exponent));
}

ValueAndSd value_and_sd(double value, double sd) {
  if (std::isnan(value)) return {"unknown", ""};
  if (std::isnan(sd) || sd < 0.0) return {general(value), "unknown"};
  if (std::isinf(sd)) return {general(value), "unbounded"};
  const auto rounding = rounding_for(value, sd);
  if (!rounding.significant) return {general(value, sd == 0.0 ? 6 : 15), general(sd, 2)};
  return {rounded(value, rounding), rounded(sd, rounding)};
}

std::string measured_text(const Estimate& estimate, std::string_view name, Language language) {
  const SectionWords words{language};
  const auto unit_after = [](const Unit& unit) { return unit.text() == "1" ? "" : " " + printable(unit.text()); };
  const auto* parameter = find_parameter(estimate, name);
  if (parameter == nullptr) {
    const auto limit = find_upper_limit(estimate, name);
    if (!limit) return {};
    return words.with("below", fmt::format("{:.3g}", limit->unit.from_si(limit->value)), unit_after(limit->unit));
  }
  const auto [value, sd] = shown(estimate, static_cast<std::size_t>(parameter - estimate.parameters.data()));
  const auto halves = value_and_sd(value, sd);
  if (language == Language::english || halves.sd.empty())
    return with_uncertainty(value, sd) + unit_after(parameter->unit);
  const auto sd_text = result_words_in(language, halves.sd).value_or(halves.sd);  // "unknown"
  return words.with("measured_apart", halves.value, sd_text, unit_after(parameter->unit));
}

BudgetCell budget_cell(const Estimate& estimate, const Contribution& part, std::size_t index, Language language) {
  const double whole = shown(estimate, index).sd;
  const double sd = estimate.parameters[index].unit.difference_from_si(std::sqrt(part.variance(index)));
  if (!std::isfinite(sd)) return {"–", "–"};
  const auto text = sd == 0.0 ? "0" : rounded(sd, rounding_for(0.0, whole));
  const double percent = 100.0 * (sd / whole) * (sd / whole);
  if (!std::isfinite(percent)) return {text, "–"};
  const auto share = percent > 0.0 && percent < 0.5 ? "<1" : fmt::format("{:.0f}", percent);
  return {text, share + (language == Language::chinese ? "%" : " %")};
}

std::vector<Contribution> budget_to_show(const Estimate& estimate, Language language) {
  std::vector<Contribution> out;
  Contribution rest{"", {}, Matrix(estimate.parameters.size(), 0)};
  std::size_t small = 0;
  const Contribution* last = nullptr;
  for (const auto& part : estimate.budget) {
    bool matters = false;
    for (std::size_t i = 0; i < estimate.parameters.size(); ++i)
      matters = matters || part.variance(i) >= 0.01 * estimate.covariance(i, i);
    if (matters) {
      out.push_back(part);
      continue;
    }
    ++small;
    last = &part;
    rest.factor.values.insert(rest.factor.values.end(), part.factor.values.begin(), part.factor.values.end());
    rest.factor.columns += part.factor.columns;
  }
  rest.source = fmt::format("{} sources below 1 %", small);
  if (auto said = result_words_in(language, rest.source)) rest.source = std::move(*said);
  if (small == 1) out.push_back(*last);
  if (small > 1) out.push_back(rest);
  return out;
}

}  // namespace tumble
