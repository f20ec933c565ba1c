#include "tumble/methods/static_bias/power_on.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/bisection.hpp"
#include "tumble/math/matrix.hpp"
#include "tumble/math/noise/whitening.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/stability/allan_covariance.hpp"
#include "tumble/methods/static_bias/averages.hpp"

namespace tumble::static_bias {
namespace {

constexpr double least_exponent = -2.0, greatest_exponent = 5.1, exponent_step = 0.5;  ///< decimal, of the ratios below

constexpr double blocks_wanted = 100.0;
constexpr double normal_quantile = 1.959963984540054;  ///< at 0.975

double length_of(const Blocks& blocks) { return blocks.length * static_cast<double>(blocks.means.size()); }

/// -2 log restricted likelihood with the level of the noise at its best, up to a constant, and the square of that
/// level.
struct Fitted {
  double minus_twice_log_likelihood = 0.0, level = 0.0;
};

/// Every power-up has a constant of its own. Given: noise with N = 1.
Fitted fitted(const std::vector<Blocks>& power_ups, const NoiseModel& noise) {
  double determinants = 0.0, squares = 0.0, freedom = 0.0;
  for (const Blocks& blocks : power_ups) {
    const std::size_t n = blocks.means.size();
    Matrix columns(n, 2);
    double origin = 0.0, measured = 0.0;
    for (std::size_t k = 0; k < n; ++k) origin += blocks.shares[k] * blocks.means[k], measured += blocks.shares[k];
    for (std::size_t k = 0; k < n; ++k) {
      columns(k, 0) = blocks.shares[k] > 0.0 ? 1.0 : 0.0;
      columns(k, 1) = blocks.shares[k] > 0.0 ? blocks.means[k] - origin / measured : 0.0;
      freedom += blocks.shares[k] > 0.0 ? 1.0 : 0.0;
    }
    determinants += Whitening(noise, blocks.length, length_of(blocks))(columns, blocks.shares);
    double ones = 0.0, cross = 0.0, own = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      ones += columns(k, 0) * columns(k, 0);
      cross += columns(k, 0) * columns(k, 1);
      own += columns(k, 1) * columns(k, 1);
    }
    determinants += std::log(ones);
    squares += own - cross * cross / ones;
    freedom -= 1.0;
  }
  return {freedom * std::log(std::max(squares, 1e-300)) + determinants, squares / freedom};
}

/// Ratio of a variance of the mean to that of white noise, from a hundredth to a hundred thousand.
std::vector<double> ratios() {
  std::vector<double> out;
  for (double exponent = least_exponent; exponent < greatest_exponent; exponent += exponent_step)
    out.push_back(std::pow(10.0, exponent));
  return out;
}

}  // namespace

Blocks blocks_of(std::span<const double> values, double rate) {
  const auto size =
      static_cast<std::size_t>(std::max(1.0, std::floor(static_cast<double>(values.size()) / blocks_wanted)));
  Blocks blocks{static_cast<double>(size) / rate, {}, {}};
  for (std::size_t first = 0; first + size <= values.size(); first += size) {
    double sum = 0.0, count = 0.0;
    for (const double value : values.subspan(first, size))
      if (!std::isnan(value)) sum += value, count += 1.0;
    blocks.means.push_back(count > 0.0 ? sum / count : 0.0);
    blocks.shares.push_back(count / static_cast<double>(size));
  }
  return blocks;
}

std::vector<NoiseHypothesis> noise_hypotheses(const std::vector<Blocks>& power_ups) {
  const Blocks& longest = *std::ranges::max_element(power_ups, {}, length_of);
  const double time = length_of(longest);
  const auto flicker_gain = [](const Blocks& blocks) {
    return mean_variance({NoiseTerm::flicker}, blocks.means.size());
  };
  std::vector<NoiseHypothesis> all;
  std::vector<double> misfits;
  for (const double flicker : ratios())
    for (const double walk : ratios()) {
      NoiseModel noise{.angle_random_walk = 1.0};
      noise.bias_instability = std::sqrt(flicker / time / flicker_gain(longest));
      noise.rate_random_walk = std::sqrt(3.0 * walk) / time;
      const Fitted fit = fitted(power_ups, noise);
      misfits.push_back(fit.minus_twice_log_likelihood);
      all.emplace_back();
      all.back().white = fit.level;
      all.back().flicker = fit.level * std::pow(noise.bias_instability, 2);
      all.back().walk = fit.level * std::pow(noise.rate_random_walk, 2);
      for (const Blocks& blocks : power_ups) {
        const double length = length_of(blocks);
        all.back().variances.push_back(all.back().white / length + all.back().flicker * flicker_gain(blocks) +
                                       all.back().walk * length / 3.0);
      }
    }
  const double best = std::ranges::min(misfits);
  double sum = 0.0;
  for (std::size_t h = 0; h < all.size(); ++h) sum += all[h].weight = std::exp(-0.5 * (misfits[h] - best));
  for (NoiseHypothesis& hypothesis : all) hypothesis.weight /= sum;
  return all;
}

double half_width(const std::vector<NoiseHypothesis>& hypotheses, std::size_t power_up, double freedom) {
  double high = 0.0;
  for (const NoiseHypothesis& hypothesis : hypotheses)
    high = std::max(high, 2.0 * std::sqrt(hypothesis.variances[power_up]));
  const auto outside = [&](double width) {
    double sum = 0.0;
    for (const NoiseHypothesis& hypothesis : hypotheses)
      sum += hypothesis.weight * std::erfc(width / std::sqrt(2.0 * hypothesis.variances[power_up]));
    return sum;
  };
  constexpr int halvings = 100;  // to rounding
  high = bisected(0.0, high, halvings, [&](double width) { return outside(width) > missed_by_95; }).high;
  return high * student_quantile(two_sided_95, std::max(1.0, freedom)) / normal_quantile;
}

}  // namespace tumble::static_bias
