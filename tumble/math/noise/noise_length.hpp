#pragma once

#include <cstddef>
#include <vector>

#include "tumble/math/noise/noise_likelihood.hpp"

namespace tumble {

/// How much longer a record of the noise that `fit` found has to be, from the information that its frequencies would
/// hold: those of the record itself more often, and the lower ones that a longer record adds.
class RecordLength {
 public:
  RecordLength(const NoiseBands& bands, const NoiseFit& fit);

  /// Times the length of the record at which the standard uncertainty of a parameter is `sd`; index and units as in
  /// NoiseFit::covariance. A term that is not in the model is tried beside the others at zero. At least 1e-3, and
  /// infinite beyond 1e5. The filter counts as known. Given: sd [unit of the parameter]. Returned: ratio of lengths
  /// [1].
  double times_for(std::size_t parameter, double sd) const;

  /// Standard uncertainty [unit of the parameter] from a record `times` [1] as long.
  double sd_of(std::size_t parameter, double times) const;

 private:
  std::vector<NoiseBand> bands_;  ///< white noise as it was filtered
  const NoiseFit& fit_;
  double longest_;  ///< [samples] of the sines: half a cycle of the lowest frequency
};

}  // namespace tumble
