#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tumble/core/finding.hpp"
#include "tumble/language/text.hpp"
#include "tumble/units/testing/asserts.hpp"

/// For the tests of findings: they ask for the code, the values and the place. The sentence may change without a change
/// of the test.
namespace tumble {

/// The first finding of this code, or null.
inline const Finding* finding_of(const Findings& findings, const std::string& code) {
  const auto finding = std::ranges::find(findings, code, &Finding::code);
  return finding == findings.end() ? nullptr : &*finding;
}

/// Whether two values of findings are the same; a number [SI] to the four digits that a sentence shows.
inline bool same_value(const FindingValue& wanted, const FindingValue& found) {
  const auto number = [](const FindingValue& v) {
    if (const auto* count = std::get_if<long long>(&v.value)) return static_cast<double>(*count);
    const auto* real = std::get_if<double>(&v.value);
    return real ? *real : std::nan("");
  };
  const auto text = [](const FindingValue& v) {
    if (const auto* phrase = std::get_if<Phrase>(&v.value)) return phrase->key;
    const auto* name = std::get_if<std::string>(&v.value);
    return name ? *name : std::string();
  };
  constexpr double last_digit = 5e-4;  // half a unit of the fourth digit, relative
  const double a = number(wanted), b = number(found);
  return wanted.name == found.name && text(wanted) == text(found) &&
         (std::isnan(a) ? std::isnan(b) : std::abs(a - b) <= last_digit * std::abs(a));
}

/// Whether a finding has this code, among others these values, and, where it is given, this place.
inline ::testing::AssertionResult is_finding(const Finding& finding, const std::string& code,
                                             const std::vector<FindingValue>& values = {},
                                             const std::optional<std::string>& where = {}) {
  const auto described = [&] { return "'" + finding.code + "' in '" + finding.where + "': " + finding.message; };
  if (finding.code != code || finding.where != where.value_or(finding.where))
    return ::testing::AssertionFailure() << "the finding is " << described();
  for (const FindingValue& wanted : values)
    if (std::ranges::none_of(finding.values, [&](const FindingValue& v) { return same_value(wanted, v); }))
      return ::testing::AssertionFailure() << "other value of " << wanted.name << " in " << described();
  return ::testing::AssertionSuccess();
}

/// Whether there is such a finding.
inline ::testing::AssertionResult has_finding(const Findings& findings, const std::string& code,
                                              const std::vector<FindingValue>& values = {},
                                              const std::optional<std::string>& where = {}) {
  std::string all;
  for (const Finding& finding : findings) {
    if (is_finding(finding, code, values, where)) return ::testing::AssertionSuccess() << "there is " << code;
    all += "\n  '" + finding.code + "' in '" + finding.where + "': " + finding.message;
  }
  return ::testing::AssertionFailure() << "no " << code << " with these values among:" << all;
}

/// Whether there is an error of this code.
inline bool has_error(const Findings& findings, const std::string& code) {
  const Finding* finding = finding_of(findings, code);
  return finding != nullptr && finding->severity == Finding::Severity::error;
}

/// A value [SI] of the first finding of this code; without it NaN, and a failure.
inline double value_of(const Findings& findings, const std::string& code, const std::string& name) {
  if (const Finding* finding = finding_of(findings, code))
    for (const FindingValue& v : finding->values) {
      if (v.name != name) continue;
      if (const auto* count = std::get_if<long long>(&v.value)) return static_cast<double>(*count);
      return std::get<double>(v.value);
    }
  ADD_FAILURE() << "no finding " << code << " with " << name;
  return std::nan("");
}

/// A text, or the key of a phrase, of the first finding of this code; without it empty, and a failure.
inline std::string text_of(const Findings& findings, const std::string& code, const std::string& name) {
  if (const Finding* finding = finding_of(findings, code))
    for (const FindingValue& v : finding->values) {
      if (v.name != name) continue;
      if (const auto* phrase = std::get_if<Phrase>(&v.value)) return phrase->key;
      if (const auto* text = std::get_if<std::string>(&v.value)) return *text;
    }
  ADD_FAILURE() << "no finding " << code << " with the text " << name;
  return "";
}

/// The question about a refusal that was made from a finding of this code (errors_among).
/// Given: values as they are shown, in the order of the sentence; the place first.
inline Asked asked_finding(const std::string& code, std::vector<std::string> values = {}, std::size_t count = 1) {
  const std::string sentence = text_of("finding", code, count);
  std::string pattern;
  for (std::size_t i = 0; i < sentence.size(); ++i) {
    const bool doubled = i + 1 < sentence.size() && sentence[i + 1] == sentence[i];
    pattern += sentence[i];
    if (sentence[i] == '{' && !doubled) {
      i = sentence.find('}', i);
      pattern += '}';
    } else if (doubled && (sentence[i] == '{' || sentence[i] == '}')) {
      pattern += sentence[++i];
    }
  }
  return {.values = std::move(values), .pattern = pattern};
}

}  // namespace tumble
