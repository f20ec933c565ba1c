#pragma once

#include <span>
#include <vector>

namespace tumble {

/// A line that explains ticks which are empty, or doubled, at regular distances, of a clock near one tick: z = a + r x.
struct Comb {
  double a = 0.0, r = 1.0;          ///< [tick]
  double off_a = 0.5, off_r = 0.0;  ///< [tick] how far they may be off
};

/// Samples at r ticks with r above 1 skip a tick each time that r - 1 has summed up to a whole one: at every c + k P,
/// rounded, with 1/P = 1 - 1/r. Lost samples leave ticks empty as well, anywhere, but fill none of these: the comb is
/// complete. So it is looked for from pairs of the empty ticks, and the one with the most teeth is taken.
///
/// Given     whole  stamps [tick] in order, whole numbers that begin with 0; r up to 1.02 is looked for
/// Returned  none of five teeth or more, or one
std::vector<Comb> comb_of_empty_ticks(std::span<const double> whole);

/// Samples at r ticks with r below 1 double a tick at every c + k P, with 1/P = 1/r - 1; a lost sample may take a
/// tooth, and adds none. The period is that of the lowest strong line in the spectrum of the doubled ticks; its
/// harmonics make it exact.
///
/// Given     whole  [tick] as above; r from 0.98 on is looked for
/// Returned  none where no line is above what ticks anywhere make, or one
std::vector<Comb> comb_of_doubled_ticks(std::span<const double> whole);

}  // namespace tumble
