#include "tumble/station/conduct/hearing.hpp"

#include <algorithm>
#include <utility>

namespace tumble::conduct {

namespace {

constexpr double short_silence = 0.5;  ///< [s] at the end of a segment, or
constexpr double few_intervals = 3.0;  ///< so many intervals, which may be the latency of a stream

}  // namespace

void Hearing::records(int power_up, double time) {
  if (std::exchange(power_up_, power_up) != power_up) since_ = time;
  begin_ = time;
}

double Hearing::silence(double heard, double now) const { return now - std::max(heard, since_); }

Sentence Hearing::missing(double heard, double rate, double now) const {
  const double silent = now - std::max(heard, begin_);
  if (!(silent > std::max(short_silence, rate > 0.0 ? few_intervals / rate : 0.0))) return {};
  return say("no sample was received in the last {:.3g} s", silent);
}

}  // namespace tumble::conduct
