#include "tumble/methods/fog_thermal_bias/fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlopt.hpp>
#include <numeric>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"
#include "tumble/math/noise/whitening.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/units/error.hpp"

namespace tumble::fog_thermal_bias {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Index = Eigen::Index;

/// [1 | columns | y], rows without data zero.
Matrix block_of(const RunData& run, const std::vector<std::size_t>& columns) {
  const std::size_t n = run.time.size();
  Matrix block(n, columns.size() + 2);
  for (std::size_t k = 0; k < n; ++k) {
    if (run.share[k] <= 0.0) continue;
    block(k, 0) = 1.0;
    for (std::size_t c = 0; c < columns.size(); ++c) block(k, c + 1) = run.regressors(k, columns[c]);
    block(k, columns.size() + 1) = run.output[k];
  }
  return block;
}

MatrixXd triangle_of(const MatrixXd& m) {
  const Index c = m.cols();
  const Eigen::HouseholderQR<MatrixXd> qr(m);
  MatrixXd r = MatrixXd::Zero(c, c);
  const Index rows = std::min(c, m.rows());
  r.topRows(rows) = qr.matrixQR().topRows(rows).triangularView<Eigen::Upper>();
  return r;
}

double longest_of(const std::vector<RunData>& runs, double interval) {
  std::size_t longest = 1;
  for (const auto& run : runs) longest = std::max(longest, run.time.size());
  return static_cast<double>(longest) * interval;
}

/// The columns `columns` and y of every triangle, one below the other.
MatrixXd stacked(const Factors& factors, const std::vector<std::size_t>& columns) {
  const auto q = static_cast<Index>(columns.size());
  Index rows = 0;
  for (const auto& t : factors.triangles) rows += static_cast<Index>(t.rows);
  MatrixXd all(rows, q + 1);
  Index at = 0;
  for (const auto& t : factors.triangles) {
    const auto r = map(t);
    for (Index c = 0; c < q; ++c)
      all.col(c).segment(at, r.rows()) = r.col(static_cast<Index>(columns[static_cast<std::size_t>(c)]));
    all.col(q).segment(at, r.rows()) = r.col(r.cols() - 1);
    at += r.rows();
  }
  return all;
}

}  // namespace

Factors factorise(const std::vector<RunData>& runs, const std::vector<std::size_t>& columns, const NoiseModel& noise,
                  double interval) {
  std::vector<const RunData*> fitted;
  for (const auto& run : runs)
    if (!run.held_out) fitted.push_back(&run);
  const Whitening whiten(noise, interval, longest_of(runs, interval));
  Factors out;
  out.triangles.resize(fitted.size());
  std::vector<double> determinants(fitted.size());
  parallel_for(fitted.size(), [&](std::size_t r) {
    Matrix block = block_of(*fitted[r], columns);
    determinants[r] = whiten(block, fitted[r]->share);
    const MatrixXd triangle = triangle_of(map(block));
    if (triangle(0, 0) != 0.0) determinants[r] += 2.0 * std::log(std::abs(triangle(0, 0)));
    out.triangles[r] = plain(triangle.bottomRightCorner(triangle.rows() - 1, triangle.cols() - 1));
  });
  for (std::size_t r = 0; r < fitted.size(); ++r) {
    out.log_determinant += determinants[r];
    out.rows += static_cast<double>(std::ranges::count_if(fitted[r]->share, [](double s) { return s > 0.0; }));
    out.runs += 1.0;
  }
  return out;
}

Likelihood::Likelihood(const std::vector<RunData>& runs, std::vector<std::size_t> columns, double interval)
    : runs_(runs), columns_(std::move(columns)), interval_(interval) {
  // The scale of the noise: differences of neighbouring averages, which hold little of anything slow.
  double squares = 0.0, count = 0.0;
  for (const auto& run : runs)
    for (std::size_t k = 1; k < run.time.size(); ++k)
      if (run.share[k] > 0.0 && run.share[k - 1] > 0.0) {
        squares += 0.5 * std::pow(run.output[k] - run.output[k - 1], 2);
        count += 1.0;
      }
  if (count < 3.0 || !(squares > 0.0))
    throw Error(Error::Kind::bad_data, "the gyro's output is constant or too short to tell its noise");
  white_ = std::sqrt(squares / count * interval);
}

NoiseModel Likelihood::noise(const Point& x) const {
  NoiseModel noise;
  noise.angle_random_walk = white_ * std::exp(x[0]);
  noise.bias_instability = white_ / std::sqrt(interval_) * std::exp(x[1]);
  noise.rate_random_walk = white_ / interval_ * std::exp(x[2]);
  return noise;
}

