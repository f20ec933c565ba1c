#include "tumble/methods/frequency_response/curves.hpp"

#include <cmath>
#include <complex>

#include "tumble/core/columns.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/frequency_response/describe.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::frequency_response {
namespace {

struct Deviation {
  double sd = 0.0, half_width = 0.0;  ///< of 95 %
};

/// Deviation of a parameter; zeros where there is none of that name (the gain to which the others are relative).
Deviation deviation_of(const Estimate& estimate, const std::string& name) {
  const Parameter* parameter = find_parameter(estimate, name);
  if (parameter == nullptr) return {};
  const double sd = standard_uncertainty(estimate, static_cast<std::size_t>(parameter - estimate.parameters.data()));
  return {sd, sd * student_quantile(two_sided_95, parameter->degrees_of_freedom)};
}

double base(const Measured& m, const Data& data) { return data.scaling.relative ? m.log_gain.front() : 0.0; }

std::complex<double> fitted(const LoopFit& fit, double f) {
  const std::complex<double> i(0.0, 1.0);
  std::complex<double> d = 1.0;
  if (fit.kind == LoopKind::first_order) d += i * f / std::exp(fit.theta[2]);
  if (fit.kind == LoopKind::second_order) {
    const double r = f / std::exp(fit.theta[2]);
    d += -r * r + 2.0 * i * fit.theta[3] * r;
  }
  return fit.theta[0] - i * two_pi * f * fit.theta[1] - std::log(d);
}

std::string label_of(const LoopFit& fit) {
  return std::string(name(fit.kind)) + (fit.kind == LoopKind::delay ? "" : " with delay");
}

/// The fit with the least AICc of those that converged; null: none did.
const LoopFit* closest(const std::vector<LoopFit>& fits) {
  const LoopFit* best = nullptr;
  for (const LoopFit& fit : fits)
    if (fit.converged && (best == nullptr || fit.aicc < best->aicc)) best = &fit;
  return best;
}

Curve curve_of(const char* name, const char* figure, const char* y, const char* unit) {
  return {.name = name,
          .figure = figure,
          .x = {"frequency", Unit::parse("Hz")},
          .y = {y, Unit::parse(unit)},
          .logarithmic_x = true};
}

double decibels(double log_gain) { return 20.0 / std::log(10.0) * log_gain; }

}  // namespace

Table bode_table(const std::vector<Point>& points, const Measured& m, const Data& data, const Estimate& estimate) {
  const auto log_gain = [&](std::size_t i) { return m.log_gain[i] - base(m, data); };
  const auto sd = [&](const char* of) {
    return [&, of](std::size_t i) { return deviation_of(estimate, of + frequency_label(points[i].nominal)).sd; };
  };
  const auto or_dash = [](double value, bool known) { return known ? Table::Cell(value) : "-"; };
  const auto cycles = [&](std::size_t i) { return or_dash(points[i].cycles, points[i].cycles > 0.0); };
  const auto distortion = [&](std::size_t i) {
    return or_dash(points[i].distortion, std::isfinite(points[i].distortion));
  };
  const auto aliased_to = [&](std::size_t i) { return or_dash(points[i].aliased_to, points[i].aliased_to > 0.0); };
  const Unit amplitude = data.scaling.differentiate ? Unit::parse("deg") : data.reference_unit;
  return tabulate("bode", data.scaling.relative ? "gain relative to the lowest frequency, and phase" : "gain and phase",
                  points.size(),
                  {{"frequency", "Hz", [&](std::size_t i) { return points[i].frequency; }},
                   {"gain", [&](std::size_t i) { return std::exp(log_gain(i)); }},
                   {"gain_sd", sd("gain_")},
                   {"gain_dB", [&](std::size_t i) { return decibels(log_gain(i)); }},
                   {"phase", "deg", [&](std::size_t i) { return m.phase[i] + m.turn; }},
                   {"phase_sd", "deg", sd("phase_")},
                   {"coherence", [&](std::size_t i) { return points[i].coherence; }},
                   {"cycles", cycles},
                   {"reference_amplitude", amplitude, [&](std::size_t i) { return points[i].amplitude; }},
                   {"distortion", "%", distortion},
                   {"aliased_to", "Hz", aliased_to},
                   {"segment", [&](std::size_t i) { return points[i].where; }}});
}

std::vector<Curve> bode_curves(const std::vector<Point>& points, const Measured& m, const Data& data,
                               const Estimate& estimate, const LoopFit* fit) {
  Curve gain = curve_of("gain", "gain", "gain in dB", "1"), phase = curve_of("phase", "phase", "phase", "deg");
  gain.points = phase.points = true;
  gain.band = phase.band = "95 % confidence";
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::string label = frequency_label(points[i].nominal);
    const double log_gain = m.log_gain[i] - base(m, data);
    add_point(gain, m.frequency[i], decibels(log_gain),
              decibels(deviation_of(estimate, "gain_" + label).half_width / std::exp(log_gain)));
    add_point(phase, m.frequency[i], m.phase[i] + m.turn, deviation_of(estimate, "phase_" + label).half_width);
  }
  std::vector<Curve> curves{gain, phase};
  if (fit == nullptr || points.size() < 2) return curves;
  const std::string label = label_of(*fit);
  Curve model_gain = curve_of(label.c_str(), "gain", "gain in dB", "1");
  Curve model_phase = curve_of(label.c_str(), "phase", "phase", "deg");
  const double step = std::log(m.frequency.back() / m.frequency.front()) / 100.0;
  for (int k = 0; k <= 100; ++k) {
    const double f = m.frequency.front() * std::exp(k * step);
    const auto value = fitted(*fit, f);
    add_point(model_gain, f, decibels(value.real() - base(m, data)));
    add_point(model_phase, f, value.imag() + m.turn);
  }
  curves.push_back(std::move(model_gain));
  curves.push_back(std::move(model_phase));
  return curves;
}

std::vector<Curve> residual_curves(const Measured& m, const std::vector<LoopFit>& fits, const LoopFit* chosen) {
  const LoopFit* fit = chosen ? chosen : closest(fits);
  if (fit == nullptr) return {};
  const std::string label = (chosen ? "less the " : "less the closest that was tried: ") + label_of(*fit);
  Curve gain = curve_of(label.c_str(), "residuals of the gain", "residual of the gain in dB", "1");
  Curve phase = curve_of(label.c_str(), "residuals of the phase", "residual of the phase", "deg");
  gain.points = phase.points = true;
  gain.band = phase.band = "2 sd of the output noise";
  for (std::size_t i = 0; i < m.frequency.size(); ++i) {
    const auto value = fitted(*fit, m.frequency[i]);
    add_point(gain, m.frequency[i], decibels(m.log_gain[i] - value.real()),
              decibels(2.0 * std::sqrt(m.log_gain_variance[i])));
    add_point(phase, m.frequency[i], m.phase[i] - value.imag(), 2.0 * std::sqrt(m.phase_variance[i]));
  }
  return {gain, phase};
}

}  // namespace tumble::frequency_response
