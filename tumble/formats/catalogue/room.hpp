#pragma once

#include <cstddef>
#include <vector>

namespace tumble::formats {

/// Room for `count` values, in large pages where the system has them: half the time of reading goes to small ones.
void make_room(std::vector<double>& values, std::size_t count);

}  // namespace tumble::formats
