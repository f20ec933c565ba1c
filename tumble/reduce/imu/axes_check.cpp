#include "tumble/reduce/imu/axes_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/median.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::imu {
namespace {

constexpr std::array<std::array<std::size_t, 3>, 6> permutations{
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
constexpr double unseen = 0.2;        ///< of the greatest felt: an axis that feels less is not judged
constexpr double clearly = 0.1;       ///< of what is shown: an exchange must explain so much more than the names do
constexpr double unexplained = 0.35;  ///< of what is shown: beyond, no exchange of axes is the reason
constexpr double astray = 0.3;        ///< of the greatest output: a segment further off is another position

double greatest(std::span<const Vector3> all) {
  double most = 0.0;
  for (const auto& one : all) most = std::max({most, std::abs(one.x), std::abs(one.y), std::abs(one.z)});
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
  for (const auto& [ratio, weight] : ratios)
    if ((sum += weight) >= 0.5 * all) return ratio;
  return 0.0;
}

double left_of(std::span<const Vector3> felt, std::span<const Vector3> shown, std::size_t output, std::size_t axis,
               double slope, double most) {
  double sum = 0.0;
  for (std::size_t g = 0; g < felt.size(); ++g)
    sum += std::min(1.0, std::abs(component(shown[g], output) - slope * component(felt[g], axis)) / most);
  return sum;
}

/// The permutation with the least cost; the names as they are unless another is better by `margin`.
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
  AxesSeen seen;
  seen.along = permutations[best_of(cost, clearly)];
  for (std::size_t i = 0; i < 3; ++i) {
    seen.ratio[i] = response(i, seen.along[i]);
    seen.misfit += cost[i][seen.along[i]] / 3.0;
  }
  return seen;
}

AxesSeen axes_seen(std::span<const Vector3> felt, std::span<const Vector3> shown) {
  AxesSeen seen;
  const double most_felt = greatest(felt), most = greatest(shown);
  if (!(most_felt > 0.0) || !(most > 0.0)) {
    seen.misfit = 1.0;
    return seen;
  }
  std::array<bool, 3> moved{};
  for (std::size_t j = 0; j < 3; ++j)
    moved[j] = std::ranges::any_of(felt, [&](Vector3 f) { return std::abs(component(f, j)) > unseen * most_felt; });
  std::array<std::array<double, 3>, 3> cost{}, slope{};
  double nothing = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    nothing += left_of(felt, shown, i, 0, 0.0, most);
    for (std::size_t j = 0; j < 3; ++j) {
      slope[i][j] = moved[j] ? slope_of(felt, shown, i, j) : 0.0;
      cost[i][j] = left_of(felt, shown, i, j, slope[i][j], most);
    }
  }
  seen.along = permutations[best_of(cost, clearly * nothing)];
  for (std::size_t i = 0; i < 3; ++i) {
    seen.ratio[i] = moved[seen.along[i]] ? slope[i][seen.along[i]] : std::nan("");
    seen.misfit += cost[i][seen.along[i]] / nothing;
  }
  return seen;
}

