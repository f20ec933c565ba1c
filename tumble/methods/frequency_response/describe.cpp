#include "tumble/methods/frequency_response/describe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tumble/core/columns.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/frequency_response/average.hpp"
#include "tumble/methods/frequency_response/curves.hpp"
#include "tumble/methods/frequency_response/phase.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::frequency_response {
namespace {

using Severity = Finding::Severity;

/// [1] of natural frequency and of damping ratio, above which their sd says that the points are far from the resonance.
constexpr double most_natural_sd = 0.25, most_damping_sd = 0.5;
constexpr double least_freedom_of_weights = 4.0;  ///< the formula is the beginning of a series in 1/nu

/// Parameters with their gradients over (ln gain, phase).
struct Builder {
  Estimate estimate;
  std::vector<std::vector<double>> gradients;
  std::vector<double> interpolation_variance;
  std::vector<double> noise_factor;
  std::vector<std::vector<double>> spread;  ///< of each over the models, see Averaged; empty: it depends on none

  void add(const std::string& name, const std::string& symbol, const char* unit, double value,
           std::vector<double> gradient, const std::string& description, double interpolation = -1.0) {
    estimate.parameters.push_back({name, symbol, Unit::parse(unit), value, description});
    gradients.push_back(std::move(gradient));
    interpolation_variance.push_back(interpolation > 0.0 ? interpolation * interpolation : 0.0);
    noise_factor.push_back(1.0);
    spread.emplace_back();
  }

