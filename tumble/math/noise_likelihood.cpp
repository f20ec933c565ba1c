#include "tumble/math/noise_likelihood.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "tumble/math/eigen/view.hpp"
#include "tumble/math/least_squares.hpp"
#include "tumble/math/noise_likelihood/dependence.hpp"
#include "tumble/math/noise_likelihood/scoring.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double process_fall = 13.8;    ///< of -2 ln L by a Gauss-Markov process: 0.1 % of chi-square of two
constexpr double shortest_time = 8.0;    ///< [samples] nearer to the sampling interval it would be a filter
constexpr double ramp_chance = 0.0027;   ///< 3 sigma
constexpr double residual_count = 30.0;  ///< contrasts that make a residual
constexpr auto power_laws = static_cast<Index>(power_law_terms.size());

/// Terms of one model: columns of the four power laws, then processes.
struct Terms {
  std::vector<bool> used{true, true, true, true};  ///< power laws
  std::vector<double> times;                       ///< [samples] of the processes
};

MatrixXd columns(const BandData& data, const Terms& terms) {
  std::vector<Index> list;
  for (Index t = 0; t < power_laws; ++t)
    if (terms.used[static_cast<std::size_t>(t)]) list.push_back(t);
  MatrixXd x(data.z.size(), at(list.size() + terms.times.size()));
  x.leftCols(at(list.size())) = data.design(Eigen::all, list);
  for (std::size_t m = 0; m < terms.times.size(); ++m) x.col(at(list.size() + m)) = data.markov(terms.times[m]);
  return x;
}

struct Tried {
  Terms terms;
  ScoringFit fit;
  double value() const { return fit.minus_twice_log_likelihood; }
};

Tried tried(const BandData& data, const Terms& terms, bool ramp, const VectorXd& start) {
  return {terms, fit_by_scoring(data, columns(data, terms), ramp, start)};
}

/// The same with the correlation time of the last process set to its best between `low` and `high`, by golden section.
Tried best_time(const BandData& data, Terms terms, bool ramp, const VectorXd& start, std::size_t which, double low,
                double high) {
  const auto of = [&](double log_time) {
    terms.times[which] = std::exp(log_time);
    return tried(data, terms, ramp, start);
  };
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  double a = std::log(low), b = std::log(high);
  double left = b - golden * (b - a), right = a + golden * (b - a);
  Tried at_left = of(left), at_right = of(right);
  while (b - a > 2e-3) {
    if (at_left.value() < at_right.value()) {
      b = right;
      right = left;
      at_right = std::move(at_left);
      at_left = of(left = b - golden * (b - a));
    } else {
      a = left;
      left = right;
      at_left = std::move(at_right);
      at_right = of(right = a + golden * (b - a));
    }
  }
  return at_left.value() < at_right.value() ? at_left : at_right;
}

/// One process more beside the terms of `before`, where it lowers -2 ln L enough.
bool add_process(const BandData& data, bool ramp, double longest, Tried& before) {
  Tried best = before;
  for (double time = shortest_time; time < longest; time *= 2.0) {
    Terms with = before.terms;
    with.times.push_back(time);
    Tried one = tried(data, with, ramp, before.fit.s);
    if (one.value() < best.value()) best = std::move(one);
  }
  const std::size_t which = before.terms.times.size();
  if (best.terms.times.size() == which || before.value() - best.value() < 1.0) return false;
  const double time = best.terms.times.back();
  best = best_time(data, best.terms, ramp, best.fit.s, which, std::max(0.5 * time, shortest_time),
                   std::min(2.0 * time, longest));
  const bool helps = before.value() - best.value() > process_fall;
  if (helps) before = std::move(best);
  return helps;
}

int size_of(const Terms& terms) {
  return static_cast<int>(std::count(terms.used.begin(), terms.used.end(), true) + 2 * std::ssize(terms.times));
}

double chance_of(double fall) { return fall <= 0.0 ? 1.0 : 0.5 * chi_square_tail(fall, 1.0); }

struct Selection {
  std::vector<Tried> all;  ///< [mask] over the power laws
  std::vector<bool> supported;
  std::vector<double> aicc;
  std::size_t chosen = 0;
};

