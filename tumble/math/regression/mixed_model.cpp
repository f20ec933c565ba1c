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
}

MatrixXd covariance_of(const MixedData& data, const Compressed& rows, const VectorXd& variances) {
  MatrixXd v = mixed_model::known_covariance(rows);
  for (std::size_t c = 0; c < data.slow.size(); ++c)
    v += variances[at(c) + 1] * rows.incidence * map(data.slow[c].kernel) * rows.incidence.transpose();
  const double floor = 1e-10 * v.diagonal().mean();  // an estimator needs V positive; the sources hold the true one
  v.diagonal().array() += std::max({variances[0], floor, std::numeric_limits<double>::min()});
  return v;
}

}  // namespace

MixedFit fit_mixed_model(const MixedData& data) {
  refuse_unusable(data, true);
  const Compressed rows = mixed_model::compress(data, mixed_model::scatter_within(data));
  const auto [start, residuals] = mixed_model::ordinary(rows);
  const mixed_model::Components found = mixed_model::restricted_likelihood(data, rows, residuals);
  const MatrixXd v = covariance_of(data, rows, found.variances);
  const mixed_model::Estimator g = mixed_model::estimator(rows.design, v);
  const VectorXd correction = g.gain * residuals;
  const VectorXd b = start + correction;

  MixedFit fit;
  fit.parameters.assign(b.data(), b.data() + b.size());
  add_sources(data, rows, g.gain, found.variances, fit);
  fit.white_variance = found.variances[0];
  fit.slow_variance.assign(found.variances.data() + 1, found.variances.data() + found.variances.size());
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
