#include "tumble/methods/allan_noise/slow_courses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/noise/whitening.hpp"
#include "tumble/methods/allan_noise/words.hpp"

namespace tumble::allan_noise {
namespace {

/// Variances that are tried, over those of the fit: a course may be all of the slow noise that was found. Factors of
/// two: -2 ln L is then within 0.3 of its least for a variance that is known to 40 %.
constexpr double slow_shares[] = {0.0, 0.0625, 0.25, 1.0};
constexpr double walk_shares[] = {0.0,      1.0 / 1024, 1.0 / 512, 1.0 / 256, 1.0 / 128, 1.0 / 64, 1.0 / 32,
                                  1.0 / 16, 1.0 / 8,    0.25,      0.5,       1.0,       2.0};
constexpr double greatest_slow_condition = 1e8;  ///< of the columns of unit length, beyond which they are one
constexpr std::size_t beside_course = 2;         ///< columns beside it: a constant and a straight trend

/// The noise of averages over `interval` [s]. Given: shares of what the fit says.
NoiseModel noise_model_of(const NoiseFit& fit, double rate, double interval, const SlowHypothesis& of) {
  NoiseModel model;
  double quantization = 0.0;
  for (const FittedTerm& term : fit.terms) {
    const NoiseTerm kind = term.unit.term;
    const bool walk = kind == NoiseTerm::random_walk, flicker = kind == NoiseTerm::flicker;
    if (!term.kept && !walk && !flicker) continue;
    // Flicker and walk are taken for each other: what is not in the fit may be there up to its limit.
    const bool limit = walk || (flicker && !term.kept);
    const double value = coefficient(kind, limit ? term.upper_limit : term.squared, rate);
    if (kind == NoiseTerm::white) model.angle_random_walk = value;
    if (flicker) model.bias_instability = std::sqrt(of.slow) * value;
    if (walk) model.rate_random_walk = std::sqrt(of.walk) * value;
    if (kind == NoiseTerm::markov && std::sqrt(of.slow) * value > model.markov_sd) {
      model.markov_sd = std::sqrt(of.slow) * value;
      model.markov_time = term.unit.markov_time / rate;
    }
    // Quantization in an average, as if independent from one to the next.
    if (kind == NoiseTerm::quantization) quantization = value * std::sqrt(2.0 / interval);
  }
  model.angle_random_walk = std::max(model.angle_random_walk, quantization);
  return model;
}

/// Triangle of the sums of products of whitened columns.
struct WhitenedSums {
  Matrix products;
  double log_determinant = 0.0;
};

WhitenedSums whitened(const Matrix& design, const SlowAverages& averages, const NoiseModel& noise) {
  Matrix rows = design;
  const double log_determinant =
      Whitening(noise, averages.interval, averages.interval * static_cast<double>(rows.rows))(rows, averages.share);
  return {gram(rows), log_determinant};
}

Matrix chosen_products(const Matrix& products, const std::vector<std::size_t>& at) {
  Matrix out(at.size(), at.size());
  for (std::size_t i = 0; i < at.size(); ++i)
    for (std::size_t j = 0; j < at.size(); ++j) out(i, j) = products(at[i], at[j]);
  return out;
}

/// -2 ln L, up to what all hypotheses share, of a regression of the last column on those at `at`.
struct OneFit {
  double minus_twice_log_likelihood = std::numeric_limits<double>::infinity();
  std::vector<double> size;
  Matrix covariance;
};

OneFit regressed(const WhitenedSums& on, const std::vector<std::size_t>& at) {
  const std::size_t last = on.products.rows - 1;
  Matrix normal = chosen_products(on.products, at);
  std::vector<double> right, unit;
  for (std::size_t i = 0; i < at.size(); ++i) {
    unit.push_back(1.0 / std::sqrt(std::max(normal(i, i), 1e-300)));
    right.push_back(unit.back() * on.products(at[i], last));
  }
  normal = scaled_columns(scaled_rows(unit, normal), unit);
  OneFit fit;
  if (condition(normal) > greatest_slow_condition) return fit;
  const Matrix inverse = inverse_symmetric(normal);
  fit.size = inverse * right;
  const double explained = dot(fit.size, right);
  fit.minus_twice_log_likelihood = on.log_determinant + on.products(last, last) - explained;
  fit.size = scaled(unit, fit.size);
  fit.covariance = scaled_columns(scaled_rows(unit, inverse), unit);
  return fit;
}

/// Constant, trend, the columns of all courses, averages; rows without data are zero.
Matrix design_of_courses(const SlowAverages& averages, const std::vector<Matrix>& courses) {
  const std::size_t n = averages.mean.size();
  std::size_t columns = beside_course + 1;
  for (const Matrix& course : courses) columns += course.columns;
  Matrix design(n, columns);
  double origin = 0.0, measured = 0.0;
  for (std::size_t k = 0; k < n; ++k)
    if (averages.share[k] > 0.0) origin += averages.mean[k], measured += 1.0;
  for (std::size_t k = 0; k < n; ++k) {
    if (!(averages.share[k] > 0.0)) continue;
    design(k, 0) = 1.0;
    design(k, 1) = (static_cast<double>(k) + 0.5) / static_cast<double>(n) - 0.5;
    std::size_t at = beside_course;
    for (const Matrix& course : courses)
      for (std::size_t c = 0; c < course.columns; ++c) design(k, at++) = course(k, c);
    design(k, at) = averages.mean[k] - origin / measured;
  }
  return design;
}

}  // namespace

std::size_t slow_stride(std::size_t samples, std::size_t most) {
  return std::max<std::size_t>(1, (samples + most - 1) / most);
}

SlowAverages slow_averages(std::span<const double> values, double rate, std::size_t stride) {
  const std::size_t n = values.size() / stride;
  SlowAverages averages{{}, {}, static_cast<double>(stride) / rate};
  for (std::size_t k = 0; k < n; ++k) {
    double sum = 0.0, there = 0.0;
    for (const double value : values.subspan(k * stride, stride))
      if (!std::isnan(value)) sum += value, there += 1.0;
    averages.mean.push_back(there > 0.0 ? sum / there : std::nan(""));
    averages.share.push_back(there / static_cast<double>(stride));
  }
  return averages;
}

std::vector<CourseFit> fit_courses(const SlowAverages& averages, const std::vector<Matrix>& courses,
                                   const NoiseFit& fit, double rate) {
  const Matrix design = design_of_courses(averages, courses);
  std::vector<CourseFit> fits(courses.size());
  std::vector<double> best(courses.size(), std::numeric_limits<double>::infinity());
  double without = std::numeric_limits<double>::infinity();
  for (const double slow : slow_shares) {
    for (const double walk : walk_shares) {
      const NoiseModel noise = noise_model_of(fit, rate, averages.interval, {slow, walk});
      if (!(noise.angle_random_walk > 0.0)) return {};
      const WhitenedSums on = whitened(design, averages, noise);
      without = std::min(without, regressed(on, {0, 1}).minus_twice_log_likelihood);
      std::size_t first = beside_course;
      for (std::size_t c = 0; c < courses.size(); ++c) {
        std::vector<std::size_t> at{0, 1};
        for (std::size_t k = 0; k < courses[c].columns; ++k) at.push_back(first++);
        OneFit with = regressed(on, at);
        if (with.minus_twice_log_likelihood >= best[c]) continue;
        best[c] = with.minus_twice_log_likelihood;
        fits[c].size.assign(with.size.begin() + beside_course, with.size.end());
        const std::size_t own = courses[c].columns;
        fits[c].covariance = block(with.covariance, beside_course, own, beside_course, own);
        fits[c].hypothesis = {slow, walk};
      }
    }
  }
  for (std::size_t c = 0; c < courses.size(); ++c)
    fits[c].fall = std::isfinite(best[c]) ? std::max(0.0, without - best[c]) : 0.0;
  return fits;
}

NoiseBands with_slow_part(const NoiseBands& bands, std::span<const double> slow) {
  NoiseBands fast = bands;
  std::erase_if(fast.bands, [](const NoiseBand& band) { return band.radix == 0; });
  fast.ordinates.clear();
  if (!fast.scatter.empty()) fast.scatter.pop_back();
  return {std::move(fast), slow, bands.slow_unit};
}

void give_back_course(const Matrix& columns, const Matrix& covariance, NoiseBands& bands) {
  std::vector<std::vector<double>> of;
  for (std::size_t c = 0; c < columns.columns; ++c) {
    const auto course = column(columns, c);
    std::vector<double> one(course.begin(), course.end());
    for (std::size_t k = 0; k < one.size(); ++k)
      if (std::isnan(bands.slow[k])) one[k] = bands.slow[k];
    of.push_back(slow_sines(one));
  }
  for (std::size_t i = 0; i < bands.ordinates.size(); ++i) {
    NoiseBand& band = bands.bands[bands.ordinates[i].band];
    for (std::size_t a = 0; a < of.size(); ++a)
      for (std::size_t b = 0; b < of.size(); ++b)
        band.mean_square += of[a][i] * covariance(a, b) * of[b][i] / band.count;
  }
}

}  // namespace tumble::allan_noise
