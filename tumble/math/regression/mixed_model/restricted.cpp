#include "tumble/math/regression/mixed_model/restricted.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/eigen/view.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/units/error.hpp"

namespace tumble::mixed_model {
namespace {

using Variances = std::vector<double>;

constexpr double least_of_step = 0.1;  ///< [1] of the white variance, that one step leaves at least
constexpr int most_rounds = 200, sure_rounds = 4, still_rounds = 2, most_halvings = 8;
constexpr double not_lower = 1e-12;       ///< [1] of the log-likelihood: rounding
constexpr double no_gain = 1e-9;          ///< of -2 ln L, in a round that gained nothing
constexpr double start_of_later = 1e-3;   ///< [1] of the variance that is tried as zero, for those behind it
constexpr double floor_of_known = 1e-10;  ///< [1] of the known variance: below, V would lose its own digits

std::vector<double> values_of(const VectorXd& v) { return {v.data(), v.data() + v.size()}; }

/// sum a_ij b_ij.
double sum_of_products(const Matrix& a, const Matrix& b) { return dot(a.values, b.values); }

/// Rows first, first + 1, ... of a matrix.
Matrix rows_from(const Matrix& a, std::size_t first) { return block(a, first, a.rows - first, 0, a.columns); }

/// The restricted likelihood of the variances: that of the contrasts A'y, A'X = 0, which know nothing of b.
///
///   -2 l = log |V| + z' V^-1 z + nu log s^2 + S/s^2,   z = A'y, V = A'(s^2 I + sum t_c^2 K_c + D D')A
///
/// with S and nu the squares and freedom within the segments.
class Restricted {
 public:
  Restricted(const std::vector<SlowNoise>& slow_noise, const Compressed& rows, const VectorXd& residuals)
      : held_{false}, within_squares_(rows.within_squares), within_freedom_(rows.within_freedom) {
    const HouseholderQr qr = householder_qr(plain(rows.design));
    const auto contrast = [&](Matrix m) {
      return rows_from(q_transposed_product(qr, std::move(m)), qr.packed.columns);
    };
    z_ = contrast(as_column(values_of(residuals))).values;
    shifts_ = contrast(plain(rows.incidence));
    Matrix factor = contrast(plain(known_factor(rows)));
    separate_white(factor);
    known_ = gram(transposed(factor));
    for (const auto& slow : slow_noise) {
      kernels_.push_back(slow.kernel);
      slow_.push_back(sandwich(shifts_, slow.kernel));
      held_.push_back(slow.known);
    }
  }

  std::size_t contrasts() const { return z_.size(); }
  std::size_t size() const { return kernels_.size() + 1; }
  /// Whether a variance is known beforehand.
  bool held(std::size_t i) const { return held_[i]; }
  double freedom() const { return within_freedom_ + static_cast<double>(contrasts()); }
  double total_squares() const { return within_squares_ + dot(z_, z_); }
  /// Mean variance of the contrasts by what is known at these variances.
  double known_mean(const Variances& variances) const {
    double mean = mean_variance(known_);
    for (std::size_t i = 1; i < size(); ++i)
      if (held(i)) mean += variances[i] * shift_mean(i - 1);
    return mean;
  }
  double within() const { return within_freedom_ > 0.0 ? within_squares_ / within_freedom_ : 0.0; }
  /// Mean variance of the contrasts for a unit of each slow component.
  double shift_mean(std::size_t c) const { return mean_variance(slow_[c]); }

  /// -2 l, its halved gradient pieces and expected information at these variances.
  struct Point {
    double value = 0.0;
    std::vector<double> fits, expects;  ///< z'PK_iPz and tr(PK_i): the gradient of l is (fits - expects)/2
    Matrix information;                 ///< tr(PK_iPK_j)/2
  };

  Point at_variances(const Variances& variances) const {
    const double s2 = variances[0];
    if (contrasts() == 0) return within_alone(s2);
    Matrix v = known_;
    for (std::size_t i = 0; i < v.rows; ++i) v(i, i) += s2;
    for (std::size_t c = 0; c < slow_.size(); ++c)
      if (variances[c + 1] > 0.0) v += variances[c + 1] * slow_[c];
    Cholesky factor = cholesky(v);
    if (!factor.positive) factor = cholesky(v + 1e-14 * trace(v) * identity(contrasts()));  // singular to rounding
    if (!factor.positive) throw Error(Error::Kind::internal, "mixed model: covariance not positive");
    const Matrix inverse = solve(factor, identity(contrasts()));
    const auto white = inverse * z_, felt = transposed_product(shifts_, white);
    const Matrix through = inverse * shifts_, middle = transposed_product(shifts_, through), twice = gram(through);
    Point point{factor.log_determinant + dot(z_, white) + within_freedom_ * std::log(s2) + within_squares_ / s2,
                {dot(white, white) + within_squares_ / square(s2)},
                {trace(inverse) + within_freedom_ / s2},
                Matrix(size(), size())};
    point.information(0, 0) = 0.5 * (sum_of_products(inverse, inverse) + within_freedom_ / square(s2));
    std::vector<Matrix> passed;
    for (std::size_t c = 0; c < kernels_.size(); ++c) {
      passed.push_back(kernels_[c] * middle);
      point.fits.push_back(quadratic_form(felt, kernels_[c]));
      point.expects.push_back(trace(passed.back()));
      point.information(0, c + 1) = point.information(c + 1, 0) = 0.5 * sum_of_products(kernels_[c], twice);
      const Matrix turned = transposed(passed.back());
      for (std::size_t d = 0; d <= c; ++d)
        point.information(c + 1, d + 1) = point.information(d + 1, c + 1) = 0.5 * sum_of_products(turned, passed[d]);
    }
    return point;
  }

