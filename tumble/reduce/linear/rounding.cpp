#include "tumble/reduce/linear/rounding.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::linear {
namespace {

constexpr int waves = 6;        ///< of the sawtooth that go together from one number to another: 91 % of its variance
constexpr int all_waves = 300;  ///< that count in the variance
/// [1] by which coefficients are further off than by errors that are independent: what simulations of 13 rates show.
constexpr double go_together = 2.0;
/// [steps] that the output of a segment may change by: over a tenth of a step the rounding error is one.
constexpr double most_moved = 0.1;
constexpr double least_share = 1e-3;  ///< [1] of the greatest eigenvalue: smaller ones are the part of each alone

/// c_k of the sawtooth [steps].
double wave(int k, double noise) {
  const double size = std::exp(-0.5 * square(two_pi * k * noise)) / (pi * k);
  return k % 2 == 0 ? -size : size;
}

/// E[sin(2 pi k x) sin(2 pi l y)] of normal x and y.
double mean_product(int k, double x, double xx, int l, double y, double yy, double xy) {
  const auto mean_cosine = [](double at, double variance) {
    return std::cos(two_pi * at) * std::exp(-0.5 * square(two_pi) * std::max(0.0, variance));
  };
  const double squares = k * k * xx + l * l * yy, mixed = 2.0 * k * l * xy;
  return 0.5 * (mean_cosine(k * x - l * y, squares - mixed) - mean_cosine(k * x + l * y, squares + mixed));
}

/// The value that all samples of a stretch have; NaN: they differ.
double only_value(const Stretch& stretch) {
  double only = std::nan("");
  for (const double v : stretch.values) {
    if (std::isnan(v) || v == only) continue;
    if (!std::isnan(only)) return std::nan("");
    only = v;
  }
  return only;
}

/// The segments whose means are rounded: their outputs by the first look, and what positions add to them, each by itself.
struct Places {
  std::vector<std::size_t> segment;
  std::vector<double> place, own;  ///< [steps], [steps^2]
  Matrix design;                   ///< [SI of the column] mean rows
};

Places places_of(const Work& work, const CoarseOutput& coarse) {
  const std::size_t all = work.evidence.test.stretches.size(), columns = work.used.size();
  std::vector<double> weight(all, 0.0), output(all, 0.0), own(all, 0.0);
  Matrix rows(all, columns);
  for (std::size_t i = 0; i < work.rows.segment.size(); ++i) {
    const std::size_t g = work.rows.segment[i];
    const double w = work.rows.weights[i];
    weight[g] += w;
    output[g] += w * work.rows.input[i];
    for (std::size_t k = 0; k < columns; ++k) {
      rows(g, k) += w * work.data.design(i, k);
      output[g] += w * work.data.design(i, k) * work.coefficients[work.used[k]];
    }
    for (const KnownEffect& effect : work.data.effects)
      if (effect.each_segment) own[g] = std::max(own[g], square(effect.column[i]));
  }
  Places places;
  for (std::size_t g = 0; g < all; ++g) {
    if (!(weight[g] > 0.0) || !work.rounded[g]) continue;
    places.segment.push_back(g);
    places.place.push_back((output[g] / weight[g] - coarse.level) / coarse.step);
    places.own.push_back(own[g] / square(coarse.step));
  }
  places.design = Matrix(places.segment.size(), columns);
  for (std::size_t a = 0; a < places.segment.size(); ++a)
    for (std::size_t k = 0; k < columns; ++k)
      places.design(a, k) = rows(places.segment[a], k) / weight[places.segment[a]] / coarse.step;
  return places;
}

/// How well the coefficients place the outputs [steps^2], by means that are off by rounding.
Matrix uncertainty_of(const Places& places, double rounding_sd) {
  const auto scale = inverses(column_norms(places.design), 1e-300);
  const Matrix unit = scaled_columns(places.design, scale);
  Matrix uncertainty = square(go_together * rounding_sd) * sandwich(unit, inverse_symmetric(gram(unit)));
  for (std::size_t a = 0; a < uncertainty.rows; ++a) uncertainty(a, a) += places.own[a];
  return uncertainty;
}

/// Effects of this covariance [steps^2] of the segments: what they have together, and what each has alone.
std::vector<KnownEffect> effects_of(const Matrix& covariance, const Places& places, const Work& work, double step) {
  const SymmetricEigen eigen = eigen_symmetric(covariance);
  const std::size_t n = places.segment.size(), rows = work.rows.segment.size();
  const double most = eigen.values.back(), alone = std::max(eigen.values.front(), least_share * most);
  std::vector<std::size_t> place(work.evidence.test.stretches.size(), n);
  for (std::size_t a = 0; a < n; ++a) place[places.segment[a]] = a;
  const auto column_of = [&](const auto& size) {
    std::vector<double> column(rows, 0.0);
    for (std::size_t i = 0; i < rows; ++i)
      if (const std::size_t a = place[work.rows.segment[i]]; a < n) column[i] = step * size(a);
    return column;
  };
  std::vector<KnownEffect> effects;
  for (std::size_t k = 0; k < n; ++k) {
    const double beyond = eigen.values[k] - alone;
    if (beyond < least_share * most) continue;
    effects.push_back(
        {rounding_source, column_of([&](std::size_t a) { return std::sqrt(beyond) * eigen.vectors(a, k); })});
  }
  effects.push_back({rounding_source, column_of([&](std::size_t) { return std::sqrt(alone); }), true});
  return effects;
}

/// Rounding of each segment by itself: where the coefficients do not place them.
KnownEffect each_alone(const Work& work, double sd) {
  KnownEffect own{rounding_source, std::vector<double>(work.rows.segment.size(), 0.0), true};
  for (std::size_t i = 0; i < own.column.size(); ++i)
    if (work.rounded[work.rows.segment[i]]) own.column[i] = sd;
  return own;
}

/// Alike, of the segments that show one and the same value: their true values lie within one step, on one side of its middle
/// perhaps.
std::vector<KnownEffect> of_equal_values(const Work& work, double sd) {
  const std::size_t rows = work.rows.segment.size();
  std::map<double, std::vector<double>> alike;
  std::map<double, std::set<std::size_t>> segments;
  for (std::size_t i = 0; i < rows; ++i) {
    const std::size_t g = work.rows.segment[i];
    if (!work.rounded[g]) continue;
    const double value = only_value(work.evidence.test.stretches[g]);
    if (std::isnan(value)) continue;
    segments[value].insert(g);
    alike.try_emplace(value, rows, 0.0).first->second[i] = sd;
  }
  std::vector<KnownEffect> effects;
  for (auto& [value, column] : alike)
    if (segments[value].size() > 1) effects.push_back({rounding_source, std::move(column)});
  return effects;
}

}  // namespace

