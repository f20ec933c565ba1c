#include "tumble/reduce/even_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/language/say.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// Places from the stamp `first` on where each sample of a stamped channel stands; its samples fill them in order, or
/// there are gaps.
std::vector<double> filled(const Channel& channel, std::size_t origin, double first, double rate, std::size_t count) {
  if (!may_be_filled(static_cast<double>(count), channel.values.size() - origin))
    throw Error(Error::Kind::bad_data,
                say("{}: by far most samples are missing from {} on: {} are expected, and there are {}",
                    Name{channel.name}, Name{say_instant(first)}, count, channel.values.size() - origin));
  std::vector<double> values(count, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = origin; i < channel.values.size(); ++i) {
    const double position =
        channel.timeline.uniform() ? static_cast<double>(i - origin) : std::round((channel.time(i) - first) * rate);
    if (position >= static_cast<double>(count)) break;
    if (position >= 0.0) values[static_cast<std::size_t>(position)] = channel.values[i];
  }
  return values;
}

/// Whether the next `count` samples stand on the grid one after the other.
bool stands_evenly(const Channel& channel, std::size_t origin, double first, double rate, std::size_t count) {
  if (origin + count > channel.values.size()) return false;
  if (channel.timeline.uniform()) return true;
  for (std::size_t i = 0; i < count; ++i)
    if (std::round((channel.time(origin + i) - first) * rate) != static_cast<double>(i)) return false;
  const std::size_t next = origin + count;  // a sample that comes early may share the last place
  return next >= channel.values.size() || std::round((channel.time(next) - first) * rate) >= static_cast<double>(count);
}

}  // namespace

EvenSamples even_samples(const Channel& channel, double rate, double begin, double end, double scale) {
  const double step = 1.0 / rate, slack = stamp_slack(begin, step);
  EvenSamples out{.step = step};
  const std::size_t i = index_at(channel, begin - slack);
  if (i >= channel.values.size() || channel.time(i) + step > end + slack) return out;
  out.first = channel.time(i);
  // index_at looks up stamps; the end of the last interval may stand for a sample that was not taken
  out.count = static_cast<std::size_t>(
      std::floor((std::min(end, channel.time(channel.values.size() - 1) + step) - out.first + slack) * rate));
  if (stands_evenly(channel, i, out.first, rate, out.count))
    out.values = EvenValues(channel.values.data() + i, out.count, scale);
  else
    out.values = EvenValues(filled(channel, i, out.first, rate, out.count), scale);
  return out;
}

}  // namespace tumble
