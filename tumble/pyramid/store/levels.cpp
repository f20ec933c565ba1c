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
  if (finished_) reopen();
  while (count > 0) {
    const std::size_t now = std::min(count, moment_block - pending_.size());
    if (pending_.empty() && now == moment_block) {
      take(values, times, now);
      samples_ += now;
    } else {
      pending_.insert(pending_.end(), values, values + now);
      if (times) pending_times_.insert(pending_times_.end(), times, times + now);
      if (pending_.size() == moment_block) {
        take(pending_.data(), times ? pending_times_.data() : nullptr, moment_block);
        samples_ += moment_block;
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
  if (finished_) return;
  finished_ = true;
  if (levels_.empty()) levels_.resize(1);
  if (moments_.empty()) moments_.resize(1);
  if (!pending_.empty())
    take(pending_.data(), pending_times_.empty() ? nullptr : pending_times_.data(), pending_.size());
  grow();
}

/// Removes what stands for blocks that are not whole.
void Levels::reopen() {
  finished_ = false;
  std::size_t bars = samples_ / finest, blocks = samples_ / moment_block;
  for (Level& level : levels_) {
    level.low.resize(bars);
    level.high.resize(bars);
    level.flags.resize(bars);
    bars /= factor;
  }
  for (auto& level : moments_) {
    level.resize(blocks);
    blocks /= factor;
  }
}

void Levels::put_bar(double least, double greatest, std::uint8_t flags) {
  const bool none = least > greatest;
  levels_[0].low.push_back(none ? std::nanf("") : rounded_down(least, offset_));
  levels_[0].high.push_back(none ? std::nanf("") : rounded_up(greatest, offset_));
  levels_[0].flags.push_back(flags);
}

/// False: some are missing.
bool Levels::take_whole(const double* values) {
  Moments all;
  BarBounds bars;
  if (!moments_of_block(values, static_cast<double>(samples_), offset_, all, bars)) return false;
  for (std::size_t i = 0; i < factor; ++i)
    put_bar(bars.least[i], bars.greatest[i], bars.least[i] == bars.greatest[i] ? ChannelView::constant : 0);
  moments_[0].push_back(all);
  return true;
}

/// A whole block of moments, or the last one.
void Levels::take(const double* values, const double* times, std::size_t count) {
  for (std::size_t i = 0; i < count && !offset_known_; ++i)
    if (std::isfinite(values[i])) offset_ = values[i], offset_known_ = true;
  if (levels_.empty()) levels_.resize(1);
  if (moments_.empty()) moments_.resize(1);
  if (!times && count == moment_block && take_whole(values)) return;
  Moments all;
  for (std::size_t first = 0; first < count; first += finest) {
    const std::size_t length = std::min(finest, count - first);
    const Moments block = moments_of(values + first, times ? times + first : nullptr, length,
                                     times ? times[first] : static_cast<double>(samples_ + first), offset_);
    put_bar(block.minimum, block.maximum, flags_of(block, length));
    all = joined(all, block);
  }
  moments_[0].push_back(all);
}

/// The coarser levels, once the finest ones are there: a sixteenth of the work.
void Levels::grow() {
  for (std::size_t k = 0; levels_[k].low.size() > factor; ++k) {
    if (k + 1 == levels_.size()) levels_.emplace_back();
    const Level& below = levels_[k];
    Level& level = levels_[k + 1];
    for (std::size_t i = level.low.size() * factor; i < below.low.size(); i += factor)
      add_block(below, i, std::min(i + factor, below.low.size()), level);
  }
  for (std::size_t k = 0; moments_[k].size() > factor; ++k) {
    if (k + 1 == moments_.size()) moments_.emplace_back();
    const auto& below = moments_[k];
    auto& level = moments_[k + 1];
    for (std::size_t i = level.size() * factor; i < below.size(); i += factor) {
      Moments block;
      for (std::size_t j = i; j < std::min(i + factor, below.size()); ++j) block = joined(block, below[j]);
      level.push_back(block);
    }
  }
}

}  // namespace tumble::store
