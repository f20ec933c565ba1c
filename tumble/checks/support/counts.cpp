#include "tumble/checks/support/counts.hpp"

#include <algorithm>
#include <cmath>

namespace tumble::support {

bool counts_pulses(const Channel& channel) { return channel.kind == QuantityKind::count; }

Spread spread_of(const Channel& channel) {
  Spread spread{INFINITY, -INFINITY, true};
  std::size_t present = 0;
  for (const double value : channel.values) {
    if (std::isnan(value)) continue;
    if (!std::isfinite(value) || value != std::round(value)) return {0.0, 0.0, false};
    spread.lowest = std::min(spread.lowest, value);
    spread.highest = std::max(spread.highest, value);
    ++present;
  }
  spread.whole = present >= 2;
  return spread;
}

}  // namespace tumble::support
