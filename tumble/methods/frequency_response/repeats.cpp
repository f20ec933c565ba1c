#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tumble/math/bisection.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/frequency_response/describe.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::frequency_response {
namespace {

using Severity = Finding::Severity;

constexpr double rare_scatter = 5e-5;  ///< p-value on each side: once in ten thousand groups
constexpr double other_tone = 1.001;   ///< ratio of two frequencies that are two tones although their labels are equal

/// Measurements at one frequency, of ln gain or of phase about the first.
struct Group {
  std::vector<double> value, variance;  ///< [1] or [rad], and by noise

  double weighted_mean(double scatter) const {
    double sum = 0.0, weights = 0.0;
    for (std::size_t i = 0; i < value.size(); ++i)
      sum += value[i] / (variance[i] + scatter), weights += 1.0 / (variance[i] + scatter);
    return sum / weights;
  }
  /// Squares about the mean over noise and scatter: chi-square of freedom() where both are right.
  double squares(double scatter) const {
    const double mean = weighted_mean(scatter);
    double sum = 0.0;
    for (std::size_t i = 0; i < value.size(); ++i)
      sum += (value[i] - mean) * (value[i] - mean) / (variance[i] + scatter);
    return sum;
  }
  double freedom() const { return static_cast<double>(value.size() - 1); }
};

/// Variance between repeats beyond their noise, of all these groups together (Paule and Mandel): with it the squares
/// are as many as the degrees of freedom.
double scatter_of(const std::vector<const Group*>& groups) {
  const auto excess = [&](double scatter) {
    double sum = 0.0;
    for (const Group* group : groups) sum += group->squares(scatter) - group->freedom();
    return sum;
  };
  if (!(excess(0.0) > 0.0)) return 0.0;
  constexpr double least = 1e-20, most = 1e6;  // [rad^2] or of a logarithm: beneath any noise; beyond any response
  constexpr int halvings = 100;                // to rounding
  double high = least;
  while (excess(high) > 0.0 && high < most) high *= 4.0;
  return bisected(0.0, high, halvings, [&](double scatter) { return excess(scatter) > 0.0; }).high;
}

/// Whether a group scatters by more than all the others [over 1]: one in ten thousand does by chance, their scatter
/// being an estimate itself (both at their limits: a bound for the distribution of F).
double share_of_limit(const Group& group, const std::vector<const Group*>& others) {
  double freedom = 0.0;
  for (const Group* other : others) freedom += other->freedom();
  const double scatter = scatter_of(others);
  const double least = scatter > 0.0 ? chi_square_quantile(rare_scatter, freedom) / freedom : 1.0;
  return group.squares(scatter) * least / chi_square_quantile(1.0 - rare_scatter, group.freedom());
}

/// Scatter [1] of each group: in common, or its own where it stands out of it.
struct Scatter {
  double common = 0.0, freedom = 0.0;
  std::vector<double> own;  ///< negative: the common one
  bool significant = false;
};

Scatter scatter_of(const std::vector<Group>& groups) {
  Scatter scatter;
  scatter.own.assign(groups.size(), -1.0);
  for (std::size_t round = 0; round < groups.size(); ++round) {
    std::vector<const Group*> together;
    double squares = 0.0;
    scatter.freedom = 0.0;
    for (std::size_t g = 0; g < groups.size(); ++g)
      if (groups[g].value.size() > 1 && scatter.own[g] < 0.0) {
        together.push_back(&groups[g]);
        squares += groups[g].squares(0.0);
        scatter.freedom += groups[g].freedom();
      }
    if (together.empty()) break;
    scatter.common = scatter_of(together);
    scatter.significant = squares > chi_square_quantile(exceeded_in_1000, scatter.freedom);
    std::size_t worst = groups.size();
    double most = 1.0;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (groups[g].value.size() < 2 || scatter.own[g] >= 0.0 || together.size() < 2) continue;
      std::vector<const Group*> others;
      for (const Group* other : together)
        if (other != &groups[g]) others.push_back(other);
      const double share = share_of_limit(groups[g], others);
      if (share > most) most = share, worst = g;
    }
    if (worst == groups.size()) break;
    scatter.own[worst] = scatter_of({&groups[worst]});
  }
  return scatter;
}

Group group_of(const std::vector<Point>& repeats, bool gain) {
  Group group;
  for (const Point& p : repeats) {
    group.value.push_back(gain ? std::log(std::abs(p.response)) : std::arg(p.response / repeats.front().response));
    group.variance.push_back(gain ? p.output_gain_variance + p.reference_gain_variance + p.counting_variance + 1e-30
                                  : p.output_phase_variance + p.reference_phase_variance + p.counting_variance + 1e-30);
  }
  return group;
}

