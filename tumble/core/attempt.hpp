#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "tumble/units/error.hpp"

namespace tumble {

/// Returns the value of `make`. If it throws, its problems that are not among `problems` yet are appended, and an empty
/// value is returned: so all parts are tried before anything is reported.
template <class Make>
auto attempt(Problems& problems, Make make) -> decltype(make()) {
  try {
    return make();
  } catch (const Error& error) {
    for (const auto& problem : error.problems)
      if (std::find(problems.begin(), problems.end(), problem) == problems.end()) problems.push_back(problem);
    return {};
  }
}

}  // namespace tumble
