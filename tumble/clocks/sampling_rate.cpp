#include "tumble/clocks/sampling_rate.hpp"

#include "tumble/clocks/clock.hpp"

namespace tumble {

double sampling_rate(const Channel& channel) {
  if (channel.timeline.uniform()) return channel.timeline.rate;
  const double rate = channel.values.empty() ? 0.0 : clock_of(channel).rate;
  return rate > 0.0 ? rate : mean_rate(channel);
}

bool sampled_together(const Channel& a, const Channel& b) {
  if (a.values.size() != b.values.size()) return false;
  if (a.timeline.uniform() && b.timeline.uniform())
    return a.timeline.rate == b.timeline.rate && a.timeline.start == b.timeline.start;
  return a.timeline.stamps == b.timeline.stamps ||
         (a.timeline.stamps && b.timeline.stamps && *a.timeline.stamps == *b.timeline.stamps);
}

}  // namespace tumble
