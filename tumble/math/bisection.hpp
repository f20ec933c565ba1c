#pragma once

namespace tumble {

/// An interval [of a position] about the place where an answer changes.
struct Bisected {
  double low, high;
  double middle() const { return 0.5 * (low + high); }  ///< [of a position]
};

/// Place between `low` and `high` [of a position] where an answer changes from true to false, by halving.
///
/// Given     halvings  how often the interval is halved: each gives one binary digit
///           is_below  called with a position, returns whether the place is above it
template <class IsBelow>
Bisected bisected(double low, double high, int halvings, const IsBelow& is_below) {
  for (int step = 0; step < halvings; ++step) {
    const double middle = 0.5 * (low + high);
    (is_below(middle) ? low : high) = middle;
  }
  return {low, high};
}

}  // namespace tumble
