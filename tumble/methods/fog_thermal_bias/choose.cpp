#include <algorithm>
#include <cmath>

#include "tumble/methods/fog_thermal_bias/fit.hpp"
#include "tumble/units/error.hpp"

namespace tumble::fog_thermal_bias {

std::size_t choose(const std::vector<Candidate>& candidates) {
  std::size_t best = candidates.size();
  for (std::size_t c = 0; c < candidates.size(); ++c)
    if (candidates[c].unobservable.empty() && std::isfinite(candidates[c].aicc) &&
        (best == candidates.size() || candidates[c].aicc < candidates[best].aicc))
      best = c;
  if (best < candidates.size()) return best;
  throw Error(Error::Kind::bad_data,
              say("the recordings do not determine any of the models; they do not show {}. Add runs that cross the "
                  "temperature range in both directions, at two ramp rates, with dwells, from at least as many start "
                  "temperatures as the polynomial has terms",
                  Sentence(candidates.front().unobservable.c_str())));
}

std::size_t largest_supported(const std::vector<Candidate>& candidates, std::size_t chosen) {
  constexpr double unsupported = 10.0;  // in AICc: a weight of exp(-5) beside the chosen model
  const auto supported = [&](const Candidate& c) {
    return c.unobservable.empty() && c.aicc <= candidates[chosen].aicc + unsupported;
  };
  int temperature = 0, gradient = 0, rate = 0;
  for (const Candidate& c : candidates) {
    if (!supported(c)) continue;
    temperature = std::max(temperature, c.temperature);
    gradient = std::max(gradient, c.gradient);
    rate = std::max(rate, c.rate);
  }
  std::size_t largest = chosen;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    const Candidate &c = candidates[k], &least = candidates[chosen];
    const bool all = c.temperature == temperature && c.gradient == gradient && c.rate == rate;
    const bool holds_chosen =
        c.temperature >= least.temperature && c.gradient >= least.gradient && c.rate >= least.rate;
    if (all && c.unobservable.empty()) return k;
    if (holds_chosen && supported(c) && c.columns.size() > candidates[largest].columns.size()) largest = k;
  }
  return largest;
}

}  // namespace tumble::fog_thermal_bias
