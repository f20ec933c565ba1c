#include <algorithm>
#include <cmath>

#include "tumble/pyramid/pyramid.hpp"
#include "tumble/pyramid/store/store.hpp"

namespace tumble::store {
namespace {

constexpr float endless = std::numeric_limits<float>::infinity();

std::uint8_t flags_of(const Moments& block, std::size_t count) {
  std::uint8_t flags = 0;
  if (block.count < static_cast<double>(count)) flags |= ChannelView::missing;
  if (block.count > 1.0 && block.minimum == block.maximum) flags |= ChannelView::constant;
  return flags;
}

/// One block from those of the level below.
void add_block(const Level& below, std::size_t first, std::size_t end, Level& to) {
  float low = std::numeric_limits<float>::quiet_NaN(), high = low;
  std::uint8_t all_constant = ChannelView::constant, missing = 0;
  for (std::size_t i = first; i < end; ++i) {
    low = std::fmin(low, below.low[i]);
    high = std::fmax(high, below.high[i]);
    all_constant &= below.flags[i];
    missing = static_cast<std::uint8_t>(missing | (below.flags[i] & ChannelView::missing));
    if (below.low[i] != below.low[first] || below.high[i] != below.high[first]) all_constant = 0;
  }
  to.low.push_back(low);
  to.high.push_back(high);
  to.flags.push_back(all_constant | missing);
}

}  // namespace

float rounded_down(double value, double offset) {
  auto bound = static_cast<float>(value - offset);
  while (offset + static_cast<double>(bound) > value) bound = std::nextafter(bound, -endless);
  return bound;
}

float rounded_up(double value, double offset) {
  auto bound = static_cast<float>(value - offset);
  while (offset + static_cast<double>(bound) < value) bound = std::nextafter(bound, endless);
  return bound;
}

void Levels::add(const double* values, const double* times, std::size_t count) {
  while (count > 0) {
    const std::size_t now = std::min(count, moment_block - pending_.size());
    if (pending_.empty() && now == moment_block) {
      take(values, times, now);
    } else {
      pending_.insert(pending_.end(), values, values + now);
      if (times) pending_times_.insert(pending_times_.end(), times, times + now);
      if (pending_.size() == moment_block) {
        take(pending_.data(), times ? pending_times_.data() : nullptr, moment_block);
        pending_.clear();
        pending_times_.clear();
      }
    }
    values += now;
    if (times) times += now;
    count -= now;
  }
}

void Levels::finish() {
  if (!pending_.empty())
    take(pending_.data(), pending_times_.empty() ? nullptr : pending_times_.data(), pending_.size());
  pending_.clear();
  if (levels_.empty()) levels_.resize(1);
  if (moments_.empty()) moments_.resize(1);
  grow();
}

/// A whole block of moments, or the last one.
void Levels::take(const double* values, const double* times, std::size_t count) {
  if (!offset_known_)
    for (std::size_t i = 0; i < count && !offset_known_; ++i)
      if (std::isfinite(values[i])) offset_ = values[i], offset_known_ = true;
  if (levels_.empty()) levels_.resize(1);
  if (moments_.empty()) moments_.resize(1);
  Moments all;
  for (std::size_t first = 0; first < count; first += finest) {
    const std::size_t length = std::min(finest, count - first);
    const Moments block = moments_of(values + first, times ? times + first : nullptr, length,
                                     times ? times[first] : static_cast<double>(samples_ + first), offset_);
    const bool none = block.count == 0.0;
    levels_[0].low.push_back(none ? std::nanf("") : rounded_down(block.minimum, offset_));
    levels_[0].high.push_back(none ? std::nanf("") : rounded_up(block.maximum, offset_));
    levels_[0].flags.push_back(flags_of(block, length));
    all = joined(all, block);
  }
  moments_[0].push_back(all);
  samples_ += count;
}

/// The coarser levels, once the finest ones are there: a sixteenth of the work.
void Levels::grow() {
  while (levels_.back().low.size() > factor) {
    Level next;
    const Level& below = levels_.back();
    for (std::size_t i = 0; i < below.low.size(); i += factor)
      add_block(below, i, std::min(i + factor, below.low.size()), next);
    levels_.push_back(std::move(next));
  }
  while (moments_.back().size() > factor) {
    std::vector<Moments> next;
    const auto& below = moments_.back();
    for (std::size_t i = 0; i < below.size(); i += factor) {
      Moments block;
      for (std::size_t k = i; k < std::min(i + factor, below.size()); ++k) block = joined(block, below[k]);
      next.push_back(block);
    }
    moments_.push_back(std::move(next));
  }
}

}  // namespace tumble::store