double aicc(const Tried& one, bool ramp, double contrasts) {
  const double p = size_of(one.terms) + (ramp ? 1.0 : 0.0);
  return one.value() + 2.0 * p + 2.0 * p * (p + 1.0) / std::max(1.0, contrasts - p - 1.0);
}

/// Every subset of the power laws beside the processes.
Selection select(const BandData& data, bool ramp, const Tried& full, double significance) {
  Selection selection;
  const std::size_t subsets = std::size_t{1} << power_laws;
  selection.all.resize(subsets);
  selection.supported.assign(subsets, false);
  selection.aicc.assign(subsets, INFINITY);
  double least = INFINITY;
  for (std::size_t mask = 0; mask < subsets; ++mask) {
    Terms terms = full.terms;
    bool within = true;
    for (std::size_t t = 0; t < power_laws; ++t) {
      terms.used[t] = (mask >> t) & 1u;
      within = within && (full.terms.used[t] || !terms.used[t]);
    }
    if (size_of(terms) == 0 || !within) continue;
    selection.all[mask] = tried(data, terms, ramp, full.fit.s);
    const Tried& one = selection.all[mask];
    bool supported = one.fit.c.minCoeff() > 0.0;
    for (std::size_t t = 0; t < power_laws && supported; ++t) {
      const std::size_t without = mask & ~(std::size_t{1} << t);
      if (without == mask || selection.all[without].fit.c.size() == 0) continue;
      supported = chance_of(selection.all[without].value() - one.value()) < significance;
    }
    selection.supported[mask] = supported;
    selection.aicc[mask] = aicc(one, ramp, data.count.sum());
    if (!supported || selection.aicc[mask] >= least) continue;
    least = selection.aicc[mask];
    selection.chosen = mask;
  }
  return selection;
}

// ---- residuals -----------------------------------------------------------------------------------------------------

std::vector<NoiseResidual> residuals_of(const BandData& data, const ScoringFit& fit) {
  std::vector<std::size_t> order(data.bands.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return data.bands[a].frequency < data.bands[b].frequency; });
  std::vector<NoiseResidual> residuals;
  double count = 0.0, ratio = 0.0, frequency = 0.0;
  for (const std::size_t i : order) {
    const Index b = at(i);
    const double z = data.z[b] - 2.0 * fit.slope * data.with_ramp[b] + fit.slope * fit.slope * data.ramp_square[b] +
                     fit.slope_variance * data.ramp_square[b];
    count += data.count[b];
    ratio += data.count[b] * z / fit.s[b];
    frequency += data.count[b] * data.bands[i].frequency;
    if (count < residual_count) continue;
    residuals.push_back({frequency / count, ratio / count, std::sqrt(2.0 / count)});
    count = ratio = frequency = 0.0;
  }
  return residuals;
}

double chi_square(const std::vector<NoiseResidual>& residuals, double error) {
  double sum = 0.0;
  for (const auto& one : residuals) sum += std::pow(one.ratio - 1.0, 2) / (one.sd * one.sd + error * error);
  return sum;
}

double residual_freedom(const std::vector<NoiseResidual>& residuals, const Tried& one, bool ramp) {
  return static_cast<double>(residuals.size()) - size_of(one.terms) - (ramp ? 1.0 : 0.0);
}

/// With an independent relative error of the power in each range of frequencies.
VectorXd counts_with(const VectorXd& count, double error) {
  return count.array() / (1.0 + 0.5 * error * error * count.array());
}

/// The relative error that makes chi-square of the model with all terms equal its degrees of freedom.
double model_error(const BandData& whole, bool ramp, const Tried& full) {
  auto residuals = residuals_of(whole, full.fit);
  const double dof = residual_freedom(residuals, full, ramp);
  if (dof < 1.0 || chi_square_tail(chi_square(residuals, 0.0) / dof, dof) > 1e-3) return 0.0;
  double low = std::log(1e-5), high = std::log(3.0);
  BandData data = whole;
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    data.count = counts_with(whole.count, std::exp(middle));
    const auto left = residuals_of(whole, tried(data, full.terms, ramp, full.fit.s).fit);
    (chi_square(left, std::exp(middle)) > dof ? low : high) = middle;
  }
  return std::exp(high);
}

// ---- what is known of the terms ------------------------------------------------------------------------------------

