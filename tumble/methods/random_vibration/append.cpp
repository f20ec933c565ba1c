#include <algorithm>
#include <cmath>
#include <functional>

#include "tumble/methods/random_vibration/statistics.hpp"
#include "tumble/reduce/answer.hpp"

namespace tumble::random_vibration {
namespace {

constexpr double agrees_sd = 2.5;  ///< [sd] within which density and expected density agree
/// Degrees of freedom of the expected density: it is half a factor of two uncertain.
constexpr double most_expected = 8.0;
constexpr double fixed_freedom = 1e6;  ///< of what is known

/// Key of the errors that the vibrations of a test share; no other result has it, so it is removed in the end.
constexpr const char* this_test = "this test";

/// One source: a covariance of all statistics, and the degrees of freedom each part of its diagonal is known with.
struct Source {
  std::string name;
  Matrix covariance;
  std::vector<double> freedom;
};

/// The density at zero, combined with the expected one as far as the two agree: the expectation rests on the noise at
/// rest, and a vibration without reference hides its own density at zero beneath the motion.
DensityAtZero joined(DensityAtZero density, double expected, double freedom) {
  if (expected < 0.0) return density;
  const double of_expected = 2.0 * expected * expected / std::max(1.0, freedom), of_density = density.covariance(0, 0);
  if (density.white - expected > agrees_sd * std::sqrt(of_density + of_expected)) return density;
  // It is a model (no K_3, no noise that the vibration raises), less reliable than its own evidence suggests.
  freedom = std::min(freedom, most_expected);
  const double own = of_density > 0.0 ? 2.0 * density.white * density.white / of_density : 0.0;
  const double all = own + freedom;
  density.white = std::max(expected, (own * density.white + freedom * expected) / all);
  density.covariance(0, 0) = 2.0 * density.white * density.white / all;
  density.covariance(0, 1) = density.covariance(1, 0) = 0.0;
  return density;
}

/// Sum of the weights of the windows that are not missing.
double share_present(const Statistic& s, const std::vector<double>& weights) {
  double share = 0.0;
  for (std::size_t j = 0; j < weights.size(); ++j)
    if (std::isfinite(s.influence[j])) share += weights[j];
  return share;
}

/// Chance in the vibration and the noise during it.
Source chance(const Exposure& exposure, const std::vector<Statistic>& statistics) {
  const std::size_t m = statistics.size();
  Source source{"chance in the vibration", Matrix(m, m), std::vector<double>(m, 1e6)};
  std::vector<std::span<const double>> series;
  std::vector<std::size_t> index;
  const std::size_t n = exposure.weights.size();
  for (std::size_t i = 0; i < m; ++i)
    if (!statistics[i].influence.empty()) {
      series.push_back(std::span(statistics[i].influence).first(n));
      index.push_back(i);
    }
  const LongRun run = long_run(series, 0.02, false);
  const auto even = faded_weights(n, 0.0);
  std::vector<double> sd;
  for (std::size_t k = 0; k < index.size(); ++k) {
    const Statistic& s = statistics[index[k]];
    const auto sum = variance_of_sum(joined(run.density[k], s.expected_white, s.expected_freedom),
                                     s.faded ? exposure.weights : even);
    sd.push_back(std::sqrt(sum.variance) / share_present(s, s.faded ? exposure.weights : even));
    source.freedom[index[k]] = sum.degrees_of_freedom;
  }
  for (std::size_t k = 0; k < index.size(); ++k)
    for (std::size_t l = 0; l < index.size(); ++l)
      source.covariance(index[k], index[l]) = run.correlation(k, l) * sd[k] * sd[l];
  return source;
}

/// Covariance of ranges: the scatter of the ranges of the blocks. The greatest of many has the scale of the greatest of
/// few (Gumbel), except for the slow approach of normal numbers to it, which `shrinking` corrects.
void add_ranges(const std::vector<Statistic>& statistics, Source& source) {
  std::vector<double> mean(statistics.size(), 0.0);
  for (std::size_t i = 0; i < statistics.size(); ++i)
    for (const double r : statistics[i].ranges) mean[i] += r / static_cast<double>(statistics[i].ranges.size());
  for (std::size_t i = 0; i < statistics.size(); ++i) {
    const auto& a = statistics[i].ranges;
    if (a.empty()) continue;
    source.freedom[i] = static_cast<double>(a.size() - 1);
    for (std::size_t j = 0; j < statistics.size(); ++j) {
      const auto& b = statistics[j].ranges;
      if (b.empty()) continue;
      double sum = 0.0;
      for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - mean[i]) * (b[k] - mean[j]);
      source.covariance(i, j) =
          statistics[i].shrinking * statistics[j].shrinking * sum / static_cast<double>(a.size() - 1);
    }
  }
}

/// An error of each unit, independent between them, that acts by the derivatives `slopes`.
Source of_units(const std::string& name, const std::vector<Statistic>& statistics, const Exposure& exposure,
                std::map<std::size_t, double> Statistic::*slopes,
                const std::function<double(const Measured&)>& variance,
                const std::function<double(const Measured&)>& freedom) {
  const std::size_t m = statistics.size();
  Source source{name, Matrix(m, m), std::vector<double>(m, 0.0)};
  for (const Measured& unit : exposure.units) {
    const double v = variance(unit);
    for (std::size_t i = 0; i < m; ++i) {
      const auto& a = statistics[i].*slopes;
      if (!a.contains(unit.unit)) continue;
      const double own = a.at(unit.unit) * a.at(unit.unit) * v;
      source.freedom[i] += own * own / freedom(unit);
      for (std::size_t j = 0; j < m; ++j)
        if (const auto& b = statistics[j].*slopes; b.contains(unit.unit))
          source.covariance(i, j) += a.at(unit.unit) * b.at(unit.unit) * v;
    }
  }
  for (std::size_t i = 0; i < m; ++i) {
    const double v = source.covariance(i, i);
    source.freedom[i] = source.freedom[i] > 0.0 ? v * v / source.freedom[i] : fixed_freedom;
  }
  return source;
}

/// Errors that all vibrations of a test share, of relative size `sd`: one, or one for each unit.
ErrorLine in_common(const char* name, const std::vector<Statistic>& statistics, std::size_t errors,
                    const std::function<double(const Statistic&, std::size_t error)>& shift) {
  ErrorLine line{name, Matrix(statistics.size(), errors), this_test, std::vector<double>(statistics.size(), 1e6)};
  for (std::size_t k = 0; k < errors; ++k)
    for (std::size_t i = 0; i < statistics.size(); ++i) line.factor(i, k) = shift(statistics[i], k);
  return line;
}

ErrorLine line_from(const Source& source) {
  ErrorLine line = from_covariance(source.name, source.covariance);
  line.degrees_of_freedom = source.freedom;
  return line;
}

std::vector<ErrorLine> lines_of(const Exposure& exposure, const vibration::Data& data,
                                const std::vector<Statistic>& statistics) {
  Source first = chance(exposure, statistics);
  add_ranges(statistics, first);
  const Source rest = of_units(
      "means at rest", statistics, exposure, &Statistic::rest, [](const Measured& u) { return u.rest.variance; },
      [](const Measured& u) { return u.rest.degrees_of_freedom; });
  const Source slow = of_units(
      "slow noise", statistics, exposure, &Statistic::rest, [](const Measured& u) { return u.rest.slow_variance; },
      [](const Measured&) { return 4.0; });
  return {line_from(first),
          line_from(rest),
          line_from(slow),
          in_common("level of the vibration", statistics, 1,
                    [&](const Statistic& s, std::size_t) { return s.level * exposure.level_sd; }),
          in_common("gain of the reference", statistics, 1,
                    [&](const Statistic& s, std::size_t) { return s.gain * exposure.rms_sd; }),
          in_common("scale factor", statistics, data.units.size(),
                    [&](const Statistic& s, std::size_t unit) {
                      const auto slope = s.scale.find(unit);
                      return slope == s.scale.end() ? 0.0 : slope->second * data.units[unit].scale_relative_sd;
                    }),
          in_common("motion across the input axis", statistics, 2 * data.units.size(),
                    [&](const Statistic& s, std::size_t error) {
                      const auto slope = s.rest.find(error / 2);  // a mean at rest is subtracted from the mean shift
                      return slope == s.rest.end()
                                 ? 0.0
                                 : -slope->second * exposure.across[error % 2] * exposure.rms * exposure.rms;
                    })};
}

}  // namespace

void append(const Exposure& exposure, const vibration::Data& data, const std::vector<Statistic>& statistics,
            Estimate& estimate) {
  Estimate part;
  for (const auto& statistic : statistics) {
    part.parameters.push_back(statistic.parameter);
    part.parameters.back().degrees_of_freedom = 1e6;
  }
  settle(part, lines_of(exposure, data, statistics));
  tumble::append(estimate, part);
}

void forget_shared(Estimate& estimate) {
  for (auto& line : estimate.budget)
    if (line.key == this_test) line.key.clear();
}

}  // namespace tumble::random_vibration
