#include "tumble/reduce/linear/missing.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/regression/added_terms.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/math/rounding_share.hpp"
#include "tumble/math/square.hpp"
#include "tumble/reduce/linear/boundaries.hpp"
#include "tumble/reduce/linear/courses.hpp"
#include "tumble/reduce/linear/work.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::linear {
namespace {

/// [1] chance that one of all terms is found in a sound test: far below the one test in a hundred that may be accused, since
/// the noise of real instruments has longer tails than that of the tests.
constexpr double of_family = 1e-4;
/// [sd] by which a parameter must move: an interval of 95 % that is off by half its sd holds 92 %.
constexpr double moves_parameter = 0.5;
constexpr double least_error_freedom_of_term = 3.0;  ///< with fewer, F says nothing at such p
constexpr double most_of_misfit = 0.5;               ///< [1] of the squares: what explains less is not the cause
constexpr std::size_t most_steps_tried = 64;         ///< boundaries between segments
constexpr int harmonics_tried = 2;                   ///< of a turn

/// What a finding says of a term, besides its times and what it moves.
using Say = std::function<std::vector<FindingValue>(double coefficient)>;

/// A term that the model may lack.
struct MissingTerm {
  const char* code;
  std::vector<double> column;  ///< one value a row
  Say say;
  /// As slow as the noise between the segments, which is in long ones too: only their means show it.
  bool slow = false;
};

std::vector<double> column_over(const std::vector<Course>& courses, const std::function<double(const Course&)>& value) {
  std::vector<double> column;
  for (const Course& course : courses) column.push_back(value(course));
  return column;
}

double largest_output(const std::vector<Course>& courses) {
  double largest = 0.0;
  for (const Course& course : courses)
    for (const double value : course.output) largest = std::max(largest, std::abs(value));
  return largest;
}

/// An output that is not linear, or larger on one of its sides: a unit of the largest output, so that powers do not overflow.
void add_curves(const std::vector<Course>& courses, double largest, std::vector<MissingTerm>& all) {
  const auto size = [](double coefficient) { return std::vector<FindingValue>{{"size", coefficient, "ppm"}}; };
  all.push_back({"output_asymmetric",
                 column_over(courses,
                             [](const Course& course) {
                               return mean_over_course(course, course.output,
                                                       [](double value) { return 0.5 * std::abs(value); });
                             }),
                 size});
  for (const int power : {2, 3})
    all.push_back({"output_not_linear",
                   column_over(courses,
                               [=](const Course& course) {
                                 return mean_over_course(course, course.output, [=](double value) {
                                   return largest * std::pow(value / largest, power);
                                 });
                               }),
                   size});
}

/// An output that is late: to the first order in the delay, and to the second where a term has the first.
void add_lags(const std::vector<Course>& courses, std::vector<MissingTerm>& all) {
  const auto say = [](double lag) { return std::vector<FindingValue>{{"lag", lag, "s"}}; };
  all.push_back({"output_lags", column_over(courses, [](const Course& course) { return -course.slope; }), say});
  all.push_back({"output_lags", column_over(courses, [](const Course& course) { return course.bend; }),
                 [=](double coefficient) { return say(std::sqrt(std::abs(coefficient))); }});
}

/// An output that repeats with the angle of an axis.
void add_harmonics(const std::vector<Course>& courses, const std::vector<std::string>& axes,
                   std::vector<MissingTerm>& all) {
  for (std::size_t axis = 0; axis < axes.size(); ++axis)
    for (int order = 1; order <= harmonics_tried; ++order)
      for (const double phase : {0.0, 0.25}) {
        const auto wave = [=](const Course& course) {
          return mean_over_course(course, course.angles[axis],
                                  [=](double angle) { return std::cos(order * angle - two_pi * phase); });
        };
        all.push_back({"output_follows_axis", column_over(courses, wave), [=, name = axes[axis]](double) {
                         return std::vector<FindingValue>{{"axis", name}, {"order", order}};
                       }});
      }
}

/// An output that steps between two segments of one power-up.
void add_steps(const Work& work, const std::vector<Course>& courses, std::vector<MissingTerm>& all) {
  const auto& stretches = work.evidence.test.stretches;
  const std::size_t every = stretches.size() / most_steps_tried + 1;
  for (std::size_t g = 1; g < stretches.size(); g += every)
    all.push_back({"output_steps",
                   column_over(courses,
                               [&](const Course& course) {
                                 const bool same = stretches[course.segment].start == stretches[g].start;
                                 return same && course.segment >= g ? 1.0 : 0.0;
                               }),
                   [label = stretches[g].label](double) {
                     return std::vector<FindingValue>{{"segment", label}};
                   }});
}

/// A known input with another size than the plan gives it: an output that is reversed, or read in another unit.
void add_known_input(const Work& work, std::vector<MissingTerm>& all) {
  if (work.rows.input.empty()) return;
  all.push_back({"known_input_differs", work.rows.input, [](double coefficient) {
                   return std::vector<FindingValue>{{"gain", 1.0 + coefficient}};
                 }});
}

void add_time_term(const std::vector<Course>& courses, std::vector<MissingTerm>& all) {
  const auto [first, last] = std::ranges::minmax(courses, {}, &Course::time);
  const double length = last.time - first.time;
  if (!(length > 0.0)) return;
  all.push_back({"output_drifts_along_test",
                 column_over(courses, [=](const Course& course) { return course.time / length; }),
                 [=](double) {
                   return std::vector<FindingValue>{{"length", length, "s"}};
                 },
                 true});
}

std::vector<MissingTerm> missing_terms(const Problem& problem, const Work& work) {
  std::vector<double> coefficients(problem.columns.size(), 0.0);
  for (std::size_t k = 0; k < work.used.size(); ++k) coefficients[work.used[k]] = work.solution.fit.parameters[k];
  const auto axes = turning_axes(work.evidence.test);
  const auto courses = output_courses(work.evidence, problem, work.rows, coefficients, axes);
  std::vector<MissingTerm> all;
  if (const double largest = largest_output(courses); largest > 0.0) add_curves(courses, largest, all);
  add_known_input(work, all);
  add_lags(courses, all);
  add_time_term(courses, all);
  add_harmonics(courses, axes, all);
  add_steps(work, courses, all);
  return all;
}

/// The term that gains most, of those that are beyond chance; null: none.
struct FoundTerm {
  const MissingTerm* term = nullptr;
  AddedTerm test;
};

/// Given: tests    of each term: by the course within the segments, by their means
///        misfit   whether the segments that move show far more than noise: a term that explains little of it is no name
/// for it
FoundTerm strongest_of(const std::vector<MissingTerm>& all, std::vector<std::vector<AddedTerm>> tests, bool misfit) {
  for (std::size_t k = 0; k < all.size(); ++k)
    if (all[k].slow) tests.front()[k] = {};
  double count = 0.0;
  for (const auto& of_kind : tests)
    for (const AddedTerm& test : of_kind) count += test.error_freedom > 0.0 ? 1.0 : 0.0;
  FoundTerm found;
  for (const auto& of_kind : tests)
    for (std::size_t k = 0; k < all.size(); ++k) {
      const AddedTerm& test = of_kind[k];
      if (test.error_freedom < least_error_freedom_of_term || test.probability * count > of_family) continue;
      if (misfit && test.explained < most_of_misfit) continue;
      if (!found.term || test.gain > found.test.gain) found = {&all[k], test};
    }
  return found;
}

/// The parameter that moves most where the term is fitted too.
struct LargestMove {
  std::size_t parameter = 0;
  double sds = 0.0;          ///< [1] of its standard uncertainty, as stated or with the term
  double coefficient = 0.0;  ///< of the term
  double chance = 1.0;       ///< [1] that so large a coefficient is none, by the whole fit with all slow noise
};

/// Given: freedom   [1] of the error, at most
LargestMove moved_by(const Work& work, const MissingTerm& term, double freedom) {
  MixedData data = work.data;
  const std::size_t p = data.design.columns;
  data.design = beside(data.design, as_column(term.column));
  const MixedFit with = fit_mixed_model(data);
  const MixedFit& without = work.solution.fit;
  LargestMove moved{.coefficient = with.parameters[p]};
  std::vector<double> itself(p + 1, 0.0);
  itself[p] = 1.0;
  moved.chance = chance_of_ratio(square(moved.coefficient) / with.covariance(p, p), 1.0,
                                 std::min(degrees_of_freedom(with, itself), freedom));
  for (std::size_t j = 0; j < p; ++j) {
    // the misfit that the term explains has made the stated uncertainty larger
    const double sd = std::sqrt(std::min(without.covariance(j, j), with.covariance(j, j)));
    const double change = with.parameters[j] - without.parameters[j];
    if (sd > 0.0 && std::abs(change) > moved.sds * sd) moved.parameter = j, moved.sds = std::abs(change) / sd;
  }
  return moved;
}

/// Whether what the term does is more than rounding.
bool is_shown(const Work& work, const MissingTerm& term, double coefficient) {
  double most = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < term.column.size(); ++i) {
    most = std::max(most, std::abs(coefficient * term.column[i]));
    largest = std::max(largest, std::abs(work.rows.output[i]));
  }
  return most > rounding_share * largest;
}

}  // namespace

