#include "tumble/desk/desk_lines/curves.hpp"

#include <algorithm>
#include <cmath>

namespace tumble::desk_lines {
namespace {

/// `bar` grown by a later one. Channels that came later are missing in what was before.
void grow(CurveBar& bar, const CurveBar& later) {
  bar.time = later.time;
  bar.low.resize(later.low.size(), std::nan(""));
  bar.high.resize(later.high.size(), std::nan(""));
  for (std::size_t i = 0; i < later.low.size(); ++i) {
    bar.low[i] = std::fmin(bar.low[i], later.low[i]);
    bar.high[i] = std::fmax(bar.high[i], later.high[i]);
  }
}

CurveBar bar_of(const RunView& view) {
  CurveBar bar;
  bar.time = view.time;
  for (const auto& channel : view.channels) {
    bar.low.push_back(channel.unit.from_si(channel.low));
    bar.high.push_back(channel.unit.from_si(channel.high));
  }
  return bar;
}

}  // namespace

void Curves::add(const RunView& view) {
  CurveBar bar = bar_of(view);
  if (in_growing_ == 0) growing_ = CurveBar{};
  grow(growing_, bar);
  recent_.push_back(std::move(bar));
  if (recent_.size() > most_) recent_.pop_front();
  if (++in_growing_ < together_) return;
  in_growing_ = 0;
  whole_.push_back(growing_);
  if (whole_.size() < most_) return;
  for (std::size_t i = 0; 2 * i + 1 < whole_.size(); ++i) {
    CurveBar pair = whole_[2 * i];
    grow(pair, whole_[2 * i + 1]);
    whole_[i] = std::move(pair);
  }
  whole_.resize(whole_.size() / 2);
  together_ *= 2;
}

std::vector<CurveBar> Curves::whole() const {
  std::vector<CurveBar> bars = whole_;
  if (in_growing_ > 0) bars.push_back(growing_);
  return bars;
}

void EstimateHistory::add(const RunView& view) {
  constexpr std::size_t most = 400;
  for (const auto& estimate : view.estimates) {
    auto curve = std::ranges::find_if(
        curves_, [&](const Curve& one) { return one.slot == estimate.slot && one.name == estimate.name; });
    if (curve == curves_.end()) {
      curves_.push_back({estimate.slot, estimate.name, estimate.unit.text(), {}});
      curve = curves_.end() - 1;
    }
    auto& points = curve->points;
    const Point point{view.time, estimate.unit.from_si(estimate.value), estimate.unit.difference_from_si(estimate.sd)};
    if (!points.empty() && points.back().value == point.value && points.back().sd == point.sd) continue;
    points.push_back(point);
    if (points.size() < most) continue;
    for (std::size_t i = 0; 2 * i + 1 < points.size(); ++i) points[i] = points[2 * i + 1];  // the last one stays
    points.resize(points.size() / 2);
  }
}

}  // namespace tumble::desk_lines
