#include "tumble/tasks/validation/coverage.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/normal.hpp"

namespace tumble::validation {
namespace {

/// Its place in the truth; absent: not there.
std::optional<std::size_t> place_in_truth(const Bench& bench, const std::string& name) {
  const auto found = std::ranges::find(bench.truth, name, [](const auto& one) { return one.first; });
  if (found == bench.truth.end()) return std::nullopt;
  return static_cast<std::size_t>(found - bench.truth.begin());
}

std::optional<double> predicted_sd(const Bench& bench, const std::string& name) {
  if (!bench.predicted) return std::nullopt;
  const Parameter* found = find_parameter(*bench.predicted, name);
  if (found == nullptr) return std::nullopt;
  const double sd =
      standard_uncertainty(*bench.predicted, static_cast<std::size_t>(found - bench.predicted->parameters.data()));
  return sd > 0.0 && std::isfinite(sd) ? std::optional(sd) : std::nullopt;
}

ValidatedParameter validated(const Bench& bench, std::size_t j) {
  ValidatedParameter out{.name = bench.parameters[j].name,
                         .symbol = bench.parameters[j].symbol,
                         .unit = bench.parameters[j].unit,
                         .truth = {},
                         .predicted = predicted_sd(bench, bench.parameters[j].name)};
  const auto place = place_in_truth(bench, out.name);
  if (place) out.truth = bench.truth[*place].second;
  double sum = 0.0, squares = 0.0, variances = 0.0;
  const double about = bench.parameters[j].value;  // near all of them, so that squares do not cancel
  for (const Outcome& one : bench.sound) {
    if (!one.answer.refusal.empty() || std::isnan(one.values[j])) continue;
    ++out.tests;
    sum += one.values[j] - about;
    squares += (one.values[j] - about) * (one.values[j] - about);
    variances += one.sds[j] * one.sds[j];
    if (place) out.held += std::abs(one.answer.deviations[*place]) <= normal_two_sided_95 ? 1 : 0;
  }
  const auto n = static_cast<double>(out.tests);
  out.scatter = out.tests > 1 ? std::sqrt(std::max(0.0, squares - sum * sum / n) / (n - 1.0)) : 0.0;
  out.stated = std::sqrt(variances / n);
  if (out.truth) out.bias = about + sum / n - *out.truth;
  const auto [lower, upper] = share_interval(out.held, out.tests, normal_two_sided_95);
  out.coverage_lower = lower, out.coverage_upper = upper;
  return out;
}

}  // namespace

ShareInterval share_interval(std::size_t count, std::size_t tests, double sd) {
  if (tests == 0) return {};
  const auto n = static_cast<double>(tests), share = static_cast<double>(count) / n;
  const double z2 = sd * sd / n;
  const double middle = (share + 0.5 * z2) / (1.0 + z2);
  const double half = sd / (1.0 + z2) * std::sqrt(share * (1.0 - share) / n + 0.25 * z2 / n);
  return {std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

std::vector<ValidatedParameter> validated_parameters(const Bench& bench) {
  std::vector<ValidatedParameter> all;
  for (std::size_t j = 0; j < bench.parameters.size(); ++j) all.push_back(validated(bench, j));
  std::erase_if(all, [](const ValidatedParameter& one) { return one.tests == 0; });
  return all;
}

}  // namespace tumble::validation
