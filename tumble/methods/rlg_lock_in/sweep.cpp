#include "tumble/methods/rlg_lock_in/sweep.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/reduce/linear/rows.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rlg_lock_in {
namespace {

linear::Problem problem_of(const Settings& settings) {
  linear::Problem problem;
  problem.role = "gyro";
  problem.input = Input::rate_x;
  problem.settling = settings.number("settling");
  problem.averaging = 1e9;  // a segment is one count, except where a tilted axis turns
  return problem;
}

bool has_dither(const Settings& settings, const std::string& label) {
  const std::string& how = settings.word("dither");
  return how == "on" || (how == "by_label" && label.starts_with("dither"));
}

bool turns(const Segment& segment) {
  return std::ranges::any_of(segment.axes, [](const auto& axis) { return axis.second.kind != Motion::Kind::hold; });
}

/// The weighted mean of the rows of one stretch.
Point point_of(const linear::Evidences& evidence, std::size_t stretch, const linear::Rows& rows) {
  const auto& from = evidence.test.stretches[stretch];
  Point point{.label = from.label, .run = from.run, .sample_step = from.step};
  point.moving = turns(evidence.test.power_ups[from.power_up].rig.segments[from.segment]);
  double squares = 0.0, counted = 0.0;
  for (std::size_t i = 0; i < rows.segment.size(); ++i) {
    if (rows.segment[i] != stretch) continue;
    const double w = rows.weights[i];
    point.duration += w;
    point.rate += w * rows.input[i];
    squares += w * rows.input[i] * rows.input[i];
    if (!rows.output.empty()) counted += w * rows.output[i];
  }
  point.rate /= point.duration;
  point.spread = std::sqrt(std::max(0.0, squares / point.duration - point.rate * point.rate));
  point.beat = rows.output.empty() ? std::nan("") : counted / point.duration / from.step;
  for (const double value : from.values) point.beats.push_back(value / from.step);
  return point;
}

Sweep assemble(const linear::Evidences& evidence, const linear::Problem& problem, const Settings& settings) {
  const auto rows = linear::rows_of(evidence, problem);
  const auto effects = linear::effects_of(evidence, problem, rows, {});
  Sweep sweep;
  sweep.findings = evidence.test.findings;
  for (std::size_t g = 0; g < evidence.test.stretches.size(); ++g) {
    Point point = point_of(evidence, g, rows);
    point.dithered = has_dither(settings, point.label);
    for (const auto& effect : effects) {
      double change = 0.0;
      for (std::size_t i = 0; i < rows.segment.size(); ++i)
        if (rows.segment[i] == g) change += rows.weights[i] * effect.column[i];
      point.effect.push_back(change / point.duration);
    }
    sweep.points.push_back(std::move(point));
  }
  for (const auto& effect : effects) sweep.effects.push_back({effect.source, effect.each_segment, effect.key});
  return sweep;
}

}  // namespace

Sweep sweep_of(const Evidence& evidence) {
  linear::Problem problem = problem_of(evidence.plan.settings);
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "no recording of the test");
  problem.scale = 1.0 / evidence.plan.settings.integer("edges");
  return assemble(linear::evidence_of(evidence, problem), problem, evidence.plan.settings);
}

Sweep sweep_of(const Plan& plan) {
  const linear::Problem problem = problem_of(plan.settings);
  return assemble(linear::evidence_of(plan, problem), problem, plan.settings);
}

}  // namespace tumble::rlg_lock_in
