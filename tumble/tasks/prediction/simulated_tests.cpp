#include "tumble/tasks/prediction/simulated_tests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "tumble/core/budget.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/square.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble::prediction {
namespace {

/// The scatter of so many values is known to 10 %, and together with what each test states to 8 %.
constexpr std::size_t most_tests = 48;
/// [tests] Weight of the stated variances beside the scatter of the values: chosen, a dozen tests.
constexpr double weight_of_stated = 12.0;
constexpr std::size_t fewest_tests = 4;         ///< of a large test: where the variance of one is known better
constexpr std::size_t steps_of_all = 1 << 23;   ///< of all channels, for one prediction: some seconds of a processor
constexpr std::size_t largest_test = 1 << 30;   ///< [byte] that one test may take in memory
constexpr std::uint64_t first_seed = 20251129;  ///< chosen: any that people do not type
constexpr std::uint64_t apart = 1000;           ///< seeds of the parts of one test: more than there are tests

/// The tests that have to be simulated for one result: that of the plan, and those of recordings with their own.
std::vector<std::shared_ptr<const Plan>> parts_of(const Plan& plan) {
  std::vector<std::shared_ptr<const Plan>> parts;
  bool whole = false;
  for (const auto& entry : plan.recordings) {
    if (entry.plan || !whole) parts.push_back(entry.plan);
    whole = whole || !entry.plan;
  }
  if (parts.empty()) parts.push_back(nullptr);
  return parts;
}

std::size_t size_of(const Plan& plan, const std::vector<std::shared_ptr<const Plan>>& parts) {
  std::size_t size = 0;
  for (const auto& part : parts) size += simulated_size(part ? *part : plan);
  return size;
}

std::vector<std::string> names_of(const Estimate& estimate) {
  std::vector<std::string> names;
  for (const auto& parameter : estimate.parameters) names.push_back(parameter.name);
  return names;
}

/// The tests that show the same parameters as most of them do.
std::vector<Estimate> alike(std::vector<Estimate> all) {
  std::map<std::vector<std::string>, std::size_t> count;
  for (const auto& one : all) ++count[names_of(one)];
  const auto most = std::ranges::max_element(count, {}, [](const auto& entry) { return entry.second; })->first;
  std::erase_if(all, [&](const Estimate& one) { return names_of(one) != most; });
  return all;
}

/// Of a number of each estimate.
template <class Number>
double mean_of(const std::vector<Estimate>& all, Number number) {
  double sum = 0.0;
  for (const auto& one : all) sum += number(one);
  return sum / static_cast<double>(all.size());
}

template <class Number>
double median_of(const std::vector<Estimate>& all, Number number) {
  std::vector<double> values;
  for (const auto& one : all) values.push_back(number(one));
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// With the values of [truth] where it has them.
std::vector<Parameter> parameters_of(const std::vector<Estimate>& all, const Settings& truth) {
  auto out = all.front().parameters;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto of = [i](const Estimate& one) -> const Parameter& { return one.parameters[i]; };
    Parameter& parameter = out[i];
    const double mean = mean_of(all, [&](const Estimate& one) { return of(one).value; });
    parameter.value = truth.texts().contains(parameter.name) ? truth.number(parameter.name) : mean;
    parameter.degrees_of_freedom = median_of(all, [&](const Estimate& one) { return of(one).degrees_of_freedom; });
    parameter.lower =
        parameter.value - mean_of(all, [&](const Estimate& one) { return of(one).value - of(one).lower; });
    parameter.upper =
        parameter.value + mean_of(all, [&](const Estimate& one) { return of(one).upper - of(one).value; });
  }
  return out;
}

/// Each line as the mean of its covariances. Errors that other results share stay the same draws: their shifts are
/// averaged.
std::vector<Contribution> budget_of(const std::vector<Estimate>& all) {
  const double tests = static_cast<double>(all.size());
  std::vector<Contribution> out;
  for (const auto& one : all)
    for (const auto& line : one.budget) {
      const bool shared = !line.key.empty();
      const auto same = std::ranges::find_if(out, [&](const Contribution& other) {
        return other.source == line.source && other.key == line.key &&
               (!shared || other.factor.columns == line.factor.columns);
      });
      const Matrix part = (shared ? 1.0 / tests : 1.0 / std::sqrt(tests)) * line.factor;
      if (same == out.end())
        out.push_back({line.source, line.key, part});
      else if (shared)
        same->factor += part;
      else {
        auto& wide = same->factor;
        wide.values.insert(wide.values.end(), part.values.begin(), part.values.end());
        wide.columns += part.columns;
        wide = narrowed(std::move(wide));
      }
    }
  return out;
}

/// [1] Median over mean of a variance that is estimated with so many degrees of freedom (Wilson and Hilferty).
double median_of_variance(double freedom) {
  const double cube_root = 1.0 - 2.0 / (9.0 * std::max(1.0, freedom));
  return cube_root * cube_root * cube_root;
}

/// Scales the variance of each parameter to what its values scatter by and to the median of what tests state: one that is
/// stated with few degrees of freedom is much too large in one test and a little too small in the next, and a test that is
/// doubtful states several times as much as others. One that is stated with many may contain what a simulated test does
/// not draw (a data sheet): that values scatter less makes it little smaller.
void scale_to_scatter(const std::vector<Estimate>& all, Estimate& out) {
  const double tests = static_cast<double>(all.size());
  if (all.size() < 2) return;
  const Matrix stated = covariance_of(out.budget, out.parameters.size());
  for (std::size_t i = 0; i < out.parameters.size(); ++i) {
    Parameter& parameter = out.parameters[i];
    const double mean = mean_of(all, [i](const Estimate& one) { return one.parameters[i].value; });
    const double squares = mean_of(all, [&](const Estimate& one) { return square(one.parameters[i].value - mean); });
    const double freedom = parameter.degrees_of_freedom;
    const double usual =
        median_of(all, [i](const Estimate& one) { return one.covariance(i, i); }) / median_of_variance(freedom);
    if (!(stated(i, i) > 0.0) || !(usual > 0.0) || !std::isfinite(squares)) continue;
    const double ratio = squares * tests / (tests - 1.0) / usual;
    const double weight = ratio < 1.0 ? std::max(weight_of_stated, freedom) : weight_of_stated;
    const double scattered = std::isinf(weight) ? 1.0 : (weight + tests * ratio) / (weight + tests);
    const double scale = std::sqrt(scattered * usual / stated(i, i));
    for (auto& line : out.budget)
      for (std::size_t k = 0; k < line.factor.columns; ++k) line.factor(i, k) *= scale;
    parameter.lower = parameter.value + scale * (parameter.lower - parameter.value);
    parameter.upper = parameter.value + scale * (parameter.upper - parameter.value);
  }
}

struct Tests {
  std::vector<Estimate> all;
  Problems refused;  ///< why the first of those that are not among them was
};

/// On all processors.
Tests tests_of(const Plan& plan, std::size_t count) {
  std::vector<std::optional<Estimate>> made(count);
  std::vector<Problems> refused(count);
  parallel_for(count, [&](std::size_t i) {
    try {
      made[i] = simulated_test(plan, first_seed + i);
    } catch (const Error& error) {
      if (error.kind != Error::Kind::bad_data && error.kind != Error::Kind::bad_input) throw;
      refused[i] = error.problems;
    }
  });
  Tests out;
  for (std::size_t i = 0; i < count; ++i) {
    if (made[i]) out.all.push_back(std::move(*made[i]));
    if (out.refused.empty()) out.refused = refused[i];
  }
  return out;
}

/// What half of the tests call an error: their values are not to be relied on.
void add_errors(const std::vector<Estimate>& all, Findings& findings) {
  std::map<std::string, std::size_t> count;
  for (const auto& one : all)
    for (const auto& finding : one.findings)
      if (finding.severity == Finding::Severity::error && ++count[finding.code + finding.where] == (all.size() + 1) / 2)
        findings.push_back(finding);
}

}  // namespace

