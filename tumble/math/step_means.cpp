#include "tumble/math/step_means.hpp"

namespace tumble {
namespace {

/// d2 and d4 of a signal: one neighbour is needed on either side, or two.
struct Differences {
  std::span<const double> v;

  double second(std::size_t j) const { return (v[j - 1] - v[j]) + (v[j + 1] - v[j]); }
  double fourth(std::size_t j) const { return (second(j - 1) - second(j)) + (second(j + 1) - second(j)); }
};

/// Squares of d2 and d4 over all signals.
bool continues(std::span<const std::array<double, 6>> signals, std::size_t j) {
  if (j < 2 || j + 2 >= signals.size()) return false;
  double seconds = 0.0, fourths = 0.0;
  for (std::size_t s = 0; s < signals[j].size(); ++s) {
    const double left = (signals[j - 2][s] - signals[j - 1][s]) + (signals[j][s] - signals[j - 1][s]);
    const double middle = (signals[j - 1][s] - signals[j][s]) + (signals[j + 1][s] - signals[j][s]);
    const double right = (signals[j][s] - signals[j + 1][s]) + (signals[j + 2][s] - signals[j + 1][s]);
    const double fourth = (left - middle) + (right - middle);
    seconds += middle * middle;
    fourths += fourth * fourth;
  }
  return fourths <= 0.25 * seconds;
}

/// What the mean over step j differs by from the value in its middle.
double correction(const Differences& d, StepCourse course, std::size_t j) {
  constexpr double of_second = 1.0 / 24.0, of_fourth = -17.0 / 5760.0;
  switch (course) {
    case StepCourse::smooth:
      return of_second * d.second(j) + of_fourth * d.fourth(j);
    case StepCourse::from_before:
      return of_second * (2.0 * d.second(j - 1) - d.second(j - 2)) + of_fourth * d.fourth(j - 2);
    case StepCourse::from_after:
      return of_second * (2.0 * d.second(j + 1) - d.second(j + 2)) + of_fourth * d.fourth(j + 2);
    default:
      return 0.0;
  }
}

}  // namespace

std::vector<StepCourse> courses_of(std::span<const std::array<double, 6>> signals) {
  std::vector<char> smooth(signals.size());
  for (std::size_t j = 0; j < signals.size(); ++j) smooth[j] = continues(signals, j) ? 1 : 0;
  std::vector<StepCourse> courses(signals.size(), StepCourse::kinked);
  for (std::size_t j = 0; j < courses.size(); ++j)
    if (smooth[j] != 0)
      courses[j] = StepCourse::smooth;
    else if (j >= 2 && smooth[j - 2] != 0)
      courses[j] = StepCourse::from_before;
    else if (j + 2 < courses.size() && smooth[j + 2] != 0)
      courses[j] = StepCourse::from_after;
  return courses;
}

void means_from_middles(std::span<const double> middles, std::span<const StepCourse> courses, std::size_t before,
                        std::span<double> means) {
  const Differences differences{middles};
  for (std::size_t k = 0; k < means.size(); ++k)
    means[k] = middles[before + k] + correction(differences, courses[before + k], before + k);
}

}  // namespace tumble
