#include "tumble/formats/file/even_clock.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace tumble::file {

namespace {

/// The nearest number with `digits` significant decimal digits.
double to_digits(double value, int digits) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::scientific, digits - 1).ptr;
  double result = value;
  std::from_chars(text, end, result);
  return result;
}

}  // namespace

double plainest_rate(double low, double high) {
  const double middle = 0.5 * (low + high);
  for (int digits = 1; digits <= 17; ++digits) {
    const double rate = to_digits(1.0 / middle, digits);
    if (rate > 0.0 && 1.0 / rate >= low && 1.0 / rate <= high) return rate;
    const double interval = to_digits(middle, digits);
    if (interval >= low && interval <= high) return 1.0 / interval;
  }
  return 1.0 / middle;
}

void EvenClock::add_to_strip(double t, double place, double k) {
  constexpr double off = 0.505, fine = 4.0, soon = 64.0, least = 0.02, greatest = 100.0;  // in digits
  if (k == 0.0 && place > 0.0) {
    digit_ = place;
    lines_.emplace(0.0, 0.0, off, least, greatest);
  }
  const double step = (t - std::exchange(last_, t)) / digit_;
  if (!lines_ || k == 0.0) return;
  gaps_ += step > 1.5, repeats_ += step < 0.5;
  const double rounding = std::numeric_limits<double>::epsilon() * std::max(std::abs(first_), std::abs(t));
  const double z = (t - first_) / digit_;
  if ((k >= soon && z > fine * k) || !lines_->add(k, z, (off * std::max(place, digit_) + rounding) / digit_))
    lines_.reset();
}

void EvenClock::add(double t, double place) {
  const auto k = static_cast<double>(count_++);
  if (count_ == 1) first_ = t;
  add_to_strip(t, place, k);
  if (count_ <= 2) place_ = std::max(place_, place);
  if (count_ == 1 || written_.empty()) return;  // no later stamp can make it even again
  const double share = 1.0 / k;
  const double mean = (t - first_) * share;
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(first_), std::abs(t));
  const double cap = std::abs(mean) / 3.0;
  const auto narrow = [&](Interval& interval, double tolerance) {
    const double half = std::min(tolerance, cap) * share;
    interval.low = std::max(interval.low, mean - half);
    interval.high = std::min(interval.high, mean + half);
  };
  narrow(exact_, rounding);
  narrow(written_, std::max({place, 1e-4 * mean, rounding}));
}

EvenClock::Interval EvenClock::by_line(std::optional<double> stated) const {
  constexpr Interval none{1.0, 0.0};
  if (!lines_ || !may_repeat(lines_->middle().r, static_cast<double>(count_), repeats_, 0.0)) return none;
  const Interval interval{lines_->lowest() * digit_, lines_->highest() * digit_};
  const bool clear = evidence_for_line(static_cast<double>(count_), gaps_, repeats_, 0.0) >= enough_for_line;
  return clear || (stated && interval.holds(*stated)) ? interval : none;
}

std::optional<Timeline> EvenClock::timeline(std::optional<double> stated) const {
  const auto stated_interval = stated && *stated > 0.0 ? std::optional(1.0 / *stated) : std::nullopt;
  const Interval written = written_.empty() ? by_line(stated_interval) : written_;
  if (count_ < 2 || written.empty()) return std::nullopt;
  if (stated_interval && written.holds(*stated_interval)) return Timeline{first_, *stated, nullptr};
  const Interval& interval = exact_.empty() ? written : exact_;
  return Timeline{first_, plainest_rate(interval.low, interval.high), nullptr};
}

bool EvenClock::allows(const Timeline& stated) const {
  if (count_ == 0 || !(stated.rate > 0.0)) return false;
  const double interval = 1.0 / stated.rate;
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * std::abs(first_);
  if (std::abs(stated.start - first_) > std::max({place_, 1e-4 * interval, rounding})) return false;
  return count_ == 1 || (written_.empty() ? by_line(interval) : written_).holds(interval);
}

}  // namespace tumble::file
