#include "tumble/methods/accelerometer_four_position/reduce.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/square.hpp"
#include "tumble/methods/accelerometer_four_position/repeatability.hpp"
#include "tumble/reduce/linear/slow.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer_four_position {
namespace {

constexpr double least_sd = 1e-14;       ///< [1] of the value and of 1, below which a sd is rounding
constexpr double variance_added = 1e-9;  ///< [1] of each variance: rows without noise do not make the matrix singular

/// Each quantity is weighted by its own covariance: the course of K_2 over temperature must not move the bias.
Matrix for_weights(Matrix v, std::size_t cells) {
  for (std::size_t i = 0; i < v.rows; ++i)
    for (std::size_t j = 0; j < v.columns; ++j)
      if (i / cells != j / cells) v(i, j) = 0.0;
  return v;
}

/// The estimator z -> beta, V made positive where the data are free of noise.
struct Estimator {
  Matrix gain;
  double chi_square = 0.0, condition = 0.0;
};

Estimator estimator(const Matrix& x, const std::vector<double>& z, const Matrix& v) {
  // Quantities have units of their own: V is scaled to a unit diagonal. Rows without any noise count as one part in 1e9
  // of the largest of their kind.
  std::vector<double> unit = diagonal_of(v);
  for (std::size_t i = 0; i < unit.size(); ++i)
    unit[i] = 1.0 / std::max(std::sqrt(unit[i]), least_sd * (1.0 + std::abs(z[i])));
  Matrix scaled_v = scaled_rows(unit, scaled_columns(v, unit));
  for (std::size_t i = 0; i < unit.size(); ++i) scaled_v(i, i) += variance_added;
  const Matrix root = cholesky(scaled_v).lower;
  if (root.rows != scaled_v.rows)
    throw Error(Error::Kind::bad_data,
                "the variances of the outputs span more than numbers can hold: look for samples out of range");
  const Matrix white = solve_lower(root, scaled_rows(unit, x));
  const auto observed = solve_lower(root, scaled(unit, z));
  const auto size = inverses(column_norms(white));
  const Matrix even = scaled_columns(white, size);
  Estimator out{scaled_rows(size, solve(householder_qr(even), solve_lower(root, diagonal(unit))))};
  const auto residual = difference(observed, white * (out.gain * z));
  out.chi_square = dot(residual, residual);
  out.condition = condition(even);
  return out;
}

/// Given: v all sources together, noise the first of them.
void fill_cells(const Stacked& all, const Matrix& v, const Matrix& noise, Reduced& out) {
  out.cells.resize(all.cells);
  for (std::size_t b = 0; b < all.active.size(); ++b)
    for (std::size_t c = 0; c < all.cells; ++c) {
      const std::size_t i = all.index(b, c);
      out.cells[c].value[all.active[b]] = all.z[i];
      out.cells[c].sd[all.active[b]] = std::sqrt(v(i, i));
      out.cells[c].noise_sd[all.active[b]] = std::sqrt(noise(i, i));
    }
}

/// Values, covariance and its sources from those of the cells.
void fill_parameters(const Matrix& gain, const std::vector<double>& z, const std::vector<Source>& sources,
                     Reduced& out) {
  out.parameters = gain * z;
  out.covariance = Matrix(gain.rows, gain.rows);
  for (const auto& source : sources) {
    out.sources.push_back({source.name, sandwich(gain, source.covariance),
                           source.shifts.empty() ? Matrix() : gain * source.shifts, source.key});
    out.covariance += out.sources.back().covariance;
  }
}

/// White noise as a factor on its own line, and the variances of each quantity.
void fill_estimated(const Matrix& gain, double white_freedom, const std::vector<Repeatability>& repeatability,
                    Reduced& out) {
  if (white_freedom > 0.0)
    out.estimated.push_back({{out.sources.front().covariance}, Matrix(1, 1, 2.0 / white_freedom), {white_freedom}});
  for (const auto& quantity : repeatability) {
    Estimated estimated{{}, quantity.covariance, quantity.freedom};
    for (const auto& unknown : quantity.unknown) estimated.shares.push_back(sandwich(gain, unknown.kernel));
    out.estimated.push_back(std::move(estimated));
  }
}

/// Slow noise and turn-on repeatability of the outputs.
void add_expected(const Bench& bench, const Stacked& all, const Expected& expected, std::vector<Source>& sources) {
  const auto& test = bench.evidence.test;
  std::vector<linear::Interval> intervals;
  for (const auto& stretch : test.stretches)
    intervals.push_back({stretch.start, test.power_ups[stretch.power_up].offset + stretch.first, stretch.duration()});
  const double step = test.stretches.front().step;
  for (const auto& slow : linear::known_slow_noise(intervals, expected.noise, expected.turn_on_sd, step))
    if (const Matrix moved = sandwich(all.slope, slow.variance * slow.kernel); trace(moved) > 0.0)
      add(sources, slow.source, moved);
}

/// Adds the sources that the scatter of the cells shows.
std::vector<Repeatability> add_repeatability(const Bench& bench, const Stacked& all, const Design& design,
                                             std::vector<Source>& sources, Reduced& out) {
  constexpr double rare = 1e-4;
  const auto repeatability = repeatabilities(bench, all, design, sum_of(sources));
  for (std::size_t b = 0; b < repeatability.size(); ++b) {
    const Repeatability& found = repeatability[b];
    out.repeatability[all.active[b]] = std::sqrt(found.unknown.front().variance);
    if (found.misfit > 0.0 && found.misfit_chance <= rare) {
      out.misfit[all.active[b]] = found.misfit;
      out.misfit_ratio[all.active[b]] = found.misfit_ratio;
    }
    for (const auto& unknown : found.unknown)
      if (unknown.variance > 0.0) add(sources, unknown.name, unknown.variance * unknown.kernel);
  }
  return repeatability;
}

/// nu' of freedom_of(): what nu lacks is of the order 1/d^2.
double with_known_part(double nu, double d) {
  constexpr double pull = 8.0;  // the least with which no d and no known part gives a coverage below 0.94
  return nu > d ? square((pull * std::sqrt(d) + d * d * std::sqrt(nu)) / (pull + d * d)) : nu;
}

}  // namespace

