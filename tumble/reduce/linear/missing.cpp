#include "tumble/reduce/linear/missing.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/regression/added_terms.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/math/rounding_share.hpp"
#include "tumble/math/square.hpp"
#include "tumble/reduce/linear/boundaries.hpp"
#include "tumble/reduce/linear/courses.hpp"
#include "tumble/reduce/linear/in_time.hpp"
#include "tumble/reduce/linear/work.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::linear {
namespace {

/// [1] chance that one of all terms is found in a sound test: far below the one test in a hundred that may be accused, since
/// the noise of real instruments has longer tails than that of the tests.
constexpr double of_family = 1e-4;
/// [1] below which a term is suspected: nothing is said of it, but its shift is in the uncertainty. One sound test in 20 has
/// larger intervals by it.
constexpr double suspected = 0.05;
/// [1] share of these chances for the best of many steps and waves within the segments: where there is one it is seen far better.
constexpr double share_in_time = 0.1;
constexpr double nearly_as_likely = 3.0;  ///< logarithm of the likelihood ratio to the best term, 1 in 20
constexpr std::size_t most_alike = 6;     ///< terms whose shifts are in the uncertainty
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
  double tries = 0.0;  ///< [1] of which it is the best, by the course in time; 0: it is tried by itself
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

/// What the course within the segments shows best: a step in one of them, and a wave.
void add_in_time(const Work& work, const std::vector<Course>& courses, const std::vector<double>& left,
                 std::vector<MissingTerm>& all) {
  if (auto step = step_within(work, left); step.tries > 0.0)
    all.push_back({"output_steps", std::move(step.column),
                   [label = work.evidence.test.stretches[step.segment].label](double) {
                     return std::vector<FindingValue>{{"segment", label}};
                   },
                   false, step.tries});
  if (auto wave = wave_within(work, courses, left); wave.tries > 0.0)
    all.push_back({"output_waves", std::move(wave.column),
                   [period = wave.period](double) {
                     return std::vector<FindingValue>{{"period", period, "s"}};
                   },
                   false, wave.tries});
}

std::vector<MissingTerm> missing_terms(const Problem& problem, const Work& work, const std::vector<double>& left) {
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
  add_in_time(work, courses, left, all);
  return all;
}

/// The term that gains most, of those that are beyond chance; null: none.
struct FoundTerm {
  const MissingTerm* term = nullptr;
  AddedTerm test;
};

/// The terms that are tried, with their tests by the course within the segments and by the means of the segments.
struct Tried {
  const std::vector<MissingTerm>& all;
  std::vector<std::vector<AddedTerm>> tests;
  bool misfit =
      false;  ///< the segments that move show far more than noise: a term that explains little is no name for it

