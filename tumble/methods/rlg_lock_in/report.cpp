#include "tumble/methods/rlg_lock_in/report.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/models/lock_in.hpp"
#include "tumble/models/lock_zones.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rlg_lock_in {
namespace {

using Severity = Finding::Severity;

constexpr double agrees_within_sd = 3.0;  ///< [sd] p = 0.3 %

double dof_of(const MixedFit& fit, std::size_t index) {
  if (fit.component_covariance.empty()) return std::numeric_limits<double>::infinity();
  std::vector<double> unit(fit.parameters.size(), 0.0);
  unit[index] = 1.0;
  return degrees_of_freedom(fit, unit);
}

/// Indices of the parameters that (1/K, b, W_L) of the fit became, and factors d parameter/d fitted.
struct Placed {
  std::vector<std::size_t> at;
  std::vector<double> factor;
};

std::size_t add(Parameter parameter, Estimate& estimate) {
  estimate.parameters.push_back(std::move(parameter));
  return estimate.parameters.size() - 1;
}

Placed add_band(const DeadBand& band, Estimate& estimate) {
  Placed placed{std::vector<std::size_t>(band.fit.parameters.size()), std::vector<double>(band.fit.parameters.size())};
  if (placed.at.size() > 2) {
    placed.at[2] = add({"lock_in_rate", "W_L", Unit::parse("deg/h"), band.lock_in_rate,
                        "half width of the dead band without dither", dof_of(band.fit, 2)},
                       estimate);
    placed.factor[2] = 1.0;
  }
  placed.at[0] = add({"scale_factor", "K", Unit::parse("pulse/arcsec"), band.sense * band.scale_factor,
                      "fringes for an angle, for any number of edges that are counted", dof_of(band.fit, 0)},
                     estimate);
  placed.factor[0] = -band.sense * band.scale_factor * band.scale_factor;
  placed.at[1] = add({"bias", "b", Unit::parse("deg/h"), band.bias,
                      "of the rate: centre of the dead band with the sign changed", dof_of(band.fit, 1)},
                     estimate);
  placed.factor[1] = 1.0;
  return placed;
}

void put_band(const DeadBand& band, const Placed& placed, Estimate& estimate, std::vector<ErrorLine>& lines) {
  Matrix gradients(estimate.parameters.size(), placed.at.size());
  for (std::size_t i = 0; i < placed.at.size(); ++i) gradients(placed.at[i], i) = placed.factor[i];
  for (auto& line : carried(gradients, lines_of(band.fit.sources))) lines.push_back(std::move(line));
  estimate.fit = {band.rows.size(), band.fit.degrees_of_freedom, band.fit.chi_square, band.fit.condition};
}

/// N of lock-in, and W_L from it where no dead band was measured.
struct Walk {
  double value = 0.0, variance = 0.0, dof = 0.0;
};

/// Noise of the random walk, and the uncertainty of the dither rate where W_L follows from both.
void put_walk(const Walk& walk, std::size_t at, const std::optional<std::size_t>& derived, double gain,
              double dither_rate_sd, std::size_t parameters, std::vector<ErrorLine>& lines) {
  Matrix noise(parameters, 1), dither(parameters, 1);
  noise(at, 0) = std::sqrt(walk.variance);
  if (derived) {
    noise(*derived, 0) = gain * noise(at, 0);
    dither(*derived, 0) = 0.5 * dither_rate_sd * gain * walk.value;
  }
  lines.push_back(from_shifts("output noise", std::move(noise)));
  lines.push_back(from_shifts("dither rate", std::move(dither)));
}

std::optional<Walk> walk_of(const BeatWalk& beat, double scale_factor, double other, Findings& findings) {
  const double squared = beat.squared / (scale_factor * scale_factor) - other * other;
  if (beat.squared > 0.0 && squared > 0.0)
    return Walk{std::sqrt(squared), beat.variance / std::pow(scale_factor, 4) / (4.0 * squared),
                beat.degrees_of_freedom};
  findings.push_back({Severity::warning,
                      beat.squared > 0.0 ? "random_walk_below_other_noise" : "random_walk_below_counting",
                      {{"limit", std::sqrt(beat.upper_limit) / scale_factor, "deg/sqrt(h)"}}});
  return std::nullopt;
}

void compare(const Walk& walk, const LockIn& lock, double lock_sd, const Settings& settings, Findings& findings) {
  const double W_A = settings.number("dither_rate");
  const double formula = angle_random_walk_from_lock_in(lock, {W_A, 1.0, 0.0}), ratio = walk.value / formula;
  const double relative = std::sqrt(walk.variance / (walk.value * walk.value) + std::pow(lock_sd / lock.rate, 2) +
                                    std::pow(0.5 * settings.number("dither_rate_sd"), 2));
  const bool agrees = std::abs(ratio - 1.0) < agrees_within_sd * ratio * relative;
  findings.push_back({agrees ? Severity::info : Severity::warning,
                      agrees ? "random_walk_agrees_with_lock_in" : "random_walk_differs_from_lock_in",
                      {{"ratio", ratio}, {"sd", ratio * relative}}});
}

}  // namespace

