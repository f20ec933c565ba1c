#include "tumble/methods/rlg_lock_in/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tumble/models/lock_in.hpp"
#include "tumble/models/lock_zones.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rlg_lock_in {
namespace {

using Severity = Finding::Severity;

/// Parameters as they come, each a linear function of independent sources.
struct Builder {
  Estimate estimate;
  struct Line {
    std::string source;
    Matrix covariance;
  };
  std::vector<Line> lines;

  std::size_t add(Parameter parameter) {
    estimate.parameters.push_back(std::move(parameter));
    return estimate.parameters.size() - 1;
  }
  /// Room for `size` parameters must be known: all are added before the first line.
  Matrix& line(const std::string& source) {
    const std::size_t n = estimate.parameters.size();
    for (auto& one : lines)
      if (one.source == source) return one.covariance;
    lines.push_back({source, Matrix(n, n)});
    return lines.back().covariance;
  }
  Estimate finish() {
    const std::size_t n = estimate.parameters.size();
    estimate.covariance = Matrix(n, n);
    for (const auto& one : lines) {
      Contribution contribution{one.source, std::vector<double>(n)};
      for (std::size_t i = 0; i < n; ++i) {
        contribution.variance[i] = one.covariance(i, i);
        for (std::size_t j = 0; j < n; ++j) estimate.covariance(i, j) += one.covariance(i, j);
      }
      estimate.budget.push_back(std::move(contribution));
    }
    return std::move(estimate);
  }
};

double dof_of(const MixedFit& fit, std::size_t index) {
  if (fit.component_covariance.empty()) return std::numeric_limits<double>::infinity();
  std::vector<double> unit(fit.parameters.size(), 0.0);
  unit[index] = 1.0;
  return degrees_of_freedom(fit, unit);
}

/// Where the fit's (1/K, b, W_L) went, and their factor: d parameter/d fitted.
struct Placed {
  std::vector<std::size_t> at;
  std::vector<double> factor;
};

Placed add_band(const DeadBand& band, Builder& builder) {
  Placed placed{std::vector<std::size_t>(band.fit.parameters.size()), std::vector<double>(band.fit.parameters.size())};
  if (placed.at.size() > 2) {
    placed.at[2] = builder.add({"lock_in_rate", "W_L", Unit::parse("deg/h"), band.lock_in_rate,
                                "half width of the dead band without dither", dof_of(band.fit, 2)});
    placed.factor[2] = 1.0;
  }
  placed.at[0] = builder.add({"scale_factor", "K", Unit::parse("pulse/arcsec"), band.scale_factor,
                              "fringes an angle, whatever the edges counted", dof_of(band.fit, 0)});
  placed.factor[0] = -band.scale_factor * band.scale_factor;
  placed.at[1] = builder.add({"bias", "b", Unit::parse("deg/h"), band.bias,
                              "of the rate: centre of the dead band with the sign changed", dof_of(band.fit, 1)});
  placed.factor[1] = 1.0;
  return placed;
}

void put_band(const DeadBand& band, const Placed& placed, Builder& builder) {
  for (const auto& source : band.fit.sources) {
    Matrix& line = builder.line(source.source);
    for (std::size_t i = 0; i < placed.at.size(); ++i)
      for (std::size_t j = 0; j < placed.at.size(); ++j)
        line(placed.at[i], placed.at[j]) += placed.factor[i] * placed.factor[j] * source.covariance(i, j);
  }
  builder.estimate.fit = {band.rows.size(), band.fit.degrees_of_freedom, band.fit.chi_square, band.fit.condition};
}

/// N of lock-in, and W_L from it where no dead band was measured.
struct Walk {
  double value = 0.0, variance = 0.0, dof = 0.0;
};

std::optional<Walk> walk_of(const BeatWalk& beat, double scale_factor, double other, Findings& findings) {
  const double squared = beat.squared / (scale_factor * scale_factor) - other * other;
  const Unit unit = Unit::parse("deg/sqrt(h)");
  if (beat.squared > 0.0 && squared > 0.0)
    return Walk{std::sqrt(squared), beat.variance / std::pow(scale_factor, 4) / (4.0 * squared),
                beat.degrees_of_freedom};
  findings.push_back(
      {Severity::warning,
       fmt::format("no random walk of lock-in is seen under the count's steps{}; below {:.2g} {} (95 %). A "
                   "longer record at rest shows it",
                   beat.squared > 0.0 ? " and the other noise" : "",
                   unit.from_si(std::sqrt(beat.upper_limit) / scale_factor), unit.text()),
       ""});
  return std::nullopt;
}

void compare(const Walk& walk, const LockIn& lock, double lock_sd, const Settings& settings, Findings& findings) {
  const double W_A = settings.number("dither_rate");
  const double formula = angle_random_walk_from_lock_in(lock, {W_A, 1.0, 0.0}), ratio = walk.value / formula;
  const double relative = std::sqrt(walk.variance / (walk.value * walk.value) + std::pow(lock_sd / lock.rate, 2) +
                                    std::pow(0.5 * settings.number("dither_rate_sd"), 2));
  const bool agrees = std::abs(ratio - 1.0) < 3.0 * ratio * relative;
  findings.push_back(
      {agrees ? Severity::info : Severity::warning,
       fmt::format("the random walk is {:.3f} +- {:.3f} of W_L/sqrt(2 pi K W_A){}", ratio, ratio * relative,
                   agrees ? "" : ": the dither's noise may be too small, or W_L has changed"),
       ""});
}

}  // namespace

