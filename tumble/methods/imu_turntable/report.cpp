#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "tumble/core/budget.hpp"
#include "tumble/core/columns.hpp"
#include "tumble/math/matrix3.hpp"
#include "tumble/methods/imu_turntable/turntable.hpp"
#include "tumble/reduce/imu/error_models.hpp"
#include "tumble/reduce/linear/words.hpp"
#include "tumble/reduce/output_model.hpp"

namespace tumble::imu_turntable {
namespace {

using imu::letters;
using imu::role_of;
using linear::JointSolution;

/// A motion that would show a term of the output of this kind and axis better.
std::string advice_for(const OutputTerm& term, Kind kind, std::size_t axis) {
  const char own = letters[axis], along = letters[term.axis];
  if (term.kind == TermKind::bias) return "longer and more positions";
  if (term.kind == TermKind::second_order) return fmt::format("positions with {0} up, down and level", own);
  if (term.kind == TermKind::lever) {
    if (term.axis == axis) return fmt::format("fast turning about an axis at right angles to {}", own);
    const char third = letters[3 - axis - term.axis];
    return fmt::format("fast turning about an axis between {} and {}, or oscillation about {}", own, along, third);
  }
  if (kind == Kind::gyro && term.kind != TermKind::sensitivity)
    return fmt::format("rates of both signs about {}", along);
  return fmt::format("positions with {} up and down", along);
}

/// The parameter that is correlated most with number `p`.
std::pair<double, std::string> greatest_correlation(const Estimate& estimate, std::size_t p) {
  std::pair<double, std::string> out{0.0, ""};
  for (std::size_t q = 0; q < estimate.parameters.size(); ++q) {
    if (q == p) continue;
    const double c = estimate.covariance(p, q) / std::sqrt(estimate.covariance(p, p) * estimate.covariance(q, q));
    if (std::abs(c) > std::abs(out.first)) out = {c, estimate.parameters[q].name};
  }
  return out;
}

/// Why a term is no parameter.
std::string absence(const std::string& name, const linear::Problem& problem, const linear::Solution& solution) {
  for (const auto& dropped : solution.dropped) {
    if (problem.columns[dropped.column].name != name) continue;
    std::vector<std::string> others;
    for (std::size_t k = 0; k < problem.columns.size(); ++k)
      if (dropped.weights[k] != 0.0) others.push_back(problem.columns[k].name);
    if (!others.empty()) return fmt::format("taken as zero: not distinguished from {}", fmt::join(others, ", "));
  }
  return "not shown";
}

Table observability(const Task& task, const JointSolution& solution, const Estimate& estimate) {
  struct Row {
    std::string term, state, unit;
    double sd = std::nan(""), correlation = std::nan("");  ///< sd [unit]
    std::string with, shown_by;
  };
  std::vector<Row> rows;
  for (std::size_t o = 0; o < task.problems.size(); ++o) {
    const Kind kind = task.kinds[o / 3];
    for (const OutputTerm& term : terms_of(kind, o % 3)) {
      const std::string& name = term.name;
      Row& row = rows.emplace_back(Row{.term = name, .shown_by = advice_for(term, kind, o % 3)});
      const Parameter* parameter = find_parameter(estimate, name);
      if (!parameter) {
        row.state = absence(name, task.problems[o], solution.outputs[o]);
        row.unit = linear::terms_of("imu", defaults(find_model("imu").constants()), {name}).front().unit;
        continue;
      }
      const auto p = static_cast<std::size_t>(parameter - estimate.parameters.data());
      const auto meaning = solution.all.stands_for.find(name);
      row.state = meaning == solution.all.stands_for.end() ? "identified" : "means " + meaning->second;
      row.unit = parameter->unit.text();
      row.sd = parameter->unit.difference_from_si(standard_uncertainty(estimate, p));
      std::tie(row.correlation, row.with) = greatest_correlation(estimate, p);
    }
  }
  return tabulate(
      "observability",
      "each term as this schedule shows it, its greatest correlation, and a motion that would show it better", rows,
      {{"term", &Row::term},
       {"state", &Row::state},
       {"unit", &Row::unit},
       {"sd", &Row::sd},
       {"correlation", &Row::correlation},
       {"with", &Row::with},
       {"shown_by", &Row::shown_by}});
}

/// u = M (y - b), M = (1 + S)^-1, as a navigation computer uses them.
Table correction(const Task& task, const Estimate& estimate) {
  const auto kind = [&](std::size_t o) { return task.kinds[o / 3]; };
  const auto role = [&](std::size_t o) { return role_of(kind(o), o % 3); };
  const auto unit = [&](std::size_t o) { return Unit::parse(kind(o) == Kind::gyro ? "deg/h" : "mg"); };
  const auto of_matrix = [&](std::size_t j) {
    return [&, j](std::size_t o) { return inverse(sensitivity_of(estimate, kind(o)))(o % 3, j); };
  };
  return tabulate(
      "correction",
      "u = M (y - b): rates and specific forces from the outputs, g-sensitivity, second order and levers apart",
      3 * task.kinds.size(),
      {{"output", role},
       {"M_x", of_matrix(0)},
       {"M_y", of_matrix(1)},
       {"M_z", of_matrix(2)},
       {"b", [&](std::size_t o) { return unit(o).difference_from_si(value_of(estimate, role(o) + "_bias")); }},
       {"unit", [&](std::size_t o) { return unit(o).text(); }}});
}

Table covered(const Look& look) {
  return tabulate("covered",
                  "the greatest rates and specific forces of the test: beyond them a compensation is extrapolated", 3,
                  {{"axis", [](std::size_t i) { return std::string(1, letters[i]); }},
                   {"rate", "deg/s", [&](std::size_t i) { return imu::component(look.fastest, i); }},
                   {"specific_force", "g", [&](std::size_t i) { return imu::component(look.strongest, i); }}});
}

/// The summary of this segment for another output; null: that has none.
const linear::SegmentSummary* same_segment(const linear::Solution& solution, const linear::SegmentSummary& as,
                                           std::size_t index) {
  const auto same = [&](const linear::SegmentSummary& s) {
    return s.label == as.label && s.run == as.run && s.begin == as.begin;
  };
  if (index < solution.segments.size() && same(solution.segments[index])) return &solution.segments[index];
  const auto match = std::ranges::find_if(solution.segments, same);
  return match == solution.segments.end() ? nullptr : &*match;
}

Table positions(const Task& task, const JointSolution& solution) {
  const auto& first = solution.outputs.front().segments;
  const bool measured = std::ranges::none_of(first, [](const auto& s) { return std::isnan(s.measured); });
  NumberedColumns columns{{"label", [&](std::size_t s) { return first[s].label; }},
                          {"run", [&](std::size_t s) { return first[s].run; }},
                          {"duration", "s", [&](std::size_t s) { return first[s].duration; }}};
  for (std::size_t i = 0; i < 3; ++i)
    columns.emplace_back(fmt::format("f_{}", letters[i]), "g",
                         [&, i](std::size_t s) { return linear::without_rounding(first[s].felt.specific_force)[i]; });
  for (std::size_t i = 0; i < 3; ++i)
    columns.emplace_back(fmt::format("w_{}", letters[i]), "deg/s",
                         [&, i](std::size_t s) { return linear::without_rounding(first[s].felt.rate)[i]; });
  for (std::size_t o = 0; measured && o < task.problems.size(); ++o)
    columns.emplace_back("residual_" + task.problems[o].role, task.kinds[o / 3] == Kind::gyro ? "deg/h" : "ug",
                         [&, o](std::size_t s) {
                           const auto* same = same_segment(solution.outputs[o], first[s], s);
                           return same ? same->measured - same->predicted : std::nan("");
                         });
  return tabulate(
      "positions",
      measured ? "input of each segment (means), and the residuals of the outputs" : "input of each segment (means)",
      first.size(), columns);
}

/// The effect of a rate error is taken as linear. Where an axis off the vertical runs away by delta until the end of a
/// segment, what goes round with it is smaller by the mean of delta^2/2, delta^2/6 at the standard deviation, and that
/// of a square of a normal number is sqrt(3) times as large: it is in no column, and goes to the scale factors.
void add_second_order(const Task& task, Estimate& estimate) {
  const double variance = std::pow(task.look.run_away, 4.0) / 12.0;
  if (!(variance > 0.0)) return;
  std::vector<double> added(estimate.parameters.size(), 0.0);
  for (const Kind kind : task.kinds)
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (const auto p = parameter_index(estimate, role_of(kind, axis) + "_scale_factor_error")) added[*p] = variance;
  estimate.budget.push_back(independent_errors("rate error, second order", added));
  estimate.covariance = covariance_of(estimate.budget, added.size());
}

/// One finding for all moves between positions, of which a schedule that was searched for has many.
void say_moves(Findings& findings) {
  const auto is_move = [](const Finding& finding) {
    const auto* why = finding.code == "segment_not_used" ? std::get_if<Phrase>(&finding.values.at(1).value) : nullptr;
    return why != nullptr && why->key == "no_sample_after_settling";
  };
  const auto moves = static_cast<std::size_t>(std::ranges::count_if(findings, is_move));
  if (moves < 3) return;
  const Finding first = *std::ranges::find_if(findings, is_move);
  std::erase_if(findings, is_move);
  findings.push_back({Finding::Severity::info,
                      "moves_between_positions",
                      {},
                      "",
                      {moves, std::get<std::string>(first.values.at(0).value), {}}});
}

/// One finding in place of the engine's, of which there is one for each output.
void say_not_shown(const Task& task, const JointSolution& solution, Findings& findings) {
  std::erase_if(findings, [](const Finding& finding) { return finding.code == "not_shown"; });
  auto names = task.not_shown;
  for (std::size_t o = 0; o < task.problems.size(); ++o)
    for (const auto& dropped : solution.outputs[o].dropped)
      if (std::ranges::all_of(dropped.weights, [](double w) { return w == 0.0; }))
        names.push_back(task.problems[o].columns[dropped.column].name);
  if (names.empty()) return;
  findings.push_back({Finding::Severity::info,
                      "terms_not_shown",
                      {{"terms", fmt::format("{}", fmt::join(names, ", "))}},
                      "",
                      {names.size(), names.front(), {}}});
}

}  // namespace

double value_of(const Estimate& estimate, const std::string& name) {
  const Parameter* parameter = find_parameter(estimate, name);
  return parameter ? parameter->value : 0.0;
}

Matrix3 sensitivity_of(const Estimate& estimate, Kind kind) {
  Matrix3 s = identity3();
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      s(i, j) += value_of(estimate, role_of(kind, i) + (i == j ? std::string("_scale_factor_error")
                                                               : fmt::format("_misalignment_{}", letters[j])));
  return s;
}

std::vector<OutputModel> models_of(const Task& task, const JointSolution& solution, const Estimate& estimate) {
  const auto range = [&](const Term& term, Kind) {
    for (const auto& alone : solution.outputs)
      for (std::size_t j = 0; j < alone.columns.size(); ++j)
        if (alone.columns[j].name == term.name) return std::pair{alone.least[j], alone.greatest[j]};
    return std::pair{0.0, 0.0};
  };
  auto models = imu::models_of(estimate, range);
  for (OutputModel& model : models) {
    const auto output = std::ranges::find(solution.outputs, model.role,
                                          [](const linear::Solution& alone) { return alone.output.role; });
    if (output != solution.outputs.end()) {  // a prediction has no channels
      model.recorded = output->output.recorded;
      model.nominal = output->output.nominal;
    }
    imu::set_covered(task.look.fastest, task.look.strongest, model);
  }
  return models;
}

Estimate answer_of(const Task& task, const JointSolution& solution) {
  Estimate estimate = linear::estimate_of(solution.all);
  add_second_order(task, estimate);
  gather_small(estimate);
  for (std::size_t o = 0; o < task.problems.size(); ++o) {
    const std::size_t before = estimate.findings.size();
    linear::warn_of_misfit(solution.outputs[o], task.kinds[o / 3] == Kind::gyro ? "deg/h" : "ug", estimate.findings);
    for (std::size_t f = before; f < estimate.findings.size(); ++f) estimate.findings[f].where = task.problems[o].role;
  }
  say_not_shown(task, solution, estimate.findings);
  say_moves(estimate.findings);
  estimate.tables.push_back(observability(task, solution, estimate));
  estimate.tables.push_back(correction(task, estimate));
  estimate.tables.push_back(positions(task, solution));
  if (auto errors = linear::rig_errors(solution); !errors.rows.empty()) estimate.tables.push_back(std::move(errors));
  estimate.tables.push_back(covered(task.look));
  estimate.models = models_of(task, solution, estimate);
  return estimate;
}

}  // namespace tumble::imu_turntable
