#include "tumble/math/regression/mixed_model/restricted.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"
#include "tumble/units/error.hpp"

namespace tumble::mixed_model {
namespace {

double square(double x) { return x * x; }

/// The restricted likelihood of the variances: that of the contrasts A'y, A'X = 0, which know nothing of b.
///
///   -2 l = log |V| + z' V^-1 z + nu log s^2 + S/s^2,   z = A'y, V = A'(s^2 I + sum t_c^2 K_c + D D')A
///
/// with S and nu the squares and freedom within the segments.
class Restricted {
 public:
  Restricted(const MixedData& data, const Compressed& rows, const VectorXd& residuals)
      : within_squares_(rows.within_squares), within_freedom_(rows.within_freedom) {
    const Index n = rows.design.rows(), p = rows.design.cols();
    const Eigen::HouseholderQR<MatrixXd> qr(rows.design);
    const auto contrast = [&](MatrixXd m) -> MatrixXd {
      m.applyOnTheLeft(qr.householderQ().transpose());
      return m.bottomRows(n - p);
    };
    z_ = contrast(residuals);
    shifts_ = contrast(rows.incidence);
    MatrixXd factor = contrast(known_factor(rows));
    keep_what_is_not_white(factor);
    known_ = factor * factor.transpose();
    held_.push_back(false);
    for (const auto& slow : data.slow) {
      kernels_.push_back(map(slow.kernel));
      held_.push_back(slow.known);
    }
  }

  Index contrasts() const { return z_.size(); }
  Index size() const { return at(kernels_.size()) + 1; }
  /// Whether a variance is known beforehand.
  bool held(Index i) const { return held_[static_cast<std::size_t>(i)]; }
  double freedom() const { return within_freedom_ + static_cast<double>(z_.size()); }
  double total_squares() const { return within_squares_ + z_.squaredNorm(); }
  /// Of what is known at these variances.
  double known_mean(const VectorXd& variances) const {
    double mean = contrasts() > 0 ? known_.trace() / static_cast<double>(contrasts()) : 0.0;
    for (Index i = 1; i < size(); ++i)
      if (held(i)) mean += variances[i] * shift_mean(i - 1);
    return mean;
  }
  double within() const { return within_freedom_ > 0.0 ? within_squares_ / within_freedom_ : 0.0; }
  /// Mean variance of the contrasts for a unit of each slow component.
  double shift_mean(Index c) const {
    return (shifts_ * kernels_[static_cast<std::size_t>(c)] * shifts_.transpose()).trace() /
           static_cast<double>(std::max<Index>(1, contrasts()));
  }

  /// -2 l, its halved gradient pieces and expected information at these variances.
  struct Point {
    double value = 0.0;
    VectorXd fits, expects;  ///< z'PK_iPz and tr(PK_i): the gradient of l is (fits - expects)/2
    MatrixXd information;    ///< tr(PK_iPK_j)/2
  };

  Point at_variances(const VectorXd& variances) const {
    MatrixXd v = known_;
    v.diagonal().array() += variances[0];
    for (std::size_t c = 0; c < kernels_.size(); ++c)
      if (variances[at(c) + 1] > 0.0) v += variances[at(c) + 1] * shifts_ * kernels_[c] * shifts_.transpose();
    const Eigen::LLT<MatrixXd> root(v);
    const MatrixXd inverse = root.solve(MatrixXd::Identity(contrasts(), contrasts()));
    const VectorXd white = inverse * z_;
    const MatrixXd through = inverse * shifts_, middle = shifts_.transpose() * through;
    const VectorXd felt = shifts_.transpose() * white;
    const double s2 = variances[0];
    Point point{0.0, VectorXd(size()), VectorXd(size()), MatrixXd(size(), size())};
    point.value = 2.0 * root.matrixLLT().diagonal().array().log().sum() + z_.dot(white) +
                  within_freedom_ * std::log(s2) + within_squares_ / s2;
    point.fits[0] = white.squaredNorm() + within_squares_ / square(s2);
    point.expects[0] = inverse.trace() + within_freedom_ / s2;
    point.information(0, 0) = 0.5 * (inverse.squaredNorm() + within_freedom_ / square(s2));
    const MatrixXd twice = through.transpose() * through;
    std::vector<MatrixXd> passed;
    for (std::size_t c = 0; c < kernels_.size(); ++c) {
      const Index i = at(c) + 1;
      passed.push_back(kernels_[c] * middle);
      point.fits[i] = felt.dot(kernels_[c] * felt);
      point.expects[i] = passed.back().trace();
      point.information(0, i) = point.information(i, 0) = 0.5 * kernels_[c].cwiseProduct(twice).sum();
      for (std::size_t d = 0; d <= c; ++d)
        point.information(i, at(d) + 1) = point.information(at(d) + 1, i) =
            0.5 * passed[c].cwiseProduct(passed[d].transpose()).sum();
    }
    return point;
  }

