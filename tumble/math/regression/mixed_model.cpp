#include "tumble/math/regression/mixed_model.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/eigen/view.hpp"
#include "tumble/math/regression/mixed_model/estimator.hpp"
#include "tumble/math/regression/mixed_model/restricted.hpp"
#include "tumble/math/regression/mixed_model/rows.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using mixed_model::Compressed;

/// Covariance that one known effect gives the parameters.
MatrixXd effect_covariance(const Compressed& rows, const MatrixXd& gain, Index effect) {
  if (!rows.each_segment[static_cast<std::size_t>(effect)]) {
    const VectorXd shift = gain * rows.effects.col(effect);
    return shift * shift.transpose();
  }
  MatrixXd sum = MatrixXd::Zero(gain.rows(), gain.rows());
  for (const auto& [first, count] : rows.parts) {
    const VectorXd shift = gain.middleCols(first, count) * rows.effects.col(effect).segment(first, count);
    sum += shift * shift.transpose();
  }
  return sum;
}

/// Everything that follows from the estimator: the covariance as a sum over its sources.
void add_sources(const MixedData& data, const Compressed& rows, const MatrixXd& gain, const VectorXd& variances,
                 MixedFit& fit) {
  const Index p = gain.rows();
  MatrixXd total = MatrixXd::Zero(p, p);
  const auto add = [&](const std::string& source, const MatrixXd& covariance) {
    total += covariance;
    fit.sources.push_back({source, plain(covariance)});
  };
  const auto add_effect = [&](const KnownEffect& effect, Index k) {
    add(effect.source, effect_covariance(rows, gain, k));
    if (effect.each_segment) return;
    fit.sources.back().shifts = plain(gain * rows.effects.col(k));
    fit.sources.back().key = effect.key;
  };
  const MatrixXd white = gain * gain.transpose();
  fit.component_sensitivity.push_back(plain(white));
  add(data.white, variances[0] * white);
  const MatrixXd shifts = gain * rows.incidence;
  for (std::size_t c = 0; c < data.slow.size(); ++c) {
    const MatrixXd slow = shifts * map(data.slow[c].kernel) * shifts.transpose();
    fit.component_sensitivity.push_back(plain(slow));
    add(data.slow[c].source, variances[at(c) + 1] * slow);
  }
  for (std::size_t k = 0; k < data.effects.size(); ++k) add_effect(data.effects[k], at(k));
  fit.covariance = plain(total);
}

void refuse_unusable(const MixedData& data, bool with_observations) {
  const std::size_t n = data.design.rows;
  const auto finite = [](double v) { return std::isfinite(v); };
  if (data.weights.size() != n || data.segment.size() != n || (with_observations && data.observations.size() != n))
    throw Error(Error::Kind::internal, "mixed model: design, observations, weights and segments differ in length");
  if (n == 0 || data.design.columns == 0) throw Error(Error::Kind::bad_data, "nothing is left to fit");
  bool good = std::ranges::all_of(data.design.values, finite) && std::ranges::all_of(data.observations, finite);
  for (const auto& effect : data.effects) good = good && std::ranges::all_of(effect.column, finite);
  if (!good) throw Error(Error::Kind::bad_data, "the observations or what is predicted of them are not finite");
  constexpr double most = 1e100;  // squares of squares have to stay finite
  if (std::ranges::any_of(data.observations, [](double v) { return std::abs(v) > most; }))
    throw Error(Error::Kind::bad_data,
                "an observation is beyond 1e100: no instrument shows that; look for samples out of range");
}

MatrixXd covariance_of(const MixedData& data, const Compressed& rows, const VectorXd& variances) {
  MatrixXd v = mixed_model::known_covariance(rows);
  for (std::size_t c = 0; c < data.slow.size(); ++c)
    v += variances[at(c) + 1] * rows.incidence * map(data.slow[c].kernel) * rows.incidence.transpose();
  const double floor = 1e-10 * v.diagonal().mean();  // an estimator needs V positive; the sources hold the true one
  v.diagonal().array() += std::max({variances[0], floor, std::numeric_limits<double>::min()});
  return v;
}

