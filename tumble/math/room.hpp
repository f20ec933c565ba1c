#pragma once

#include <cstddef>
#include <vector>

namespace tumble {

/// Room for `count` values, in large pages where the system has them: handing out small ones takes longer than filling
/// them.
void make_room(std::vector<double>& values, std::size_t count);

}  // namespace tumble