double Likelihood::operator()(const Point& x) const {
  const Factors factors = factorise(runs_, columns_, noise(x), interval_);
  std::vector<std::size_t> every(columns_.size());
  std::iota(every.begin(), every.end(), std::size_t{0});
  const MatrixXd r = triangle_of(stacked(factors, every));
  const Index q = r.cols() - 1;
  double value = factors.log_determinant + r(q, q) * r(q, q);
  for (Index c = 0; c < q; ++c)
    if (std::abs(r(c, c)) > 0.0) value += 2.0 * std::log(std::abs(r(c, c)));
  return value;
}

Likelihood::Point Likelihood::most_likely() const {
  nlopt::opt optimiser(nlopt::LN_SBPLX, 3);
  optimiser.set_min_objective(
      [](const Point& x, Point&, void* self) { return (*static_cast<const Likelihood*>(self))(x); },
      const_cast<Likelihood*>(this));
  // The lower ends are as good as absent (1e-3 of the white level of one average and less).
  optimiser.set_lower_bounds({-7.0, -7.0, -7.0});
  optimiser.set_upper_bounds({2.0, 5.0, 5.0});
  optimiser.set_initial_step(1.0);
  optimiser.set_ftol_abs(0.02);  // in -2 log L: far below the one unit that a standard error is worth
  optimiser.set_maxeval(150);
  Point x{-0.3, -1.5, -2.5};
  double best = 0.0;
  optimiser.optimize(x, best);
  return x;
}

std::vector<double> degrees_of_freedom(const Likelihood& likelihood, const Likelihood::Point& x,
                                       const std::function<std::vector<double>(const NoiseModel&)>& variances) {
  constexpr double step = 0.25;
  const auto at = [&](int i, double a, int j, double b) {
    auto y = x;
    y[static_cast<std::size_t>(i)] += a * step;
    y[static_cast<std::size_t>(j)] += b * step;
    return y;
  };
  Eigen::Matrix3d hessian;
  const double centre = likelihood(x);
  const std::vector<double> here = variances(likelihood.noise(x));
  MatrixXd gradient(static_cast<Index>(here.size()), 3);
  for (int i = 0; i < 3; ++i) {
    const auto up = variances(likelihood.noise(at(i, 1, i, 0))), down = variances(likelihood.noise(at(i, -1, i, 0)));
    for (std::size_t k = 0; k < here.size(); ++k) gradient(static_cast<Index>(k), i) = (up[k] - down[k]) / (2.0 * step);
    hessian(i, i) = (likelihood(at(i, 1, i, 0)) - 2.0 * centre + likelihood(at(i, -1, i, 0))) / (step * step);
    for (int j = 0; j < i; ++j)
      hessian(i, j) = hessian(j, i) = (likelihood(at(i, 1, j, 1)) - likelihood(at(i, 1, j, -1)) -
                                       likelihood(at(i, -1, j, 1)) + likelihood(at(i, -1, j, -1))) /
                                      (4.0 * step * step);
  }
  // A term that is as good as absent has a flat likelihood: nothing is known of its logarithm beyond a factor e^2.
  hessian.diagonal().array() += 2.0 / 4.0;
  const Eigen::Matrix3d covariance = 2.0 * hessian.inverse();
  std::vector<double> degrees(here.size());
  for (std::size_t k = 0; k < here.size(); ++k) {
    const double variance =
        gradient.row(static_cast<Index>(k)) * covariance * gradient.row(static_cast<Index>(k)).transpose();
    degrees[k] =
        variance > 0.0 ? std::max(1.0, 2.0 * here[k] * here[k] / variance) : std::numeric_limits<double>::infinity();
  }
  return degrees;
}

LinearFit joint(const Factors& factors, const std::vector<std::size_t>& columns,
                const std::vector<std::string>& names) {
  const MatrixXd r = triangle_of(stacked(factors, columns));
  const Index q = r.cols() - 1;
  LeastSquaresOptions options;
  options.known_sigma = true;
  options.names = names;
  const VectorXd y = r.col(q).head(q);
  const auto fit = least_squares(plain(r.topLeftCorner(q, q)), {y.data(), y.data() + q}, {}, options);
  LinearFit out;
  out.parameters = fit.parameters;
  out.covariance = fit.covariance;
  out.condition = fit.condition;
  out.chi_square = r(q, q) * r(q, q);
  out.degrees_of_freedom = factors.rows - factors.runs - static_cast<double>(q);
  if (out.degrees_of_freedom > 0.0) out.inflation = std::max(1.0, out.chi_square / out.degrees_of_freedom);
  for (auto& v : out.covariance.values) v *= out.inflation;
  for (const auto& u : fit.unobservable) out.unobservable += (out.unobservable.empty() ? "" : "; ") + u.in_words;
  return out;
}

