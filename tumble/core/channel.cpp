#include "tumble/core/channel.hpp"

#include <algorithm>
#include <cmath>

namespace tumble {

std::string_view name(QuantityKind kind) {
  switch (kind) {
    case QuantityKind::angular_rate:
      return "angular_rate";
    case QuantityKind::angle:
      return "angle";
    case QuantityKind::specific_force:
      return "specific_force";
    case QuantityKind::velocity:
      return "velocity";
    case QuantityKind::count:
      return "count";
    case QuantityKind::temperature:
      return "temperature";
    case QuantityKind::time:
      return "time";
    case QuantityKind::other:
      break;
  }
  return "other";
}

QuantityKind kind_of(const Unit& unit) {
  struct Row {
    std::array<signed char, Dimension::bases> halves;  // m kg s A K rad count
    QuantityKind kind;
  };
  static constexpr Row rows[] = {
      {{0, 0, -2, 0, 0, 2}, QuantityKind::angular_rate},
      {{0, 0, 0, 0, 0, 2}, QuantityKind::angle},
      {{2, 0, -4}, QuantityKind::specific_force},
      {{2, 0, -2}, QuantityKind::velocity},
      {{0, 0, 0, 0, 0, 0, 2}, QuantityKind::count},
      {{0, 0, 0, 0, 2}, QuantityKind::temperature},
      {{0, 0, 2}, QuantityKind::time},
  };
  for (const Row& row : rows)
    if (row.halves == unit.dimension().halves) return row.kind;
  return QuantityKind::other;
}

double span(const Channel& channel) {
  const std::size_t count = channel.values.size();
  return count < 2 ? 0.0 : channel.time(count - 1) - channel.time(0);
}

double mean_rate(const Channel& channel) {
  if (channel.values.size() < 2) return 0.0;
  if (channel.timeline.uniform()) return channel.timeline.rate;
  const double seconds = span(channel);
  return seconds > 0.0 ? static_cast<double>(channel.values.size() - 1) / seconds : 0.0;
}

std::size_t index_at(const Channel& channel, double time) {
  const std::size_t count = channel.values.size();
  if (!channel.timeline.uniform()) {
    const auto& stamps = *channel.timeline.stamps;
    return static_cast<std::size_t>(std::lower_bound(stamps.begin(), stamps.end(), time) - stamps.begin());
  }
  const double exact = std::ceil((time - channel.timeline.start) * channel.timeline.rate);
  auto index = static_cast<std::size_t>(std::clamp(exact, 0.0, static_cast<double>(count)));
  while (index > 0 && channel.time(index - 1) >= time) --index;  // the product above is rounded
  while (index < count && channel.time(index) < time) ++index;
  return index;
}

}  // namespace tumble