  void add(const std::string& name, const std::string& symbol, const char* unit, const Averaged& mean,
           const std::string& description) {
    add(name, symbol, unit, mean.value, mean.gradient, description);
    spread.back() = mean.spread;
  }
};

std::vector<double> through(const std::vector<double>& over_theta, const Matrix& gain) {
  return transposed(gain) * over_theta;
}

/// sd of a function of the fit under the noise it was weighted with.
double noise_sd(const std::vector<double>& gradient, const Measured& m) {
  double variance = 0.0;
  const std::size_t n = m.frequency.size();
  for (std::size_t i = 0; i < 2 * n; ++i)
    variance += gradient[i] * gradient[i] * (i < n ? m.log_gain_variance[i] : m.phase_variance[i - n]);
  return std::sqrt(variance);
}

void add_second_order(const LoopFit& fit, const Measured& m, Builder& builder) {
  const double natural = std::exp(fit.theta[2]), zeta = fit.theta[3];
  const auto by_natural = through({0.0, 0.0, natural, 0.0}, fit.gain);
  const auto by_zeta = through({0.0, 0.0, 0.0, 1.0}, fit.gain);
  const double sd = noise_sd(by_natural, m), zeta_sd = noise_sd(by_zeta, m);
  if (sd > most_natural_sd * natural || zeta_sd > most_damping_sd * zeta) {
    builder.estimate.findings.push_back({Severity::info, "natural_frequency_too_far", {{"natural", natural, "Hz"}}});
    return;
  }
  builder.add("natural_frequency", "f_n", "Hz", natural, by_natural, "undamped natural frequency of the second order");
  builder.add("damping_ratio", "zeta", "1", zeta, by_zeta, "its damping ratio");
  if (zeta + 2.0 * zeta_sd > std::sqrt(0.5)) return;
  const Derived peak = peaking_of(fit), where = resonance_frequency_of(fit);
  if (where.value > m.frequency.back()) return;
  builder.add("peaking", "M_p", "1", peak.value, through(peak.gradient, fit.gain),
              "highest gain over the gain at rest");
  builder.add("resonance_frequency", "f_p", "Hz", where.value, through(where.gradient, fit.gain), "where it is");
}

void add_crossing(const Measured& m, Builder& builder) {
  const Crossing crossing = crossing_of(m.frequency, m.log_gain);
  if (!crossing.found) {
    builder.estimate.findings.push_back(
        {Severity::warning, "bandwidth_not_reached", {{"highest", m.frequency.back(), "Hz"}}});
    return;
  }
  if (crossing.frequency < 2.0 * m.frequency.front()) {
    builder.estimate.findings.push_back(
        {Severity::warning, "bandwidth_without_gain_at_rest", {{"lowest", m.frequency.front(), "Hz"}}});
    return;
  }
  std::vector<double> gradient(2 * m.frequency.size(), 0.0);
  const double h = 1e-6;
  for (std::size_t i = 0; i < m.frequency.size(); ++i) {
    auto up = m.log_gain, down = m.log_gain;
    up[i] += h;
    down[i] -= h;
    const Crossing a = crossing_of(m.frequency, up), b = crossing_of(m.frequency, down);
    if (a.found && b.found) gradient[i] = (a.frequency - b.frequency) / (2.0 * h);
  }
  builder.add("bandwidth", "f_3dB", "Hz", crossing.frequency, std::move(gradient),
              "where the gain is 3 dB below that at the lowest frequency, between the points beside it",
              crossing.interpolation_sd);
}

/// The fits that the data support, and that with the least AICc.
struct Models {
  const std::vector<Supported>& supported;
  const LoopFit* chosen = nullptr;  ///< null: none is accepted
};

/// The bandwidth of fitted loops with poles.
void add_bandwidth(const Models& models, const Measured& m, Builder& builder) {
  const Averaged bandwidth = averaged(models.supported, m, [](const LoopFit& fit) -> std::optional<Derived> {
    if (fit.kind == LoopKind::delay) return std::nullopt;
    return bandwidth_of(fit);
  });
  if (bandwidth.value <= m.frequency.back())
    builder.add("bandwidth", "f_3dB", "Hz", bandwidth,
                fmt::format("where the gain is 3 dB below that at rest; {} with delay", name(models.chosen->kind)));
  else
    builder.estimate.findings.push_back(
        {Severity::warning,
         "bandwidth_beyond_frequencies",
         {{"highest", m.frequency.back(), "Hz"},
          {"model", Phrase{models.chosen->kind == LoopKind::first_order ? "first_order" : "second_order"}},
          {"bandwidth", bandwidth.value, "Hz"}}});
}

/// No model fits: because of one point, which the bandwidth then rests on as well, or of the instrument.
void say_why_none_fits(const Measured& m, Findings& findings) {
  if (m.frequency.size() <= 2) return;
  const auto apart = point_apart(m);
  if (!apart) return findings.push_back({Severity::info, "no_loop_fits", {}});
  findings.push_back({Severity::error,
                      "frequency_apart",
                      {{"frequency", m.frequency[apart->point], "Hz"},
                       {"gain", apart->gain - 1.0, "%"},
                       {"phase", apart->phase, "deg"}}});
}

void add_loop(const Models& models, const Measured& m, Builder& builder) {
  const LoopFit* fit = models.chosen;
  if (fit == nullptr) {
    add_crossing(m, builder);
    say_why_none_fits(m, builder.estimate.findings);
    return;
  }
  const bool has_poles = fit->kind != LoopKind::delay;
  if (has_poles)
    add_bandwidth(models, m, builder);
  else
    builder.estimate.findings.push_back(
        {Severity::warning, "bandwidth_of_delay", {{"highest", m.frequency.back(), "Hz"}}});
  if (fit->kind == LoopKind::second_order) add_second_order(*fit, m, builder);
  const Averaged delay = averaged(models.supported, m, delay_of);
  builder.add("delay", "tau", "ms", delay,
              fmt::format("delay in addition to the {}", has_poles ? name(fit->kind) : "constant gain"));
}

/// The delay of slow motion, -d(phase)/d(omega) at 0 Hz: of the fitted loop, else of a polynomial of odd powers of f
/// through the phases.
void add_group_delay(const Models& models, const Measured& m, Builder& builder) {
  constexpr const char* what = "delay of slow motion: slope of the phase at 0 Hz, the lag of the loop in it";
  if (models.chosen != nullptr) {
    builder.add("group_delay", "tau_g", "ms", averaged(models.supported, m, group_delay_of), what);
    return;
  }
  const PhaseSlope slope = slope_at_rest(m);
  if (slope.found) builder.add("group_delay", "tau_g", "ms", slope.delay, slope.gradient, what, slope.model_sd);
}

void add_points(const std::vector<Point>& points, const Measured& m, bool relative, Builder& builder) {
  const std::size_t n = points.size();
  for (std::size_t i = relative ? 1 : 0; i < n; ++i) {
    std::vector<double> gradient(2 * n, 0.0);
    const double gain = std::exp(m.log_gain[i] - (relative ? m.log_gain[0] : 0.0));
    gradient[i] = gain;
    if (relative) gradient[0] = -gain;
    builder.add("gain_" + frequency_label(points[i].nominal), "|H|", "1", gain, std::move(gradient),
                relative ? "gain over that at the lowest frequency" : "amplitude of the output over the reference's");
  }
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<double> gradient(2 * n, 0.0);
    gradient[n + i] = 1.0;
    builder.add("phase_" + frequency_label(points[i].nominal), "arg H", "deg", m.phase[i] + m.turn, std::move(gradient),
                "output ahead of the reference");
  }
}

