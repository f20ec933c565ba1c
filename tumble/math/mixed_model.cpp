#include "tumble/math/mixed_model.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Index at(std::size_t i) { return static_cast<Index>(i); }

Eigen::Map<const MatrixXd> map(const Matrix& m) { return {m.values.data(), at(m.rows), at(m.columns)}; }

Matrix plain(const MatrixXd& m) {
  Matrix out(static_cast<std::size_t>(m.rows()), static_cast<std::size_t>(m.cols()));
  Eigen::Map<MatrixXd>(out.values.data(), m.rows(), m.cols()) = m;
  return out;
}

double square(double x) { return x * x; }

/// The sufficient statistics of all segments: rows of unit white noise, and what is left within the segments.
struct Compressed {
  MatrixXd design;
  MatrixXd effects;                ///< a column for each known effect
  std::vector<bool> each_segment;  ///< of the effects
  MatrixXd incidence;              ///< rows x segments: what a shift of the segment does
  VectorXd observations;
  std::vector<std::pair<Index, Index>> parts;  ///< first row and number of rows of each segment
  double within_squares = 0.0;                 ///< sum of squares about anything the model could explain
  double within_freedom = 0.0;
};

/// Rows of one segment: [X | D | 1], whitened, and y.
struct Block {
  MatrixXd model;
  VectorXd observations;
};

constexpr double rounding = 1e-13;

/// Turns a segment's rows so that all but the first few vanish: pivoted Householder QR of the columns over `scale`.
/// Returns how many remain; what is below `rounding` is left out.
Index compress(Block& block, const VectorXd& scale) {
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(block.model * scale.cwiseInverse().asDiagonal());
  const auto diagonal = qr.matrixQR().diagonal().cwiseAbs();
  Index rank = 0;
  while (rank < diagonal.size() && diagonal[rank] > rounding) ++rank;
  const Index n = block.model.rows();
  MatrixXd r = qr.matrixQR().topRows(rank).triangularView<Eigen::Upper>();
  block.model = r * qr.colsPermutation().transpose() * scale.asDiagonal();
  block.observations.applyOnTheLeft(qr.householderQ().setLength(std::min(n, qr.matrixQR().cols())).transpose());
  return rank;
}

/// Least scatter about the mean of any segment, per unit weight: white noise, where a segment is at rest.
double scatter_within(const MixedData& data) {
  double least = std::numeric_limits<double>::infinity();
  const std::size_t n = data.segment.size();
  for (std::size_t first = 0, last = 0; first < n; first = last) {
    double weight = 0.0, sum = 0.0, squares = 0.0;
    for (; last < n && data.segment[last] == data.segment[first]; ++last)
      weight += data.weights[last], sum += data.weights[last] * data.observations[last];
    if (last - first < 4) continue;
    for (std::size_t i = first; i < last; ++i) squares += data.weights[i] * square(data.observations[i] - sum / weight);
    least = std::min(least, squares / static_cast<double>(last - first - 1));
  }
  return std::isfinite(least) ? std::sqrt(least) : 0.0;
}

