#include <algorithm>
#include <cmath>

#include "tumble/methods/method.hpp"
#include "tumble/methods/rlg_lock_in/dead_band.hpp"
#include "tumble/methods/rlg_lock_in/departures.hpp"
#include "tumble/methods/rlg_lock_in/random_walk.hpp"
#include "tumble/methods/rlg_lock_in/report.hpp"
#include "tumble/methods/rlg_lock_in/small_counts.hpp"
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
  return {
      word("dither", {"off", "on", "by_label"})
          .otherwise("off")
          .says("segments in which the dither runs: none, all, or those whose label begins with \"dither\""),
      integer("edges").between(1, 4).otherwise("1").says("counts a fringe: 1, 2 or 4"),
      quantity("settling", "s")
          .at_least(0)
          .otherwise("1 s")
          .says("time that is skipped in each segment after the rig has settled"),
      quantity("edge_margin", "%")
          .above(0)
          .otherwise("5 %")
          .says("share of W_L; the fit does not use rates nearer to the edge of the dead band than this"),
      quantity("scale_factor", "pulse/arcsec").above(0).says("K in fringes, where no rates of the test show it"),
      quantity("dither_rate", "deg/s").above(0).says("W_A, to compare the random walk with (4.27)"),
      quantity("dither_rate_sd", "%")
          .at_least(0)
          .otherwise("1 %")
          .says("relative standard uncertainty of the dither rate"),
      quantity("other_random_walk", "deg/sqrt(h)")
          .at_least(0)
          .otherwise("0 deg/sqrt(h)")
          .says("white noise that is not due to lock-in"),
  };
}

/// A range cannot say this.
void refuse_three_edges(const Settings& settings) {
  if (settings.integer("edges") == 3)
    throw Error(Error::Kind::bad_input, "[settings] edges = 3, but a fringe gives 1, 2 or 4 counts");
}

DeadBandOptions dead_band_options(const Settings& settings) {
  return {.margin = settings.number("edge_margin"), .edges = settings.integer("edges")};
}

bool any(const Sweep& sweep, bool dithered) {
  return std::ranges::any_of(sweep.points, [&](const Point& point) { return point.dithered == dithered; });
}

/// Beats in the dead band: the dither was on, or the lock-in rate is not constant. Rates at its edge.
void append_findings(const Sweep& sweep, const DeadBand& band, int edges, Findings& findings) {
  Occurrences beats{0, {}, {}};
  double worst = 0.0;
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    const Point& point = sweep.points[i];
    const double fringes = point.beat * point.duration;
    if (band.why_not[i] != "in the dead band" || !(std::abs(fringes) > 2.0 + 2.0 / edges)) continue;
    if (beats.count++ == 0) beats.first = point.label;
    if (std::abs(fringes) > std::abs(worst)) beats.worst = point.label, worst = fringes;
  }
  if (beats.count > 0) findings.push_back({Severity::warning, "beat_in_dead_band", {{"fringes", worst}}, "", beats});
  if (const auto rates = std::ranges::count(band.why_not, "at the edge"); rates > 0)
    findings.push_back({Severity::info, "rates_at_edge_of_dead_band", {{"rates", rates}}});
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  report(progress, 0.0, "lock-in");
  const Settings& settings = evidence.plan.settings;
  refuse_three_edges(settings);
  const Sweep sweep = sweep_of(evidence);
  Answer answer;
  answer.findings = sweep.findings;
  for (Finding& one : small_counts_lost(sweep, settings.integer("edges"))) answer.findings.push_back(std::move(one));
  const bool moving = std::ranges::any_of(sweep.points, [](const Point& point) { return point.moving; });
  if (any(sweep, false) || moving || !settings.has("scale_factor")) {
    answer.band = fit_dead_band(sweep, dead_band_options(settings));
    append_findings(sweep, *answer.band, settings.integer("edges"), answer.findings);
    SweepDepartures departures = departures_of(sweep, dead_band_options(settings), *answer.band);
    for (Finding& one : departures.findings) answer.findings.push_back(std::move(one));
    answer.shift = std::move(departures.shift);
  }
  if (any(sweep, true)) answer.walk = beat_walk(sweep);
  if (answer.walk && !answer.walk->lines.empty())
    answer.findings.push_back({Severity::warning,
                               "dither_left_in_counts",
                               {{"frequency", answer.walk->lines.front().frequency, "Hz"},
                                {"amplitude", answer.walk->lines.front().amplitude, "pulse/s"}},
                               "",
                               {answer.walk->lines.size(), {}, {}}});
  Estimate estimate = estimate_of(answer, settings);
  if (answer.band) append_curves(sweep, *answer.band, estimate);
  report(progress, 1.0, "lock-in");
  return estimate;
}

/// The dead band alone: how well the random walk will be known depends on the length of the record.
Estimate predict(const Plan& plan) {
  refuse_three_edges(plan.settings);
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
    .summary =
        "ring laser gyro: lock-in rate and scale factor from a slow rate sweep, random walk that remains with dither",
    .source = "Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015, slides 54-56",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify,
    .predict = predict};

}  // namespace tumble::rlg_lock_in