Matrix rounding_covariance(const std::vector<double>& places, const Matrix& uncertainty, double noise) {
  const std::size_t n = places.size();
  Matrix covariance(n, n);
  double rest = 0.0;
  for (int k = waves + 1; k <= all_waves; ++k) rest += 0.5 * square(wave(k, noise));
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      double sum = a == b ? rest : 0.0;
      for (int k = 1; k <= waves; ++k)
        for (int l = 1; l <= waves; ++l)
          sum += wave(k, noise) * wave(l, noise) *
                 mean_product(k, places[a], uncertainty(a, a), l, places[b], uncertainty(b, b), uncertainty(a, b));
      covariance(a, b) = covariance(b, a) = sum;
    }
  return covariance;
}

std::vector<bool> rounded_alike(const Work& work, double step) {
  const std::size_t all = work.evidence.test.stretches.size();
  std::vector<double> least(all, INFINITY), most(all, -INFINITY);
  for (std::size_t i = 0; i < work.rows.segment.size(); ++i) {
    double output = work.rows.input[i];
    for (std::size_t k = 0; k < work.used.size(); ++k)
      output += work.data.design(i, k) * work.coefficients[work.used[k]];
    double& low = least[work.rows.segment[i]];
    double& high = most[work.rows.segment[i]];
    low = std::min(low, output), high = std::max(high, output);
  }
  std::vector<bool> alike(all);
  for (std::size_t g = 0; g < all; ++g) alike[g] = most[g] - least[g] < most_moved * step;
  return alike;
}

std::vector<KnownEffect> rounding_effects(const Work& work, const CoarseOutput& coarse) {
  std::vector<KnownEffect> effects = of_equal_values(work, coarse.rounding_sd);
  const Places places = places_of(work, coarse);
  const Matrix covariance =
      places.segment.size() > work.used.size()
          ? rounding_covariance(places.place, uncertainty_of(places, coarse.rounding_sd / coarse.step),
                                coarse.noise / coarse.step)
          : Matrix();
  if (std::ranges::all_of(covariance.values, [](double x) { return std::isfinite(x); }) && covariance.rows > 0) {
    for (KnownEffect& effect : effects_of(covariance, places, work, coarse.step)) effects.push_back(std::move(effect));
  } else {
    effects.push_back(each_alone(work, coarse.rounding_sd));
  }
  return effects;
}

}  // namespace tumble::linear