Estimate estimate_of(const Answer& answer, const Settings& settings) {
  Builder builder;
  builder.estimate.findings = answer.findings;
  const double K = answer.band ? answer.band->scale_factor : settings.number("scale_factor");
  const bool locked = answer.band && answer.band->lock_in_rate > 0.0;
  const std::optional<Walk> walk =
      answer.walk ? walk_of(*answer.walk, K, settings.number("other_random_walk"), builder.estimate.findings)
                  : std::nullopt;
  const bool derived = walk && !locked && settings.has("dither_rate");
  Placed placed;
  if (answer.band) placed = add_band(*answer.band, builder);
  std::size_t at = 0, from = 0;
  if (walk)
    at = builder.add({"angle_random_walk_from_lock_in", "N", Unit::parse("deg/sqrt(h)"), walk->value,
                      "random walk of the angle with the dither on", walk->dof});
  const double gain = derived ? std::sqrt(2.0 * std::numbers::pi * K * settings.number("dither_rate")) : 0.0;
  if (derived)
    from = builder.add({"lock_in_rate", "W_L", Unit::parse("deg/h"), gain * walk->value,
                        "from the random walk with the dither on: N sqrt(2 pi K W_A)", walk->dof});
  if (builder.estimate.parameters.empty())
    throw Error(Error::Kind::bad_data, "the record shows neither a dead band nor a random walk of lock-in");
  if (answer.band) put_band(*answer.band, placed, builder);
  if (walk) {
    Matrix& noise = builder.line("output noise");
    noise(at, at) += walk->variance;
    if (derived) {
      noise(at, from) = noise(from, at) = gain * walk->variance;
      noise(from, from) += gain * gain * walk->variance;
      builder.line("dither rate")(from, from) +=
          std::pow(0.5 * settings.number("dither_rate_sd") * gain * walk->value, 2);
    }
    builder.estimate.fit.observations += answer.walk->observations;
  }
  if (walk && locked && settings.has("dither_rate"))
    compare(*walk, {K, answer.band->lock_in_rate}, std::sqrt(answer.band->fit.covariance(2, 2)), settings,
            builder.estimate.findings);
  return builder.finish();
}

void append_curves(const Sweep& sweep, const DeadBand& band, Estimate& estimate) {
  const Unit rate = Unit::parse("deg/h"), beat = Unit::parse("pulse/s"), seconds = Unit::parse("s");
  Table table{"sweep",
              "beat of each segment; the rate at which the fit gives it, nominal less fitted",
              {{"label", Unit()},
               {"run", Unit()},
               {"duration", seconds},
               {"rate", rate},
               {"beat", beat},
               {"fitted", beat},
               {"residual", rate},
               {"used", Unit()}},
              {}};
  Curve measured{"measured", "beat over rate", {"input rate", rate, {}}, {"beat frequency", beat, {}}, {}, {}};
  measured.points = true;
  double widest = 0.0;
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    const Point& point = sweep.points[i];
    table.rows.push_back({point.label, static_cast<double>(point.run), point.duration, point.rate, point.beat,
                          band.why_not[i] == "dithered" ? std::nan("") : beat_frequency(band, point.rate),
                          band.residual[i], band.used[i] ? "yes" : band.why_not[i]});
    if (band.why_not[i] == "dithered") continue;
    measured.x.values.push_back(point.rate);
    measured.y.values.push_back(point.beat);
    widest = std::max(widest, std::abs(point.rate));
  }
  Curve fitted{"fit", "beat over rate", {"input rate", rate, {}}, {"beat frequency", beat, {}}, {}, {}};
  constexpr int half = 200;
  for (int k = -half; k <= half; ++k) {  // cubic spacing: dense about the dead band
    const double u = static_cast<double>(k) / half, w = widest * u * (0.1 + 0.9 * u * u);
    fitted.x.values.push_back(w);
    fitted.y.values.push_back(beat_frequency(band, w));
  }
  estimate.tables.push_back(std::move(table));
  estimate.curves.push_back(std::move(measured));
  estimate.curves.push_back(std::move(fitted));
}

}  // namespace tumble::rlg_lock_in