Estimate simulated_test(const Plan& plan, std::uint64_t seed) {
  Evidence evidence{plan, {}, parts_of(plan)};
  evidence.plan.recordings.clear(), evidence.plan.limits.clear(), evidence.plan.prior = {};
  for (std::size_t i = 0; i < evidence.plans.size(); ++i)
    evidence.recordings.push_back(simulate(evidence.plans[i] ? *evidence.plans[i] : plan, seed + apart * i, {}));
  return identify(std::move(evidence), {});
}

Estimate predict_by_tests(const Plan& plan) {
  const std::size_t size = std::max<std::size_t>(1, size_of(plan, parts_of(plan)));
  if (size > largest_test)
    throw Error(Error::Kind::bad_input,
                say("{}: {} is predicted from simulated tests, each of which would take {:.2g} GB; at most {:.2g} GB "
                    "are simulated: let the schedule be shorter, or the rate lower",
                    Name{plan.file}, Name{plan.method}, static_cast<double>(size) * 1e-9,
                    static_cast<double>(largest_test) * 1e-9));
  const std::size_t steps = size * static_cast<std::size_t>(oversampling_of(plan)) / sizeof(double);
  const std::size_t tests = std::clamp(steps_of_all / (steps + 1), fewest_tests, most_tests);
  auto [all, refused] = tests_of(plan, tests);
  if (2 * all.size() < tests) {
    for (auto& problem : refused)
      problem = say("{}: {} would refuse this test: {}", Name{plan.file}, Name{plan.method}, problem);
    throw Error(Error::Kind::bad_input, refused);
  }
  all = alike(std::move(all));
  Estimate out;
  out.title = all.front().title;
  out.parameters = parameters_of(all, plan.truth);
  out.budget = budget_of(all);
  scale_to_scatter(all, out);
  out.covariance = covariance_of(out.budget, out.parameters.size());
  out.fit = all.front().fit;
  gather_small(out);
  add_errors(all, out.findings);
  out.findings.push_back({Finding::Severity::info,
                          "predicted_from_tests",
                          {{"method", plan.method}, {"tests", tests}, {"alike", all.size()}}});
  return out;
}

}  // namespace tumble::prediction
