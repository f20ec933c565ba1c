#include <algorithm>
#include <cmath>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/each_channel.hpp"
#include "tumble/checks/support/texture.hpp"
#include "tumble/math/extremes.hpp"

namespace tumble::checks {

namespace {

using namespace support;

constexpr std::size_t block = 1024, thinning = 8, near = 24, ringing = 8;
constexpr double far = 8.0;              // usual bends
constexpr double sd_of_median = 1.4826;  // of the normal distribution: sd over the median of magnitudes

/// Distance of a sample from the mean of its neighbours.
double bend(const std::vector<double>& x, std::size_t i) { return std::abs(x[i] - 0.5 * (x[i - 1] + x[i + 1])); }

/// Robust standard deviation of the bends of every `step`-th sample in [begin, end); 0 where there are none.
double usual_bend(const std::vector<double>& x, std::size_t begin, std::size_t end, std::size_t step,
                  std::vector<double>& room) {
  room.clear();
  for (std::size_t i = std::max<std::size_t>(1, begin); i < std::min(end, x.size() - 1); i += step)
    if (const double b = bend(x, i); !std::isnan(b)) room.push_back(b);
  if (room.empty()) return 0.0;
  const auto middle = room.begin() + static_cast<long>(room.size() / 2);
  std::nth_element(room.begin(), middle, room.end());
  return sd_of_median * *middle;
}

/// Whether a sample in [begin, end) may stand off its neighbours by `far` usual bends, those of every `step`-th sample.
/// Their median is compared by counting, which takes a fraction of the time that finding it does.
bool may_hold_some(const std::vector<double>& x, std::size_t begin, std::size_t end, std::size_t step) {
  constexpr double rounding = 1.0 + 1e-12;
  const double least = greatest_spike(x, begin, end) / (far * sd_of_median) * rounding;
  std::size_t bends = 0, less = 0;
  for (std::size_t i = begin; i < end; i += step) {
    const double b = bend(x, i);
    bends += b == b;
    less += b < least;
  }
  return bends == 0 || less > bends / 2;
}

/// The greatest bend of the samples [begin, end).
double greatest_bend(const std::vector<double>& x, std::size_t begin, std::size_t end) {
  double greatest = 0.0;
  for (std::size_t i = std::max<std::size_t>(1, begin); i < std::min(end, x.size() - 1); ++i)
    greatest = std::max(greatest, bend(x, i));  // not NaN: the comparison keeps the first
  return greatest;
}

struct Outliers {
  std::size_t count = 0, first = 0, farthest = 0;
  double distance = 0.0, usual = 0.0;  // of the farthest
};

/// Samples that stand apart from both neighbours, on the same side, by eight times the usual bend: that of the block,
/// and of what comes just before and just after, so that the onset of a motion is none. A step is none either, nor is a
/// knock, which rings: no sample nearby may bend by a third as much.
/// Nor is what comes within `near` samples of the beginning of a segment, where the rig moves.
Outliers find_outliers(const std::vector<double>& x, double quantum, const std::vector<std::size_t>& moves) {
  const double coarseness = 0.5 * quantum;  // the median of coarse values may be off by that
  Outliers found;
  std::vector<double> room;
  for (std::size_t begin = 1; begin + 1 < x.size(); begin += block) {
    const std::size_t end = std::min(begin + block, x.size() - 1);
    const std::size_t step = end - begin < block ? 1 : thinning;
    if (!may_hold_some(x, begin, end, step)) continue;
    const double usual = usual_bend(x, begin, end, step, room) + coarseness;
    for (std::size_t i = begin; i < end; ++i) {
      const double from_last = x[i] - x[i - 1], from_next = x[i] - x[i + 1];
      const double distance = std::min(std::abs(from_last), std::abs(from_next));
      if (!(distance > far * usual) || from_last * from_next < 0.0) continue;
      const auto move = std::ranges::upper_bound(moves, i + 1);  // the first that comes later
      if (move != moves.begin() && i < *std::prev(move) + near) continue;
      const double before = usual_bend(x, i > near + 1 ? i - near - 1 : 1, i - 1, 1, room) + coarseness;
      const double after = usual_bend(x, i + 2, i + 2 + near, 1, room) + coarseness;
      const double local = std::max({usual, before, after});
      const double rings = std::max(greatest_bend(x, i > ringing + 1 ? i - ringing - 1 : 1, i - 1),
                                    greatest_bend(x, i + 2, i + 2 + ringing));
      if (!(distance > far * local) || rings > distance / 3.0) continue;
      if (found.count++ == 0) found.first = i;
      if (distance > found.distance) found.farthest = i, found.distance = distance, found.usual = local;
    }
  }
  return found;
}

Findings look_at(const Channel& channel, const std::vector<Mark>& marks) {
  if (channel.values.size() < 16) return {};
  std::vector<std::size_t> moves;
  const double slack = 1e-6 / mean_rate(channel);  // durations that add up are rounded
  for (const Mark& mark : marks) moves.push_back(index_at(channel, mark.begin - slack));
  std::ranges::sort(moves);
  const Outliers found = find_outliers(channel.values, texture_of(channel.values).quantum, moves);
  if (found.count == 0) return {};
  // A distance has no zero: that of two temperatures is in K.
  const Unit unit = channel.unit.offset() == 0.0 ? channel.unit : Unit::parse("K");
  return {{Finding::Severity::warning,
           "outlier",
           {{"distance", found.distance, unit}, {"times", found.distance / found.usual}},
           channel.name,
           {found.count, channel.time(found.first), channel.time(found.farthest)}}};
}

Findings run(const Recording& recording, const Plan*) {
  return findings_of_each(recording, [&](const Channel& channel) { return look_at(channel, recording.marks); });
}

}  // namespace

extern const Check outliers{"outliers", "single samples far from both neighbours", run};

}  // namespace tumble::checks