double freedom_of(const Reduced& reduced, const std::vector<double>& weights) {
  double of_v = 0.0, single = 0.0, over_freedom = 0.0;
  for (const auto& estimated : reduced.estimated) {
    std::vector<double> slope;
    for (const auto& share : estimated.shares) slope.push_back(quadratic_form(weights, share));
    of_v += quadratic_form(slope, estimated.covariance);
    for (std::size_t c = 0; c < slope.size(); ++c) {
      const double own = slope[c] * slope[c] * estimated.covariance(c, c);
      single += own;
      over_freedom += own / estimated.freedom[c];
    }
  }
  if (!(of_v > 0.0)) return std::numeric_limits<double>::infinity();
  const double v = quadratic_form(weights, reduced.covariance);
  return std::max(1.0, with_known_part(2.0 * v * v / of_v, single / over_freedom));
}

Reduced reduce(const Bench& bench, std::size_t order, bool two, double thermometer_sd, const Expected* expected) {
  const Stacked all = stacked_of(bench, two);
  const Design design = design_of(bench, all, order);
  const Matrix convert = to_plain(design);
  const auto centred = qr_fit(design.x, all.z).x;
  auto sources = known_sources(bench, all, design, convert * centred);
  add_thermometer(bench, all, design, centred, thermometer_sd, sources);

  Reduced out;
  out.active = all.active;
  for (std::size_t b = 0; b < all.active.size(); ++b) out.polynomial[all.active[b]] = design.blocks[b];
  out.repeated = repeated(bench);
  out.repeatability_known =
      !expected && bench.cells.size() > (out.repeated ? bench.group_temperature.size() : order + 1);
  std::vector<Repeatability> repeatability;
  if (out.repeatability_known) repeatability = add_repeatability(bench, all, design, sources, out);
  if (expected) add_expected(bench, all, *expected, sources);

  const Matrix v = sum_of(sources);
  const Estimator estimate = estimator(design.x, all.z, for_weights(v, all.cells));
  const Matrix gain = convert * estimate.gain;
  fill_cells(all, v, sources.front().covariance, out);
  fill_parameters(gain, all.z, sources, out);
  fill_estimated(gain, bench.white_freedom, repeatability, out);
  out.fit = {all.z.size(), static_cast<double>(all.z.size() - gain.rows), estimate.chi_square, estimate.condition};
  return out;
}

}  // namespace tumble::accelerometer_four_position
