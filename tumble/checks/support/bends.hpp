#pragma once

#include <cstddef>
#include <vector>

namespace tumble::support {

/// Distance of a sample from the mean of its neighbours [u].
double bend(const std::vector<double>& x, std::size_t i);

/// Robust standard deviation [u] of the bends of every `step`-th sample in [begin, end); 0 without any. In a test with
/// moves it is that of the rests, which are most samples. Given: room  for the bends, to be used again
double usual_bend(const std::vector<double>& x, std::size_t begin, std::size_t end, std::size_t step,
                  std::vector<double>& room);

}  // namespace tumble::support
