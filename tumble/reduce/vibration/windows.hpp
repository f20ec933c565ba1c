#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/core/finding.hpp"

namespace tumble::vibration {

/// The windows of one channel: when each began and how long it counted.
struct Windows {
  std::vector<double> begin;   ///< [s]
  std::vector<double> length;  ///< [s]
  std::vector<bool> usable;  ///< false: missing, or beside a gap, where a count may hold the pulses of several windows
  double window = 0.0;       ///< [s] mean
  double scatter = 0.0;      ///< [s] rms of the stamps about an even clock
  bool by_stamps = false;    ///< each window lasts from its stamp to the next
};

/// Windows by an even clock: stamps that come late are corrected, gaps stay open. `usable` is false for missing samples
/// and for their neighbours. Throws Error::bad_data for fewer than 16 samples or stamps that run backwards.
Windows even_windows(const Channel& channel, Findings& findings);

/// Windows that last from stamp to stamp; the last window, and windows beside a gap, are not usable.
Windows stamped_windows(const Channel& channel, const Windows& even);

/// Whether counts taken at a constant input follow the time between the stamps (1) or not (0) [1]: the slope of count
/// over mean count against interval over mean interval. NaN: the stamps do not scatter, or too little to know the slope
/// to a tenth.
double slope_with_interval(const Channel& channel, const std::vector<std::pair<double, double>>& at_rest);

/// Counts of a register of n bits that overflowed: each is put within half of 2^n of `expected`.
///
/// Suspected where all counts fit into n bits although expected +- reach, their range by the plan, does not; repaired
/// where all of them then lie well within that half and scatter less; ambiguous where they do not, although the mean of
/// the recorded counts differs from the expected one, or they fill the register from end to end.
struct Unwrapped {
  enum class Outcome { sound, repaired, ambiguous };
  Outcome outcome = Outcome::sound;
  int bits = 0;
  std::size_t windows = 0;  ///< moved
};
/// Given: counts [pulse], repaired in place; expected, reach [pulse].
Unwrapped unwrap(std::vector<double>& counts, double expected, double reach);

/// Why windows cannot show a sine of this frequency: a null of their mean, or half of their rate, where sine and cosine
/// are one. None: they can.
///
/// Given: frequency [Hz] > 0; window [s] over which a sample is the mean; interval [s] from one to the next; span [s]
/// measured; where, the place of the finding.
std::optional<Finding> hidden_tone(double frequency, double window, double interval, double span,
                                   const std::string& where);

}  // namespace tumble::vibration