/// Variance of the means of parts of a segment beyond white noise [u^2], with the variance of that.
struct WithinSegments {
  double variance = 0.0, of_variance = 0.0;
  bool shown = false;
};

/// Weighted sums over some rows.
struct Sums {
  double weight = 0.0, sum = 0.0, squares = 0.0;

  void add(double w, double value) { weight += w, sum += w * value, squares += w * square(value); }
  double about_mean() const { return squares - square(sum) / weight; }
};

/// Sums of squares with their degrees of freedom, of the means of parts and within the parts.
struct Scatters {
  double between = 0.0, between_freedom = 0.0, inside = 0.0, inside_freedom = 0.0;
  double weight = 0.0, parts = 0.0;  ///< of all parts

  /// Given: rows [first, last) of one segment, and their residuals [u].
  void add(const MixedData& data, const VectorXd& residuals, std::size_t first, std::size_t last) {
    constexpr std::size_t most_parts = 8, least_rows = 2;
    const std::size_t rows = last - first, count = std::min(most_parts, rows / least_rows);
    if (count < 2) return;
    Sums means;
    for (std::size_t part = 0; part < count; ++part) {
      Sums of_part;
      for (std::size_t i = first + rows * part / count; i < first + rows * (part + 1) / count; ++i)
        of_part.add(data.weights[i], residuals[at(i)]);
      inside += of_part.about_mean();
      means.add(of_part.weight, of_part.sum / of_part.weight);
    }
    inside_freedom += static_cast<double>(rows - count);
    between += means.about_mean();
    between_freedom += static_cast<double>(count) - 1.0;
    weight += means.weight;
    parts += static_cast<double>(count);
  }
};

/// From the residuals of a fit: scatter of the means of up to eight parts about the mean of their segment, less what
/// the scatter within the parts explains.
WithinSegments within_segments(const MixedData& data, const VectorXd& parameters) {
  const Eigen::Map<const VectorXd> observations(data.observations.data(), at(data.observations.size()));
  const VectorXd residuals = observations - map(data.design) * parameters;
  Scatters scatters;
  for (std::size_t first = 0, last = 0; first < data.segment.size(); first = last) {
    while (last < data.segment.size() && data.segment[last] == data.segment[first]) ++last;
    scatters.add(data, residuals, first, last);
  }
  const auto& [between, between_freedom, inside, inside_freedom, weight, parts] = scatters;
  if (!(between_freedom > 0.0 && inside_freedom > 0.0)) return {};
  const double white = inside / inside_freedom, mean = between / between_freedom, of_part = weight / parts;
  return {std::max(0.0, mean - white) / of_part,
          2.0 * (square(mean) / between_freedom + square(white) / inside_freedom) / square(of_part), true};
}

/// Slow noise that no contrast shows, held at what else is known of it.
struct Held {
  std::vector<SlowNoise> slow;
  std::vector<SlowOrigin> origin;
  std::vector<double> of_variance;  ///< variance of each variance that is from the parts of the segments; else 0
};

Held held_where_not_shown(const MixedData& data, const Compressed& rows, const VectorXd& start) {
  constexpr double least_shown = 1e-3;
  Held out{data.slow, {}, std::vector<double>(data.slow.size(), 0.0)};
  const auto shown = mixed_model::shown_by_contrasts(data.slow, rows);
  const bool given =
      std::ranges::any_of(data.slow, [](const SlowNoise& slow) { return slow.known && slow.variance > 0.0; });
  for (std::size_t c = 0; c < data.slow.size(); ++c) {
    SlowNoise& slow = out.slow[c];
    out.origin.push_back(slow.known ? SlowOrigin::known : SlowOrigin::contrasts);
    if (slow.known || shown[c] > least_shown) continue;
    slow.known = true;
    slow.variance = 0.0;
    out.origin.back() = given ? SlowOrigin::beside_known : SlowOrigin::nothing_shows;
    const bool of_each_segment = map(slow.kernel).isDiagonal();
    if (given || !of_each_segment) continue;
    const WithinSegments within = within_segments(data, start);
    if (!within.shown) continue;
    slow.variance = within.variance;
    out.of_variance[c] = within.variance > 0.0 ? within.of_variance : 0.0;
    out.origin.back() = SlowOrigin::within;
  }
  return out;
}

}  // namespace

