#include "tumble/methods/allan_noise/rounding.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/checks/grain.hpp"
#include "tumble/math/square.hpp"

namespace tumble::allan_noise {
namespace {

/// [1] of the variance of the record's white noise, that rounding may be: noise of 0.43 steps has 0.31. What is coarser is
/// an output that shows its steps and hardly the noise.
constexpr double most_rounding = 0.31;

const FittedTerm* term_of(const NoiseFit& fit, NoiseTerm which) {
  const auto found = std::ranges::find(fit.terms, which, [](const FittedTerm& term) { return term.unit.term; });
  return found == fit.terms.end() ? nullptr : &*found;
}

/// The uncertainty of a value whose square loses what is known grows as the value shrinks.
void scale_uncertainty(std::size_t term, double by, NoiseFit& fit) {
  for (std::size_t i = 0; i < fit.value.size(); ++i) {
    fit.value_covariance(term, i) *= by;
    fit.value_covariance(i, term) *= by;
  }
  fit.value_error_variance[term] *= by * by;
}

}  // namespace

void take_rounding_out(std::span<const double> values, ChannelNoise& result) {
  NoiseFit& fit = result.fit;
  const FittedTerm *white = term_of(fit, NoiseTerm::white), *counted = term_of(fit, NoiseTerm::quantization);
  if (white == nullptr || !white->kept || fit.filter.given() || (counted != nullptr && counted->kept)) return;
  const auto at = static_cast<std::size_t>(white - fit.terms.data());
  const Grain grain = grain_of(values);
  const double rounding = square(grain.step) / 12.0, record = fit.value[at];
  if (!(rounding > 0.0) || rounding > most_rounding * square(record)) return;
  if (counted != nullptr && counted->upper_limit >= rounding) return;
  fit.value[at] = std::sqrt(square(record) - rounding);
  scale_uncertainty(at, record / fit.value[at], fit);
  const TermWords said = words(NoiseTerm::white, result.kind);
  result.findings.push_back({Finding::Severity::info,
                             "rounding_taken_out",
                             {{"term", said.name},
                              {"step", grain.step, rate_unit(result.kind)},
                              {"record", coefficient(NoiseTerm::white, square(record), result.rate), said.unit},
                              {"share", rounding / square(record), "%"}},
                             result.label});
}

}  // namespace tumble::allan_noise