LinearFit two_stage(const Factors& factors, const std::vector<std::size_t>& columns, int powers,
                    const std::vector<double>& start_difference, std::vector<std::size_t>& unused) {
  // Stage one: columns come in groups of `powers`; within a run they are one column times a constant, so the first of
  // each group stands for it.
  const std::size_t groups = columns.size() / static_cast<std::size_t>(powers);
  std::vector<std::size_t> first;
  for (std::size_t g = 0; g < groups; ++g) first.push_back(columns[g * static_cast<std::size_t>(powers)]);
  const auto q = static_cast<Index>(groups);
  std::vector<VectorXd> coefficients;
  std::vector<MatrixXd> covariances;
  std::vector<double> starts;
  for (std::size_t run = 0; run < factors.triangles.size(); ++run) {
    Factors one;
    one.triangles = {factors.triangles[run]};
    one.rows = 1e300;  // the scale of a single run is not estimated
    const LinearFit fit = joint(one, first, {});
    if (!fit.unobservable.empty()) {
      unused.push_back(run);
      continue;
    }
    coefficients.emplace_back(Eigen::Map<const VectorXd>(fit.parameters.data(), q));
    covariances.emplace_back(map(fit.covariance));
    starts.push_back(start_difference[run]);
  }
  if (coefficients.size() < static_cast<std::size_t>(powers))
    throw Error(
        Error::Kind::bad_data,
        fmt::format("two_stage: {} runs determine the coefficients by themselves and {} are needed for a "
                    "polynomial of {} terms in the start temperature; use estimator = \"joint\" or add runs that "
                    "cross the temperature range",
                    coefficients.size(), powers, powers));
  // Stage two: P_i maps the runs' values of coefficient i to its polynomial in the start temperature.
  const auto n = static_cast<Index>(coefficients.size());
  MatrixXd vandermonde(n, powers);
  for (Index r = 0; r < n; ++r)
    for (Index j = 0; j < powers; ++j)
      vandermonde(r, j) = std::pow(starts[static_cast<std::size_t>(r)], static_cast<double>(j));
  std::vector<MatrixXd> maps;
  LinearFit out;
  out.condition = 1.0;
  for (Index i = 0; i < q; ++i) {
    VectorXd root(n), values(n);
    for (Index r = 0; r < n; ++r) {
      root[r] = 1.0 / std::sqrt(covariances[static_cast<std::size_t>(r)](i, i));
      values[r] = coefficients[static_cast<std::size_t>(r)][i];
    }
    const MatrixXd weighted = root.asDiagonal() * vandermonde;
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(weighted);
    maps.emplace_back(qr.solve(MatrixXd(root.asDiagonal())));
    const VectorXd b = maps.back() * values;
    out.parameters.insert(out.parameters.end(), b.data(), b.data() + b.size());
    const VectorXd left = root.asDiagonal() * (values - vandermonde * b);
    out.chi_square += left.squaredNorm();
    const VectorXd singular =
        (weighted * weighted.colwise().norm().cwiseInverse().asDiagonal()).jacobiSvd().singularValues();
    out.condition = std::max(out.condition, singular[0] / singular[singular.size() - 1]);
  }
  MatrixXd covariance(q * powers, q * powers);
  for (Index i = 0; i < q; ++i)
    for (Index k = 0; k < q; ++k) {
      VectorXd between(n);
      for (Index r = 0; r < n; ++r) between[r] = covariances[static_cast<std::size_t>(r)](i, k);
      covariance.block(i * powers, k * powers, powers, powers) =
          maps[static_cast<std::size_t>(i)] * between.asDiagonal() * maps[static_cast<std::size_t>(k)].transpose();
    }
  out.degrees_of_freedom = static_cast<double>((n - powers) * q);
  if (out.degrees_of_freedom > 0.0) out.inflation = std::max(1.0, out.chi_square / out.degrees_of_freedom);
  covariance *= out.inflation;
  out.covariance = plain(covariance);
  return out;
}

