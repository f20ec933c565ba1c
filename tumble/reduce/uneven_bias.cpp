#include "tumble/reduce/uneven_bias.hpp"

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <vector>

#include "tumble/math/median.hpp"

namespace tumble {
namespace {

/// Differences over independent ones: those of white means are correlated with the next, and two thirds of them count.
constexpr double correlated_differences = 1.5;

/// Differences on each side, that their mean square is compared with: F with fewer degrees of freedom says nothing.
constexpr double fewest_compared = 3.0;
constexpr double least_freedom_of_jump = 3.0;  ///< of Student's t, which has a variance from there on
/// Length of the record over the time of an exponential [1]: the slowest that is tried takes half of the record. A
/// slower one is a ramp.
constexpr double least_of_record = 1.5;

constexpr double rare_comparison = 1e-5;  ///< p-value of one comparison
constexpr double median_size = 0.6745;    ///< [sd] median of the magnitudes, of the normal distribution
/// [1] efficiency of that median: the sd is known as well as from 37 % of the differences by their squares.
constexpr double median_efficiency = 0.37;
/// [usual differences] below which no probability is calculated: it would be too great in any record.
constexpr double least_jump = 4.0;
/// [1] of a jump that must remain in the means around it, where a level stays; a pulse leaves none. Chosen: a little
/// more than half of it.
constexpr double staying_part = 0.6;
constexpr double looser = 10.0;  ///< times that for the jumps that are counted; the worst one must be rare
/// Shares of the record that the times of exponentials are: 1/32 to 1/2, each half of the one before, in so many tries.
constexpr double shortest_share = 32.0, tries_of_exponentials = 5.0;
constexpr std::size_t fewest_means = 32, fewest_of_jumps = 64, shortest_mean = 16, parts = 8;

/// Means of two neighbours each; missing where one is.
std::vector<double> halved(const std::vector<double>& values) {
  std::vector<double> means;
  for (std::size_t i = 0; i + 1 < values.size(); i += 2) means.push_back(0.5 * (values[i] + values[i + 1]));
  return means;
}

/// Means of one length with the differences of neighbours.
struct Means {
  std::vector<double> values;
  double unit = 1.0;                ///< [samples]
  std::vector<double> difference;   ///< to the next; NaN: missing
  double count = 0.0, usual = 0.0;  ///< number of differences, and their sd by the median size [u]
};

Means means_of(std::vector<double> values, double unit) {
  Means result{std::move(values), unit, {}, 0.0, 0.0};
  std::vector<double> sizes;
  for (std::size_t i = 0; i + 1 < result.values.size(); ++i) {
    result.difference.push_back(result.values[i + 1] - result.values[i]);
    if (!std::isnan(result.difference.back())) sizes.push_back(std::abs(result.difference.back()));
  }
  result.count = static_cast<double>(sizes.size());
  if (!sizes.empty()) result.usual = median(sizes) / median_size;
  return result;
}

/// Whether the level stays where difference i brings it: a pulse comes back.
bool stays(const Means& means, std::size_t i) {
  const double size = means.difference[i];
  const auto follows = [&](std::size_t from, std::size_t to) {
    const double change = means.values[to] - means.values[from];
    return std::isnan(change) || change / size > staying_part;
  };
  const bool before = i > 0, after = i + 2 < means.values.size();
  return (!before || follows(i - 1, i + 1)) && (!after || follows(i, i + 2)) &&
         (!before || !after || follows(i - 1, i + 2));
}

/// Probability of a difference as large or larger among all, the usual one being known from their median only.
double chance_of_jump(const Means& means, double size) {
  const boost::math::students_t distribution(std::max(least_freedom_of_jump, median_efficiency * means.count));
  return 2.0 * means.count * boost::math::cdf(boost::math::complement(distribution, size / means.usual));
}

struct Jumps {
  std::size_t count = 0;
  double first = 0.0, worst = 0.0, last = 0.0, size = 0.0;  ///< [s], [s], [s], [u]
  double chance = 1.0;
};

Jumps jumps_of(const Means& means, double begin, double rate) {
  Jumps jumps;
  std::size_t last = 0;
  for (std::size_t i = 0; i < means.difference.size(); ++i) {
    const double size = std::abs(means.difference[i]);
    if (!(size > least_jump * means.usual)) continue;
    const double chance = chance_of_jump(means, size);
    if (chance > looser * rare_comparison || !stays(means, i)) continue;
    const double time = begin + static_cast<double>(i + 1) * means.unit / rate;
    if (jumps.count == 0 || i > last + 1) ++jumps.count;
    if (jumps.count == 1 && jumps.first == 0.0) jumps.first = time;
    last = i;
    jumps.last = time;
    if (size <= std::abs(jumps.size)) continue;
    jumps.size = means.difference[i];
    jumps.worst = time;
    jumps.chance = chance;
  }
  return jumps;
}

/// How much larger the differences of the first eighth are than the others (ratio of mean squares), and the chance of
/// it.
struct Settling {
  double ratio = 1.0, chance = 1.0;
};

Settling settling_of(const Means& means) {
  double sum[2] = {}, count[2] = {};
  for (std::size_t i = 0; i < means.difference.size(); ++i) {
    if (std::isnan(means.difference[i])) continue;
    const int which = i < means.difference.size() / parts ? 0 : 1;
    sum[which] += means.difference[i] * means.difference[i];
    ++count[which];
  }
  if (count[0] < fewest_compared || count[1] < fewest_compared || !(sum[1] > 0.0)) return {};
  const double ratio = sum[0] / count[0] / (sum[1] / count[1]);
  const boost::math::fisher_f distribution(count[0] / correlated_differences, count[1] / correlated_differences);
  return {ratio, boost::math::cdf(boost::math::complement(distribution, ratio))};
}

/// Chance of so much of an exponential that dies away with `time` [number of means] in the differences, beside a trend.
/// What is constant noise has no more power at low frequencies of its differences than a walk, whose differences are
/// white.
double chance_of_exponential(const Means& means, double time) {
  double n = 0.0, x = 0.0, xx = 0.0, y = 0.0, yy = 0.0, xy = 0.0;
  for (std::size_t i = 0; i < means.difference.size(); ++i) {
    const double one = means.difference[i], shape = std::exp(-static_cast<double>(i) / time);
    if (std::isnan(one)) continue;
    n += 1.0;
    x += shape;
    xx += shape * shape;
    y += one;
    yy += one * one;
    xy += shape * one;
  }
  const double sxx = xx - x * x / n, sxy = xy - x * y / n, rest = yy - y * y / n - sxy * sxy / sxx;
  if (!(sxx > 0.0) || !(rest > 0.0)) return 1.0;
  const boost::math::students_t distribution(n - 3.0);
  const double t = std::abs(sxy) / std::sqrt(rest / (n - 3.0) * sxx);
  return 2.0 * boost::math::cdf(boost::math::complement(distribution, t));
}

/// The least chance of exponentials of several times, as if each were tried by itself.
double chance_of_settling(const Means& means) {
  double least = 1.0;
  const double length = static_cast<double>(means.difference.size());
  for (double share = shortest_share; share > least_of_record; share *= 0.5)
    least = std::min(least, tries_of_exponentials * chance_of_exponential(means, length / share));
  return least;
}

}  // namespace

Findings uneven_bias(const NoiseBands& bands, double begin, double rate, const std::string& unit_shown,
                     const std::string& label) {
  std::vector<double> values = bands.slow;
  double unit = bands.slow_unit;
  Jumps jumps;
  Settling settling;
  for (; values.size() >= fewest_means; values = halved(values), unit *= 2.0) {
    if (unit < shortest_mean) continue;
    const Means means = means_of(values, unit);
    if (!(means.usual > 0.0) || means.count < 0.5 * fewest_means) continue;
    const Jumps here = values.size() < fewest_of_jumps ? Jumps() : jumps_of(means, begin, rate);
    if (here.chance < rare_comparison && (jumps.count == 0 || here.chance < jumps.chance)) jumps = here;
    Settling now = settling_of(means);
    now.chance = std::min(now.chance, chance_of_settling(means));
    if (now.chance < settling.chance) settling = now;
  }
  Findings findings;
  // What dies away from the begin on is steep enough there to be taken for jumps.
  const double eighth = begin + static_cast<double>(bands.samples) / parts / rate;
  const bool settles = settling.chance < rare_comparison && (jumps.count == 0 || jumps.last < eighth);
  if (jumps.count > 0 && !settles)
    findings.push_back({Finding::Severity::error,
                        "bias_jumps",
                        {{"size", jumps.size, unit_shown}, {"worst", jumps.worst, "s"}},
                        label,
                        {jumps.count, jumps.first, jumps.worst}});
  else if (settles)
    findings.push_back(
        {Finding::Severity::error, "bias_settles", {{"ratio", std::sqrt(settling.ratio)}, {"to", eighth, "s"}}, label});
  return findings;
}

}  // namespace tumble
