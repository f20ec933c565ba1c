#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <vector>

#include "tumble/station/carry_out.hpp"

namespace tumble::desk {

/// One bar a view: the least and the greatest sample of each channel [unit shown] since the one before; NaN: none.
struct CurveBar {
  double time = 0.0;  ///< [s] of its end
  std::vector<double> low, high;
};

/// Curves of the channels of a run as they are drawn, in constant memory: the last bars as they came, and the whole run
/// in bars that hold ever more of them.
class Curves {
 public:
  explicit Curves(std::size_t most = 600) : most_(most) {}
  void add(const RunView& view);
  const std::deque<CurveBar>& recent() const { return recent_; }
  /// All bars of the run, the one that is growing too.
  std::vector<CurveBar> whole() const;

 private:
  std::size_t most_, together_ = 1;  ///< bars of `whole_`, views in each of them
  std::deque<CurveBar> recent_;
  std::vector<CurveBar> whole_;
  CurveBar growing_;
  std::size_t in_growing_ = 0;
};

/// The estimate as it converges: a point whenever it changes, every second one dropped where there are too many.
class EstimateHistory {
 public:
  struct Point {
    double time = 0.0, value = 0.0, sd = 0.0;  ///< [s], [unit shown]
  };
  struct Curve {
    std::string slot, name, unit;
    std::vector<Point> points;
  };
  void add(const RunView& view);
  const std::vector<Curve>& curves() const { return curves_; }

 private:
  std::vector<Curve> curves_;
};

}  // namespace tumble::desk
