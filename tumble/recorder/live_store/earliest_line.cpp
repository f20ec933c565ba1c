#include "tumble/recorder/live_store/earliest_line.hpp"

#include <algorithm>
#include <cstddef>

namespace tumble::live_store {

namespace {

constexpr std::size_t most_corners = 4096;  ///< of a hull that is a smooth curve every second one says the same

}  // namespace

void EarliestLine::add(double x, double t) {
  if (!hull_.empty() && x <= hull_.back().x) {
    if (t >= hull_.back().t) return;
    hull_.pop_back();
  }
  const auto is_above = [&](const Point& a, const Point& b) {
    return (b.t - a.t) * (x - a.x) >= (t - a.t) * (b.x - a.x);
  };
  while (hull_.size() > 1 && is_above(hull_[hull_.size() - 2], hull_.back())) hull_.pop_back();
  hull_.push_back({x, t});
  if (hull_.size() < most_corners) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < hull_.size(); i += 2) hull_[kept++] = hull_[i];
  hull_.resize(kept);
}

double EarliestLine::width() const {
  double width = 0.0;
  for (std::size_t i = 1; i < hull_.size(); ++i) width = std::max(width, hull_[i].x - hull_[i - 1].x);
  return width;
}

double EarliestLine::slope() const {
  const double longest = width();
  for (std::size_t i = 1; i < hull_.size(); ++i)
    if (hull_[i].x - hull_[i - 1].x == longest) return (hull_[i].t - hull_[i - 1].t) / longest;
  return 0.0;
}

}  // namespace tumble::live_store
