// A check of one's own: a temperature that jumps. A chamber changes by kelvins a minute; a jump from one sample to the
// next is a loose contact or an electrical disturbance.

#include <cmath>

#include "tumble/checks/check.hpp"

namespace tumble::checks::my_check {
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
    findings.push_back({Finding::Severity::warning,
                        Phrase{"temperature_jump",
                               "{count:jump} of more than {limit:difference} between two samples, first at {first}; "
                               "check the contacts of the sensor"},
                        {{"limit", largest_step, "K"}},
                        channel.name,
                        {jumps, channel.time(first)}});
  }
  return findings;
}

}  // namespace

extern const Check my_check{"my_check", "temperatures that jump from one sample to the next", run};

}  // namespace tumble::checks::my_check