void warn_of_missing_terms(const Problem& problem, Work& work) {
  Solution& solution = work.solution;
  const double white = solution.fit.white_variance;
  if (!(white > 0.0) || misplaced(solution.findings)) return;
  const auto all = missing_terms(problem, work);
  std::vector<double> left;
  for (std::size_t i = 0; i < work.data.observations.size(); ++i)
    left.push_back(work.data.observations[i] - solution.fit.fitted[i]);
  Matrix columns(left.size(), all.size());
  for (std::size_t k = 0; k < all.size(); ++k) std::ranges::copy(all[k].column, column(columns, k).begin());
  const bool misfit =
      std::ranges::find(solution.findings, "motion_differs_from_model", &Finding::code) != solution.findings.end();
  const FoundTerm found = strongest_of(all,
                                       {added_within_segments(work.data, left, columns, white),
                                        added_between_segments(segment_means(work.data, left, columns, white))},
                                       misfit);
  if (!found.term || !is_shown(work, *found.term, found.test.coefficient)) return;
  const LargestMove moved = moved_by(work, *found.term, found.test.error_freedom);
  if (moved.chance * static_cast<double>(2 * all.size()) > of_family) return;
  std::vector<FindingValue> values = found.term->say(moved.coefficient);
  values.emplace_back("times", std::sqrt(found.test.ratio));
  values.emplace_back("parameter", solution.columns[moved.parameter].name);
  values.emplace_back("shift", moved.sds);
  solution.findings.push_back({moved.sds < moves_parameter ? Finding::Severity::info : Finding::Severity::warning,
                               found.term->code, std::move(values), problem.role});
}

}  // namespace tumble::linear
