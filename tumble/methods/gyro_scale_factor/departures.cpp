#include "tumble/methods/gyro_scale_factor/departures.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <tuple>

#include "tumble/math/normal.hpp"
#include "tumble/math/random.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/gyro_scale_factor/segments.hpp"

namespace tumble::gyro_scale_factor {
namespace {

using linear::SegmentSummary;

constexpr double least_freedom_of_repeats = 4.0;  ///< with which the scatter of repeats replaces that about the line
constexpr double most_share_sd = 0.2;             ///< [1] of the output due, above which its share is not known
constexpr double half_of_due = 0.5;               ///< [1] of the output due: the threshold, by IEEE Std 528
constexpr std::size_t fewest_shares = 3;          ///< inputs that were tried
/// [1] of the range: rates below it, and steps below it at rates above `resolution_from`, are small.
constexpr double small_input = 0.01, resolution_from = 0.05;
constexpr double least_spread_of_rates = 0.01;  ///< [1] of the square of the range: a run has a line of its own

void find_scatter(const linear::Solution& solution, std::size_t parameters, const std::vector<Segments>& groups,
                  Line& line) {
  double squares = 0.0, dof = 0.0;
  for (const auto& group : groups) {
    for (const auto* s : group) squares += std::pow(s->measured - mean_of(group), 2);
    dof += static_cast<double>(group.size()) - 1.0;
  }
  line.scatter_from = "repeated rates";
  if (dof < least_freedom_of_repeats) {
    squares = 0.0;
    dof = 0.0;
    for (const auto& group : groups)
      for (const auto* s : group) squares += std::pow(s->measured - s->predicted, 2), ++dof;
    dof -= static_cast<double>(parameters);
    line.scatter_from = "misfit of the model";
  }
  double white = 0.0;
  for (const auto& segment : solution.segments)
    white += segment.sd * segment.sd / static_cast<double>(solution.segments.size());
  line.degrees_of_freedom = std::max(1.0, dof);
  line.scatter = std::sqrt(dof >= 1.0 ? squares / dof : white);
}

/// The size `of` a set of deviations known with errors, for which `draw` makes new errors: the part that noise adds is
/// subtracted.
Size size_of(const std::vector<double>& deviations, double (*of)(const std::vector<double>&), bool significant,
             const std::function<std::vector<double>(const RandomStream&)>& draw) {
  constexpr std::uint64_t draws = 1000;
  Size size;
  size.significant = significant;
  const double plain = of(deviations);
  double sum = 0.0, squares = 0.0;
  for (std::uint64_t k = 0; k < draws; ++k) {
    auto moved = draw(RandomStream(20150901).split(k));
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += deviations[i];
    const double change = of(moved) - plain;
    sum += change / draws;
    squares += change * change / draws;
  }
  size.value = std::max(0.0, plain - sum);
  size.sd = std::sqrt(std::max(0.0, squares - sum * sum));
  size.limit = plain + 2.0 * size.sd;
  return size;
}

double greatest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double v : values) most = std::max(most, std::abs(v));
  return most;
}

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Errors of the departures: of the group means, less the line through them. Rounding is one error of a group.
std::vector<double> drawn_departures(const std::vector<Segments>& groups, const Line& line,
                                     const RandomStream& random) {
  std::vector<SegmentSummary> made;
  Segments all;
  for (const auto& group : groups)
    for (const auto* s : group) made.push_back(*s);
  const RandomStream of_group = random.split("rounding");
  std::size_t next = 0;
  for (std::size_t g = 0; g < groups.size(); ++g)
    for (std::size_t k = 0; k < groups[g].size(); ++k, ++next) {
      made[next].measured = line.scatter * random.normal(next) + line.rounding * of_group.normal(g);
      all.push_back(&made[next]);
    }
  const auto [offset, slope] = straight(all);
  std::vector<double> errors;
  std::size_t at = 0;
  for (const auto& group : groups) {
    double mean = 0.0;
    for (std::size_t k = 0; k < group.size(); ++k, ++at)
      mean += (made[at].measured - offset - slope * made[at].felt.rate.x) / static_cast<double>(group.size());
    errors.push_back(mean);
  }
  return errors;
}

/// Segments whose rate was reached from below and from above.
struct Sides {
  std::set<const SegmentSummary*> below, above;
};

Sides sides_of(const Segments& in_time) {
  Sides sides;
  for (std::size_t i = 1; i < in_time.size(); ++i) {
    if (in_time[i]->run != in_time[i - 1]->run) continue;
    (in_time[i]->felt.rate.x > in_time[i - 1]->felt.rate.x ? sides.below : sides.above).insert(in_time[i]);
  }
  return sides;
}

