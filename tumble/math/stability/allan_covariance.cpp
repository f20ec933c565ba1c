#include "tumble/math/stability/allan_covariance.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/math/noise_model.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

constexpr std::array<double, 3> second_difference{1.0, -2.0, 1.0};

/// Without quantization, which is apart: it is one at lag zero and nothing else.
double smooth_autocovariance(const UnitTerm& term, double lag) {
  return term.term == NoiseTerm::quantization ? 0.0 : generalised_autocovariance(term, lag);
}

/// C_ij at the lag s from its centre of symmetry.
double cross_covariance(const UnitTerm& term, double mi, double mj, double s) {
  double sum = 0.0;
  for (int a = -1; a <= 1; ++a)
    for (int b = -1; b <= 1; ++b)
      sum += second_difference[a + 1] * second_difference[b + 1] * smooth_autocovariance(term, s + b * mj - a * mi);
  return sum;
}

double quantization_covariance(long mi, long mj, long s) {
  double sum = 0.0;
  for (int a = -1; a <= 1; ++a)
    for (int b = -1; b <= 1; ++b)
      if (s + b * mj - a * mi == 0) sum += second_difference[a + 1] * second_difference[b + 1];
  return sum;
}

struct Node {
  double at, weight;
};

/// Sum over the whole numbers of [a, b] with half weight at both ends: each, or as an integral.
std::vector<Node> nodes_between(long a, long b) {
  constexpr long few = 24;
  std::vector<Node> nodes;
  if (b - a <= few) {
    for (long s = a; s <= b; ++s) nodes.push_back({static_cast<double>(s), s == a || s == b ? 0.5 : 1.0});
    return nodes;
  }
  constexpr std::array<double, 4> x{0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
  constexpr std::array<double, 4> w{0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
  const double centre = 0.5 * static_cast<double>(a + b), half = 0.5 * static_cast<double>(b - a);
  for (std::size_t i = 0; i < x.size(); ++i) {
    nodes.push_back({centre - half * x[i], half * w[i]});
    nodes.push_back({centre + half * x[i], half * w[i]});
  }
  return nodes;
}

/// Where C or the number of pairs kinks, from the centre to where only flicker has a tail left (its square falls as
/// s^-4: 2e-4 of the sum lies beyond 8 times the last kink).
std::vector<long> kinks(long mi, long mj, long end) {
  const long sum = mi + mj;
  std::vector<long> all{0, std::abs(mi - mj), std::min(mi, mj), std::max(mi, mj), sum, 2 * sum, 4 * sum, 8 * sum};
  for (long& s : all) s = std::min(s, end);
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

/// Sums of C_t C_u over all pairs of differences, for the pairs (t, u <= t) of terms.
std::vector<double> pair_sums(const std::vector<UnitTerm>& terms, long mi, long mj, long phases) {
  const long end = phases - mi - mj;
  const double most = static_cast<double>(std::min(phases - 2 * mi, phases - 2 * mj));
  const auto pairs_at = [&](double s) { return std::clamp(static_cast<double>(end) - s, 0.0, most); };
  std::vector<double> sums(terms.size() * (terms.size() + 1) / 2, 0.0), c(terms.size());
  const auto add = [&](double weight) {
    for (std::size_t t = 0, at = 0; t < c.size(); ++t)
      for (std::size_t u = 0; u <= t; ++u) sums[at++] += weight * c[t] * c[u];
  };
  const auto evaluate = [&](double s) {
    for (std::size_t t = 0; t < c.size(); ++t)
      c[t] = cross_covariance(terms[t], static_cast<double>(mi), static_cast<double>(mj), s);
  };
  const auto bounds = kinks(mi, mj, end);
  for (std::size_t b = 0; b + 1 < bounds.size(); ++b)
    for (const auto& [s, weight] : nodes_between(bounds[b], bounds[b + 1])) {
      evaluate(s);
      add(2.0 * weight * pairs_at(s));
    }
  // Quantization is correlated at the kinks alone: what it adds to the products there.
  const auto found = std::find_if(terms.begin(), terms.end(),
                                  [](const UnitTerm& term) { return term.term == NoiseTerm::quantization; });
  if (found == terms.end()) return sums;
  for (const long s : bounds) {
    const double q = quantization_covariance(mi, mj, s);
    if (q == 0.0) continue;
    const double weight = (s == 0 ? 1.0 : 2.0) * pairs_at(static_cast<double>(s));
    evaluate(static_cast<double>(s));
    add(-weight);
    c[found - terms.begin()] += q;
    add(weight);
  }
  return sums;
}

}  // namespace

double generalised_autocovariance(const UnitTerm& term, double t) {
  t = std::abs(t);
  switch (term.term) {
    case NoiseTerm::quantization:
      return t == 0.0 ? 1.0 : 0.0;
    case NoiseTerm::white:
      return -0.5 * t;
    case NoiseTerm::flicker:
      return t == 0.0 ? 0.0 : t * t * std::log(t) / (2.0 * pi);
    case NoiseTerm::random_walk:
      return t * t * t / 12.0;
    case NoiseTerm::markov: {
      const double s = t / term.markov_time;
      return -term.markov_time * term.markov_time * (std::expm1(-s) + s - 0.5 * s * s);
    }
  }
  return 0.0;
}

double unit_allan_variance(const UnitTerm& term, double factor) {
  NoiseModel noise;
  switch (term.term) {
    case NoiseTerm::quantization:
      noise.quantization_noise = 1.0;
      break;
    case NoiseTerm::white:
      noise.angle_random_walk = 1.0;
      break;
    case NoiseTerm::flicker:
      noise.bias_instability = 1.0;
      break;
    case NoiseTerm::random_walk:
      noise.rate_random_walk = 1.0;
      break;
    case NoiseTerm::markov:
      noise.markov_sd = 1.0;
      noise.markov_time = term.markov_time;
      break;
  }
  return expected_allan_variance(noise, factor);
}

double allan_variance_by_markov_time(const UnitTerm& term, double factor) {
  const double step = 1e-3 * term.markov_time;
  return (unit_allan_variance({term.term, term.markov_time + step}, factor) -
          unit_allan_variance({term.term, term.markov_time - step}, factor)) /
         (2.0 * step);
}

AllanCovariance::AllanCovariance(std::vector<UnitTerm> terms, std::vector<std::size_t> factors, std::size_t samples)
    : terms_(std::move(terms)), factors_(std::move(factors)), design_(factors_.size(), terms_.size()) {
  const std::size_t n = factors_.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t t = 0; t < terms_.size(); ++t)
      design_(i, t) = unit_allan_variance(terms_[t], static_cast<double>(factors_[i]));
  forms_.assign(terms_.size() * (terms_.size() + 1) / 2, Matrix(n, n));
  const long phases = static_cast<long>(samples) + 1;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      const long mi = static_cast<long>(factors_[i]), mj = static_cast<long>(factors_[j]);
      const auto sums = pair_sums(terms_, mi, mj, phases);
      const double scale = 0.5 / (static_cast<double>(phases - 2 * mi) * static_cast<double>(phases - 2 * mj) *
                                  static_cast<double>(mi * mi) * static_cast<double>(mj * mj));
      for (std::size_t p = 0; p < forms_.size(); ++p) forms_[p](i, j) = forms_[p](j, i) = scale * sums[p];
    }
}

Matrix AllanCovariance::at(const std::vector<double>& squared) const {
  Matrix covariance(factors_.size(), factors_.size());
  for (std::size_t t = 0, p = 0; t < terms_.size(); ++t)
    for (std::size_t u = 0; u <= t; ++u, ++p) {
      const double weight = (t == u ? 1.0 : 2.0) * squared[t] * squared[u];
      if (weight == 0.0) continue;
      for (std::size_t i = 0; i < covariance.values.size(); ++i) covariance.values[i] += weight * forms_[p].values[i];
    }
  return covariance;
}

}  // namespace tumble