 private:
  /// Where the parameters explain every contrast between the segments.
  Point within_alone(double s2) const {
    Point point{within_freedom_ * std::log(s2) + within_squares_ / s2, std::vector<double>(size()),
                std::vector<double>(size()), Matrix(size(), size())};
    point.fits[0] = within_squares_ / square(s2);
    point.expects[0] = within_freedom_ / s2;
    point.information(0, 0) = 0.5 * within_freedom_ / square(s2);
    return point;
  }

  double mean_variance(const Matrix& covariance) const {
    return trace(covariance) / static_cast<double>(std::max<std::size_t>(1, contrasts()));
  }

  /// Turns the contrasts so that known effects and shifts fill the first few; the rest has white noise alone and goes
  /// to the squares within the segments.
  void separate_white(Matrix& factor) {
    const std::size_t m = contrasts(), used = factor.columns + shifts_.columns;
    if (used >= m) return;
    const HouseholderQr qr = householder_qr(beside(factor, shifts_));
    const Matrix upper = upper_of(qr);
    shifts_ = block(upper, 0, used, factor.columns, shifts_.columns);
    factor = block(upper, 0, used, 0, factor.columns);
    z_ = q_transposed_product(qr, z_);
    const auto rest = std::span(z_).subspan(used);
    within_squares_ += dot(rest, rest);
    within_freedom_ += static_cast<double>(m - used);
    z_.resize(used);
  }