MixedFit fit_mixed_model(const MixedData& data) {
  refuse_unusable(data, true);
  const Compressed rows = mixed_model::compress(data, mixed_model::scatter_within(data));
  const auto [start, residuals] = mixed_model::ordinary(rows);
  Held held = held_where_not_shown(data, rows, start);
  mixed_model::Components found = mixed_model::restricted_likelihood(held.slow, rows, residuals);
  for (std::size_t c = 0; c < held.of_variance.size(); ++c)
    found.covariance(at(c) + 1, at(c) + 1) += held.of_variance[c];
  const MatrixXd v = covariance_of(data, rows, found.variances);
  const mixed_model::Estimator g = mixed_model::estimator(rows.design, v);
  const VectorXd correction = g.gain * residuals;
  const VectorXd b = start + correction;

  MixedFit fit;
  fit.parameters.assign(b.data(), b.data() + b.size());
  add_sources(data, rows, g.gain, found.variances, fit);
  fit.white_variance = found.variances[0];
  fit.slow_variance.assign(found.variances.data() + 1, found.variances.data() + found.variances.size());
  fit.slow_origin = std::move(held.origin);
  fit.component_covariance = plain(found.covariance);
  fit.condition = g.condition;
  const VectorXd last = residuals - rows.design * correction;
  fit.chi_square = last.dot(g.root.solve(last));
  if (found.variances[0] > 0.0) fit.chi_square += rows.within_squares / found.variances[0];
  fit.degrees_of_freedom = static_cast<double>(data.design.rows) - static_cast<double>(data.design.columns);
  const VectorXd fitted = map(data.design) * b;
  fit.fitted.assign(fitted.data(), fitted.data() + fitted.size());
  return fit;
}

MixedFit predict_mixed_model(const MixedData& data, double white_variance) {
  refuse_unusable(data, false);
  const Compressed rows = mixed_model::compress(data, std::sqrt(white_variance));
  mixed_model::ordinary(rows);
  VectorXd variances(at(data.slow.size()) + 1);
  variances[0] = white_variance;
  for (std::size_t c = 0; c < data.slow.size(); ++c) variances[at(c) + 1] = data.slow[c].variance;
  const mixed_model::Estimator g = mixed_model::estimator(rows.design, covariance_of(data, rows, variances));
  MixedFit fit;
  fit.parameters.assign(data.design.columns, 0.0);
  add_sources(data, rows, g.gain, variances, fit);
  fit.white_variance = white_variance;
  for (const auto& slow : data.slow) fit.slow_variance.push_back(slow.variance);
  fit.condition = g.condition;
  fit.degrees_of_freedom = std::numeric_limits<double>::infinity();
  fit.fitted.assign(data.design.rows, 0.0);
  return fit;
}

double degrees_of_freedom(const MixedFit& fit, const std::vector<double>& function) {
  const Eigen::Map<const VectorXd> c(function.data(), at(function.size()));
  const double v = c.dot(map(fit.covariance) * c);
  if (fit.component_covariance.empty() || !(v > 0.0)) return std::numeric_limits<double>::infinity();
  VectorXd gradient(at(fit.component_sensitivity.size()));
  for (std::size_t i = 0; i < fit.component_sensitivity.size(); ++i)
    gradient[at(i)] = c.dot(map(fit.component_sensitivity[i]) * c);
  const double of_v = gradient.dot(map(fit.component_covariance) * gradient);
  return of_v > 0.0 ? std::max(1.0, 2.0 * v * v / of_v) : std::numeric_limits<double>::infinity();
}

}  // namespace tumble
