#include "tumble/reduce/imu/axes_check.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tumble/math/median.hpp"
#include "tumble/reduce/mistaken_unit.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::imu {
namespace {

/// [1] of the greatest input: ranges whose ends differ by less are even about zero, and reach the half of it on each
/// axis.
constexpr double even_range = 0.1, reached_range = 0.5;
/// [1] Logarithm within which two channels are of one size: chosen, far from any ratio of units.
constexpr double others_agree = 0.35;

constexpr std::array<std::array<std::size_t, 3>, 6> permutations{
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
constexpr double least_felt = 0.2;          ///< of the greatest input: an axis with less input is not judged
constexpr double least_improvement = 0.1;   ///< of the output: an exchange must explain so much more than the names do
constexpr double greatest_misfit = 0.35;    ///< of the output: beyond, no exchange of axes is the reason
constexpr double greatest_deviation = 0.3;  ///< of the greatest output: a segment further off is another position
constexpr std::size_t most_findings = 6;    ///< of segments in another order

double greatest(std::span<const Vector3> all) {
  double most = 0.0;
  for (const Vector3 v : all) most = std::max({most, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  return most;
}

/// Line through the origin with the least sum of deviations: the median of the ratios, weighted by |felt|.
double slope_of(std::span<const Vector3> felt, std::span<const Vector3> shown, std::size_t output, std::size_t axis) {
  std::vector<std::pair<double, double>> ratios;
  double all = 0.0;
  for (std::size_t g = 0; g < felt.size(); ++g) {
    const double f = component(felt[g], axis);
    if (f == 0.0) continue;
    ratios.emplace_back(component(shown[g], output) / f, std::abs(f));
    all += std::abs(f);
  }
  std::ranges::sort(ratios);
  double sum = 0.0;
  for (const auto& [ratio, weight] : ratios) {
    sum += weight;
    if (sum >= 0.5 * all) return ratio;
  }
  return 0.0;
}

/// Sum of the deviations from the line, in the greatest output and 1 at most.
double misfit_of(std::span<const Vector3> felt, std::span<const Vector3> shown, std::size_t output, std::size_t axis,
                 double slope, double most) {
  double sum = 0.0;
  for (std::size_t g = 0; g < felt.size(); ++g)
    sum += std::min(1.0, std::abs(component(shown[g], output) - slope * component(felt[g], axis)) / most);
  return sum;
}

/// The permutation with the least cost; that of the names unless another is better by `margin`.
std::size_t best_of(const std::array<std::array<double, 3>, 3>& cost, double margin) {
  const auto total = [&](std::size_t p) {
    double sum = 0.0;
    for (std::size_t i = 0; i < 3; ++i) sum += cost[i][permutations[p][i]];
    return sum;
  };
  std::size_t best = 0;
  for (std::size_t p = 1; p < permutations.size(); ++p)
    if (total(p) < total(best) - (best == 0 ? margin : 0.0)) best = p;
  return best;
}

}  // namespace

AxesSeen axes_seen(const Matrix& response) {
  std::array<std::array<double, 3>, 3> cost{};
  std::array<double, 3> size{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) size[i] += std::abs(response(i, j));
    for (std::size_t j = 0; j < 3; ++j) cost[i][j] = size[i] > 0.0 ? 1.0 - std::abs(response(i, j)) / size[i] : 1.0;
  }
  AxesSeen axes;
  axes.along = permutations[best_of(cost, least_improvement)];
  for (std::size_t i = 0; i < 3; ++i) {
    axes.ratio[i] = response(i, axes.along[i]);
    axes.misfit += cost[i][axes.along[i]] / 3.0;
  }
  return axes;
}

AxesSeen axes_seen(std::span<const Vector3> felt, std::span<const Vector3> shown) {
  AxesSeen axes;
  const double most_felt = greatest(felt), most = greatest(shown);
  if (!(most_felt > 0.0) || !(most > 0.0)) {
    axes.misfit = 1.0;
    return axes;
  }
  std::array<bool, 3> moved{};
  for (std::size_t j = 0; j < 3; ++j)
    moved[j] = std::ranges::any_of(felt, [&](Vector3 f) { return std::abs(component(f, j)) > least_felt * most_felt; });
  std::array<std::array<double, 3>, 3> cost{}, slope{};
  double nothing = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    nothing += misfit_of(felt, shown, i, 0, 0.0, most);
    for (std::size_t j = 0; j < 3; ++j) {
      slope[i][j] = moved[j] ? slope_of(felt, shown, i, j) : 0.0;
      cost[i][j] = misfit_of(felt, shown, i, j, slope[i][j], most);
    }
  }
  axes.along = permutations[best_of(cost, least_improvement * nothing)];
  for (std::size_t i = 0; i < 3; ++i) {
    axes.ratio[i] = moved[axes.along[i]] ? slope[i][axes.along[i]] : std::nan("");
    axes.misfit += cost[i][axes.along[i]] / nothing;
  }
  return axes;
}

namespace {

/// Least and greatest of each component.
struct Range {
  Vector3 least, greatest;
};

Range range_of(std::span<const Vector3> all) {
  Range range{all[0], all[0]};
  for (const Vector3& v : all)
    for (std::size_t i = 0; i < 3; ++i) {
      range.least[i] = std::min(range.least[i], v[i]);
      range.greatest[i] = std::max(range.greatest[i], v[i]);
    }
  return range;
}

}  // namespace

std::vector<Vector3> without_offsets(std::span<const Vector3> felt, std::span<const Vector3> shown) {
  std::vector<Vector3> out(shown.begin(), shown.end());
  if (felt.empty()) return out;
  const Range of_felt = range_of(felt), of_shown = range_of(shown);
  const double most = greatest(felt);
  for (std::size_t i = 0; i < 3; ++i)
    if (std::abs(of_felt.least[i] + of_felt.greatest[i]) > even_range * most ||
        of_felt.greatest[i] < reached_range * most)
      return out;
  const Vector3 middle = 0.5 * (of_shown.least + of_shown.greatest);
  for (Vector3& v : out) v = v - middle;
  return out;
}

namespace {

/// The two axes that remain.
constexpr std::array<std::size_t, 2> other_axes(std::size_t axis) { return {axis == 0 ? 1u : 0u, axis == 2 ? 1u : 2u}; }

std::array<std::string, 3> names_of(Kind kind, const std::array<std::string, 3>& channels) {
  std::array<std::string, 3> names = channels;
  for (std::size_t i = 0; i < 3; ++i)
    if (names[i].empty()) names[i] = role_of(kind, i);
  return names;
}

using enum Finding::Severity;

bool even(const std::array<std::size_t, 3>& along) {
  return along == permutations[0] || along == permutations[3] || along == permutations[4];
}

/// Axis that output i shows, with its sign: "-y".
std::string axis_of(const AxesSeen& axes, std::size_t i) {
  return std::string(axes.ratio[i] < 0.0 ? "-" : "") + letters[axes.along[i]];
}

Findings about_directions(Kind kind, const AxesSeen& axes, const std::array<std::string, 3>& names) {
  std::vector<std::size_t> named, reversed;  // outputs with the axis of their name; reversed outputs
  for (std::size_t i = 0; i < 3; ++i) {
    if (axes.along[i] == i) named.push_back(i);
    if (axes.ratio[i] < 0.0) reversed.push_back(i);
  }
  if (named.size() == 3 && reversed.empty()) return {};
  if (named.size() == 3 && reversed.size() == 3)
    return {{error, kind == Kind::accelerometer ? "gravity_inverted" : "rates_inverted", {}}};
  if (named.size() == 3 && reversed.size() == 1) return {{error, "axis_reversed", {{"channel", names[reversed[0]]}}}};
  if (named.size() == 1 && reversed.empty())
    return {{error,
             "axes_exchanged",
             {{"first", names[other_axes(named[0])[0]]}, {"second", names[other_axes(named[0])[1]]}}}};
  const bool right_handed = even(axes.along) == (reversed.size() % 2 == 0);
  std::vector<FindingValue> values;
  for (std::size_t i = 0; i < 3; ++i) {
    values.emplace_back(std::string("output_") + letters[i], names[i]);
    values.emplace_back(std::string("axis_") + letters[i], axis_of(axes, i));
  }
  return {{error, right_handed ? "axes_turned" : "axes_mirrored", std::move(values)}};
}

/// One channel that is larger or smaller than the two others by the ratio of two units, while they agree.
Findings about_one_unit(Kind kind, const AxesSeen& axes, const std::array<std::string, 3>& names) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [j, k] = other_axes(i);
    const double one = std::abs(axes.ratio[i]), others = std::sqrt(std::abs(axes.ratio[j] * axes.ratio[k]));
    if (!(std::abs(std::log(std::abs(axes.ratio[j] / axes.ratio[k]))) < others_agree)) continue;
    const double ratio = one / others;
    if (const auto unit = kind == Kind::gyro ? mistaken_unit_of_rate(ratio) : mistaken_unit_of_force(ratio))
      return {{error,
               "channel_unit_mistaken",
               {{"channel", names[i]}, {"ratio", ratio}, {"unit", unit->of}, {"read_as", unit->read_as}}}};
  }
  return {};
}