/// Columns of the terms above zero and, last, the derivatives by ln T_c of the processes, at the fitted model.
struct Linear {
  MatrixXd x;
  std::vector<std::size_t> terms;      ///< index in NoiseFit::terms of the first columns
  std::vector<std::size_t> processes;  ///< of the last columns
};

Linear linear(const BandData& data, const Tried& chosen) {
  Linear result;
  const MatrixXd x = columns(data, chosen.terms);
  Index column = 0;
  std::vector<Index> list;
  std::vector<VectorXd> slopes;
  for (std::size_t t = 0; t < power_laws; ++t) {
    if (!chosen.terms.used[t]) continue;
    if (chosen.fit.c[column] > 0.0) {
      list.push_back(column);
      result.terms.push_back(t);
    }
    ++column;
  }
  for (std::size_t m = 0; m < chosen.terms.times.size(); ++m, ++column) {
    list.push_back(column);
    result.terms.push_back(power_laws + m);
    result.processes.push_back(m);
    constexpr double h = 1e-3;
    const double time = chosen.terms.times[m];
    slopes.push_back(chosen.fit.c[column] * (data.markov(time * std::exp(h)) - data.markov(time * std::exp(-h))) /
                     (2.0 * h));
  }
  result.x.resize(x.rows(), at(list.size() + slopes.size()));
  result.x.leftCols(at(list.size())) = x(Eigen::all, list);
  for (std::size_t m = 0; m < slopes.size(); ++m) result.x.col(at(list.size() + m)) = slopes[m];
  return result;
}

std::vector<WeightedTerm> weighted_terms(const Tried& chosen) {
  std::vector<WeightedTerm> terms;
  Index column = 0;
  for (std::size_t t = 0; t < power_laws; ++t)
    if (chosen.terms.used[t]) terms.push_back({{power_law_terms[t]}, chosen.fit.c[column++]});
  for (const double time : chosen.terms.times) terms.push_back({{NoiseTerm::markov, time}, chosen.fit.c[column++]});
  return terms;
}

/// Of the estimates as linear sums of the mean squares.
struct Spread {
  MatrixXd covariance, by_error;
  VectorXd widening;  ///< of the sd by dependence
  double condition = 0.0;
};

/// The inverse of the information, or, where contrasts depend on each other, the covariance of the maximum all the
/// same: with A the information and B the covariance of the derivative of ln L, A^-1 B A^-1.
Spread spread(const BandData& data, const VectorXd& statistical_count, const Linear& model, const Tried& chosen) {
  const ScoringFit& fit = chosen.fit;
  const VectorXd weight = (0.5 * data.count).cwiseSqrt().cwiseQuotient(fit.s);
  const MatrixXd weighted = weight.asDiagonal() * model.x;
  const VectorXd scale = weighted.colwise().norm().cwiseInverse();
  const MatrixXd unit = weighted * scale.asDiagonal(), gram = unit.transpose() * unit;
  const MatrixXd inverse = gram.ldlt().solve(MatrixXd::Identity(gram.rows(), gram.cols()));
  Spread result;
  const MatrixXd independent = scale.asDiagonal() * inverse * scale.asDiagonal();
  // Weight of each contrast in the derivative.
  const VectorXd each = data.count.cwiseQuotient(statistical_count).cwiseQuotient(fit.s.cwiseAbs2());
  const MatrixXd more = covariance_of_dependence(data.bands, weighted_terms(chosen), each.asDiagonal() * model.x);
  result.covariance = independent + independent * more * independent;
  result.widening = (result.covariance.diagonal().array() / independent.diagonal().array()).sqrt();
  const MatrixXd gain = independent * weighted.transpose() * weight.asDiagonal();  // c = gain z
  const Eigen::ArrayXd s = fit.s.array(), error = 2.0 / data.count.array() - 2.0 / statistical_count.array();
  result.by_error = gain * (s.square() * error).matrix().asDiagonal() * gain.transpose();
  const VectorXd values = Eigen::SelfAdjointEigenSolver<MatrixXd>(gram).eigenvalues();
  result.condition = std::sqrt(values.maxCoeff() / std::max(values.minCoeff(), 1e-300));
  return result;
}