Estimate estimate_of(const Answer& answer, const Settings& settings) {
  Estimate estimate;
  estimate.findings = answer.findings;
  const double K = answer.band ? answer.band->scale_factor : settings.number("scale_factor");
  const bool locked = answer.band && answer.band->lock_in_rate > 0.0;
  const std::optional<Walk> walk =
      answer.walk ? walk_of(*answer.walk, K, settings.number("other_random_walk"), estimate.findings) : std::nullopt;
  const bool derived = walk && !locked && settings.has("dither_rate");
  Placed placed;
  if (answer.band) placed = add_band(*answer.band, estimate);
  std::size_t at = 0;
  std::optional<std::size_t> from;
  if (walk)
    at = add({"angle_random_walk_from_lock_in", "N", Unit::parse("deg/sqrt(h)"), walk->value,
              "random walk of the angle with the dither on", walk->dof},
             estimate);
  const double gain = derived ? std::sqrt(two_pi * K * settings.number("dither_rate")) : 0.0;
  if (derived)
    from = add({"lock_in_rate", "W_L", Unit::parse("deg/h"), gain * walk->value,
                "from the random walk with the dither on: N sqrt(2 pi K W_A)", walk->dof},
               estimate);
  if (estimate.parameters.empty())
    throw Error(Error::Kind::bad_data, "the record shows neither a dead band nor a random walk of lock-in");
  std::vector<ErrorLine> lines;
  if (answer.band) put_band(*answer.band, placed, estimate, lines);
  if (!answer.shift.empty()) {
    std::vector<double> shift(estimate.parameters.size(), 0.0);
    for (std::size_t i = 0; i < placed.at.size(); ++i) shift[placed.at[i]] = placed.factor[i] * answer.shift[i];
    lines.push_back(from_shifts("what the sweep may hold beside the dead band", as_column(shift)));
  }
  if (walk) {
    put_walk(*walk, at, from, gain, derived ? settings.number("dither_rate_sd") : 0.0, estimate.parameters.size(),
             lines);
    estimate.fit.observations += answer.walk->observations;
  }
  if (walk && locked && settings.has("dither_rate"))
    compare(*walk, {K, answer.band->lock_in_rate}, std::sqrt(answer.band->fit.covariance(2, 2)), settings,
            estimate.findings);
  settle(estimate, lines);
  return estimate;
}

Table sweep_table(const std::vector<Point>& points, const DeadBand& band) {
  const auto fitted = [&](std::size_t i) {
    return band.why_not[i] == "dithered" ? std::nan("") : beat_frequency(band, points[i].rate);
  };
  return tabulate("sweep", "beat of each segment; the rate at which the fit gives it, nominal less fitted",
                  points.size(),
                  {{"label", [&](std::size_t i) { return points[i].label; }},
                   {"run", [&](std::size_t i) { return points[i].run; }},
                   {"duration", "s", [&](std::size_t i) { return points[i].duration; }},
                   {"rate", "deg/h", [&](std::size_t i) { return points[i].rate; }},
                   {"beat", "pulse/s", [&](std::size_t i) { return points[i].beat; }},
                   {"fitted", "pulse/s", fitted},
                   {"residual", "deg/h", [&](std::size_t i) { return band.residual[i]; }},
                   {"used", [&](std::size_t i) { return band.used[i] ? "yes" : band.why_not[i]; }}});
}

void append_curves(const Sweep& sweep, const DeadBand& band, Estimate& estimate) {
  Curve measured{.name = "measured",
                 .figure = "beat over rate",
                 .x = {"input rate", Unit::parse("deg/h")},
                 .y = {"beat frequency", Unit::parse("pulse/s")},
                 .points = true};
  Curve fitted = measured;
  fitted.name = "fit";
  fitted.points = false;
  double widest = 0.0;
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    const Point& point = sweep.points[i];
    if (band.why_not[i] == "dithered") continue;
    add_point(measured, point.rate, point.beat);
    widest = std::max(widest, std::abs(point.rate));
  }
  constexpr int half = 200;
  for (int k = -half; k <= half; ++k) {  // cubic spacing: dense about the dead band
    const double u = static_cast<double>(k) / half, w = widest * u * (0.1 + 0.9 * u * u);
    add_point(fitted, w, beat_frequency(band, w));
  }
  estimate.tables.push_back(sweep_table(sweep.points, band));
  estimate.curves.push_back(std::move(measured));
  estimate.curves.push_back(std::move(fitted));
}

}  // namespace tumble::rlg_lock_in
