#include "tumble/archive/deposits/sources.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/archive/schema/shape.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/math/square.hpp"

namespace tumble::deposits {

std::vector<KeyedError> keyed_errors(const Estimate& estimate, std::size_t parameter) {
  constexpr double negligible = 1e-4;
  std::vector<KeyedError> errors;
  if (estimate.provenance.seed) return errors;
  const double least = negligible * square(standard_uncertainty(estimate, parameter));
  for (const auto& line : estimate.budget)
    for (std::size_t k = 0; !line.key.empty() && k < line.factor.columns; ++k)
      if (const double factor = line.factor(parameter, k); square(factor) > least)
        errors.push_back({line.source + "\n" + line.key + "\n" + std::to_string(k), factor});
  std::ranges::stable_sort(errors, {}, &KeyedError::name);
  return errors;
}

ErrorSources sources_of(const Estimate& estimate, std::size_t parameter) {
  double variance = square(standard_uncertainty(estimate, parameter));
  std::string names;
  for (const auto& [name, factor] : keyed_errors(estimate, parameter)) {
    variance -= square(factor);
    names += (factor < 0.0 ? "-" : "+") + name + "\n";
  }
  return {std::sqrt(std::max(0.0, variance)), names.empty() ? 0 : schema::number_of(sha256_of(names))};
}

}  // namespace tumble::deposits