/// P(estimate of one coefficient <= `estimate`) if it were c: the estimate as a sum of mean squares, of which variance
/// and third moment make a shifted chi-square.
double chance_below(const BandData& data, const MatrixXd& x, const VectorXd& fitted, Index column, double estimate,
                    double c, double widening) {
  const VectorXd s = (fitted + (c - estimate) * x.col(column)).cwiseMax(1e-6 * fitted);
  const VectorXd weight = (0.5 * data.count).cwiseSqrt().cwiseQuotient(s);
  MatrixXd weighted = weight.asDiagonal() * x;
  const VectorXd scale = weighted.colwise().norm().cwiseInverse();
  weighted = weighted * scale.asDiagonal();
  const VectorXd row = (weighted.transpose() * weighted).ldlt().solve(VectorXd::Unit(x.cols(), column));
  const double sd = scale[column] * std::sqrt(row[column]);
  const VectorXd gain = scale[column] * (weight.asDiagonal() * (weighted * row));
  const double third = (gain.array().cube() * 8.0 * s.array().cube() / data.count.array().square()).sum();
  const double skew = third / (sd * sd * sd), edf = 8.0 / std::max(skew * skew, 1e-6);
  const double off = (estimate - c) / (widening * sd * std::sqrt(0.5 * edf));
  return skew > 0.0 ? 1.0 - chi_square_tail(1.0 + off, edf) : chi_square_tail(1.0 - off, edf);
}

/// Degrees of freedom for which value +- t sd holds the coefficient with 95 %: so that the chances of an estimate as
/// low from the upper end and as high from the lower end add up to 5 %.
double interval_freedom(const BandData& data, const MatrixXd& x, const VectorXd& s, Index column, double squared,
                        double value, double sd, double widening) {
  const auto missed = [&](double t) {
    const double lower = value - t * sd;
    return chance_below(data, x, s, column, squared, std::pow(value + t * sd, 2), widening) +
           (lower > 0.0 ? 1.0 - chance_below(data, x, s, column, squared, lower * lower, widening) : 0.0);
  };
  constexpr double most = 1e4;
  const double normal = student_quantile(0.975, most);
  double low = normal, high = student_quantile(0.975, 1.0);
  if (missed(low) <= 0.05) return std::numeric_limits<double>::infinity();
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    (missed(middle) > 0.05 ? low : high) = middle;
  }
  double few = 0.0, many = std::log(most);
  for (int i = 0; i < 20; ++i) {
    const double middle = 0.5 * (few + many);
    (student_quantile(0.975, std::exp(middle)) > high ? few : many) = middle;
  }
  return std::exp(0.5 * (few + many));
}

/// Where -2 ln L rises by 2.71 (95 % one-sided) above its least as the coefficient of `column` grows.
double upper_limit(const BandData& data, const MatrixXd& others, const VectorXd& column, bool ramp,
                   const ScoringFit& free, double value, double sd) {
  const auto rise = [&](double c) {
    const VectorXd known = c * column;
    const VectorXd start = free.s + (c - value) * column;
    return fit_by_scoring(data, others, ramp, start.cwiseMax(free.s * 1e-3), &known).minus_twice_log_likelihood -
           free.minus_twice_log_likelihood;
  };
  double low = value, high = value + 1.645 * sd;
  for (int i = 0; i < 30 && rise(high) < 2.71; ++i) {
    low = high;
    high = value + 1.5 * (high - value);
  }
  for (int i = 0; i < 8; ++i) {
    const double middle = 0.5 * (low + high);
    (rise(middle) < 2.71 ? low : high) = middle;
  }
  return high;
}

/// A power law that is left out, tried beside the others.
void describe_absent(const BandData& data, const Tried& chosen, bool ramp, std::size_t term, FittedTerm& result) {
  const MatrixXd others = columns(data, chosen.terms);
  MatrixXd x(others.rows(), others.cols() + 1);
  x << others, data.design.col(at(term));
  const ScoringFit with = fit_by_scoring(data, x, ramp, chosen.fit.s);
  const VectorXd weight = (0.5 * data.count).cwiseSqrt().cwiseQuotient(with.s);
  MatrixXd weighted = weight.asDiagonal() * x;
  const VectorXd scale = weighted.colwise().norm().cwiseInverse();
  weighted = weighted * scale.asDiagonal();
  const MatrixXd inverse = (weighted.transpose() * weighted).ldlt().solve(MatrixXd::Identity(x.cols(), x.cols()));
  result.squared = with.c[x.cols() - 1];
  result.squared_sd = scale[x.cols() - 1] * std::sqrt(inverse(x.cols() - 1, x.cols() - 1));
  result.z = result.squared / result.squared_sd;
  result.improvement = chosen.value() - with.minus_twice_log_likelihood;
  result.chance = chance_of(result.improvement);
  result.upper_limit =
      upper_limit(data, others, data.design.col(at(term)), ramp, with, result.squared, result.squared_sd);
}

