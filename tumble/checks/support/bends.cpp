#include "tumble/checks/support/bends.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/normal.hpp"

namespace tumble::support {

double bend(const std::vector<double>& x, std::size_t i) { return std::abs(x[i] - 0.5 * (x[i - 1] + x[i + 1])); }

double usual_bend(const std::vector<double>& x, std::size_t begin, std::size_t end, std::size_t step,
                  std::vector<double>& room) {
  room.clear();
  for (std::size_t i = std::max<std::size_t>(1, begin); i < std::min(end, x.size() - 1); i += step)
    if (const double b = bend(x, i); !std::isnan(b)) room.push_back(b);
  if (room.empty()) return 0.0;
  const auto middle = room.begin() + static_cast<long>(room.size() / 2);
  std::nth_element(room.begin(), middle, room.end());
  return sd_of_median_size * *middle;
}

}  // namespace tumble::support
