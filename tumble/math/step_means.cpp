#include "tumble/math/step_means.hpp"

#include <algorithm>

#include "tumble/math/square.hpp"

namespace tumble {
namespace {

constexpr double kink_of_bends = 16.0;  ///< [bends beside] chosen: bends of a smooth course differ by less

/// d2 and d4 of a signal: one neighbour is needed on either side, or two.
struct Differences {
  std::span<const double> v;

  double second(std::size_t j) const { return (v[j - 1] - v[j]) + (v[j + 1] - v[j]); }
  double fourth(std::size_t j) const { return (second(j - 1) - second(j)) + (second(j + 1) - second(j)); }
};

/// |d2|^2 over all signals; 0 at the ends.
std::vector<double> bends(std::span<const std::array<double, 6>> signals) {
  std::vector<double> out(signals.size(), 0.0);
  for (std::size_t j = 1; j + 1 < signals.size(); ++j)
    for (std::size_t s = 0; s < signals[j].size(); ++s)
      out[j] += square((signals[j - 1][s] - signals[j][s]) + (signals[j + 1][s] - signals[j][s]));
  return out;
}

/// 1 where there is a kink; of the ends nothing is known.
std::vector<char> kinks(std::span<const std::array<double, 6>> signals) {
  const auto bend = bends(signals);
  std::vector<char> out(signals.size(), 0);
  for (std::size_t j = 2; j + 2 < signals.size(); ++j)
    out[j] = bend[j] > kink_of_bends * std::max(bend[j - 2], bend[j + 2]) ? 1 : 0;
  return out;
}

/// At step j, by the parabola through d2 at `in` and beside it.
double extrapolated(const Differences& d, std::size_t j, std::size_t in) {
  const double left = d.second(in - 1), middle = d.second(in), right = d.second(in + 1);
  const double fourth = d.fourth(in), off = static_cast<double>(j) - static_cast<double>(in);
  return (middle + 0.5 * off * (right - left) + 0.5 * off * off * fourth) / 24.0 - 17.0 / 5760.0 * fourth;
}

/// What the mean over step j differs by from the value in its middle.
double correction(const Differences& d, StepCourse course, std::size_t j) {
  constexpr double of_second = 1.0 / 24.0, of_fourth = -17.0 / 5760.0;
  switch (course) {
    case StepCourse::smooth:
      return of_second * d.second(j) + of_fourth * d.fourth(j);
    case StepCourse::beside_kink:
      return of_second * d.second(j);
    case StepCourse::from_before:
      return of_second * (2.0 * d.second(j - 1) - d.second(j - 2));
    case StepCourse::from_after:
      return of_second * (2.0 * d.second(j + 1) - d.second(j + 2));
    case StepCourse::first:
      return extrapolated(d, j, 2);
    case StepCourse::last:
      return extrapolated(d, j, d.v.size() - 3);
    default:
      return 0.0;
  }
}

}  // namespace

std::vector<StepCourse> courses_of(std::span<const std::array<double, 6>> signals) {
  const auto kink = kinks(signals);
  const std::size_t size = kink.size();
  std::vector<StepCourse> courses(size, StepCourse::kinked);
  const auto kinks_in = [&](std::size_t from, std::size_t to) {
    return std::any_of(kink.begin() + static_cast<std::ptrdiff_t>(from), kink.begin() + static_cast<std::ptrdiff_t>(to),
                       [](char k) { return k != 0; });
  };
  if (size >= 5) {
    if (!kinks_in(2, std::min<std::size_t>(5, size - 2))) courses[0] = courses[1] = StepCourse::first;
    if (!kinks_in(size < 7 ? 2 : size - 5, size - 2)) courses[size - 1] = courses[size - 2] = StepCourse::last;
  }
  for (std::size_t j = 2; j + 2 < size; ++j) {
    const bool before = kink[j - 1] != 0, after = kink[j + 1] != 0;
    if (kink[j] == 0)
      courses[j] = before || after ? StepCourse::beside_kink : StepCourse::smooth;
    else if (after && !before && j >= 3)
      courses[j] = StepCourse::from_before;
    else if (before && !after && j + 3 < size)
      courses[j] = StepCourse::from_after;
  }
  return courses;
}

void means_from_middles(std::span<const double> middles, std::span<const StepCourse> courses, std::size_t before,
                        std::span<double> means) {
  const Differences differences{middles};
  for (std::size_t k = 0; k < means.size(); ++k)
    means[k] = middles[before + k] + correction(differences, courses[before + k], before + k);
}

}  // namespace tumble
