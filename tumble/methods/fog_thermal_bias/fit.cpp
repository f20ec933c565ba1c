#include "tumble/methods/fog_thermal_bias/fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/noise/whitening.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/units/error.hpp"

namespace tumble::fog_thermal_bias {
namespace {

constexpr double fewest_steps_of_noise = 3.0;  ///< from average to average

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

/// R of the orthogonal factors, with rows of zeros where the matrix has fewer rows than columns.
Matrix triangle_of(const Matrix& m) {
  Matrix triangle(m.columns, m.columns);
  set_block(triangle, 0, 0, upper_of(householder_qr(m)));
  return triangle;
}

/// From the first row of R of [1 | columns | y].
RunLevel level_of(const Matrix& triangle) {
  const double root = triangle(0, 0);
  RunLevel level;
  level.variance = 1.0 / (root * root);
  for (std::size_t c = 1; c < triangle.columns; ++c) level.regressors.push_back(triangle(0, c) / root);
  level.output = level.regressors.back();
  level.regressors.pop_back();
  return level;
}

double longest_of(const std::vector<RunData>& runs, double interval) {
  std::size_t longest = 1;
  for (const auto& run : runs) longest = std::max(longest, run.time.size());
  return static_cast<double>(longest) * interval;
}

/// The columns `columns` and y of every triangle, one below the other.
Matrix stacked_triangles(const Factors& factors, std::vector<std::size_t> columns) {
  columns.push_back(0);
  std::size_t rows = 0;
  for (const Matrix& triangle : factors.triangles) rows += triangle.rows;
  Matrix all(rows, columns.size());
  std::size_t first = 0;
  for (const Matrix& triangle : factors.triangles) {
    columns.back() = triangle.columns - 1;
    set_block(all, first, 0, chosen_columns(triangle, columns));
    first += triangle.rows;
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
  out.levels.resize(fitted.size());
  std::vector<double> determinants(fitted.size());
  parallel_for(fitted.size(), [&](std::size_t r) {
    Matrix white = block_of(*fitted[r], columns);
    determinants[r] = whiten(white, fitted[r]->share);
    const Matrix triangle = triangle_of(white);
    if (triangle(0, 0) != 0.0) determinants[r] += 2.0 * std::log(std::abs(triangle(0, 0)));
    out.levels[r] = level_of(triangle);
    out.triangles[r] = block(triangle, 1, triangle.rows - 1, 1, triangle.columns - 1);
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
  if (count < fewest_steps_of_noise || !(squares > 0.0))
    throw Error(Error::Kind::bad_data, "the gyro's output is constant or too short to determine its noise");
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
  const Matrix r = triangle_of(stacked_triangles(factors, every));
  const std::size_t q = r.columns - 1;
  double value = factors.log_determinant + r(q, q) * r(q, q);
  for (std::size_t c = 0; c < q; ++c)
    if (std::abs(r(c, c)) > 0.0) value += 2.0 * std::log(std::abs(r(c, c)));
  return value;
}

std::vector<double> degrees_of_freedom(const Likelihood& likelihood, const Likelihood::Point& x,
                                       const std::function<std::vector<double>(const NoiseModel&)>& variances) {
  constexpr double step = 0.25;
  const auto beside = [&](std::size_t i, double a, std::size_t j, double b) {
    auto y = x;
    y[i] += a * step;
    y[j] += b * step;
    return y;
  };
  const double centre = likelihood(x);
  const std::vector<double> here = variances(likelihood.noise(x));
  Matrix gradient(here.size(), 3), hessian(3, 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto up = beside(i, 1, i, 0), down = beside(i, -1, i, 0);
    const auto more = variances(likelihood.noise(up)), less = variances(likelihood.noise(down));
    for (std::size_t k = 0; k < here.size(); ++k) gradient(k, i) = (more[k] - less[k]) / (2.0 * step);
    // A term that is almost absent has a flat likelihood: its logarithm is not known beyond a factor e^2.
    hessian(i, i) = (likelihood(up) - 2.0 * centre + likelihood(down)) / (step * step) + 2.0 / 4.0;
    for (std::size_t j = 0; j < i; ++j)
      hessian(i, j) = hessian(j, i) = (likelihood(beside(i, 1, j, 1)) - likelihood(beside(i, 1, j, -1)) -
                                       likelihood(beside(i, -1, j, 1)) + likelihood(beside(i, -1, j, -1))) /
                                      (4.0 * step * step);
  }
  const Matrix covariance = 2.0 * inverse(hessian);
  std::vector<double> degrees(here.size());
  for (std::size_t k = 0; k < here.size(); ++k) {
    const double variance = quadratic_form(row(gradient, k), covariance);
    degrees[k] =
        variance > 0.0 ? std::max(1.0, 2.0 * here[k] * here[k] / variance) : std::numeric_limits<double>::infinity();
  }
  return degrees;
}

LinearFit joint(const Factors& factors, const std::vector<std::size_t>& columns,
                const std::vector<std::string>& names) {
  const Matrix r = triangle_of(stacked_triangles(factors, columns));
  const std::size_t q = r.columns - 1;
  LeastSquaresOptions options;
  options.known_sigma = true;
  options.names = names;
  const auto fit = least_squares(block(r, 0, q, 0, q), block(r, 0, q, q, 1).values, {}, options);
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

namespace {

/// Stage one: the fits of the runs that determine the coefficients by themselves.
struct RunFits {
  std::vector<LinearFit> fits;
  std::vector<double> starts;  ///< start temperature of each less the reference [K]
};

RunFits run_by_run(const Factors& factors, const std::vector<std::size_t>& columns,
                   const std::vector<double>& start_difference, std::vector<std::size_t>& unused) {
  RunFits out;
  for (std::size_t run = 0; run < factors.triangles.size(); ++run) {
    Factors single;
    single.triangles = {factors.triangles[run]};
    single.rows = 1e300;  // the scale of a single run is not estimated
    LinearFit fit = joint(single, columns, {});
    if (!fit.unobservable.empty()) {
      unused.push_back(run);
      continue;
    }
    out.fits.push_back(std::move(fit));
    out.starts.push_back(start_difference[run]);
  }
  return out;
}

/// Stage two of one coefficient: its values in the runs as a polynomial of the start temperature.
struct StartPolynomial {
  Matrix of_values;  ///< d polynomial / d values [powers x runs]
  std::vector<double> coefficients;
  double chi_square = 0.0, condition = 1.0;
};

StartPolynomial over_start(const RunFits& runs, std::size_t coefficient, const Matrix& vandermonde) {
  std::vector<double> weight, values;
  for (const LinearFit& fit : runs.fits) {
    weight.push_back(1.0 / std::sqrt(fit.covariance(coefficient, coefficient)));
    values.push_back(fit.parameters[coefficient]);
  }
  const Matrix weighted = scaled_rows(weight, vandermonde);
  StartPolynomial out;
  out.of_values = solve(householder_qr(weighted), diagonal(weight));
  out.coefficients = out.of_values * values;
  const auto residual = scaled(weight, difference(values, vandermonde * out.coefficients));
  out.chi_square = dot(residual, residual);
  out.condition = condition(scaled_columns(weighted, inverses(column_norms(weighted))));
  return out;
}

/// Covariance of the polynomials of all coefficients, one after the other.
Matrix covariance_of(const RunFits& runs, const std::vector<StartPolynomial>& polynomials, std::size_t powers) {
  Matrix covariance(polynomials.size() * powers, polynomials.size() * powers);
  for (std::size_t i = 0; i < polynomials.size(); ++i)
    for (std::size_t k = 0; k < polynomials.size(); ++k) {
      std::vector<double> between;
      for (const LinearFit& fit : runs.fits) between.push_back(fit.covariance(i, k));
      set_block(covariance, i * powers, k * powers,
                scaled_columns(polynomials[i].of_values, between) * transposed(polynomials[k].of_values));
    }
  return covariance;
}

}  // namespace

LinearFit two_stage(const Factors& factors, const std::vector<std::size_t>& columns, std::size_t powers,
                    const std::vector<double>& start_difference, std::vector<std::size_t>& unused) {
  // Columns come in groups of `powers`; within a run they are one column times a constant: the first represents them.
  std::vector<std::size_t> first;
  for (std::size_t k = 0; k < columns.size(); k += powers) first.push_back(columns[k]);
  const RunFits runs = run_by_run(factors, first, start_difference, unused);
  if (runs.fits.size() < powers)
    throw Error(Error::Kind::bad_data,
                say("two_stage: {} runs determine the coefficients by themselves and {} are needed for a "
                    "polynomial of {} terms in the start temperature; use estimator = \"joint\" or add runs that "
                    "cross the temperature range",
                    runs.fits.size(), powers, powers));
  Matrix vandermonde(runs.starts.size(), powers);
  for (std::size_t r = 0; r < vandermonde.rows; ++r)
    for (std::size_t j = 0; j < powers; ++j) vandermonde(r, j) = std::pow(runs.starts[r], static_cast<double>(j));
  LinearFit out;
  out.condition = 1.0;
  std::vector<StartPolynomial> polynomials;
  for (std::size_t i = 0; i < first.size(); ++i) {
    polynomials.push_back(over_start(runs, i, vandermonde));
    const StartPolynomial& latest = polynomials.back();
    out.parameters.insert(out.parameters.end(), latest.coefficients.begin(), latest.coefficients.end());
    out.chi_square += latest.chi_square;
    out.condition = std::max(out.condition, latest.condition);
  }
  out.degrees_of_freedom = static_cast<double>((runs.fits.size() - powers) * first.size());
  if (out.degrees_of_freedom > 0.0) out.inflation = std::max(1.0, out.chi_square / out.degrees_of_freedom);
  out.covariance = out.inflation * covariance_of(runs, polynomials, powers);
  return out;
}

Residual residual_of(const RunData& run, const std::vector<std::size_t>& columns,
                     const std::vector<double>& parameters) {
  double sum = 0.0, squares = 0.0, count = 0.0;
  const double level = run.start_output;
  for (std::size_t k = 0; k < run.time.size(); ++k) {
    if (run.share[k] <= 0.0) continue;
    double residual = run.output[k] - level;
    for (std::size_t c = 0; c < columns.size(); ++c) residual -= parameters[c] * run.regressors(k, columns[c]);
    sum += residual;
    squares += residual * residual;
    count += 1.0;
  }
  return {count > 0.0 ? std::max(0.0, squares - sum * sum / count) : 0.0, count};
}

namespace {

/// Fits of the stacked triangles without the rows of one run: the normal equations of all less its own, in columns of
/// unit length.
class LeaveOneOut {
 public:
  LeaveOneOut(const Factors& factors, const std::vector<std::size_t>& positions)
      : all_(stacked_triangles(factors, positions)), q_(positions.size()) {
    const Matrix design = block(all_, 0, all_.rows, 0, q_);
    scale_ = inverses(column_norms(design), 1e-300);
    design_ = scaled_columns(design, scale_);
    normal_ = normal_equations(design_, {}, column(all_, q_));
  }

  /// Parameters without the rows `first` to `first + rows`.
  std::vector<double> without(std::size_t first, std::size_t rows) const {
    const Matrix own = block(design_, first, rows, 0, q_);
    const auto right = transposed_product(own, column(all_, q_).subspan(first, rows));
    return scaled(scale_, solve_symmetric(normal_.matrix - gram(own), difference(normal_.right, right)));
  }

 private:
  Matrix all_, design_;
  std::size_t q_;
  std::vector<double> scale_;
  NormalEquations normal_;
};

}  // namespace

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
  const LeaveOneOut others(factors, positions);
  Residual inside, outside;
  std::size_t first = 0, fitted = 0;
  for (const auto& run : runs) {
    if (run.held_out) continue;
    const std::size_t rows = factors.triangles[fitted++].rows;
    const Residual in = residual_of(run, candidate.columns, fit.parameters);
    const Residual out = residual_of(run, candidate.columns, others.without(first, rows));
    first += rows;
    inside.squares += in.squares;
    outside.squares += out.squares;
    candidate.held_out_squares.push_back(out.squares);
    outside.count += std::max(0.0, out.count - 1.0);
  }
  candidate.sd = std::sqrt(inside.squares / outside.count);
  candidate.sd_held_out = fitted > 1 ? std::sqrt(outside.squares / outside.count) : std::nan("");
}

}  // namespace tumble::fog_thermal_bias
