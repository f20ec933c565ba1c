#include "tumble/formats/file/even_clock.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

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

void EvenClock::add(double t, double place) {
  const auto k = static_cast<double>(count_++);
  if (count_ == 1) first_ = t;
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

std::optional<Timeline> EvenClock::timeline() const {
  if (count_ < 2 || written_.empty()) return std::nullopt;
  const Interval& interval = exact_.empty() ? written_ : exact_;
  return Timeline{first_, plainest_rate(interval.low, interval.high), nullptr};
}

bool EvenClock::allows(const Timeline& stated) const {
  if (count_ == 0 || !(stated.rate > 0.0)) return false;
  const double interval = 1.0 / stated.rate;
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * std::abs(first_);
  if (std::abs(stated.start - first_) > std::max({place_, 1e-4 * interval, rounding})) return false;
  return count_ == 1 || (interval >= written_.low && interval <= written_.high);
}

}  // namespace tumble::file
