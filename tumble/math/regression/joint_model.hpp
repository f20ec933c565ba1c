#pragma once

#include <span>
#include <string>
#include <vector>

#include "tumble/math/regression/mixed_model.hpp"

namespace tumble {

/// A known disturbance as the observations show it.
struct FoundEffect {
  std::string source;
  std::string draw;    ///< as in KnownEffect::draws
  double value = 0.0;  ///< in units of its standard deviation
  double sd = 1.0;     ///< what of it the observations leave open; 1: they show nothing
};

struct JointFit {
  MixedFit fit;                      ///< parameters of all outputs, in order; a source of one name is one line
  std::vector<FoundEffect> effects;  ///< those that outputs share; empty where predicted
};

/// Generalised least squares of several outputs observed together: each has parameters and noise of its own, and known
/// effects whose draws have the same name move them together. So the part of a disturbance that one output shows is
/// subtracted from the others.
///
/// Given     outputs   [M] as fit_mixed_model or predict_mixed_model took them; observations in all or in none
///           alone     [M] what these gave: the variances of noise and slow noise are taken from them
/// Throws    Error::bad_data as fit_mixed_model
/// See       Henderson, Biometrics 31 (1975) 423: prediction of random effects
JointFit fit_joint_model(std::span<const MixedData> outputs, std::span<const MixedFit> alone);

}  // namespace tumble
