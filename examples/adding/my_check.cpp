// A check of one's own: a temperature that jumps. A chamber changes by kelvins a minute; a jump from one sample to the
// next is a loose contact or an electrical disturbance.

#include <fmt/format.h>

#include <cmath>

#include "tumble/checks/check.hpp"
#include "tumble/core/say.hpp"

namespace tumble::checks {
namespace {

constexpr double largest_step = 5.0;  ///< [K] between two samples

Findings run(const Recording& recording, const Plan*) {
  Findings findings;
  for (const auto& channel : recording.channels) {
    if (channel.kind != QuantityKind::temperature) continue;
    std::size_t jumps = 0, first = 0;
    for (std::size_t k = 1; k < channel.values.size(); ++k)
      if (std::abs(channel.values[k] - channel.values[k - 1]) > largest_step && jumps++ == 0) first = k;
    if (jumps == 0) continue;
    findings.push_back(
        {Finding::Severity::warning,
         fmt::format("{} of more than {} between two samples, first at {}; check the contacts of the sensor",
                     say_count(jumps, "jump"), say_difference(largest_step, Unit::parse("K")),
                     say_instant(channel.time(first))),
         channel.name});
  }
  return findings;
}

}  // namespace

extern const Check my_check{"my_check", "temperatures that jump from one sample to the next", run};

}  // namespace tumble::checks