/// `white`: sd of unit weight, at least roughly.
Compressed compress(const MixedData& data, double white) {
  const Index n = at(data.design.rows), p = at(data.design.columns), q = at(data.effects.size());
  MatrixXd model(n, p + q + 1);
  const VectorXd root = Eigen::Map<const VectorXd>(data.weights.data(), n).cwiseSqrt();
  model.leftCols(p) = map(data.design);
  for (Index k = 0; k < q; ++k)
    model.col(p + k) = Eigen::Map<const VectorXd>(data.effects[static_cast<std::size_t>(k)].column.data(), n);
  model.col(p + q).setOnes();
  model = root.asDiagonal() * model;
  VectorXd scale = model.colwise().norm();
  for (auto& s : scale)
    if (!(s > 0.0)) s = 1.0;
  // What a known effect does beyond the columns is of no account below a hundredth of the white noise of one row.
  for (Index k = 0; k < q; ++k) scale[p + k] = std::max(scale[p + k], 0.01 * white / rounding);
  VectorXd y = VectorXd::Zero(n);
  if (!data.observations.empty()) y = root.cwiseProduct(Eigen::Map<const VectorXd>(data.observations.data(), n));

  Compressed out;
  for (const auto& effect : data.effects) out.each_segment.push_back(effect.each_segment);
  MatrixXd rows(n, p + q + 1);
  VectorXd kept(n);
  Index used = 0;
  for (Index first = 0, last = 0; first < n; first = last) {
    while (last < n && data.segment[static_cast<std::size_t>(last)] == data.segment[static_cast<std::size_t>(first)])
      ++last;
    Block block{model.middleRows(first, last - first), y.segment(first, last - first)};
    const Index rank = compress(block, scale);
    rows.middleRows(used, rank) = block.model;
    kept.segment(used, rank) = block.observations.head(rank);
    out.within_squares += block.observations.tail(last - first - rank).squaredNorm();
    out.within_freedom += static_cast<double>(last - first - rank);
    out.parts.emplace_back(used, rank);
    used += rank;
  }
  out.design = rows.topLeftCorner(used, p);
  out.effects = rows.block(0, p, used, q);
  out.observations = kept.head(used);
  out.incidence = MatrixXd::Zero(used, at(out.parts.size()));
  for (std::size_t g = 0; g < out.parts.size(); ++g) {
    const auto [first, count] = out.parts[g];
    out.incidence.col(at(g)).segment(first, count) = rows.col(p + q).segment(first, count);
  }
  return out;
}

/// Ordinary least squares and its residuals: where the estimate starts.
std::pair<VectorXd, VectorXd> ordinary(const Compressed& rows) {
  const Index p = rows.design.cols();
  const VectorXd scale = rows.design.colwise().norm();
  if (rows.design.rows() < p || !(scale.minCoeff() > 0.0))
    throw Error(Error::Kind::bad_data,
                fmt::format("{} independent observations cannot determine {} parameters", rows.design.rows(), p));
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(rows.design * scale.cwiseInverse().asDiagonal());
  if (std::abs(qr.matrixQR()(p - 1, p - 1)) < 1e-12 * std::abs(qr.matrixQR()(0, 0)))
    throw Error(Error::Kind::bad_data, "the parameters cannot be told apart");
  const VectorXd b = scale.cwiseInverse().cwiseProduct(qr.solve(rows.observations));
  return {b, rows.observations - rows.design * b};
}

/// Columns whose outer products sum to the covariance of the known effects.
MatrixXd known_factor(const Compressed& rows) {
  const Index n = rows.design.rows();
  std::vector<VectorXd> columns;
  for (Index k = 0; k < rows.effects.cols(); ++k) {
    if (!rows.each_segment[static_cast<std::size_t>(k)]) {
      columns.emplace_back(rows.effects.col(k));
      continue;
    }
    for (const auto& [first, count] : rows.parts) {
      columns.emplace_back(VectorXd::Zero(n));
      columns.back().segment(first, count) = rows.effects.col(k).segment(first, count);
    }
  }
  MatrixXd factor(n, at(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) factor.col(at(c)) = columns[c];
  return factor;
}

MatrixXd known_covariance(const Compressed& rows) {
  MatrixXd v = MatrixXd::Zero(rows.design.rows(), rows.design.rows());
  for (Index k = 0; k < rows.effects.cols(); ++k) {
    if (!rows.each_segment[static_cast<std::size_t>(k)]) {
      v += rows.effects.col(k) * rows.effects.col(k).transpose();
      continue;
    }
    for (const auto& [first, count] : rows.parts) {
      const auto d = rows.effects.col(k).segment(first, count);
      v.block(first, first, count, count) += d * d.transpose();
    }
  }
  return v;
}

struct Components {
  VectorXd variances;   ///< s^2, t_c^2
  MatrixXd covariance;  ///< of these
};

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
    for (const auto& slow : data.slow) kernels_.push_back(map(slow.kernel));
  }

  Index contrasts() const { return z_.size(); }
  Index size() const { return at(kernels_.size()) + 1; }
  double freedom() const { return within_freedom_ + static_cast<double>(z_.size()); }
  double total_squares() const { return within_squares_ + z_.squaredNorm(); }
  double known_mean() const { return contrasts() > 0 ? known_.trace() / static_cast<double>(contrasts()) : 0.0; }
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
  double within_squares_, within_freedom_;
};

