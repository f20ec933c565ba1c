#include "tumble/pyramid/store/live_track.hpp"

#include <unistd.h>

#include <algorithm>

#include "tumble/pyramid/store/live_file.hpp"
#include "tumble/units/error.hpp"

namespace tumble::store {

OpenFile::~OpenFile() {
  if (descriptor >= 0) close(descriptor);
}

void LiveTrack::read(std::uint64_t LiveRun::*place, std::size_t first, std::size_t number,
                     std::vector<double>& to) const {
  std::size_t low = 0, high = run_count;  // the first run behind
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (runs[middle].first <= first)
      low = middle + 1;
    else
      high = middle;
  }
  to.reserve(to.size() + number);
  for (std::size_t run = low - 1; number > 0; ++run) {
    const std::size_t end = run + 1 < run_count ? runs[run + 1].first : count;
    const std::size_t now = std::min(number, end - first), before = to.size();
    to.resize(before + now);
    if (!read_at(file->descriptor, runs[run].*place + (first - runs[run].first) * sizeof(double), to.data() + before,
                 now * sizeof(double)))
      throw Error{Error::Kind::bad_file, "the samples of the run can no longer be read"};
    first += now;
    number -= now;
  }
}

void LiveTrack::read(std::size_t first, std::size_t number, std::vector<double>& to) const {
  read(&LiveRun::values, first, number, to);
}

void LiveTrack::read_times(std::size_t first, std::size_t number, std::vector<double>& to) const {
  read(&LiveRun::times, first, number, to);
}

double LiveTrack::time(std::size_t sample) const {
  if (sample % finest == 0) return bar_times[sample / finest];
  std::vector<double> one;
  read_times(sample, 1, one);
  return one.front();
}

std::size_t LiveTrack::index_at(double wanted) const {
  std::size_t low = 0, high = (count + finest - 1) / finest;  // the first bar that begins at or after it
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (bar_times[middle] < wanted)
      low = middle + 1;
    else
      high = middle;
  }
  if (low == 0) return 0;
  const std::size_t begin = (low - 1) * finest;
  std::vector<double> times;
  read_times(begin, std::min(finest, count - begin), times);
  return begin + static_cast<std::size_t>(std::ranges::lower_bound(times, wanted) - times.begin());
}

}  // namespace tumble::store