void describe_kept(const BandData& data, const Selection& selection, const Linear& model, const Spread& known,
                   const Tried& chosen, NoiseFit& fit) {
  for (std::size_t a = 0; a < model.terms.size(); ++a) {
    FittedTerm& term = fit.terms[model.terms[a]];
    const std::size_t t = model.terms[a];
    term.kept = true;
    Index column = 0;
    if (t < power_laws) {
      column = std::count(chosen.terms.used.begin(), chosen.terms.used.begin() + at(t), true);
      const Tried& without = selection.all[selection.chosen & ~(std::size_t{1} << t)];
      const bool sole = without.fit.c.size() == 0;  // nothing to be compared with
      term.improvement = sole ? 0.0 : without.value() - chosen.value();
      term.chance = sole ? 0.0 : chance_of(term.improvement);
    } else {
      column = chosen.fit.c.size() - at(chosen.terms.times.size()) + at(t) - power_laws;
    }
    term.squared = chosen.fit.c[column];
    const double variance = known.covariance(at(a), at(a));
    term.squared_sd = std::sqrt(variance);
    term.z = term.squared / term.squared_sd;
    const double relative = variance / (term.squared * term.squared), root = std::sqrt(term.squared);
    term.root_correction = 1.0 + relative / 8.0;
    term.degrees_of_freedom =
        interval_freedom(data, model.x, chosen.fit.s, at(a), term.squared, root * term.root_correction,
                         0.5 * root * std::sqrt(relative), known.widening[at(a)]);
    const double factor = student_quantile(0.95, term.degrees_of_freedom);
    term.upper_limit = term.squared * std::pow(term.root_correction + 0.5 * factor * std::sqrt(relative), 2);
  }
}

void add_covariance(const Linear& model, const Spread& known, const Tried& chosen, NoiseFit& fit) {
  const std::size_t terms = fit.terms.size(), all = terms + chosen.terms.times.size();
  std::vector<std::size_t> place = model.terms;
  VectorXd scale = VectorXd::Ones(known.covariance.rows());
  for (const std::size_t m : model.processes) {
    scale[at(place.size())] = chosen.terms.times[m];
    place.push_back(terms + m);
  }
  fit.covariance = Matrix(all, all);
  fit.model_error_variance.assign(all, 0.0);
  for (std::size_t a = 0; a < place.size(); ++a) {
    for (std::size_t b = 0; b < place.size(); ++b)
      fit.covariance(place[a], place[b]) = scale[at(a)] * scale[at(b)] * known.covariance(at(a), at(b));
    fit.model_error_variance[place[a]] = scale[at(a)] * scale[at(a)] * known.by_error(at(a), at(a));
  }
}

/// The ramp's slope with the random walk at its limit where none was seen, and the chance of so much.
NoiseRamp ramp_of(const BandData& data, const Tried& chosen, const Linear& model, const Spread& known,
                  const FittedTerm& walk) {
  NoiseRamp ramp;
  VectorXd s = chosen.fit.s;
  if (!walk.kept) s += walk.upper_limit * data.design.col(power_laws - 1);
  const RampFit best = fit_ramp(data, s);
  // Relative change of the slope's variance by each coefficient.
  const VectorXd by = best.variance * model.x.transpose() *
                      (data.slow.array() * data.count.array() * data.ramp_square.array() / s.array().square()).matrix();
  ramp.slope = best.slope;
  ramp.sd = std::sqrt(best.variance);
  ramp.degrees_of_freedom = std::clamp(2.0 / std::max(by.dot(known.covariance * by), 1e-9), 1.0, 1e6);
  ramp.chance = 2.0 * boost::math::cdf(boost::math::complement(boost::math::students_t(ramp.degrees_of_freedom),
                                                               std::abs(ramp.slope) / ramp.sd));
  return ramp;
}

