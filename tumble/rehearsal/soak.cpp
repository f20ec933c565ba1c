#include "tumble/rehearsal/soak.hpp"

#include <algorithm>
#include <cmath>

namespace tumble {

double soak_time_of(const Plan& plan, double within) {
  constexpr double room = 293.15;  // [K]
  if (!plan.rig.has("top_time") || !plan.rig.has("side_time")) return 0.0;
  double coldest = room, hottest = room;
  bool used = false;
  for (const Segment& segment : plan.schedule) {
    const auto found = segment.axes.find("chamber");
    if (found == segment.axes.end()) continue;
    const Motion& motion = found->second;
    const double air = motion.kind == Motion::Kind::ramp ? motion.to : motion.value;
    coldest = std::min(coldest, air);
    hottest = std::max(hottest, air);
    used = true;
  }
  if (!used) return 0.0;
  const double own =
      std::max(std::abs(plan.rig.number("top_self_heating")), std::abs(plan.rig.number("side_self_heating")));
  const double slowest = std::max(plan.rig.number("top_time"), plan.rig.number("side_time"));
  return slowest * std::log(std::max(1.0, (hottest - coldest + own) / within));
}

}  // namespace tumble
