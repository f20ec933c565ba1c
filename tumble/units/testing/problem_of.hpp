#pragma once

#include <functional>
#include <string>

#include "tumble/units/error.hpp"

namespace tumble {

/// For tests: the message of the Error with which work ends, or "nothing was thrown".
inline std::string problem_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

}  // namespace tumble
