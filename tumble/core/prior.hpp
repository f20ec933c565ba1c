#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace tumble {

struct Estimate;

/// Where an estimate is that of a further unit of a model, made from the results of the units tested before: its
/// values are the means, its covariance is that of the units about them, and its budget says which part of it other
/// results share.
struct PopulationFacts {
  std::string method;      ///< of the results
  std::string sha256;      ///< over model, method and the SHA-256 of each result
  std::size_t units = 0;   ///< tested ones
  double shrinkage = 0.0;  ///< nu [1] of docs/equations (8.11); infinite: correlations are not used
  double inflation = 1.0;  ///< c [1] of docs/equations (8.17)
};

/// The prior that a plan asks for.
struct PriorChoice {
  std::string from;                                      ///< "archive", or a file; empty: none
  bool verdicts = false;                                 ///< limits are judged by the estimate with prior
  std::shared_ptr<const Estimate> population = nullptr;  ///< null until it is read
  std::string sha256 = {};                               ///< of the bytes of a file
};

/// The answer with a prior, beside the one without.
struct PriorUse {
  std::string from;
  bool verdicts = false;
  std::shared_ptr<const Estimate> population;  ///< mean, covariance and budget of the prior
  std::shared_ptr<const Estimate> with_prior;  ///< null: the unit does not fit its population, and no prior is used
  double belongs = 1.0;         ///< p-value [1] of all parameters together, if the unit is of the population
  double belongs_by_one = 1.0;  ///< p-value [1] of the parameter that fits worst, by Holm's rule
};

}  // namespace tumble
