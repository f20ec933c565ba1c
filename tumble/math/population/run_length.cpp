#include "tumble/math/population/run_length.hpp"

#include <fmt/format.h>

#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr unsigned nodes = 80;

struct Node {
  double at, weight;
};

std::vector<Node> nodes_between(double low, double high) {
  using Rule = boost::math::quadrature::gauss<double, nodes>;
  std::vector<Node> out;
  const double half = 0.5 * (high - low), middle = 0.5 * (high + low);
  for (std::size_t i = 0; i < Rule::abscissa().size(); ++i) {
    out.push_back({middle + half * Rule::abscissa()[i], half * Rule::weights()[i]});
    out.push_back({middle - half * Rule::abscissa()[i], half * Rule::weights()[i]});
  }
  return out;
}

double density(double x) { return std::exp(-0.5 * x * x) / std::sqrt(two_pi); }

/// Of a one-sided CUSUM from zero whose points have this mean.
double one_sided(double k, double h, double mean) {
  // L(u) = 1 + L(0) P(r <= k - u) + integral over (0, h) of L(z) phi(z + k - u - mean) dz
  const auto grid = nodes_between(0.0, h);
  const std::size_t n = grid.size() + 1;  // the last is u = 0
  Matrix a(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    const double u = i + 1 < n ? grid[i].at : 0.0;
    for (std::size_t j = 0; j + 1 < n; ++j) a(i, j) = -grid[j].weight * density(grid[j].at + k - u - mean);
    a(i, n - 1) = -normal_below(k - u - mean);
    a(i, i) += 1.0;
  }
  return solve(a, std::vector<double>(n, 1.0)).back();
}

/// A limit between 0 and where the run length is long enough; it grows with the limit.
template <class RunLength>
double limit_for(const RunLength& run_length, double wanted) {
  if (!(wanted >= 2.0) || !std::isfinite(wanted))
    throw Error(Error::Kind::bad_input,
                say("an average run length of at least 2 points is expected, not {:g}", wanted));
  // the logarithm is almost a straight line
  const auto excess = [&](double limit) { return std::log(run_length(limit) / wanted); };
  double low = 0.0, high = 1.0;
  while (excess(high) < 0.0) low = high, high *= 1.5;
  std::uintmax_t most = 60;
  const auto [from, to] =
      boost::math::tools::toms748_solve(excess, low, high, boost::math::tools::eps_tolerance<double>(40), most);
  return 0.5 * (from + to);
}

}  // namespace

double run_length_of_ewma(double lambda, double limit, double shift) {
  if (!(lambda > 0.0 && lambda <= 1.0))
    throw Error(Error::Kind::bad_input, say("lambda between 0 and 1 is expected, not {:g}", lambda));
  const double h = limit * std::sqrt(lambda / (2.0 - lambda));
  const auto grid = nodes_between(-h, h);
  const std::size_t n = grid.size() + 1;  // the last is the start, 0
  Matrix a(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    const double u = i + 1 < n ? grid[i].at : 0.0;
    for (std::size_t j = 0; j + 1 < n; ++j)
      a(i, j) = -grid[j].weight / lambda * density((grid[j].at - (1.0 - lambda) * u) / lambda - shift);
    a(i, i) += 1.0;
  }
  return solve(a, std::vector<double>(n, 1.0)).back();
}

double run_length_of_cusum(double k, double h, double shift) {
  if (!(k >= 0.0)) throw Error(Error::Kind::bad_input, say("k of at least 0 is expected, not {:g}", k));
  return 1.0 / (1.0 / one_sided(k, h, shift) + 1.0 / one_sided(k, h, -shift));
}

double limit_of_ewma(double lambda, double run_length) {
  return limit_for([&](double limit) { return run_length_of_ewma(lambda, limit); }, run_length);
}

double limit_of_cusum(double k, double run_length) {
  return limit_for([&](double h) { return run_length_of_cusum(k, h); }, run_length);
}

}  // namespace tumble
