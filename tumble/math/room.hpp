#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace tumble {

/// Room for `count` values, in large pages where the system has them: handing out small ones takes longer than filling
/// them. Given: values [any], empty.
void make_room(std::vector<double>& values, std::size_t count);

/// Values that are needed for a while, not set to anything, from the start of a line of the cache on. Those of a long
/// record are taken from what was given back before, and a few are kept for that: the system clears what it hands out,
/// which takes as long as to integrate it.
struct GiveBack {
  std::size_t count = 0;
  /// Gives `values` [count] back.
  void operator()(double* values) const;
};
using Room = std::unique_ptr<double[], GiveBack>;
Room borrow_room(std::size_t count);

}  // namespace tumble
