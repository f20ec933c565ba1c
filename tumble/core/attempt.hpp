#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "tumble/units/error.hpp"

namespace tumble {

/// What `make` returns. If it throws, what it complains of that is not among `problems` yet is appended, and an empty
/// result returned: so that all parts are tried before anything is said.
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
