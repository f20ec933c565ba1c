#include "tumble/methods/accelerometer_four_position/reduce.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"
#include "tumble/methods/accelerometer_four_position/repeatability.hpp"

namespace tumble::accelerometer_four_position {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Each quantity is weighted by its own covariance: what K_2 does over temperature is not to move the bias.
MatrixXd for_weights(MatrixXd v, Index cells) {
  for (Index i = 0; i < v.rows(); ++i)
    for (Index j = 0; j < v.cols(); ++j)
      if (i / cells != j / cells) v(i, j) = 0.0;
  return v;
}

/// The estimator z -> beta, V made positive where the data are free of noise.
struct Estimator {
  MatrixXd gain;
  double chi_square = 0.0, condition = 0.0;
};

Estimator estimator(const MatrixXd& x, const VectorXd& z, const MatrixXd& v) {
  // Quantities have units of their own: V is scaled to a unit diagonal. Rows without any noise count as one part in 1e9
  // of the largest of their kind.
  VectorXd unit = v.diagonal().cwiseSqrt();
  for (Index i = 0; i < unit.size(); ++i) unit[i] = std::max(unit[i], 1e-14 * (1.0 + std::abs(z[i])));
  MatrixXd scaled = unit.cwiseInverse().asDiagonal() * v * unit.cwiseInverse().asDiagonal();
  scaled.diagonal().array() += 1e-9;
  const Eigen::LLT<MatrixXd> root(scaled);
  const MatrixXd white = root.matrixL().solve(unit.cwiseInverse().asDiagonal() * x);
  const VectorXd seen = root.matrixL().solve(unit.cwiseInverse().asDiagonal() * z);
  const VectorXd size = white.colwise().norm().cwiseInverse();
  const MatrixXd even = white * size.asDiagonal();
  const Eigen::HouseholderQR<MatrixXd> qr(even);
  const MatrixXd inverse = qr.solve(root.matrixL().solve(MatrixXd(unit.cwiseInverse().asDiagonal())));
  Estimator out{size.asDiagonal() * inverse};
  out.chi_square = (seen - white * (out.gain * z)).squaredNorm();
  const Eigen::JacobiSVD<MatrixXd> svd(even);
  out.condition = svd.singularValues()[0] / svd.singularValues()[even.cols() - 1];
  return out;
}

void fill_cells(const Stacked& all, const MatrixXd& v, Reduced& out) {
  out.cells.resize(all.cells);
  for (std::size_t b = 0; b < all.active.size(); ++b)
    for (std::size_t c = 0; c < all.cells; ++c) {
      const Index i = all.index(b, c);
      out.cells[c].value[all.active[b]] = all.z[i];
      out.cells[c].sd[all.active[b]] = std::sqrt(v(i, i));
    }
}

/// Values, covariance and its sources from those of the cells.
void fill_parameters(const MatrixXd& gain, const VectorXd& z, const std::vector<Source>& sources, Reduced& out) {
  const VectorXd parameters = gain * z;
  out.parameters.assign(parameters.data(), parameters.data() + parameters.size());
  MatrixXd total = MatrixXd::Zero(gain.rows(), gain.rows());
  for (const auto& source : sources) {
    const MatrixXd covariance = gain * source.covariance * gain.transpose();
    total += covariance;
    out.sources.push_back({source.name, plain(covariance)});
  }
  out.covariance = plain(total);
}

/// Welch-Satterthwaite: nu = 2 v^2/Var(v), Var(v) from the variances that were found and that of the white noise.
double freedom_of(std::size_t parameter, const VectorXd& gain, double white_freedom, const std::vector<Found>& found,
                  const Reduced& out) {
  double of_v = 0.0;
  if (white_freedom > 0.0) {
    const double share = out.sources.front().covariance(parameter, parameter);
    of_v += 2.0 * share * share / white_freedom;
  }
  for (const auto& one : found) {
    VectorXd slope(at(one.unknown.size()));
    for (std::size_t k = 0; k < one.unknown.size(); ++k) slope[at(k)] = gain.dot(one.unknown[k].kernel * gain);
    of_v += slope.dot(one.covariance * slope);
  }
  const double v = out.covariance(parameter, parameter);
  return of_v > 0.0 ? std::max(1.0, 2.0 * v * v / of_v) : std::numeric_limits<double>::infinity();
}

/// Turn-on repeatability of the bias, which is the first quantity.
void add_expected(const Bench& bench, const Stacked& all, double turn_on_sd, std::vector<Source>& sources) {
  if (!(turn_on_sd > 0.0)) return;
  MatrixXd kernel = MatrixXd::Zero(all.z.size(), all.z.size());
  kernel.topLeftCorner(at(all.cells), at(all.cells)) = same_power_up(bench);
  add(sources, "turn-on repeatability", turn_on_sd * turn_on_sd * kernel);
}

}  // namespace

Reduced reduce(const Bench& bench, std::size_t order, bool two, double thermometer_sd, const Expected* expected) {
  const Stacked all = stacked_of(bench, two);
  const Design design = design_of(bench, all, order);
  const MatrixXd convert = to_plain(design);
  const VectorXd look = design.x.colPivHouseholderQr().solve(all.z), first = convert * look;
  auto sources = known_sources(bench, all, design, {first.begin(), first.end()});
  add_thermometer(bench, all, design, look, thermometer_sd, sources);

  Reduced out;
  out.active = all.active;
  for (std::size_t b = 0; b < all.active.size(); ++b) out.polynomial[all.active[b]] = design.blocks[b];
  out.repeated = repeated(bench);
  out.repeatability_known =
      !expected && bench.cells.size() > (out.repeated ? bench.group_temperature.size() : order + 1);
  std::vector<Found> found;
  if (out.repeatability_known) found = repeatabilities(bench, all, design, sum_of(sources));
  for (std::size_t b = 0; b < found.size(); ++b) {
    out.repeatability[all.active[b]] = std::sqrt(found[b].unknown.front().variance);
    for (const auto& unknown : found[b].unknown) add(sources, unknown.name, unknown.variance * unknown.kernel);
  }
  if (expected) add_expected(bench, all, expected->turn_on_sd, sources);

  const MatrixXd v = sum_of(sources);
  const Estimator estimate = estimator(design.x, all.z, for_weights(v, at(all.cells)));
  const MatrixXd gain = convert * estimate.gain;
  fill_cells(all, v, out);
  fill_parameters(gain, all.z, sources, out);
  for (Index j = 0; j < gain.rows(); ++j)
    out.degrees_of_freedom.push_back(
        freedom_of(static_cast<std::size_t>(j), gain.row(j), bench.white_freedom, found, out));
  out.fit.observations = static_cast<std::size_t>(all.z.size());
  out.fit.degrees_of_freedom = static_cast<double>(all.z.size() - gain.rows());
  out.fit.chi_square = estimate.chi_square;
  out.fit.condition = estimate.condition;
  return out;
}

}  // namespace tumble::accelerometer_four_position