/// By how much the models differ, one row a parameter; empty: one model alone.
Matrix choice_of_model(const Builder& builder) {
  std::size_t columns = 0;
  for (const auto& row : builder.spread) columns = std::max(columns, row.size());
  Matrix shifts(columns == 0 ? 0 : builder.spread.size(), columns);
  for (std::size_t i = 0; i < shifts.rows; ++i)
    for (std::size_t c = 0; c < builder.spread[i].size(); ++c) shifts(i, c) = builder.spread[i][c];
  return shifts;
}

/// Covariance, budget and degrees of freedom from the gradients.
void propagate(const std::vector<Source>& sources, Builder& builder) {
  Estimate& estimate = builder.estimate;
  const std::size_t p = estimate.parameters.size();
  std::vector<ErrorLine> lines;
  for (const Source& source : sources) {
    Matrix moved(p, source.shifts.columns);
    for (std::size_t i = 0; i < p; ++i)
      for (std::size_t c = 0; c < source.shifts.columns; ++c)
        for (std::size_t r = 0; r < source.shifts.rows; ++r)
          moved(i, c) += builder.gradients[i][r] * source.shifts(r, c) *
                         (source.degrees_of_freedom.empty() ? 1.0 : builder.noise_factor[i]);
    for (std::size_t c = 0; c < moved.columns; ++c) {
      Matrix column(p, 1);
      for (std::size_t i = 0; i < p; ++i) column(i, 0) = moved(i, c);
      lines.push_back(from_shifts(source.name, std::move(column)));
      if (!source.degrees_of_freedom.empty()) lines.back().degrees_of_freedom.assign(p, source.degrees_of_freedom[c]);
    }
  }
  lines.push_back(from_variances("interpolation between frequencies", builder.interpolation_variance));
  if (const auto line = choice_of_model(builder); !line.empty())
    lines.push_back(from_shifts("choice of the model", line));
  settle(estimate, lines);
}

/// Value and sd of a parameter of a fit, its sd widened where the fit leaves more than the noise.
std::pair<double, double> of_fit(const LoopFit& fit, const Measured& m, std::size_t parameter, double slope) {
  const double wider = std::sqrt(std::max(1.0, fit.chi_square / std::max(1.0, fit.degrees_of_freedom)));
  std::vector<double> gradient(fit.theta.size(), 0.0);
  gradient[parameter] = slope;
  return {fit.theta[parameter], wider * noise_sd(through(gradient, fit.gain), m)};
}

double weight_of(const LoopFit& fit, const Models& models) {
  const auto one = std::ranges::find(models.supported, &fit, &Supported::fit);
  return one == models.supported.end() ? 0.0 : one->weight;
}

std::string verdict_on(const LoopFit& fit, const Models& models) {
  if (&fit == models.chosen) return "yes";
  if (!fit.converged) return "no: did not converge";
  return fit.accepted ? "no" : "no: does not fit";
}

constexpr std::size_t delay_at = 1, corner_at = 2, damping_at = 3;  ///< in LoopFit::theta

