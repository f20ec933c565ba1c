#include "tumble/methods/north_finding/solve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"
#include "tumble/units/error.hpp"

namespace tumble::north_finding {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Effects of one source, each by one standard deviation of its own.
struct Source {
  std::string name;
  MatrixXd columns;
};

/// All rows of all signals at one state.
struct System {
  VectorXd residual;
  MatrixXd slopes;   ///< by all quantities
  VectorXd white;    ///< variance of each row by white noise
  VectorXd scatter;  ///< and by what rounding adds in a turn: what rows are weighted by
  std::vector<Source> sources;
};

std::vector<Index> firsts_of(const Bench& bench) {
  std::vector<Index> firsts{0};
  for (const auto& signal : bench.signals) firsts.push_back(firsts.back() + at(signal.rows.size()));
  return firsts;
}

void add_noise(const Bench& bench, const std::vector<Noise>& noise, const std::vector<Index>& firsts, System& system) {
  for (std::size_t c = 0; c < bench.signals.size(); ++c) {
    const auto& signal = bench.signals[c];
    const std::string of = bench.signals.size() > 1 ? std::string(" of ") + signal.problem.role : "";
    for (const auto& slow : noise[c].slow) {
      const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(slow.variance * map(slow.kernel));
      const VectorXd sd = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
      Source source{slow.source + of, MatrixXd::Zero(firsts.back(), sd.size())};
      for (std::size_t r = 0; r < signal.rows.size(); ++r)
        source.columns.row(firsts[c] + at(r)) =
            solver.eigenvectors().row(at(signal.rows[r].place)).cwiseProduct(sd.transpose());
      if (source.columns.cwiseAbs().maxCoeff() > 0.0) system.sources.push_back(std::move(source));
    }
    if (!(signal.problem.pulse > 0.0)) continue;
    Source source{"counting" + of, MatrixXd::Zero(firsts.back(), at(signal.rows.size()))};
    for (std::size_t r = 0; r < signal.rows.size(); ++r)
      source.columns(firsts[c] + at(r), at(r)) = signal.rows[r].rounding_sd;
    system.sources.push_back(std::move(source));
  }
}

void add_rig(const Bench& bench, const State& state, const std::vector<Disturbance>& disturbances,
             const std::vector<Index>& firsts, System& system) {
  for (const auto& one : disturbances) {
    Source source{one.source, MatrixXd::Zero(firsts.back(), 1)};
    for (std::size_t c = 0; c < bench.signals.size(); ++c) {
      const auto shift = effect_of(bench.signals[c], one.moves[c], state);
      for (std::size_t r = 0; r < shift.size(); ++r) source.columns(firsts[c] + at(r), 0) = shift[r];
    }
    system.sources.push_back(std::move(source));
  }
}

void add_priors(const Instrument& instrument, System& system) {
  for (const auto& prior : instrument.priors) {
    MatrixXd of(system.slopes.rows(), at(prior.of.size()));
    for (std::size_t k = 0; k < prior.of.size(); ++k) of.col(at(k)) = system.slopes.col(at(prior.of[k]));
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(map(prior.covariance));
    const VectorXd sd = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
    system.sources.push_back({prior.source, of * solver.eigenvectors() * sd.asDiagonal()});
  }
}

System system_at(const Bench& bench, const State& state, const std::vector<Noise>& noise,
                 const std::vector<Disturbance>& disturbances, const Instrument& instrument, bool predicted) {
  const auto firsts = firsts_of(bench);
  System system{VectorXd::Zero(firsts.back()),
                MatrixXd(firsts.back(), at(quantities)),
                VectorXd(firsts.back()),
                VectorXd(firsts.back()),
                {}};
  for (std::size_t c = 0; c < bench.signals.size(); ++c)
    for (std::size_t r = 0; r < bench.signals[c].rows.size(); ++r) {
      const Row& row = bench.signals[c].rows[r];
      const Index i = firsts[c] + at(r);
      if (!predicted) system.residual[i] = row.output - output_of(state, row);
      const auto slopes = slopes_of(state, row);
      for (std::size_t k = 0; k < quantities; ++k) system.slopes(i, at(k)) = slopes[k];
      system.white[i] = noise[c].white / row.seconds;
      system.scatter[i] = noise[c].scatter / row.seconds;
    }
  add_noise(bench, noise, firsts, system);
  add_rig(bench, state, disturbances, firsts, system);
  add_priors(instrument, system);
  return system;
}

/// Standard deviations that rows are divided by: of the white noise, but never less than a trace of all that moves the
/// row or of its rounding.
VectorXd weights_of(const System& system) {
  VectorXd total = system.scatter;
  for (const auto& source : system.sources) total += source.columns.rowwise().squaredNorm();
  VectorXd out(total.size());
  for (Index i = 0; i < total.size(); ++i) {
    const double size = system.slopes.row(i).cwiseAbs().maxCoeff() * 1e-18;
    out[i] = std::sqrt(std::max({system.scatter[i], 1e-10 * total[i], size * size, 1e-300}));
  }
  return out;
}

/// The linear estimator: free quantities from rows.
struct Estimator {
  MatrixXd gain;
  double chi_square = 0.0, condition = 0.0;
};

Estimator estimator_of(const System& system, const std::vector<Quantity>& free) {
  Index effects = 0;
  for (const auto& source : system.sources) effects += source.columns.cols();
  const Index n = system.residual.size(), p = at(free.size());
  const VectorXd weight = weights_of(system).cwiseInverse();
  MatrixXd a = MatrixXd::Zero(n + effects, p + effects);
  for (Index k = 0; k < p; ++k)
    a.col(k).head(n) = weight.cwiseProduct(system.slopes.col(at(free[static_cast<std::size_t>(k)])));
  Index j = p;
  for (const auto& source : system.sources) {
    a.block(0, j, n, source.columns.cols()) = weight.asDiagonal() * source.columns;
    j += source.columns.cols();
  }
  a.block(n, p, effects, effects).setIdentity();
  // the effects first: what is left of the free quantities beyond them comes last and is solved for first
  MatrixXd ordered(a.rows(), a.cols());
  ordered << a.rightCols(effects), a.leftCols(p);
  const VectorXd size = ordered.colwise().norm().cwiseMax(1e-300);
  ordered = ordered * size.cwiseInverse().asDiagonal();
  const Eigen::HouseholderQR<MatrixXd> qr(ordered);
  const MatrixXd r = qr.matrixQR().bottomRightCorner(a.rows() - effects, p).topRows(p).triangularView<Eigen::Upper>();
  MatrixXd last = MatrixXd::Zero(a.rows(), p);
  last.block(effects, 0, p, p).setIdentity();
  const MatrixXd q = qr.householderQ() * last;  // the columns of Q that belong to the free quantities
  const VectorXd s = r.jacobiSvd().singularValues();
  Estimator out;
  out.condition = s[p - 1] > 0.0 ? s[0] / s[p - 1] : std::numeric_limits<double>::infinity();
  out.gain = size.tail(p).cwiseInverse().asDiagonal() *
             r.triangularView<Eigen::Upper>().solve(q.topRows(n).transpose()) * weight.asDiagonal();
  VectorXd y = VectorXd::Zero(a.rows());
  y.head(n) = weight.cwiseProduct(system.residual);
  const VectorXd turned = qr.householderQ().transpose() * y;
  out.chi_square = turned.tail(a.rows() - a.cols()).squaredNorm();
  return out;
}

void check_gain(const Estimator& estimator) {
  if (!estimator.gain.allFinite() || !(estimator.condition < 1e10))
    throw Error(Error::Kind::bad_data,
                "the index angles do not show the azimuth: near this heading the rate does not change with it (two "
                "positions near north and south), or angles are missing; add positions 90 deg apart");
}

/// Welch and Satterthwaite: nu = 2 v^2/Var(v), the variance of v from that of the components found.
double freedom_of(const Bench& bench, const std::vector<Noise>& noise, const std::vector<Index>& firsts,
                  const VectorXd& gain, double v) {
  double of_v = 0.0;
  for (std::size_t c = 0; c < bench.signals.size(); ++c) {
    if (noise[c].component_covariance.empty()) continue;
    const auto& signal = bench.signals[c];
    VectorXd gradient = VectorXd::Zero(at(noise[c].component_covariance.rows));
    VectorXd by_place = VectorXd::Zero(at(signal.places.size()));
    for (std::size_t r = 0; r < signal.rows.size(); ++r) {
      const double g = gain[firsts[c] + at(r)];
      gradient[0] += g * g / signal.rows[r].seconds;
      by_place[at(signal.rows[r].place)] += g;
    }
    for (Index k = 1; k < gradient.size(); ++k)
      gradient[k] = by_place.dot(map(noise[c].slow[static_cast<std::size_t>(k - 1)].kernel) * by_place);
    of_v += gradient.dot(map(noise[c].component_covariance) * gradient);
  }
  return of_v > 0.0 ? std::max(1.0, 2.0 * v * v / of_v) : std::numeric_limits<double>::infinity();
}

/// What rounding to whole pulses gives where a table turns: neighbours share a reading.
MatrixXd counted_turns(const Bench& bench, const std::vector<Index>& firsts, const MatrixXd& gain) {
  MatrixXd covariance = MatrixXd::Zero(gain.rows(), gain.rows());
  VectorXd end = VectorXd::Zero(gain.rows());  // of the reading after the row before
  const auto close = [&](const VectorXd& reading) { covariance += reading * reading.transpose(); };
  for (std::size_t c = 0; c < bench.signals.size(); ++c)
    for (std::size_t r = 0; r < bench.signals[c].rows.size(); ++r) {
      const Row& row = bench.signals[c].rows[r];
      const VectorXd now = row.reading_sd * gain.col(firsts[c] + at(r));
      if (!row.follows) {
        close(end);
        end.setZero();
      }
      close(end - now);
      end = now;
    }
  close(end);
  return covariance;
}

void fill(const Bench& bench, const std::vector<Noise>& noise, const System& system, const Estimator& estimator,
          Solution& out) {
  const auto& g = estimator.gain;
  const auto add = [&](const std::string& name, const MatrixXd& covariance) {
    auto line = std::ranges::find(out.sources, name, &SourceCovariance::source);
    if (line == out.sources.end()) line = out.sources.insert(line, {name, Matrix(out.free.size(), out.free.size())});
    line->covariance = plain(map(line->covariance) + covariance);
  };
  const auto firsts = firsts_of(bench);
  for (std::size_t c = 0; c < bench.signals.size(); ++c) {
    const auto of = g.middleCols(firsts[c], firsts[c + 1] - firsts[c]);
    add(bench.signals.size() > 1 ? "output noise of " + bench.signals[c].problem.role : "output noise",
        of * system.white.segment(firsts[c], of.cols()).asDiagonal() * of.transpose());
  }
  for (const auto& source : system.sources) {
    const MatrixXd moved = g * source.columns;
    add(source.name, moved * moved.transpose());
  }
  if (const MatrixXd turns = counted_turns(bench, firsts, g); turns.trace() > 0.0) add("counting of turns", turns);
  MatrixXd total = MatrixXd::Zero(g.rows(), g.rows());
  for (const auto& source : out.sources) total += map(source.covariance);
  out.covariance = plain(total);
  for (Index k = 0; k < g.rows(); ++k)
    out.degrees_of_freedom.push_back(freedom_of(bench, noise, firsts, g.row(k), total(k, k)));
  out.gain = plain(g);
  out.residuals.assign(system.residual.data(), system.residual.data() + system.residual.size());
  for (Index i = 0; i < system.white.size(); ++i) out.sd.push_back(std::sqrt(system.white[i]));
  out.fit = {static_cast<std::size_t>(g.cols()), static_cast<double>(g.cols() - g.rows()), estimator.chi_square,
             estimator.condition};
}

}  // namespace

Solution solve(const Bench& bench, const Instrument& instrument, const Setup& setup, const std::vector<Noise>& noise,
               const std::vector<Disturbance>& disturbances, bool predicted) {
  Solution out;
  out.state = setup.start;
  out.free = setup.free;
  constexpr int least = 2, most = 30;  // the azimuth may be right from the start while the rest is not
  for (int step = 0;; ++step) {
    const System system = system_at(bench, out.state, noise, disturbances, instrument, predicted);
    const Estimator estimator = estimator_of(system, setup.free);
    check_gain(estimator);
    const VectorXd change = estimator.gain * system.residual;
    const double turn = std::abs(change[0]);
    if (predicted || (step >= least && turn < 1e-13) || step == most) {
      fill(bench, noise, system, estimator, out);
      return out;
    }
    const double share = std::min(1.0, 0.5 / std::max(turn, 1e-300));
    for (std::size_t k = 0; k < setup.free.size(); ++k) out.state[setup.free[k]] += share * change[at(k)];
  }
}

}  // namespace tumble::north_finding
