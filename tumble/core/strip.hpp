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

  /// Of the lines with a slope between `low` and `high` [u] those within `half` [u] of the point (x [1], y [u]).
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

/// Evidence [nat] above which the line is taken: samples that are lost at regular distances are rare, but do occur.
constexpr double enough_for_line = 8.0;

}  // namespace tumble
