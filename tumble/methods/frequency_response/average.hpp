#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "tumble/methods/frequency_response/loop.hpp"

namespace tumble::frequency_response {

/// A fit that the data support.
struct Supported {
  const LoopFit* fit = nullptr;
  double weight = 1.0;  ///< exp(-d/2) over the sum of all, d its chi-square above the least
};

/// The accepted fits within 10 of the least AICc; those that lie farther weigh less than 0.7 %. Empty: none is
/// accepted.
std::vector<Supported> supported(const std::vector<LoopFit>& fits);

/// A function of the response, averaged over the models.
struct Averaged {
  bool found = false;
  double value = 0.0;
  std::vector<double> gradient;  ///< by log_gain 1..n, phase 1..n
  std::vector<double> spread;    ///< by which the models differ from it: its square is a variance, see below
};

/// Mean over the models that have this function, with the covariance of a mean over models:
///
///   mean = sum w x,   covariance = sum w (C + (x - mean)(x - mean)')
///
/// A model with a pole more takes from the delay what the pole lags by; which of them is right the data may leave open,
/// and the interval of either alone then does not hold.
///
/// Given     of   value and gradient over theta; nothing where the model lacks it
/// Returned: gradient g = sum w g_m; spread with one column a model of sqrt(w_m) (x_m - mean), and 2n of
///           sqrt(w_m) (g_m - g) sd, so that gradient and spread together give the covariance of two such functions
/// See       decision 045
Averaged averaged(const std::vector<Supported>& models, const Measured& measured,
                  const std::function<std::optional<Derived>(const LoopFit&)>& of);

}  // namespace tumble::frequency_response
