#pragma once

#include <cstddef>

namespace tumble {

/// The number of threads of all parallel loops of this process from now on: 1 where other processes use the other
/// processors; 0: as many as the machine has.
void limit_threads(std::size_t count);

}  // namespace tumble
