#pragma once

#include <vector>

namespace tumble::recorder {

/// A straight line below points that are early or late, never too early: the longest edge of their lower convex hull.
/// Points that are late, however many and however late, do not move it.
class EarliestLine {
 public:
  void add(double x, double t);  ///< x does not go back
  double slope() const;          ///< of the longest edge; 0: no edge
  double width() const;          ///< [x] of that edge

 private:
  struct Point {
    double x = 0.0, t = 0.0;
  };
  std::vector<Point> hull_;
};

}  // namespace tumble::recorder
