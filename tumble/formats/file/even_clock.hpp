#pragma once

#include <cstddef>
#include <limits>
#include <optional>

#include "tumble/clocks/strip.hpp"
#include "tumble/core/channel.hpp"

namespace tumble::file {

/// [s] 30 000 years: a step that a file states and that no instrument has.
inline constexpr double longest_step = 1e12;

/// The rate [Hz] with the fewest digits, itself or its inverse, of all those with 1/rate between low and high [s].
double plainest_rate(double low, double high);

/// Decides whether stamps are evenly spaced, one stamp after the other and in constant memory.
///
/// They are when one interval dt exists with
///
///   |t_k - (t_0 + k dt)| <= e_k    for every k,    e_k = min(max(q, 1e-4 D, 4 eps max(|t_0|, |t_k|)), D/3)
///
/// where D = (t_k - t_0)/k and q is the place of the last digit written: t_0 and t_k are each off by up to half of it.
/// D/3 keeps a lost sample visible where the digits are coarse. 1e-4 D covers clocks summed up in floating point, and
/// is below what any method could notice. The allowed dt form an interval, which each stamp narrows.
///
/// Where q is no small part of the interval, stamps are even as well when each lies within half of q of one line
/// a + k dt: rounded, cut off or rounded up. Steps of no digit and of two then come at regular distances. With few of
/// them the stamps may as well be those of an interval of one digit, of which samples were lost: see
/// evidence_for_line().
class EvenClock {
 public:
  /// t [s]; place [s] of the last digit written, 0 where unknown.
  void add(double t, double place);

  std::size_t count() const { return count_; }
  /// The clock, if at least two stamps were even: it starts at the first stamp, and of all rates that fit it has the
  /// one with the fewest digits in Hz or in s. A clock that fits to rounding alone, without q and 1e-4 D,
  /// comes first. A stated rate [Hz] that fits is the rate.
  std::optional<Timeline> timeline(std::optional<double> stated = {}) const;
  /// Whether a clock that something else states (start [s], rate [Hz]) agrees with every stamp.
  bool allows(const Timeline& stated) const;

 private:
  struct Interval {
    double low = 0.0;
    double high = std::numeric_limits<double>::infinity();
    bool empty() const { return !(low <= high && high > 0.0); }
    bool holds(double interval) const { return interval >= low && interval <= high; }
  };

  void add_to_strip(double t, double place, double k);
  /// The allowed dt, as the lines are that pass the stamps; empty where none does, or where it is not clear that one
  /// does rather than that samples were lost. A stated interval [s] may be what makes it clear.
  Interval by_line(std::optional<double> stated) const;

  std::size_t count_ = 0;
  double first_ = 0.0;
  double place_ = 0.0;  ///< of the first two stamps
  Interval written_;    ///< of dt [s], within the digits written
  Interval exact_;      ///< to rounding alone
  double last_ = 0.0;
  double digit_ = 0.0;                 ///< [s] place of the first stamp
  std::optional<Strip> lines_;         ///< in digits; none where no line passes the stamps, or the digits are fine
  double gaps_ = 0.0, repeats_ = 0.0;  ///< steps of more than one digit, and of none
};

}  // namespace tumble::file