Findings about_units(Kind kind, const AxesSeen& axes) {
  std::vector<double> sizes;
  for (const double ratio : axes.ratio)
    if (!std::isnan(ratio)) sizes.push_back(std::abs(ratio));
  if (sizes.empty()) return {};
  const double size = median(sizes);
  const bool gyro = kind == Kind::gyro;
  if (const auto unit = gyro ? mistaken_unit_of_rate(size) : mistaken_unit_of_force(size))
    return {{error,
             "unit_mistaken",
             {{"sensors", Phrase{gyro ? "gyros" : "accelerometers"}},
              {"ratio", size},
              {"unit", unit->of},
              {"read_as", unit->read_as}}}};
  if (size > 0.5 && size < 2.0) return {};
  return {{error, "scale_mistaken", {{"sensors", Phrase{gyro ? "gyros" : "accelerometers"}}, {"ratio", size}}}};
}

}  // namespace

Findings about_axes(Kind kind, const AxesSeen& axes, const std::array<std::string, 3>& channels) {
  Findings findings = about_directions(kind, axes, names_of(kind, channels));
  std::ranges::move(about_units(kind, axes), std::back_inserter(findings));
  std::ranges::move(about_one_unit(kind, axes, names_of(kind, channels)), std::back_inserter(findings));
  return findings;
}