  /// By how much the chance of a term [1] is greater since there are others.
  double times(const MissingTerm& term) const {
    const auto kinds = static_cast<double>(tests.size());
    if (term.tries > 0.0) return kinds * term.tries / share_in_time;
    double count = 0.0;
    for (const auto& of_kind : tests)
      for (std::size_t k = 0; k < all.size(); ++k)
        count += of_kind[k].error_freedom > 0.0 && !(all[k].tries > 0.0) ? 1.0 : 0.0;
    return count / (1.0 - share_in_time);
  }
  bool can_explain(const AddedTerm& test) const {
    return test.error_freedom >= least_error_freedom_of_term && !(misfit && test.explained < most_of_misfit);
  }
};

/// Given: chance   [1] of all terms together
FoundTerm strongest_of(const Tried& tried, double chance) {
  FoundTerm found;
  for (const auto& of_kind : tried.tests)
    for (std::size_t k = 0; k < tried.all.size(); ++k) {
      const AddedTerm& test = of_kind[k];
      if (!tried.can_explain(test) || test.probability * tried.times(tried.all[k]) > chance) continue;
      if (!found.term || test.gain > found.test.gain) found = {&tried.all[k], test};
    }
  return found;
}

/// The others that explain nearly as much, the best first.
std::vector<FoundTerm> nearly_as_strong(const Tried& tried, const FoundTerm& best) {
  std::vector<FoundTerm> others;
  for (std::size_t k = 0; k < tried.all.size(); ++k) {
    FoundTerm other{&tried.all[k], {}};
    for (const auto& of_kind : tried.tests)
      if (tried.can_explain(of_kind[k]) && of_kind[k].gain > other.test.gain) other.test = of_kind[k];
    if (other.term != best.term && other.test.gain > best.test.gain - nearly_as_likely) others.push_back(other);
  }
  std::ranges::sort(others, std::greater(), [](const FoundTerm& other) { return other.test.gain; });
  others.resize(std::min(others.size(), most_alike - 1));
  return others;
}

/// The parameter that moves most where the term is fitted too.
struct LargestMove {
  std::size_t parameter = 0;
  double sds = 0.0;                ///< [1] of its standard uncertainty, as stated or with the term
  double coefficient = 0.0;        ///< of the term
  double chance = 1.0;             ///< [1] that so large a coefficient is none, by the whole fit with all slow noise
  std::vector<double> shift = {};  ///< [SI] of the parameters
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
    moved.shift.push_back(change);
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

/// The term that explains best what the fit leaves.
struct Explained {
  FoundTerm found;
  LargestMove moved;
  double chance = 1.0;                     ///< [1] that a sound test shows as much
  std::vector<std::vector<double>> doubt;  ///< see Solution
};

/// Shifts by the best term and by those that are nearly as likely: the data do not say which of them it is.
std::vector<std::vector<double>> doubt_by(const Work& work, const Tried& tried, const Explained& best) {
  std::vector<std::vector<double>> shifts{best.moved.shift};
  std::vector<double> likelihood{1.0};
  for (const FoundTerm& other : nearly_as_strong(tried, best.found)) {
    shifts.push_back(moved_by(work, *other.term, other.test.error_freedom).shift);
    likelihood.push_back(std::exp(other.test.gain - best.found.test.gain));
  }
  double sum = 0.0;
  for (const double one : likelihood) sum += one;
  for (std::size_t k = 0; k < shifts.size(); ++k) shifts[k] = scaled(std::sqrt(likelihood[k] / sum), shifts[k]);
  return shifts;
}

Explained explained_by(const Work& work, const std::vector<MissingTerm>& all, const std::vector<double>& left) {
  const double white = work.solution.fit.white_variance;
  Matrix columns(left.size(), all.size());
  for (std::size_t k = 0; k < all.size(); ++k) std::ranges::copy(all[k].column, column(columns, k).begin());
  const auto& findings = work.solution.findings;
  auto within = added_within_segments(work.data, left, columns, white);
  for (std::size_t k = 0; k < all.size(); ++k)
    if (all[k].slow) within[k] = {};
  const Tried tried{all,
                    {std::move(within), added_between_segments(segment_means(work.data, left, columns, white))},
                    std::ranges::find(findings, "motion_differs_from_model", &Finding::code) != findings.end()};
  for (const double chance : {of_family, suspected}) {
    const FoundTerm found = strongest_of(tried, chance);
    if (!found.term || !is_shown(work, *found.term, found.test.coefficient)) continue;
    Explained explained{found, moved_by(work, *found.term, found.test.error_freedom)};
    explained.chance = std::max(chance, explained.moved.chance * tried.times(*found.term));
    if (explained.chance <= suspected) explained.doubt = doubt_by(work, tried, explained);
    return explained;
  }
  return {};
}

/// Whether the test can be fitted with one term more: a segment at rest is one observation.
bool takes_another(const Work& work) {
  std::set<std::size_t> resting;
  std::size_t observations = 0;
  for (const std::size_t g : work.rows.segment)
    if (!work.evidence.uniform(g) || resting.insert(g).second) ++observations;
  return observations > work.data.design.columns;
}

}  // namespace

void warn_of_missing_terms(const Problem& problem, Work& work) {
  Solution& solution = work.solution;
  if (!(solution.fit.white_variance > 0.0) || misplaced(solution.findings) || !takes_another(work)) return;
  std::vector<double> left;
  for (std::size_t i = 0; i < work.data.observations.size(); ++i)
    left.push_back(work.data.observations[i] - solution.fit.fitted[i]);
  const auto all = missing_terms(problem, work, left);
  Explained best = explained_by(work, all, left);
  solution.doubt = std::move(best.doubt);
  if (!best.found.term || best.chance > of_family) return;
  std::vector<FindingValue> values = best.found.term->say(best.moved.coefficient);
  values.emplace_back("times", std::sqrt(best.found.test.ratio));
  values.emplace_back("parameter", solution.columns[best.moved.parameter].name);
  values.emplace_back("shift", best.moved.sds);
  solution.findings.push_back({best.moved.sds < moves_parameter ? Finding::Severity::info : Finding::Severity::warning,
                               best.found.term->code, std::move(values), problem.role});
}

}  // namespace tumble::linear