/// Repeats from one side show the scatter alone; without enough of them it is that of the line, which holds the
/// hysteresis too and makes the judgement cautious.
double scatter_of(const Sides& sides, const std::vector<Segments>& groups, const Line& line) {
  double squares = 0.0, dof = 0.0;
  for (const auto& group : groups)
    for (const auto* side : {&sides.below, &sides.above}) {
      Segments same;
      for (const auto* s : group)
        if (side->contains(s)) same.push_back(s);
      for (const auto* s : same) squares += std::pow(s->measured - mean_of(same), 2);
      dof += same.empty() ? 0.0 : static_cast<double>(same.size()) - 1.0;
    }
  return dof >= least_freedom_of_repeats ? std::sqrt(squares / dof) : line.scatter;
}

void find_hysteresis(const Segments& in_time, const std::vector<Segments>& groups, Line& line) {
  const Sides sides = sides_of(in_time);
  const double scatter = scatter_of(sides, groups, line);
  std::vector<double> differences, sds;
  double chi = 0.0;
  for (const auto& group : groups) {
    double below = 0.0, above = 0.0, sum_below = 0.0, sum_above = 0.0;
    for (const auto* s : group) {
      if (sides.below.contains(s)) ++below, sum_below += s->measured;
      if (sides.above.contains(s)) ++above, sum_above += s->measured;
    }
    if (below < 1.0 || above < 1.0) continue;
    differences.push_back((sum_below / below - sum_above / above) / (line.slope * line.range));
    sds.push_back(scatter * std::sqrt(1.0 / below + 1.0 / above) / std::abs(line.slope * line.range));
    chi += std::pow(differences.back() / sds.back(), 2);
  }
  line.both_ways = differences.size();
  if (line.both_ways < 3) return;
  const double limit = chi_square_quantile(exceeded_in_100, static_cast<double>(sds.size()));
  line.hysteresis = size_of(differences, greatest, chi > limit, [&](const RandomStream& random) {
    std::vector<double> errors;
    for (std::size_t i = 0; i < sds.size(); ++i) errors.push_back(sds[i] * random.normal(i));
    return errors;
  });
}

/// The input at which the share falls below a half. Given: pairs of input, and share of the output due with its sd.
Bracket bracket_of(std::map<double, std::pair<double, double>> tried) {
  Bracket bracket;
  std::erase_if(tried, [](const auto& pair) { return pair.second.second > most_share_sd; });
  bracket.tried = tried.size() >= fewest_shares;
  if (!bracket.tried) return bracket;
  bracket.smallest = tried.begin()->first;
  double below = 0.0;
  for (const auto& [input, share] : tried)
    if (share.first < half_of_due) below = input;
  if (below == 0.0) return bracket;
  const auto above = tried.upper_bound(below);
  if (above == tried.end()) return bracket;
  bracket.bounded = true;
  bracket.value = 0.5 * (below + above->first);
  bracket.sd = 0.5 * (above->first - below) / std::sqrt(3.0);
  return bracket;
}

/// The segments less the mean misfit of their power-up: its turn-on bias is no departure from the line.
linear::Solution without_turn_on(linear::Solution solution) {
  const auto [offset, slope] = straight(all_of(solution));
  std::map<int, std::pair<double, double>> sums;
  for (const auto& s : solution.segments) {
    if (std::isnan(s.measured)) continue;
    sums[s.run].first += s.measured - offset - slope * s.felt.rate.x;
    ++sums[s.run].second;
  }
  if (sums.size() < 2) return solution;
  for (auto& s : solution.segments) s.measured -= sums[s.run].first / std::max(1.0, sums[s.run].second);
  return solution;
}

}  // namespace

