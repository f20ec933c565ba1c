#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

#include "tumble/exchange/comparison.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Severity = Finding::Severity;

/// A line of one budget and the line of another that is the same errors.
struct SharedLine {
  const Contribution *first, *second;
};

struct SharedLines {
  std::vector<SharedLine> lines;
  std::vector<std::string> unlike;  ///< sources of one key whose numbers of errors differ
};

/// Lines of one source and key, the first of a result with the first of the other and so on.
SharedLines shared_lines(const Estimate& a, const Estimate& b) {
  SharedLines shared;
  std::vector<const Contribution*> used;
  for (const auto& line : a.budget) {
    if (line.key.empty()) continue;
    for (const auto& other : b.budget) {
      if (other.key != line.key || other.source != line.source || std::ranges::find(used, &other) != used.end())
        continue;
      used.push_back(&other);
      if (line.factor.columns == other.factor.columns)
        shared.lines.push_back({&line, &other});
      else
        shared.unlike.push_back(line.source);
      break;
    }
  }
  return shared;
}

/// [SI^2] Covariance of parameter i of the first result with parameter j of the second.
double shared_covariance(const SharedLines& shared, std::size_t i, std::size_t j) {
  double sum = 0.0;
  for (const auto& [first, second] : shared.lines)
    for (std::size_t k = 0; k < first->factor.columns; ++k) sum += first->factor(i, k) * second->factor(j, k);
  return sum;
}

bool has_interval_of_its_own(const Parameter& parameter) {
  return std::isfinite(parameter.lower) && std::isfinite(parameter.upper);
}

/// [SI] Standard uncertainty towards larger (up) or smaller values, and its degrees of freedom.
struct Facing {
  double sd, degrees_of_freedom;
};

Facing facing(const Estimate& estimate, std::size_t index, bool up) {
  const Parameter& parameter = estimate.parameters[index];
  if (!has_interval_of_its_own(parameter))
    return {standard_uncertainty(estimate, index), std::max(0.0, parameter.degrees_of_freedom)};
  const double half = up ? parameter.upper - parameter.value : parameter.value - parameter.lower;
  return {half / student_quantile(0.975, INFINITY), INFINITY};
}

/// Numbers of a parameter in two results.
struct Common {
  std::size_t first, second;
};

/// E_n of a difference that has no uncertainty: infinite where the values differ by more than rounding.
double without_uncertainty(double step, double own_variance, double largest) {
  const double rounding = std::max(1e-6 * std::sqrt(own_variance), 1e-12 * largest);
  return std::abs(step) > rounding ? std::copysign(INFINITY, step) : NAN;
}

Difference difference_of(const Estimate& a, const Estimate& b, const Common& at, const SharedLines& shared) {
  const Parameter& earlier = a.parameters[at.first];
  const Parameter& later = b.parameters[at.second];
  const double step = later.value - earlier.value;
  const auto [sd_a, nu_a] = facing(a, at.first, step > 0.0);
  const auto [sd_b, nu_b] = facing(b, at.second, step < 0.0);
  const double covariance = shared_covariance(shared, at.first, at.second);
  const double own = sd_a * sd_a + sd_b * sd_b;
  double variance = own - 2.0 * covariance;
  if (variance < 1e-12 * own) variance = 0.0;  // rounding: all errors are shared
  const double spread = std::pow(sd_a, 4) / nu_a + std::pow(sd_b, 4) / nu_b;
  const double nu = spread > 0.0 ? std::max(1.0, variance * variance / spread) : INFINITY;
  const double expanded = student_quantile(0.975, nu) * std::sqrt(variance);
  const double e_n = variance > 0.0
                         ? step / expanded
                         : without_uncertainty(step, own, std::max(std::abs(earlier.value), std::abs(later.value)));
  return {earlier.name, earlier.unit, earlier.value, later.value, step, std::sqrt(variance),
          covariance,   nu,           expanded,      e_n};
}

