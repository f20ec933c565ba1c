#include "tumble/core/sampling_rate.hpp"

#include "tumble/core/clock.hpp"

namespace tumble {

double sampling_rate(const Channel& channel) {
  if (channel.timeline.uniform()) return channel.timeline.rate;
  const double rate = channel.values.empty() ? 0.0 : clock_of(channel).rate;
  return rate > 0.0 ? rate : mean_rate(channel);
}

}  // namespace tumble