namespace {

std::array<std::string, 3> names_of(Kind kind, const std::array<std::string, 3>& channels) {
  std::array<std::string, 3> names = channels;
  for (std::size_t i = 0; i < 3; ++i)
    if (names[i].empty()) names[i] = role_of(kind, i);
  return names;
}

Finding error(std::string message) { return {Finding::Severity::error, std::move(message), ""}; }

bool even(const std::array<std::size_t, 3>& along) {
  return along == permutations[0] || along == permutations[3] || along == permutations[4];
}

/// "accelerometer_x and accelerometer_y look exchanged", or where each lies.
std::string exchange_of(const AxesSeen& seen, const std::array<std::string, 3>& names) {
  if (seen.along == permutations[0]) return "";
  for (std::size_t i = 0; i < 3; ++i)
    if (seen.along[i] == i) {
      const std::size_t a = i == 0 ? 1 : 0, b = i == 2 ? 1 : 2;
      return fmt::format("{} and {} look exchanged", names[a], names[b]);
    }
  std::vector<std::string> all;
  for (std::size_t i = 0; i < 3; ++i) all.push_back(fmt::format("{} shows {}", names[i], letters[seen.along[i]]));
  return fmt::format("the axes look turned on: {}", fmt::join(all, ", "));
}

std::string axes_in_words(Kind kind, const AxesSeen& seen, const std::array<std::string, 3>& names) {
  std::vector<std::string> reversed, parts;
  for (std::size_t i = 0; i < 3; ++i)
    if (seen.ratio[i] < 0.0) reversed.push_back(names[i]);
  if (const auto exchanged = exchange_of(seen, names); !exchanged.empty()) parts.push_back(exchanged);
  if (reversed.size() == 3 && parts.empty())
    return kind == Kind::accelerometer
               ? "all three accelerometers show the specific force with the opposite sign: the sign of gravity is "
                 "inverted. Here an accelerometer at rest whose axis points up shows +1 g; change the sign of all three"
               : "all three gyros show the angular rate with the opposite sign: rates are positive for right-handed "
                 "turns here; change the sign of all three, or does the table count its angles the other way?";
  if (!reversed.empty())
    parts.push_back(fmt::format("{} {} reversed", fmt::join(reversed, " and "), reversed.size() == 1 ? "is" : "are"));
  if (parts.empty()) return "";
  const bool right_handed = even(seen.along) == (reversed.size() % 2 == 0);
  return fmt::format(
      "{}{}. {}", fmt::join(parts, ", and "), right_handed ? "" : ": the triad is left-handed",
      right_handed ? "Set them right under [channels] and in the sign of the data, or turn the unit in the plan "
                     "(mount_roll, mount_pitch, mount_yaw)"
                   : "Set them right under [channels] and in the sign of the data; no mounting makes a left-handed "
                     "triad right-handed");
}

struct Mistaken {
  double ratio;
  const char* what;
};

/// A unit taken for another: what is shown for a unit felt.
std::string units_in_words(Kind kind, const AxesSeen& seen) {
  constexpr double g = standard_gravity;
  static constexpr Mistaken rates[] = {{degrees_per_radian, "values in deg/s are read as rad/s"},
                                       {1.0 / degrees_per_radian, "values in rad/s are read as deg/s"},
                                       {hour, "values in deg/h are read as deg/s"},
                                       {1.0 / hour, "values in deg/s are read as deg/h"},
                                       {1e3, "values in thousandths are read as whole units"},
                                       {1e-3, "values in whole units are read as thousandths"}};
  static constexpr Mistaken forces[] = {{g, "values in m/s^2 are read as g"},
                                        {1.0 / g, "values in g are read as m/s^2"},
                                        {1e3, "values in mg are read as g"},
                                        {1e-3, "values in g are read as mg"}};
  std::vector<double> sizes;
  for (const double ratio : seen.ratio)
    if (!std::isnan(ratio)) sizes.push_back(std::abs(ratio));
  if (sizes.empty()) return "";
  const double size = median(sizes);
  const auto all = kind == Kind::gyro ? std::span<const Mistaken>(rates) : std::span<const Mistaken>(forces);
  for (const auto& one : all)
    if (std::abs(size / one.ratio - 1.0) < 0.15)
      return fmt::format("the {}s show {:.4g} times what was felt: {}, it seems; correct the unit of the columns",
                         kind == Kind::gyro ? "gyro" : "accelerometer", size, one.what);
  if (size > 0.5 && size < 2.0) return "";
  return fmt::format(
      "the {}s show {:.4g} times what was felt: correct the unit of the columns or the scale factor in [settings]; a "
      "ratio that is the sample rate or its inverse means increments taken for rates, or the other way round",
      kind == Kind::gyro ? "gyro" : "accelerometer", size);
}

}  // namespace

Findings about_axes(Kind kind, const AxesSeen& seen, const std::array<std::string, 3>& channels) {
  Findings findings;
  for (const auto& text : {axes_in_words(kind, seen, names_of(kind, channels)), units_in_words(kind, seen)})
    if (!text.empty()) findings.push_back(error(text));
  return findings;
}

namespace {

Vector3 read_along(const AxesSeen& seen, Vector3 felt) {
  std::array<double, 3> out{};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = std::isnan(seen.ratio[i]) ? component(felt, i) : seen.ratio[i] * component(felt, seen.along[i]);
  return {out[0], out[1], out[2]};
}

/// The names as they are, with the size that fits most segments.
AxesSeen as_named(std::span<const Vector3> felt, std::span<const Vector3> shown) {
  std::vector<double> ratios;
  for (std::size_t g = 0; g < felt.size(); ++g)
    if (norm(felt[g]) > 0.0) ratios.push_back(norm(shown[g]) / norm(felt[g]));
  AxesSeen seen;
  seen.ratio.fill(median(ratios));
  return seen;
}

Findings about_order(const AxesSeen& seen, std::span<const Vector3> felt, std::span<const Vector3> shown,
                     const std::vector<std::string>& labels) {
  std::vector<std::string> said;
  std::size_t astray_segments = 0;
  const double most = greatest(shown);
  for (std::size_t g = 0; g < felt.size(); ++g) {
    if (!(norm(shown[g] - read_along(seen, felt[g])) > astray * most)) continue;
    ++astray_segments;
    std::size_t nearest = g;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t h = 0; h < felt.size(); ++h)
      if (const double apart = norm(shown[g] - read_along(seen, felt[h])); apart < least) {
        nearest = h;
        least = apart;
      }
    if (said.size() < 6)
      said.push_back(least < 0.5 * astray * most
                         ? fmt::format("'{}' reads as '{}' should", labels[g], labels[nearest])
                         : fmt::format("'{}' reads as no segment of the plan should", labels[g]));
  }
  if (said.empty()) return {};
  return {error(fmt::format(
      "{}{}: are the segments in the order of the plan, and were they recorded at its angles?", fmt::join(said, ", "),
      astray_segments > said.size() ? fmt::format(" and {} more", astray_segments - said.size()) : ""))};
}

}  // namespace

Findings about_triad(Kind kind, std::span<const Vector3> felt, std::span<const Vector3> shown,
                     const std::vector<std::string>& labels, const std::array<std::string, 3>& channels) {
  const AxesSeen seen = axes_seen(felt, shown);
  if (seen.misfit > unexplained) return about_order(as_named(felt, shown), felt, shown, labels);
  Findings findings = about_axes(kind, seen, channels);
  for (auto& finding : about_order(seen, felt, shown, labels)) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace tumble::imu