 private:
  /// Turns the contrasts so that known effects and shifts fill the first few; the rest has white noise alone and goes
  /// to the squares within the segments.
  void keep_what_is_not_white(MatrixXd& factor) {
    const Index m = z_.size(), used = factor.cols() + shifts_.cols();
    if (used >= m) return;
    MatrixXd both(m, used);
    both << factor, shifts_;
    const Eigen::HouseholderQR<MatrixXd> qr(both);
    const MatrixXd r = qr.matrixQR().topRows(used).triangularView<Eigen::Upper>();
    factor = r.leftCols(factor.cols());
    shifts_ = MatrixXd(r.rightCols(shifts_.cols()));
    z_.applyOnTheLeft(qr.householderQ().transpose());
    within_squares_ += z_.tail(m - used).squaredNorm();
    within_freedom_ += static_cast<double>(m - used);
    z_ = VectorXd(z_.head(used));
  }

  VectorXd z_;
  MatrixXd shifts_, known_;
  std::vector<MatrixXd> kernels_;
  std::vector<bool> held_;
  double within_squares_, within_freedom_;
};

/// One step of Fisher's scoring over the variances that are neither known nor held at zero.
VectorXd scoring_step(const Restricted& likelihood, const Restricted::Point& point, const VectorXd& variances) {
  const VectorXd gradient = 0.5 * (point.fits - point.expects);
  std::vector<Index> free;
  for (Index i = 0; i < variances.size(); ++i)
    if (i == 0 || (!likelihood.held(i) && (variances[i] > 0.0 || gradient[i] > 0.0))) free.push_back(i);
  const MatrixXd information = point.information(free, free);
  const VectorXd unit = information.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  const MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  const VectorXd step =
      unit.cwiseProduct(scaled.completeOrthogonalDecomposition().solve(unit.cwiseProduct(VectorXd(gradient(free)))));
  VectorXd next = variances;
  for (std::size_t k = 0; k < free.size(); ++k) next[free[k]] = std::max(0.0, variances[free[k]] + step[at(k)]);
  next[0] = std::max(next[0], 0.1 * variances[0]);
  return next;
}

/// theta_i sqrt(z'PK_iPz/tr(PK_i)): never leads downhill (Zhou, Hu, Zhou and Lange, J. Comput. Graph. Stat. 28 (2019)
/// 350), but slow where a variance is zero. Rounding may put z'PK_iPz below zero where data that repeat exactly cancel.
VectorXd sure_step(const Restricted::Point& point, const VectorXd& variances) {
  return variances.cwiseProduct(point.fits.cwiseMax(0.0).cwiseQuotient(point.expects.cwiseMax(1e-300)).cwiseSqrt());
}

/// Variances and what the likelihood says there.
struct Top {
  VectorXd variances;
  Restricted::Point point;
};

/// Climbs from `start`; a variance that begins at zero stays there, and one that is known where it is.
Top climb(const Restricted& likelihood, const VectorXd& start, double floor) {
  Top top{start, likelihood.at_variances(start)};
  int still = 0;  // rounds that gained nothing
  for (int round = 0; round < 200 && still < 2; ++round) {
    VectorXd next =
        round < 4 ? sure_step(top.point, top.variances) : scoring_step(likelihood, top.point, top.variances);
    for (Index i = 0; i < next.size(); ++i)
      if (start[i] == 0.0 || likelihood.held(i)) next[i] = start[i];
    next[0] = std::max(next[0], floor);
    auto there = likelihood.at_variances(next);
    const double value = top.point.value;
    for (int half = 0; half < 8 && !(there.value <= value + 1e-12 * std::abs(value)); ++half) {
      next = 0.5 * (next + top.variances);
      there = likelihood.at_variances(next);
    }
    still = round >= 4 && value - there.value < 1e-9 ? still + 1 : 0;
    top = {next, std::move(there)};
  }
  return top;
}

/// Slow noise is left out where the likelihood hardly misses it and something like it stays: other slow noise of the
/// same source's name, or of known size. Two variances that the data cannot tell apart make intervals too wide.
Top without_needless(const MixedData& data, const Restricted& likelihood, Top top, double floor) {
  const bool some_known = std::ranges::any_of(data.slow, &SlowNoise::known);
  for (std::size_t c = 0; c < data.slow.size(); ++c) {
    const Index i = at(c) + 1;
    const bool alternative = std::any_of(data.slow.begin() + static_cast<std::ptrdiff_t>(c) + 1, data.slow.end(),
                                         [&](const SlowNoise& other) { return other.source == data.slow[c].source; });
    if (likelihood.held(i) || !(alternative || some_known) || !(top.variances[i] > 0.0)) continue;
    VectorXd start = top.variances;
    for (Index later = i + 1; later < start.size(); ++later)
      if (!likelihood.held(later)) start[later] = std::max(start[later], 1e-3 * top.variances[i]);
    start[i] = 0.0;
    Top less = climb(likelihood, start, floor);
    if (less.point.value - top.point.value < 1.0) top = std::move(less);
  }
  return top;
}

}  // namespace

Components restricted_likelihood(const MixedData& data, const Compressed& rows, const VectorXd& residuals) {
  const Restricted likelihood(data, rows, residuals);
  if (!(likelihood.freedom() > 0.0))
    throw Error(Error::Kind::bad_data, fmt::format("{} observations leave nothing to tell the noise of {} parameters",
                                                   data.design.rows, data.design.columns));
  const double mean = likelihood.total_squares() / likelihood.freedom();
  VectorXd start = VectorXd::Constant(likelihood.size(), 0.0);
  for (std::size_t c = 0; c < data.slow.size(); ++c)
    if (data.slow[c].known) start[at(c) + 1] = data.slow[c].variance;
  // Below, the observations are free of noise to rounding: V would lose its own digits.
  const double floor = std::max({1e-10 * likelihood.known_mean(start), square(1e-16) * rows.observations.squaredNorm(),
                                 std::numeric_limits<double>::min() * 1e20});
  start[0] = std::max(likelihood.within() > 0.0 ? likelihood.within() : mean, floor);
  for (Index c = 0; c + 1 < start.size(); ++c)
    if (const double unit = likelihood.shift_mean(c);
        !likelihood.held(c + 1) && likelihood.contrasts() > 0 && unit > 0.0)
      start[c + 1] = std::max(mean, floor) / unit / static_cast<double>(start.size());
  const auto [now, point] = without_needless(data, likelihood, climb(likelihood, start, floor), floor);
  // A variance found to be zero is taken as known: counting its uncertainty as well would make the intervals wider
  // still where there is no slow noise.
  MatrixXd information = point.information;
  for (Index i = 1; i < now.size(); ++i)
    if (!(now[i] > 0.0) || likelihood.held(i)) information.row(i).setZero(), information.col(i).setZero();
  const VectorXd unit =
      information.diagonal().cwiseSqrt().cwiseInverse().unaryExpr([](double u) { return std::isfinite(u) ? u : 0.0; });
  const MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  return {now, unit.asDiagonal() * scaled.completeOrthogonalDecomposition().pseudoInverse() * unit.asDiagonal()};
}

}  // namespace tumble::mixed_model
