#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tumble/methods/method.hpp"
#include "tumble/units/error.hpp"

/// For the tests of methods.
namespace tumble {

inline double value(const Estimate& estimate, const std::string& name) {
  const Parameter* p = find_parameter(estimate, name);
  if (p != nullptr) return p->value;
  ADD_FAILURE() << "no " << name;
  return std::nan("");
}

inline bool says(const Findings& findings, const std::string& words) {
  return std::ranges::any_of(findings, [&](const Finding& f) { return f.message.find(words) != std::string::npos; });
}

/// The first finding of this code, or null.
inline const Finding* finding_of(const Findings& findings, const std::string& code) {
  const auto finding = std::ranges::find(findings, code, &Finding::code);
  return finding == findings.end() ? nullptr : &*finding;
}

/// A value [SI] of the first finding of this code; NaN, and a failure, without it.
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

/// The message with which the method refuses the evidence.
inline std::string refusal(const Method& method, const Evidence& evidence) {
  try {
    method.identify(evidence, {});
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "not refused";
  return "";
}

/// Whether there is a finding of this code.
inline bool has_finding(const Findings& findings, const std::string& code) {
  return finding_of(findings, code) != nullptr;
}

/// Whether there is an error of this code.
inline bool has_error(const Findings& findings, const std::string& code) {
  const Finding* finding = finding_of(findings, code);
  return finding != nullptr && finding->severity == Finding::Severity::error;
}

/// A text, or the key of a phrase, of the first finding of this code; empty, and a failure, without it.
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

}  // namespace tumble