std::vector<Common> common_of(const NamedResult& a, const NamedResult& b) {
  std::vector<Common> common;
  Problems problems;
  for (std::size_t i = 0; i < a.estimate.parameters.size(); ++i) {
    const Parameter& one = a.estimate.parameters[i];
    const auto* other = find_parameter(b.estimate, one.name);
    if (!other) continue;
    if (other->unit.dimension() != one.unit.dimension() || other->unit.offset() != one.unit.offset()) {
      problems.push_back(say("{} is in {} [{}] in {}, but in {} [{}] in {}", Name{one.name}, Name{one.unit.text()},
                             Name{name(one.unit.dimension())}, Name{a.name}, Name{other->unit.text()},
                             Name{name(other->unit.dimension())}, Name{b.name}));
      continue;
    }
    const auto j = static_cast<std::size_t>(other - b.estimate.parameters.data());
    const double known =
        one.value + other->value + standard_uncertainty(a.estimate, i) + standard_uncertainty(b.estimate, j);
    if (std::isfinite(known)) common.push_back({i, j});
  }
  if (problems.empty() && common.empty())
    problems.push_back(say("{} and {} have no parameter with a value in common", Name{a.name}, Name{b.name}));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return common;
}

/// Chi-square of all differences in the directions that the uncertainties show; scaled, since units differ.
void judge_together(ResultPair& pair, const Estimate& a, const Estimate& b, const std::vector<Common>& common,
                    const SharedLines& shared) {
  if (std::ranges::any_of(pair.differences, [](const Difference& one) { return std::isinf(one.e_n); })) {
    pair.chi_square = INFINITY, pair.rank = common.size(), pair.probability = 0.0;
    return;
  }
  const auto n = static_cast<Eigen::Index>(common.size());
  Eigen::MatrixXd covariance(n, n);
  Eigen::VectorXd step(n), scale(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& one = common[static_cast<std::size_t>(i)];
    scale(i) = std::sqrt(a.covariance(one.first, one.first) + b.covariance(one.second, one.second));
    if (scale(i) == 0.0) scale(i) = 1.0;  // known exactly: it has no part in the sum
    step(i) = pair.differences[static_cast<std::size_t>(i)].difference / scale(i);
    for (Eigen::Index j = 0; j <= i; ++j) {
      const auto& other = common[static_cast<std::size_t>(j)];
      covariance(i, j) = covariance(j, i) =
          (a.covariance(one.first, other.first) + b.covariance(one.second, other.second) -
           shared_covariance(shared, one.first, other.second) - shared_covariance(shared, other.first, one.second)) /
          (scale(i) * scale(j));
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double variance = solver.eigenvalues()(i);
    if (variance < 1e-9) continue;
    pair.chi_square += std::pow(solver.eigenvectors().col(i).dot(step), 2) / variance;
    ++pair.rank;
  }
  if (pair.rank == 0 || !std::isfinite(pair.chi_square)) return;
  // The least known of the uncertainties decides for all: the cautious side.
  double nu = INFINITY;
  for (const auto& difference : pair.differences) nu = std::min(nu, difference.degrees_of_freedom);
  const double rank = static_cast<double>(pair.rank);
  pair.probability = nu < 1e6 ? cdf(complement(boost::math::fisher_f(rank, nu), pair.chi_square / rank))
                              : cdf(complement(boost::math::chi_squared(rank), pair.chi_square));
}

void look_at_pair(const NamedResult& a, const NamedResult& b, const SharedLines& shared, std::size_t common,
                  Findings& findings) {
  const auto add = [&](Severity severity, const char* code, std::vector<FindingValue> values) {
    values.emplace_back("earlier", a.name), values.emplace_back("later", b.name);
    findings.push_back({severity, code, std::move(values)});
  };
  const Estimate &one = a.estimate, &other = b.estimate;
  if (one.instrument_serial != other.instrument_serial)
    add(Severity::warning, "results_of_two_serials",
        {{"first_serial", one.instrument_serial}, {"second_serial", other.instrument_serial}});
  if (one.instrument_model != other.instrument_model)
    add(Severity::warning, "results_of_two_models",
        {{"first_model", one.instrument_model}, {"second_model", other.instrument_model}});
  if (one.method != other.method)
    add(Severity::warning, "results_of_two_methods", {{"first_method", one.method}, {"second_method", other.method}});
  for (const auto& input : one.provenance.inputs)
    if (std::ranges::any_of(other.provenance.inputs, [&](const auto& i) { return i.sha256 == input.sha256; })) {
      add(Severity::warning, "results_of_one_recording", {{"recording", input.file}});
      break;
    }
  for (const auto& source : shared.unlike) add(Severity::warning, "shared_source_differs", {{"source", source}});
  const std::size_t missing = one.parameters.size() + other.parameters.size() - 2 * common;
  if (missing > 0) add(Severity::info, "parameters_of_one_result", {{"parameters", missing}});
}

/// Each seed draws the errors of rig, site and references anew: two simulations have none in common, nor has one with a
/// measurement.
bool simulated_apart(const Estimate& a, const Estimate& b) { return a.provenance.seed != b.provenance.seed; }

/// A change that no uncertainty stands against.
void look_at_certain_changes(const ResultPair& pair, const NamedResult& a, const NamedResult& b, Findings& findings) {
  std::vector<std::string> names;
  for (const auto& one : pair.differences)
    if (std::isinf(one.e_n)) names.push_back(one.parameter);
  if (names.empty()) return;
  findings.push_back(
      {Severity::warning,
       "change_without_uncertainty",
       {{"parameters", fmt::format("{}", fmt::join(names, ", "))}, {"earlier", a.name}, {"later", b.name}}});
}

ResultPair pair_of(const std::vector<NamedResult>& results, std::size_t earlier, std::size_t later,
                   Findings& findings) {
  const auto &a = results[earlier], &b = results[later];
  const auto common = common_of(a, b);
  const bool apart = simulated_apart(a.estimate, b.estimate);
  const SharedLines shared = apart ? SharedLines{} : shared_lines(a.estimate, b.estimate);
  if (apart && later == earlier + 1)
    findings.push_back({Severity::info,
                        a.estimate.provenance.seed && b.estimate.provenance.seed ? "simulated_apart" : "simulated_once",
                        {{"earlier", a.name}},
                        b.name});
  ResultPair pair{.earlier = earlier, .later = later, .differences = {}};
  for (const auto& at : common) pair.differences.push_back(difference_of(a.estimate, b.estimate, at, shared));
  judge_together(pair, a.estimate, b.estimate, common, shared);
  if (later == earlier + 1) look_at_pair(a, b, shared, common.size(), findings);
  look_at_certain_changes(pair, a, b, findings);
  return pair;
}

}  // namespace