Line line_of(const linear::Solution& as_measured, std::size_t parameters) {
  const linear::Solution solution = without_turn_on(as_measured);
  const auto all = all_of(solution);
  Line line;
  std::tie(line.offset, line.slope) = straight(all);
  for (const auto* s : all) line.range = std::max(line.range, std::abs(s->felt.rate.x));
  const auto groups = groups_of(all, line.range);
  find_scatter(solution, parameters, groups, line);
  for (const auto* s : all) line.rounding = std::max(line.rounding, s->rounding);
  const double unit = line.slope * line.range;
  std::vector<double> values;
  double chi = 0.0;
  for (const auto& group : groups) {
    Departure d;
    d.segments = group.size();
    for (const auto* s : group) {
      d.rate += s->felt.rate.x / static_cast<double>(group.size());
      d.value += (s->measured - line.offset - line.slope * s->felt.rate.x) / unit / static_cast<double>(group.size());
    }
    d.sd = std::hypot(line.scatter / std::sqrt(static_cast<double>(group.size())), line.rounding) / std::abs(unit);
    chi += std::pow(d.value / d.sd, 2);
    line.departures.push_back(d);
    values.push_back(d.value);
  }
  const double dof = static_cast<double>(groups.size()) - 2.0;
  if (dof >= 1.0) {
    // F of dof and nu degrees of freedom, by the chi-square it tends to, widened for few nu.
    const double limit = chi_square_quantile(exceeded_in_100, dof) * (1.0 + 4.0 / line.degrees_of_freedom);
    const auto draw = [&](const RandomStream& random) {
      auto errors = drawn_departures(groups, line, random);
      for (double& e : errors) e /= unit;
      return errors;
    };
    line.greatest = size_of(values, greatest, chi > limit, draw);
    line.rms = size_of(values, rms, chi > limit, draw);
  }
  find_hysteresis(all, groups, line);
  return line;
}

Bracket threshold_of(const linear::Solution& solution, const Line& line) {
  std::map<double, std::pair<double, double>> tried;
  for (const auto* s : all_of(solution)) {
    const double w = s->felt.rate.x;
    if (w == 0.0 || std::abs(w) > small_input * line.range) continue;
    const double due = line.slope * w;
    tried[std::abs(w)] = {(s->measured - line.offset) / due, s->sd / std::abs(due)};
  }
  return bracket_of(std::move(tried));
}

Bracket resolution_of(const linear::Solution& solution, const Line& line) {
  std::map<double, std::pair<double, double>> tried;
  const auto all = all_of(solution);
  for (std::size_t i = 1; i < all.size(); ++i) {
    const double step = all[i]->felt.rate.x - all[i - 1]->felt.rate.x;
    if (all[i]->run != all[i - 1]->run || step == 0.0 || std::abs(all[i]->felt.rate.x) < resolution_from * line.range ||
        std::abs(step) > small_input * line.range)
      continue;
    const double due = line.slope * step;
    tried[std::abs(step)] = {(all[i]->measured - all[i - 1]->measured) / due,
                             std::hypot(all[i]->sd, all[i - 1]->sd) / std::abs(due)};
  }
  return bracket_of(std::move(tried));
}

Repeatability repeatability_of(const linear::Solution& solution, const Line& line) {
  std::map<int, Segments> runs;
  for (const auto* s : all_of(solution)) runs[s->run].push_back(s);
  std::vector<double> bias, slope;
  double within_bias = 0.0, within_slope = 0.0;
  for (const auto& [run, segments] : runs) {
    double ww = 0.0, mean = 0.0, misfit = 0.0;
    const auto n = static_cast<double>(segments.size());
    for (const auto* s : segments) mean += s->felt.rate.x / n;
    for (const auto* s : segments) ww += std::pow(s->felt.rate.x - mean, 2);
    if (segments.size() < 3 || ww < least_spread_of_rates * n * line.range * line.range) continue;
    const auto [c, k] = straight(segments);
    for (const auto* s : segments) misfit += std::pow(s->measured - c - k * s->felt.rate.x, 2) / (n - 2.0);
    bias.push_back(c / k);
    slope.push_back(k / line.slope);
    within_bias += misfit * (1.0 / n + mean * mean / ww) / (k * k);
    within_slope += misfit / ww / (k * k);
  }
  Repeatability out;
  out.runs = bias.size();
  if (out.runs < 3) return out;
  const double n = static_cast<double>(out.runs), dof = n - 1.0;
  const auto spread = [&](const std::vector<double>& values, double within) {
    double mean = 0.0, between = 0.0;
    for (const double v : values) mean += v / n;
    for (const double v : values) between += (v - mean) * (v - mean) / dof;
    Size size;
    const double variance = between - within / n;
    size.limit = std::sqrt(std::max(0.0, between * dof / chi_square_quantile(missed_by_95, dof) - within / n));
    size.significant = variance > 0.0 && between > within / n * chi_square_quantile(one_sided_95, dof) / dof;
    if (size.significant)
      size.value = std::sqrt(variance), size.sd = between * std::sqrt(2.0 / dof) / (2.0 * size.value);
    return size;
  };
  out.bias = spread(bias, within_bias);
  out.slope = spread(slope, within_slope);
  return out;
}

}  // namespace tumble::gyro_scale_factor
