#pragma once

#include <cstddef>
#include <vector>

namespace tumble {

/// All straight lines a + r x that pass within `half` of every point given so far: a convex polygon of (a, r), which
/// each point cuts, unless it would remove less than 0.002 of the unit of y. Stamps of a clock that counts whole ticks
/// have few corners, whatever their number.
class Strip {
 public:
  struct Line {
    double a = 0.0, r = 0.0;
  };

  /// The lines with a slope between `low` and `high` [u] that pass within `half` [u] of the point (x [1], y [u]).
  Strip(double x, double y, double half, double low, double high);

  /// Removes the lines that do not pass within `half` [u] of (x [1], y [u]); no change and false where none would
  /// remain.
  bool add(double x, double y, double half);

  double lowest() const;   ///< slope [u]
  double highest() const;  ///< slope [u]
  /// The mean of the corners.
  Line middle() const;

 private:
  std::vector<Line> corners_, cut_, spare_;
};

/// How much better whole stamps of a clock of coarse ticks are explained by a line of its own than by an interval of
/// one tick [nat]: there, each of `missing` samples and of `repeats` is an event that may be anywhere among `count`
/// samples; a line needs its slope and its level, and leaves `still_missing`.
double evidence_for_line(double count, double missing, double repeats, double still_missing);

/// Whether a line of slope r [tick] over `length` samples may have that many stamps that repeat the one before: it
/// doubles a tick when 1 - r has summed up to a whole one. More come from stamps that scatter about the edge of a tick,
/// and then few samples are missing; else a sample lost beside each repeat would make any record one of r = 1.
constexpr bool may_repeat(double r, double length, double repeats, double still_missing) {
  constexpr double by_chance = 8.0;  // repeats and lost samples that happen to alternate
  return repeats <= (r < 1.0 ? 1.0 - r : 0.0) * length + 1.5 ||
         (repeats >= by_chance && 4.0 * still_missing <= repeats);
}

/// Evidence [nat] above which the line is taken: samples that are lost at regular distances are rare, but do occur.
constexpr double enough_for_line = 8.0;

}  // namespace tumble
