#pragma once

#include <vector>

namespace tumble::frequency_response {

/// Loss of amplitude of a tone by flat tops.
struct FlatTops {
  double loss = 0.0;         ///< [1] of the amplitude of the fundamental; 0: none
  double improvement = 0.0;  ///< of chi-square against harmonics 2 and 3 alone
  bool found = false;        ///< chi-square falls by 40 and more, and to four fifths
};

/// Whether the tops of a tone are flat beneath its noise. The values are averaged over 64 parts of the cycle, and
///
///   a + A g(psi) + harmonics 2 and 3,     g = cos(psi) cut at cos(high) and -cos(low)
///
/// is fitted for angles of 0 to 80 deg on either side. Distortion of the motion is in the harmonics, and a smooth
/// nonlinearity is too.
///
/// Given     phase   [rad] of each value from the peak of the tone
///           values  [u], NaN where missing, without drift
FlatTops flat_tops(const std::vector<double>& phase, const std::vector<double>& values);

}  // namespace tumble::frequency_response