Residual residual_of(const RunData& run, const std::vector<std::size_t>& columns,
                     const std::vector<double>& parameters) {
  double sum = 0.0, squares = 0.0, count = 0.0;
  const double level = run.start_output;
  for (std::size_t k = 0; k < run.time.size(); ++k) {
    if (run.share[k] <= 0.0) continue;
    double left = run.output[k] - level;
    for (std::size_t c = 0; c < columns.size(); ++c) left -= parameters[c] * run.regressors(k, columns[c]);
    sum += left;
    squares += left * left;
    count += 1.0;
  }
  return {count > 0.0 ? std::max(0.0, squares - sum * sum / count) : 0.0, count};
}

void score(Candidate& candidate, const Factors& factors, const std::vector<std::size_t>& factorised,
           const std::vector<RunData>& runs, const std::vector<std::string>& names) {
  std::vector<std::size_t> positions;
  std::vector<std::string> used;
  for (const auto column : candidate.columns) {
    positions.push_back(static_cast<std::size_t>(std::ranges::find(factorised, column) - factorised.begin()));
    used.push_back(names[column]);
  }
  const LinearFit fit = joint(factors, positions, used);
  candidate.condition = fit.condition;
  candidate.unobservable = fit.unobservable;
  const double k = static_cast<double>(positions.size()) + factors.runs + 1.0;
  candidate.aicc =
      factors.rows * std::log(fit.chi_square / factors.rows) + 2.0 * k + 2.0 * k * (k + 1.0) / (factors.rows - k - 1.0);

  // Leave one run out: the others' normal equations are the whole minus its own, in columns of unit norm.
  const auto q = static_cast<Index>(positions.size());
  const MatrixXd all = stacked(factors, positions);
  const VectorXd scale = all.leftCols(q).colwise().norm().cwiseMax(1e-300).cwiseInverse();
  const MatrixXd scaled = all.leftCols(q) * scale.asDiagonal();
  const MatrixXd normal = scaled.transpose() * scaled;
  const VectorXd right = scaled.transpose() * all.col(q);
  Residual inside, outside;
  Index at = 0;
  std::size_t fitted = 0;
  for (const auto& run : runs) {
    if (run.held_out) continue;
    const Index rows = static_cast<Index>(factors.triangles[fitted++].rows);
    const auto own = scaled.middleRows(at, rows);
    const VectorXd b =
        scale.asDiagonal() *
        (normal - own.transpose() * own).ldlt().solve(right - own.transpose() * all.col(q).segment(at, rows));
    at += rows;
    const Residual in = residual_of(run, candidate.columns, fit.parameters);
    const Residual out = residual_of(run, candidate.columns, {b.data(), b.data() + b.size()});
    inside.squares += in.squares;
    outside.squares += out.squares;
    candidate.held_out_squares.push_back(out.squares);
    outside.count += std::max(0.0, out.count - 1.0);
  }
  candidate.sd = std::sqrt(inside.squares / outside.count);
  candidate.sd_held_out = std::sqrt(outside.squares / outside.count);
}

std::size_t choose(const std::vector<Candidate>& candidates) {
  std::size_t best = candidates.size();
  for (std::size_t c = 0; c < candidates.size(); ++c)
    if (candidates[c].unobservable.empty() && std::isfinite(candidates[c].sd_held_out) &&
        (best == candidates.size() || candidates[c].sd_held_out < candidates[best].sd_held_out))
      best = c;
  if (best == candidates.size())
    throw Error(
        Error::Kind::bad_data,
        "the recordings determine none of the models; not seen: " + candidates.front().unobservable +
            ". Add runs that cross the temperature range in both directions, at two ramp rates, with dwells, from "
            "at least as many start temperatures as the polynomial has terms");
  std::size_t chosen = best;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    if (!candidates[c].unobservable.empty() || candidates[c].columns.size() >= candidates[chosen].columns.size())
      continue;
    double sum = 0.0, squares = 0.0;
    const auto& a = candidates[c].held_out_squares;
    const auto& b = candidates[best].held_out_squares;
    const double n = static_cast<double>(a.size());
    for (std::size_t r = 0; r < a.size(); ++r) {
      sum += a[r] - b[r];
      squares += (a[r] - b[r]) * (a[r] - b[r]);
    }
    if (n > 1.0 && sum <= std::sqrt(std::max(0.0, squares - sum * sum / n) * n / (n - 1.0))) chosen = c;
  }
  return chosen;
}

}  // namespace tumble::fog_thermal_bias