/// A value of the fit and its sd; dashes where the model lacks this parameter.
struct ValueOfFit {
  Table::Cell value, sd;
};

ValueOfFit value_of(const LoopFit& fit, const Measured& m, std::size_t parameter) {
  if (parameter >= fit.theta.size()) return {"-", "-"};
  const bool logarithm = parameter == corner_at;
  const double slope = logarithm ? std::exp(fit.theta[parameter]) : 1.0;
  const auto [value, sd] = of_fit(fit, m, parameter, slope);
  return {logarithm ? std::exp(value) : value, sd};
}

Table models_table(const std::vector<LoopFit>& fits, const Measured& m, bool relative, const Models& models) {
  const double lowest = relative ? m.log_gain.front() : 0.0;
  const auto model = [](const LoopFit& fit) {
    return std::string(name(fit.kind)) + (fit.kind == LoopKind::delay ? "" : " with delay");
  };
  const auto value = [&](std::size_t p) { return [&, p](const LoopFit& fit) { return value_of(fit, m, p).value; }; };
  const auto sd = [&](std::size_t p) { return [&, p](const LoopFit& fit) { return value_of(fit, m, p).sd; }; };
  return tabulate(
      "models",
      "responses that were fitted to gains and phases together, with their values; sd of those that do not fit "
      "are widened by their chi-square",
      fits,
      {{"model", model},
       {"chi-square", &LoopFit::chi_square},
       {"dof", &LoopFit::degrees_of_freedom},
       {"AICc", &LoopFit::aicc},
       {"chosen", [&](const LoopFit& fit) { return verdict_on(fit, models); }},
       {"weight", [&](const LoopFit& fit) { return weight_of(fit, models); }},
       {"gain", [&](const LoopFit& fit) { return std::exp(fit.theta[0] - lowest); }},
       {"delay", "ms", value(delay_at)},
       {"delay_sd", "ms", sd(delay_at)},
       {"frequency", "Hz", value(corner_at)},
       {"frequency_sd", "Hz", sd(corner_at)},
       {"damping", value(damping_at)},
       {"damping_sd", sd(damping_at)}});
}

}  // namespace

Estimate describe(const std::vector<Point>& points, const Data& data, const std::vector<Source>& sources) {
  Builder builder;
  const Measured m = measured_of(points);
  report_sign(m, data.scaling.relative, builder.estimate.findings);
  const std::vector<LoopFit> fits = fits_of(m);
  const auto near = supported(fits);
  const auto likeliest = std::ranges::min_element(near, {}, [](const Supported& one) { return one.fit->aicc; });
  const LoopFit* chosen = near.empty() ? nullptr : likeliest->fit;
  const Models models{near, chosen};
  add_loop(models, m, builder);
  add_group_delay(models, m, builder);
  // Weights that are themselves estimates, nu degrees of freedom each: the variance is 1 + 4/nu of that stated
  // (Meier, Biometrics 9 (1953) 59).
  if (chosen != nullptr)
    std::ranges::fill(builder.noise_factor,
                      std::sqrt(1.0 + 4.0 / std::max(least_freedom_of_weights, m.degrees_of_freedom)));
  add_points(points, m, data.scaling.relative, builder);
  propagate(sources, builder);
  Estimate& estimate = builder.estimate;
  estimate.fit.observations = 2 * points.size();
  estimate.fit.condition = 1.0;
  if (chosen != nullptr) {
    estimate.fit.degrees_of_freedom = chosen->degrees_of_freedom;
    estimate.fit.chi_square = chosen->chi_square;
  }
  estimate.tables.push_back(bode_table(points, m, data, estimate));
  if (!fits.empty()) estimate.tables.push_back(models_table(fits, m, data.scaling.relative, models));
  estimate.curves = bode_curves(points, m, data, estimate, chosen);
  for (auto& curve : residual_curves(m, fits, chosen)) estimate.curves.push_back(std::move(curve));
  return std::move(builder.estimate);
}

}  // namespace tumble::frequency_response