/// Weights 1/(noise + scatter), of sum 1.
std::vector<double> weights_of(const Group& group, double scatter) {
  std::vector<double> weights;
  double sum = 0.0;
  for (const double v : group.variance) weights.push_back(1.0 / (v + scatter)), sum += weights.back();
  for (double& w : weights) w /= sum;
  return weights;
}

struct Mean {
  double value = 0.0, output = 0.0, reference = 0.0, counting = 0.0, scatter = 0.0;  ///< and variances
};

Mean mean_over(const std::vector<Point>& repeats, const Group& group, double scatter, bool gain) {
  Mean mean;
  const auto weights = weights_of(group, scatter);
  for (std::size_t i = 0; i < repeats.size(); ++i) {
    const Point& p = repeats[i];
    const double square = weights[i] * weights[i];
    mean.value += weights[i] * group.value[i];
    mean.output += square * (gain ? p.output_gain_variance : p.output_phase_variance);
    mean.reference += square * (gain ? p.reference_gain_variance : p.reference_phase_variance);
    mean.counting += square * p.counting_variance;
    mean.scatter += square * scatter;
  }
  return mean;
}

Point mean_of(const std::vector<Point>& repeats, const Group& gains, const Group& phases, double gain_scatter,
              double phase_scatter) {
  Point mean = repeats.front();
  const Mean gain = mean_over(repeats, gains, gain_scatter, true),
             phase = mean_over(repeats, phases, phase_scatter, false);
  mean.response = std::polar(std::exp(gain.value), std::arg(mean.response) + phase.value);
  mean.output_gain_variance = gain.output, mean.output_phase_variance = phase.output;
  mean.reference_gain_variance = gain.reference, mean.reference_phase_variance = phase.reference;
  mean.counting_variance = std::max(gain.counting, phase.counting);
  mean.scatter_gain_variance = gain.scatter, mean.scatter_phase_variance = phase.scatter;
  double output = 0.0, reference = 0.0;
  for (const Point& p : repeats) output += p.output_dof, reference += p.reference_dof;
  mean.output_dof = output, mean.reference_dof = reference;
  return mean;
}

void report(const std::vector<std::vector<Point>>& repeats, const Scatter& gain, const Scatter& phase,
            Findings& findings) {
  std::size_t repeated = 0;
  for (std::size_t g = 0; g < repeats.size(); ++g) {
    if (repeats[g].size() < 2) continue;
    ++repeated;
    if (gain.own[g] >= 0.0 || phase.own[g] >= 0.0)
      findings.push_back({Severity::warning,
                          "repeats_differ",
                          {{"measurements", repeats[g].size()}, {"frequency", repeats[g].front().nominal, "Hz"}}});
  }
  if (gain.significant || phase.significant)
    findings.push_back({Severity::info,
                        "repeats_scatter",
                        {{"gain", std::sqrt(gain.common), "%"}, {"phase", std::sqrt(phase.common), "deg"}},
                        "",
                        {repeated}});
}

}  // namespace

std::vector<Point> combined(std::vector<Point> points, Findings& findings) {
  // Different tones with equal labels of three digits get five.
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    if (points[i].nominal == points[i + 1].nominal && points[i + 1].frequency > other_tone * points[i].frequency)
      for (Point* p : {&points[i], &points[i + 1]}) p->nominal = rounded_to_digits(p->frequency, 5);
  std::vector<std::vector<Point>> repeats;
  for (Point& p : points) {
    if (repeats.empty() || repeats.back().front().nominal != p.nominal) repeats.emplace_back();
    repeats.back().push_back(std::move(p));
  }
  std::vector<Group> gains, phases;
  for (const auto& group : repeats) {
    gains.push_back(group_of(group, true));
    phases.push_back(group_of(group, false));
  }
  const Scatter gain = scatter_of(gains), phase = scatter_of(phases);
  report(repeats, gain, phase, findings);
  std::vector<Point> means;
  for (std::size_t g = 0; g < repeats.size(); ++g) {
    const bool own_gain = gain.own[g] >= 0.0, own_phase = phase.own[g] >= 0.0;
    means.push_back(mean_of(repeats[g], gains[g], phases[g], own_gain ? gain.own[g] : gain.common,
                            own_phase ? phase.own[g] : phase.common));
    means.back().scatter_gain_dof = std::max(1.0, own_gain ? gains[g].freedom() : gain.freedom);
    means.back().scatter_phase_dof = std::max(1.0, own_phase ? phases[g].freedom() : phase.freedom);
  }
  return means;
}

}  // namespace tumble::frequency_response
