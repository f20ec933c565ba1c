#include "tumble/archive/statistics/unstated_rigs.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/math/square.hpp"
#include "tumble/reduce/rig_keys.hpp"

namespace tumble::statistics {
namespace {

/// Of a private sd that remains where errors of the rig give all of it: another result is never without its own.
constexpr double least_private = 1e-2;

/// The errors of a rig that the result does not name, of one parameter.
std::vector<deposits::KeyedError> unstated_errors(const Estimate& estimate, const std::string& name) {
  std::vector<deposits::KeyedError> errors;
  const auto* parameter = find_parameter(estimate, name);
  if (!parameter || estimate.provenance.seed) return errors;
  const auto row = static_cast<std::size_t>(parameter - estimate.parameters.data());
  for (const auto& line : estimate.budget)
    for (std::size_t k = 0; line.key.empty() && rig_keys::is_error_of_rig(line.source) && k < line.factor.columns; ++k)
      errors.push_back({line.source + "\n" + rig_keys::unstated + "\n" + std::to_string(k), line.factor(row, k)});
  return errors;
}

double without(double private_sd, double variance) {
  const double left = square(private_sd) - variance;
  return std::sqrt(std::max(left, square(least_private * private_sd)));
}

}  // namespace

bool share_unstated_rigs(PastResults& results, std::vector<Occasion>& occasions, SharedBySource& errors) {
  std::map<std::int64_t, double> variance;  // that goes, by sources
  for (const auto& occasion : occasions) {
    const auto [place, is_new] = variance.try_emplace(occasion.sources, 0.0);
    if (!is_new) continue;
    for (auto& error : unstated_errors(results.read.estimate(occasion.result), results.over.parameter)) {
      place->second += square(error.factor);
      errors[occasion.sources].push_back(std::move(error));
    }
  }
  for (auto& occasion : occasions)
    occasion.private_sd =
        without(occasion.private_sd, variance[occasion.sources] / static_cast<double>(occasion.results));
  for (auto& value : results.over.values)
    if (const auto found = variance.find(value.sources); found != variance.end() && std::isfinite(value.private_sd))
      value.private_sd = without(value.private_sd, found->second);
  return std::ranges::any_of(variance, [](const auto& entry) { return entry.second > 0.0; });
}

}  // namespace tumble::statistics
