#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/say.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/rlg_lock_in/dead_band.hpp"
#include "tumble/methods/rlg_lock_in/random_walk.hpp"
#include "tumble/methods/rlg_lock_in/report.hpp"
#include "tumble/methods/rlg_lock_in/trial.hpp"
#include "tumble/models/lock_zones.hpp"
#include "tumble/models/sagnac.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rlg_lock_in {
namespace {
using Severity = Finding::Severity;

std::vector<Role> roles() {
  return {{"gyro", "pulse", true, "counts of the ring laser gyro, one number a sampling interval"}};
}

std::vector<Option> options() {
  using Type = Option::Type;
  return {
      {"dither",
       Type::word,
       "1",
       "off",
       {"off", "on", "by_label"},
       "in which segments the dither runs: none, all, or those whose label begins with \"dither\""},
      {"edges", Type::integer, "1", "1", {}, "counts a fringe: 1, 2 or 4"},
      {"settling", Type::quantity, "s", "1 s", {}, "time dropped in each segment after the rig has settled"},
      {"edge_margin", Type::quantity, "%", "5 %", {}, "of W_L: rates nearer to the edge of the dead band are left out"},
      {"scale_factor", Type::quantity, "pulse/arcsec", "", {}, "K in fringes, where no rates of the test show it"},
      {"dither_rate", Type::quantity, "deg/s", "", {}, "W_A, to compare the random walk with (4.27)"},
      {"dither_rate_sd", Type::quantity, "%", "1 %", {}, "its relative standard uncertainty"},
      {"other_random_walk", Type::quantity, "deg/sqrt(h)", "0 deg/sqrt(h)", {}, "white noise that is not of lock-in"},
  };
}

void refuse(const Settings& settings) {
  std::vector<std::string> problems;
  const int edges = settings.integer("edges");
  if (edges != 1 && edges != 2 && edges != 4)
    problems.push_back(fmt::format("[settings] edges = {}, but a fringe gives 1, 2 or 4 counts", edges));
  if (!(settings.number("edge_margin") > 0.0)) problems.push_back("[settings] edge_margin must be above zero");
  for (const char* name : {"settling", "dither_rate_sd", "other_random_walk"})
    if (settings.number(name) < 0.0) problems.push_back(fmt::format("[settings] {} must not be negative", name));
  for (const char* name : {"scale_factor", "dither_rate"})
    if (settings.has(name) && !(settings.number(name) > 0.0))
      problems.push_back(fmt::format("[settings] {} must be above zero", name));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

DeadBandOptions dead_band_options(const Settings& settings) {
  return {.margin = settings.number("edge_margin"), .edges = settings.integer("edges")};
}

bool any(const Sweep& sweep, bool dithered) {
  return std::ranges::any_of(sweep.points, [&](const Point& point) { return point.dithered == dithered; });
}

/// Beats where the counter should stand still: the dither was on, or the lock-in rate is not one number.
void append_findings(const Sweep& sweep, const DeadBand& band, int edges, Findings& findings) {
  std::size_t edge = 0;
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    const Point& point = sweep.points[i];
    edge += band.why_not[i] == "at the edge" ? 1 : 0;
    if (band.why_not[i] == "in the dead band" && std::abs(point.beat) * point.duration > 2.0 + 2.0 / edges)
      findings.push_back({Severity::warning,
                          fmt::format("{:.1f} fringes where the dead band should hold the count: was the dither on, or "
                                      "the rate not even?",
                                      point.beat * point.duration),
                          point.label});
  }
  if (edge > 0)
    findings.push_back(
        {Severity::info, say_count(edge, "rate") + " at the edge of the dead band left out (edge_margin)", ""});
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  report(progress, 0.0, "lock-in");
  const Settings& settings = evidence.plan.settings;
  refuse(settings);
  const Sweep sweep = sweep_of(evidence);
  Answer answer;
  answer.findings = sweep.findings;
  const bool moving = std::ranges::any_of(sweep.points, [](const Point& point) { return point.moving; });
  if (any(sweep, false) || moving || !settings.has("scale_factor")) {
    answer.band = fit_dead_band(sweep, dead_band_options(settings));
    append_findings(sweep, *answer.band, settings.integer("edges"), answer.findings);
  }
  if (any(sweep, true)) answer.walk = beat_walk(sweep);
  Estimate estimate = estimate_of(answer, settings);
  if (answer.band) append_curves(sweep, *answer.band, estimate);
  estimate.method = "rlg_lock_in";
  estimate.title = evidence.plan.title;
  estimate.instrument_model = evidence.plan.instrument_model;
  estimate.instrument_serial = evidence.plan.instrument_serial;
  report(progress, 1.0, "lock-in");
  return estimate;
}

/// The dead band alone: how well the random walk will be known depends on the length of the record.
Estimate predict(const Plan& plan) {
  refuse(plan.settings);
  if (plan.instrument_model != "ring_laser_gyro" || plan.truth.texts().empty())
    throw Error(Error::Kind::bad_input,
                "to predict, the plan needs [instrument] model = \"ring_laser_gyro\" and [truth]");
  const Settings& truth = plan.truth;
  Answer answer;
  answer.band =
      predict_dead_band(sweep_of(plan), dead_band_options(plan.settings), ring_laser_scale_factor(truth),
                        truth.number("bias"), truth.number("lock_in_rate"), truth.number("angle_random_walk"));
  return estimate_of(answer, plan.settings);
}

}  // namespace

extern const Method rlg_lock_in{
    .name = "rlg_lock_in",
    .summary = "ring laser gyro: lock-in rate and scale factor from a slow rate sweep, random walk left by dither",
    .source = "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 54-56",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify,
    .trial = trial,
    .compensate = nullptr,
    .predict = predict};

}  // namespace tumble::rlg_lock_in