namespace {

Vector3 read_along(const AxesSeen& axes, Vector3 felt) {
  std::array<double, 3> out{};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = std::isnan(axes.ratio[i]) ? component(felt, i) : axes.ratio[i] * component(felt, axes.along[i]);
  return {out[0], out[1], out[2]};
}

/// The names as they are, with the size that fits most segments.
AxesSeen as_named(std::span<const Vector3> felt, std::span<const Vector3> shown) {
  std::vector<double> ratios;
  for (std::size_t g = 0; g < felt.size(); ++g)
    if (norm(felt[g]) > 0.0) ratios.push_back(norm(shown[g]) / norm(felt[g]));
  AxesSeen axes;
  axes.ratio.fill(median(ratios));
  return axes;
}

Findings about_order(const AxesSeen& axes, std::span<const Vector3> felt, std::span<const Vector3> shown,
                     const std::vector<std::string>& labels) {
  Findings findings;
  const double most = greatest(shown);
  std::size_t deviating = 0;
  for (std::size_t g = 0; g < felt.size(); ++g) {
    const auto distance = [&](std::size_t of) { return norm(shown[g] - read_along(axes, felt[of])); };
    if (!(distance(g) > greatest_deviation * most)) continue;
    if (++deviating > most_findings) continue;
    std::size_t nearest = g;
    for (std::size_t h = 0; h < felt.size(); ++h)
      if (distance(h) < distance(nearest)) nearest = h;
    if (distance(nearest) < 0.5 * greatest_deviation * most)
      findings.push_back({error, "segment_reads_as_another", {{"segment", labels[g]}, {"other", labels[nearest]}}});
    else
      findings.push_back({error, "segment_reads_as_none", {{"segment", labels[g]}}});
  }
  if (deviating > most_findings)
    findings.push_back({error, "more_segments_deviate", {{"more", deviating - most_findings}}});
  return findings;
}

}  // namespace

Findings about_triad(Kind kind, std::span<const Vector3> felt, std::span<const Vector3> shown,
                     const std::vector<std::string>& labels, const std::array<std::string, 3>& channels) {
  const AxesSeen axes = axes_seen(felt, shown);
  if (axes.misfit > greatest_misfit) return about_order(as_named(felt, shown), felt, shown, labels);
  Findings findings = about_axes(kind, axes, channels);
  std::ranges::move(about_order(axes, felt, shown, labels), std::back_inserter(findings));
  return findings;
}

}  // namespace tumble::imu