  std::vector<double> z_;
  Matrix shifts_, known_;
  std::vector<Matrix> kernels_, slow_;  ///< of the shifts, and what they make of the contrasts
  std::vector<bool> held_;
  double within_squares_, within_freedom_;
};

/// One step of Fisher's scoring over the variances that are neither known nor held at zero.
Variances scoring_step(const Restricted& likelihood, const Restricted::Point& point, const Variances& variances) {
  const auto gradient = scaled(0.5, difference(point.fits, point.expects));
  std::vector<std::size_t> free;
  std::vector<double> unit, slope;
  for (std::size_t i = 0; i < variances.size(); ++i) {
    if (i > 0 && (likelihood.held(i) || !(variances[i] > 0.0 || gradient[i] > 0.0))) continue;
    free.push_back(i);
    unit.push_back(1.0 / std::max(std::sqrt(point.information(i, i)), 1e-300));
    slope.push_back(unit.back() * gradient[i]);
  }
  const Matrix information = chosen_rows(chosen_columns(point.information, free), free);
  const auto step = pseudo_inverse(scaled_columns(scaled_rows(unit, information), unit)) * slope;
  Variances next = variances;
  for (std::size_t k = 0; k < free.size(); ++k) next[free[k]] = std::max(0.0, variances[free[k]] + unit[k] * step[k]);
  next[0] = std::max(next[0], least_of_step * variances[0]);
  return next;
}

/// theta_i sqrt(z'PK_iPz/tr(PK_i)): never leads downhill (Zhou, Hu, Zhou and Lange, J. Comput. Graph. Stat. 28 (2019)
/// 350), but slow where a variance is zero. Rounding may put z'PK_iPz below zero where data that repeat exactly cancel.
Variances sure_step(const Restricted::Point& point, Variances variances) {
  for (std::size_t i = 0; i < variances.size(); ++i)
    variances[i] *= std::sqrt(std::max(0.0, point.fits[i]) / std::max(point.expects[i], 1e-300));
  return variances;
}

/// Variances and what the likelihood says there.
struct Top {
  Variances variances;
  Restricted::Point point;
};

/// Climbs from `start`; a variance that begins at zero stays there, and one that is known where it is.
Top climb(const Restricted& likelihood, const Variances& start, double floor) {
  Top top{start, likelihood.at_variances(start)};
  int still = 0;  // rounds that gained nothing
  for (int round = 0; round < most_rounds && still < still_rounds; ++round) {
    Variances next =
        round < sure_rounds ? sure_step(top.point, top.variances) : scoring_step(likelihood, top.point, top.variances);
    for (std::size_t i = 0; i < next.size(); ++i)
      if (start[i] == 0.0 || likelihood.held(i)) next[i] = start[i];
    next[0] = std::max(next[0], floor);
    auto there = likelihood.at_variances(next);
    const double value = top.point.value;
    for (int half = 0; half < most_halvings && !(there.value <= value + not_lower * std::abs(value)); ++half) {
      next = scaled(0.5, scaled_sum(next, 1.0, top.variances));
      there = likelihood.at_variances(next);
    }
    still = round >= sure_rounds && value - there.value < no_gain ? still + 1 : 0;
    top = {next, std::move(there)};
  }
  return top;
}

/// Slow noise is removed where the likelihood hardly needs it and something like it remains: other slow noise of its
/// source's name, or of known size. Two variances that the data cannot distinguish make intervals too wide.
Top without_needless(const std::vector<SlowNoise>& slow, const Restricted& likelihood, Top top, double floor) {
  const bool some_known = std::ranges::any_of(slow, &SlowNoise::known);
  for (std::size_t c = 0; c < slow.size(); ++c) {
    const std::size_t i = c + 1;
    const bool alternative = std::any_of(slow.begin() + static_cast<std::ptrdiff_t>(c) + 1, slow.end(),
                                         [&](const SlowNoise& other) { return other.source == slow[c].source; });
    if (likelihood.held(i) || !(alternative || some_known) || !(top.variances[i] > 0.0)) continue;
    Variances start = top.variances;
    for (std::size_t later = i + 1; later < start.size(); ++later)
      if (!likelihood.held(later)) start[later] = std::max(start[later], start_of_later * top.variances[i]);
    start[i] = 0.0;
    Top less = climb(likelihood, start, floor);
    if (less.point.value - top.point.value < 1.0) top = std::move(less);
  }
  return top;
}

}  // namespace

std::vector<double> shown_by_contrasts(const std::vector<SlowNoise>& slow, const Compressed& rows) {
  const HouseholderQr qr = householder_qr(plain(rows.design));
  const Matrix shifts = plain(rows.incidence);
  const Matrix contrasts = rows_from(q_transposed_product(qr, shifts), qr.packed.columns);
  std::vector<double> shown;
  for (const auto& one : slow) {
    const double whole = trace(sandwich(shifts, one.kernel));
    shown.push_back(whole > 0.0 ? trace(sandwich(contrasts, one.kernel)) / whole : 0.0);
  }
  return shown;
}

Components restricted_likelihood(const std::vector<SlowNoise>& slow, const Compressed& rows,
                                 const VectorXd& residuals) {
  const Restricted likelihood(slow, rows, residuals);
  if (!(likelihood.freedom() > 0.0))
    throw Error(Error::Kind::bad_data,
                say("{} observations do not show the noise of {} parameters: more than that are needed",
                    rows.design.rows(), rows.design.cols()));
  const double mean = likelihood.total_squares() / likelihood.freedom();
  Variances start(likelihood.size());
  for (std::size_t c = 0; c < slow.size(); ++c)
    if (slow[c].known) start[c + 1] = slow[c].variance;
  // Below, the observations are free of noise to rounding: V would lose its own digits.
  const double floor =
      std::max({floor_of_known * likelihood.known_mean(start), square(1e-16) * rows.observations.squaredNorm(),
                std::numeric_limits<double>::min() * 1e20});
  start[0] = std::max(likelihood.within() > 0.0 ? likelihood.within() : mean, floor);
  for (std::size_t c = 0; c + 1 < start.size(); ++c)
    if (const double unit = likelihood.shift_mean(c);
        !likelihood.held(c + 1) && likelihood.contrasts() > 0 && unit > 0.0)
      start[c + 1] = std::max(mean, floor) / unit / static_cast<double>(start.size());
  const auto [now, point] = without_needless(slow, likelihood, climb(likelihood, start, floor), floor);
  // A variance found to be zero is taken as known: counting its uncertainty as well would make the intervals wider
  // still where there is no slow noise.
  std::vector<double> unit(now.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    const bool free = i == 0 || (now[i] > 0.0 && !likelihood.held(i));
    const double inverse = 1.0 / std::sqrt(point.information(i, i));
    unit[i] = free && std::isfinite(inverse) ? inverse : 0.0;
  }
  const Matrix inverse = pseudo_inverse(scaled_columns(scaled_rows(unit, point.information), unit));
  return {Eigen::Map<const VectorXd>(now.data(), at(now.size())),
          map(scaled_columns(scaled_rows(unit, inverse), unit))};
}

}  // namespace tumble::mixed_model