Comparison compare(std::vector<NamedResult> results) {
  if (results.size() < 2) throw Error(Error::Kind::bad_input, "two results or more are needed to compare");
  Comparison comparison{.results = std::move(results), .pairs = {}, .findings = {}};
  for (const auto& [file, estimate] : comparison.results)
    for (const auto& finding : estimate.findings)
      if (finding.code == "budget_without_factors")
        comparison.findings.push_back({Severity::warning, "budget_without_factors", {}, file});
  for (std::size_t i = 1; i < comparison.results.size(); ++i)
    comparison.pairs.push_back(pair_of(comparison.results, i - 1, i, comparison.findings));
  if (comparison.results.size() > 2)
    comparison.pairs.push_back(pair_of(comparison.results, 0, comparison.results.size() - 1, comparison.findings));
  return comparison;
}

std::vector<Figure> figures_of(const Comparison& comparison) {
  std::vector<Figure> figures;
  for (const auto& parameter : comparison.results.front().estimate.parameters) {
    Figure figure{.name = parameter.name,
                  .x = {"result", {}, false},
                  .y = {parameter.name, parameter.unit, false},
                  .series = {},
                  .notes = {}};
    Figure::Series series{
        .name = parameter.name, .points = true, .x = {}, .y = {}, .lower = {}, .upper = {}, .band = "95 % interval"};
    for (std::size_t i = 0; i < comparison.results.size(); ++i) {
      const auto& [file, estimate] = comparison.results[i];
      const auto* found = find_parameter(estimate, parameter.name);
      if (!found || !std::isfinite(found->value)) break;
      const auto interval = interval95(estimate, static_cast<std::size_t>(found - estimate.parameters.data()));
      series.x.push_back(static_cast<double>(i + 1));
      series.y.push_back(parameter.unit.from_si(found->value));
      series.lower.push_back(parameter.unit.from_si(interval.lower));
      series.upper.push_back(parameter.unit.from_si(interval.upper));
      figure.notes.push_back(fmt::format("{}: {}", i + 1, file));
    }
    if (series.x.size() < comparison.results.size()) continue;
    figure.series.push_back(std::move(series));
    figures.push_back(std::move(figure));
  }
  return figures;
}

}  // namespace tumble
