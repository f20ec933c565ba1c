#include "tumble/methods/static_bias/common_course.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::static_bias {
namespace {

constexpr std::size_t fewest_power_ups = 3, fewest_blocks = 40;
constexpr std::size_t waves = 16;       ///< of half a period each
constexpr std::size_t step_parts = 10;  ///< parts of a power-up, of which a step has one on either side
constexpr double rare_course = 1e-4;    ///< probability of all that is tried, in sound tests
/// [1] of the degrees of freedom of pooled scatter that count: neighbouring steps share half of their blocks, neighbouring
/// waves have nearly the same noise and are independent.
constexpr double of_steps = 0.5;

/// What is tried of each power-up: its coefficient.
using Shape = std::vector<double>;

std::vector<Shape> waves_of(std::size_t blocks) {
  std::vector<Shape> all;
  for (std::size_t k = 1; k <= waves; ++k) {
    Shape wave;
    for (std::size_t i = 0; i < blocks; ++i)
      wave.push_back(
          std::cos(pi * static_cast<double>(k) * (static_cast<double>(i) + 0.5) / static_cast<double>(blocks)));
    all.push_back(scaled(2.0 / static_cast<double>(blocks), wave));  // the amplitude
  }
  return all;
}

std::vector<Shape> steps_of(std::size_t blocks) {
  const std::size_t side = blocks / step_parts;
  std::vector<Shape> all;
  for (std::size_t at = side; at + side <= blocks; at += side / 2) {
    Shape step(blocks, 0.0);
    for (std::size_t i = 0; i < side; ++i)
      step[at + i] = 1.0 / static_cast<double>(side), step[at - 1 - i] = -step[at + i];
    all.push_back(std::move(step));
  }
  return all;
}

/// Mean of a coefficient over the power-ups, and its variance between them.
struct Coefficient {
  double mean = 0.0, variance = 0.0;
};

Coefficient coefficient_of(const Shape& shape, const std::vector<Shape>& courses) {
  std::vector<double> all;
  for (const Shape& course : courses) all.push_back(dot(shape, course));
  const auto n = static_cast<double>(all.size());
  Coefficient out;
  for (const double one : all) out.mean += one / n;
  for (const double one : all) out.variance += (one - out.mean) * (one - out.mean) / (n - 1.0);
  return out;
}

struct Course {
  double chance = 1.0, size = 0.0;  ///< of one comparison; [u]
};

/// The rarest of some shapes. Given: reach, how many neighbours on either side have the same scatter; share of their degrees
/// of freedom that count.
Course rarest(const std::vector<Shape>& shapes, const std::vector<Shape>& courses, std::size_t reach, double share) {
  std::vector<Coefficient> all;
  for (const Shape& shape : shapes) all.push_back(coefficient_of(shape, courses));
  const auto runs = static_cast<double>(courses.size());
  Course out;
  for (std::size_t k = 0; k < all.size(); ++k) {
    double variance = 0.0, count = 0.0;
    for (std::size_t j = k - std::min(k, reach); j < std::min(all.size(), k + reach + 1); ++j)
      variance += all[j].variance, count += 1.0;
    const double freedom = (runs - 1.0) * std::max(1.0, share * count);
    const double chance = chance_of_ratio(all[k].mean * all[k].mean * runs * count / variance, 1.0, freedom);
    if (chance < out.chance) out = {chance, all[k].mean};
  }
  return out;
}

}  // namespace

Findings common_course(const std::vector<Blocks>& power_ups, const Unit& unit) {
  std::vector<Shape> courses;
  for (const Blocks& one : power_ups) {
    if (one.means.size() != power_ups.front().means.size() || one.length != power_ups.front().length) return {};
    double mean = 0.0, measured = 0.0;
    for (std::size_t i = 0; i < one.means.size(); ++i) mean += one.shares[i] * one.means[i], measured += one.shares[i];
    Shape course;
    for (std::size_t i = 0; i < one.means.size(); ++i)
      course.push_back(one.shares[i] > 0.0 ? one.means[i] - mean / measured : 0.0);
    courses.push_back(std::move(course));
  }
  const std::size_t blocks = courses.front().size();
  if (courses.size() < fewest_power_ups || blocks < fewest_blocks) return {};
  const std::vector<Shape> all_waves = waves_of(blocks), all_steps = steps_of(blocks);
  Course course = rarest(all_waves, courses, 1, 1.0);
  if (const Course step = rarest(all_steps, courses, all_steps.size(), of_steps); step.chance < course.chance)
    course = step;
  const double chance = course.chance * static_cast<double>(all_waves.size() + all_steps.size());
  if (!(chance < rare_course)) return {};
  return {{Finding::Severity::warning,
           "power_ups_share_course",
           {{"size", std::abs(course.size), unit}, {"p", std::max(1e-6, chance)}}}};
}

}  // namespace tumble::static_bias