void list_composites(const Selection& selection, NoiseFit& fit) {
  for (std::size_t mask = 0; mask < selection.all.size(); ++mask) {
    const Tried& one = selection.all[mask];
    if (one.fit.c.size() == 0) continue;
    NoiseComposite composite{{},
                             one.value(),
                             size_of(one.terms),
                             selection.aicc[mask] - selection.aicc[selection.chosen],
                             selection.supported[mask]};
    for (std::size_t t = 0; t < power_laws; ++t)
      if (one.terms.used[t]) composite.terms.push_back({power_law_terms[t]});
    for (const double time : one.terms.times) composite.terms.push_back({NoiseTerm::markov, time});
    fit.composites.push_back(composite);
  }
  std::stable_sort(fit.composites.begin(), fit.composites.end(), [](const NoiseComposite& a, const NoiseComposite& b) {
    return a.supported != b.supported ? a.supported : a.aicc < b.aicc;
  });
}

NoiseFit fit_beside(const BandData& whole, bool ramp, std::size_t samples, const NoiseLikelihoodOptions& options) {
  Terms all;
  for (std::size_t t = 0; t < power_laws; ++t)
    all.used[t] = std::count(options.terms.begin(), options.terms.end(), power_law_terms[t]) > 0;
  Tried full = tried(whole, all, ramp, whole.start);
  const double longest = static_cast<double>(samples) / 20.0;
  for (std::size_t m = 0; m < options.most_markov && add_process(whole, ramp, longest, full); ++m) {
  }
  NoiseFit fit;
  fit.model_error = model_error(whole, ramp, full);
  BandData data = whole;
  data.count = counts_with(whole.count, fit.model_error);
  Selection selection = select(data, ramp, full, options.significance);
  if (!full.terms.times.empty()) {
    // The terms that fall away give the correlation times more room.
    Tried refined = selection.all[selection.chosen];
    for (int round = 0; round < 2; ++round)
      for (std::size_t m = 0; m < refined.terms.times.size(); ++m)
        refined = best_time(data, refined.terms, ramp, refined.fit.s, m,
                            std::max(0.5 * refined.terms.times[m], shortest_time),
                            std::min(2.0 * refined.terms.times[m], longest));
    refined.terms.used = all.used;
    selection = select(data, ramp, refined, options.significance);
  }
  const Tried& chosen = selection.all[selection.chosen];
  for (const NoiseTerm term : power_law_terms) fit.terms.push_back({{term}});
  for (const double time : chosen.terms.times) fit.terms.push_back({{NoiseTerm::markov, time}});
  const Linear model = linear(data, chosen);
  const Spread known = spread(data, whole.count, model, chosen);
  describe_kept(data, selection, model, known, chosen, fit);
  for (std::size_t t = 0; t < power_laws; ++t)
    if (!fit.terms[t].kept) describe_absent(data, chosen, ramp, t, fit.terms[t]);
  add_covariance(model, known, chosen, fit);
  list_composites(selection, fit);
  fit.ramp = ramp_of(data, chosen, model, known, fit.terms[power_laws - 1]);
  fit.residuals = residuals_of(whole, chosen.fit);
  fit.chi_square = chi_square(fit.residuals, 0.0);
  fit.degrees_of_freedom = std::max(0.0, residual_freedom(fit.residuals, chosen, ramp));
  fit.minus_twice_log_likelihood = chosen.value();
  fit.condition = known.condition;
  return fit;
}

}  // namespace

NoiseFit fit_noise(const NoiseBands& bands, const NoiseLikelihoodOptions& options) {
  NoiseBands used = bands;
  std::erase_if(used.bands, [&](const NoiseBand& band) {
    return band.frequency * options.shortest > 0.5 || 0.5 > band.frequency * options.longest;
  });
  const BandData data(used);
  if (data.count.size() < 2 || !(data.z.maxCoeff() > 0.0))
    throw Error(Error::Kind::bad_data, "nothing that changes between the averaging times to fit");
  NoiseFit with = fit_beside(data, true, bands.samples, options);
  if (with.ramp.chance <= ramp_chance) {
    with.ramp.kept = true;
    return with;
  }
  NoiseFit without = fit_beside(data, false, bands.samples, options);
  without.ramp = with.ramp;
  return without;
}

}  // namespace tumble