/// One step of Fisher's scoring over the variances that are not held at zero.
VectorXd scoring_step(const Restricted::Point& point, const VectorXd& variances) {
  const VectorXd gradient = 0.5 * (point.fits - point.expects);
  std::vector<Index> free;
  for (Index i = 0; i < variances.size(); ++i)
    if (i == 0 || variances[i] > 0.0 || gradient[i] > 0.0) free.push_back(i);
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
/// 350), but slow where a variance is zero.
VectorXd sure_step(const Restricted::Point& point, const VectorXd& variances) {
  return variances.cwiseProduct((point.fits.cwiseQuotient(point.expects.cwiseMax(1e-300))).cwiseSqrt());
}

/// Variances and what the likelihood says there.
struct Top {
  VectorXd variances;
  Restricted::Point point;
};

/// Climbs from `start`; a variance that begins at zero stays there.
Top climb(const Restricted& likelihood, const VectorXd& start, double floor) {
  Top top{start, likelihood.at_variances(start)};
  int still = 0;  // rounds that gained nothing
  for (int round = 0; round < 200 && still < 2; ++round) {
    VectorXd next = round < 4 ? sure_step(top.point, top.variances) : scoring_step(top.point, top.variances);
    for (Index i = 0; i < next.size(); ++i)
      if (start[i] == 0.0) next[i] = 0.0;
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

/// Of slow noise with one source's name the first is left out where the likelihood hardly misses it: two variances that
/// the data cannot tell apart make intervals too wide.
Top without_needless(const MixedData& data, const Restricted& likelihood, Top top, double floor) {
  for (std::size_t c = 0; c + 1 < data.slow.size(); ++c) {
    const Index i = at(c) + 1;
    const bool alternative = std::any_of(data.slow.begin() + static_cast<std::ptrdiff_t>(c) + 1, data.slow.end(),
                                         [&](const SlowNoise& other) { return other.source == data.slow[c].source; });
    if (!alternative || !(top.variances[i] > 0.0)) continue;
    VectorXd start = top.variances.cwiseMax(1e-3 * top.variances[i]);
    start[i] = 0.0;
    Top less = climb(likelihood, start, floor);
    if (less.point.value - top.point.value < 1.0) top = std::move(less);
  }
  return top;
}

/// Variances of greatest restricted likelihood, none below zero, and their covariance (inverse expected information).
Components restricted_likelihood(const MixedData& data, const Compressed& rows, const VectorXd& residuals) {
  const Restricted likelihood(data, rows, residuals);
  if (!(likelihood.freedom() > 0.0))
    throw Error(Error::Kind::bad_data, fmt::format("{} observations leave nothing to tell the noise of {} parameters",
                                                   data.design.rows, data.design.columns));
  const double mean = likelihood.total_squares() / likelihood.freedom();
  // Below, the observations are free of noise to rounding: V would lose its own digits.
  const double floor = std::max({1e-10 * likelihood.known_mean(), square(1e-16) * rows.observations.squaredNorm(),
                                 std::numeric_limits<double>::min() * 1e20});
  VectorXd start = VectorXd::Constant(likelihood.size(), 0.0);
  start[0] = std::max(likelihood.within() > 0.0 ? likelihood.within() : mean, floor);
  for (Index c = 0; c + 1 < start.size(); ++c)
    if (const double unit = likelihood.shift_mean(c); likelihood.contrasts() > 0 && unit > 0.0)
      start[c + 1] = std::max(mean, floor) / unit / static_cast<double>(start.size());
  const auto [now, point] = without_needless(data, likelihood, climb(likelihood, start, floor), floor);
  // A variance found to be zero is taken as known: counting its uncertainty as well would make the intervals wider
  // still where there is no slow noise.
  MatrixXd information = point.information;
  for (Index i = 1; i < now.size(); ++i)
    if (!(now[i] > 0.0)) information.row(i).setZero(), information.col(i).setZero();
  const VectorXd unit =
      information.diagonal().cwiseSqrt().cwiseInverse().unaryExpr([](double u) { return std::isfinite(u) ? u : 0.0; });
  const MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  return {now, unit.asDiagonal() * scaled.completeOrthogonalDecomposition().pseudoInverse() * unit.asDiagonal()};
}

/// The linear estimator b = G y for a covariance V of the compressed observations.
struct Estimator {
  MatrixXd gain;  ///< G, p x n
  double condition = 1.0;
};

/// QR of the whitened design with unit columns: X = V^1/2 Q R D, G = D^-1 R^-1 Q' V^-1/2.
Estimator estimator(const MatrixXd& design, const MatrixXd& covariance) {
  const Eigen::LLT<MatrixXd> root(covariance);
  if (root.info() != Eigen::Success) throw Error(Error::Kind::internal, "mixed model: covariance not positive");
  const Index p = design.cols();
  MatrixXd white = root.matrixL().solve(design);
  const VectorXd scale = white.colwise().norm();
  white = white * scale.cwiseInverse().asDiagonal();
  const Eigen::HouseholderQR<MatrixXd> qr(white);
  const MatrixXd q = qr.householderQ() * MatrixXd::Identity(white.rows(), p);
  const MatrixXd r = qr.matrixQR().topRows(p).triangularView<Eigen::Upper>();
  const VectorXd s = Eigen::JacobiSVD<MatrixXd>(r).singularValues();
  const MatrixXd inner = root.matrixU().solve(q);  // V^-1/2' Q
  Estimator result;
  result.gain = scale.cwiseInverse().asDiagonal() * r.triangularView<Eigen::Upper>().solve(inner.transpose());
  result.condition = s[p - 1] > 0.0 ? s[0] / s[p - 1] : std::numeric_limits<double>::infinity();
  return result;
}

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
  const MatrixXd white = gain * gain.transpose();
  fit.component_sensitivity.push_back(plain(white));
  add(data.white, variances[0] * white);
  const MatrixXd shifts = gain * rows.incidence;
  for (std::size_t c = 0; c < data.slow.size(); ++c) {
    const MatrixXd slow = shifts * map(data.slow[c].kernel) * shifts.transpose();
    fit.component_sensitivity.push_back(plain(slow));
    add(data.slow[c].source, variances[at(c) + 1] * slow);
  }
  for (std::size_t k = 0; k < data.effects.size(); ++k)
    add(data.effects[k].source, effect_covariance(rows, gain, at(k)));
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
  MatrixXd v = known_covariance(rows);
  for (std::size_t c = 0; c < data.slow.size(); ++c)
    v += variances[at(c) + 1] * rows.incidence * map(data.slow[c].kernel) * rows.incidence.transpose();
  const double floor = 1e-10 * v.diagonal().mean();  // an estimator needs V positive; the sources hold the true one
  v.diagonal().array() += std::max({variances[0], floor, std::numeric_limits<double>::min()});
  return v;
}

}  // namespace

MixedFit fit_mixed_model(const MixedData& data) {
  refuse_unusable(data, true);
  const Compressed rows = compress(data, scatter_within(data));
  const auto [start, residuals] = ordinary(rows);
  const Components found = restricted_likelihood(data, rows, residuals);
  const MatrixXd v = covariance_of(data, rows, found.variances);
  const Estimator g = estimator(rows.design, v);
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
  fit.chi_square = last.dot(Eigen::LLT<MatrixXd>(v).solve(last));
  if (found.variances[0] > 0.0) fit.chi_square += rows.within_squares / found.variances[0];
  fit.degrees_of_freedom = static_cast<double>(data.design.rows) - static_cast<double>(data.design.columns);
  const VectorXd fitted = map(data.design) * b;
  fit.fitted.assign(fitted.data(), fitted.data() + fitted.size());
  return fit;
}

MixedFit predict_mixed_model(const MixedData& data, double white_variance) {
  refuse_unusable(data, false);
  const Compressed rows = compress(data, std::sqrt(white_variance));
  ordinary(rows);
  VectorXd variances(at(data.slow.size()) + 1);
  variances[0] = white_variance;
  for (std::size_t c = 0; c < data.slow.size(); ++c) variances[at(c) + 1] = data.slow[c].variance;
  const Estimator g = estimator(rows.design, covariance_of(data, rows, variances));
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
