#pragma once

#include <cstddef>
#include <vector>

namespace tumble {

/// Memory about to be written for the first time: in large pages where the system has them.
void in_large_pages(void* begin, std::size_t bytes);

/// Room for `count` values, in large pages where the system has them: handing out small ones takes longer than filling
/// them.
void make_room(std::vector<double>& values, std::size_t count);

}  // namespace tumble
