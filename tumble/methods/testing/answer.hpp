#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tumble/core/testing/asserts.hpp"
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

/// How the method refuses the evidence.
inline Refused refusal(const Method& method, const Evidence& evidence) {
  return refusal_of([&] { method.identify(evidence, {}); });
}

}  // namespace tumble
