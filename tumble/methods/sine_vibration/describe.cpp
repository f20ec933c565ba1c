#include "tumble/methods/sine_vibration/describe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/language/say.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/sine_vibration/raw.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/rig_effects.hpp"
#include "tumble/rigs/error_names.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::sine_vibration {
namespace {

constexpr double most_freedom = 1e5;  ///< more are infinite: the quantiles agree to 1e-5

namespace names = error_names;

/// Parameters with their gradients over the raw quantities.
struct Builder {
  const Raw& raw;
  Estimate estimate;
  std::vector<std::vector<double>> gradients;

  void add(const std::string& name, const std::string& symbol, const char* unit, double value,
           std::vector<double> gradient, const std::string& description, std::vector<std::string> channels = {}) {
    estimate.parameters.push_back({name, symbol, Unit::parse(unit), value, description});
    estimate.parameters.back().channels = std::move(channels);
    gradients.push_back(std::move(gradient));
  }
};

void add_rectification(const vibration::Data& data, const Rectification& r, const std::vector<std::size_t>& at,
                       Builder& builder) {
  const Raw& raw = builder.raw;
  const std::string &own = data.units[r.unit].name, &prefix = data.units[r.unit].prefix;
  const Unit g = Unit::parse("g");
  std::map<std::string, int> names;
  for (const auto& way : r.ways) {
    std::string name = "vibration_rectification";
    if (r.ways.size() > 1) name += "_" + way_name(way.rest);
    if (const int n = names[name]++; n > 0) name += fmt::format("_{}", n + 1);
    const std::string posture = std::isnan(way.rest) ? "gravity along the input axis not known"
                                                     : fmt::format("a_0 = {:+.4g} g", g.from_si(way.rest));
    builder.add(prefix + name, "K_v", "ug/g^2", raw.value[at[way.column]],
                unit_vector(raw.value.size(), at[way.column]),
                fmt::format("shift of the mean over the mean square of vibration, {}", posture), {own});
  }
  if (r.quartic)
    builder.add(prefix + "vibration_rectification_quartic", "c", "ug/g^4", raw.value[at[r.quartic_column]],
                unit_vector(raw.value.size(), at[r.quartic_column]), "shift of the mean per A^4", {own});
  if (r.ways.size() < 2) return;
  const auto &up = r.ways.front(), &down = r.ways.back();
  const double apart = up.rest - down.rest;
  if (!(apart > 0.5 * standard_gravity)) return;
  std::vector<double> second(raw.value.size(), 0.0), third = second;
  second[at[up.column]] = -down.rest / apart, second[at[down.column]] = up.rest / apart;
  third[at[up.column]] = 1.0 / (3.0 * apart), third[at[down.column]] = -1.0 / (3.0 * apart);
  builder.add(prefix + "second_order_coefficient", "K_2", "ug/g^2", dot(second, raw.value), second,
              "from both directions of the axis", {own});
  builder.add(prefix + "third_order_coefficient", "K_3", "ug/g^3", dot(third, raw.value), third,
              "from both directions of the axis", {own});
}

/// Points of one unit at one frequency.
using Tones = std::map<double, std::vector<std::size_t>>;

Tones tones_of(const Measured& measured, std::size_t unit) {
  Tones tones;
  for (std::size_t i = 0; i < measured.points.size(); ++i)
    if (measured.points[i].unit == unit) tones[measured.points[i].nominal].push_back(i);
  return tones;
}

void add_gains(const vibration::Data& data, const Measured& measured, std::size_t unit, Builder& builder) {
  for (const auto& [frequency, points] : tones_of(measured, unit)) {
    std::vector<double> gradient(builder.raw.value.size(), 0.0);
    double log_gain = 0.0;
    for (const std::size_t i : points)
      log_gain += std::log(measured.points[i].gain) / static_cast<double>(points.size());
    const double gain = std::exp(log_gain);
    for (const std::size_t i : points) gradient[builder.raw.first_gain + i] = gain / static_cast<double>(points.size());
    builder.add(data.units[unit].prefix + "gain_" + frequency_label(frequency), "|G|", "1", gain, std::move(gradient),
                "of the motion, without the effect of the counting window", {data.units[unit].name});
  }
}

/// Mean over the frequencies that all units share of ln gain, with gradient.
struct MeanGain {
  double value = 0.0;
  std::vector<double> gradient;
};

std::vector<MeanGain> mean_gains(const Measured& measured, std::size_t units, const Raw& raw) {
  std::vector<Tones> tones;
  for (std::size_t u = 0; u < units; ++u) tones.push_back(tones_of(measured, u));
  std::vector<MeanGain> means(units, {0.0, std::vector<double>(raw.value.size(), 0.0)});
  std::vector<double> shared;
  for (const auto& [frequency, points] : tones.front())
    if (std::ranges::all_of(tones, [f = frequency](const Tones& t) { return t.contains(f); }))
      shared.push_back(frequency);
  if (shared.empty()) return {};
  for (std::size_t u = 0; u < units; ++u)
    for (const double f : shared) {
      const auto& points = tones[u][f];
      const double weight = 1.0 / static_cast<double>(points.size() * shared.size());
      for (const std::size_t i : points) {
        means[u].value += weight * std::log(measured.points[i].gain);
        means[u].gradient[raw.first_gain + i] += weight;
      }
    }
  return means;
}

/// How the units differ: gains over the first unit's, and the spread of them all.
void compare_gains(const vibration::Data& data, const Measured& measured, Builder& builder) {
  const std::size_t units = data.units.size();
  if (units < 2) return;
  const auto means = mean_gains(measured, units, builder.raw);
  if (means.empty()) return;
  double centre = 0.0, squares = 0.0;
  for (std::size_t u = 0; u < units; ++u) centre += means[u].value / static_cast<double>(units);
  for (std::size_t u = 0; u < units; ++u) {
    squares += std::pow(means[u].value - centre, 2);
    if (u == 0) continue;
    const double ratio = std::exp(means[u].value - means[0].value);
    std::vector<double> gradient(builder.raw.value.size());
    for (std::size_t i = 0; i < gradient.size(); ++i)
      gradient[i] = ratio * (means[u].gradient[i] - means[0].gradient[i]);
    builder.add(data.units[u].prefix + "gain_ratio", "G/G_1", "1", ratio, std::move(gradient),
                "gain over that of " + data.units[0].name + ", mean over the frequencies of both",
                {data.units[u].name, data.units[0].name});
  }
  const double sd = std::sqrt(squares / static_cast<double>(units - 1));
  if (!(sd > 0.0)) return;
  std::vector<double> gradient(builder.raw.value.size(), 0.0);
  for (std::size_t u = 0; u < units; ++u)
    for (std::size_t i = 0; i < gradient.size(); ++i)
      gradient[i] += (means[u].value - centre) / (static_cast<double>(units - 1) * sd) * means[u].gradient[i];
  builder.add("gain_spread", "s(ln G)", "%", sd, std::move(gradient),
              "standard deviation over the units of their mean gains");
}

void compare_rectifications(const vibration::Data& data, const std::vector<Rectification>& rectified,
                            Builder& builder) {
  const Raw& raw = builder.raw;
  for (std::size_t k = 1; k < rectified.size(); ++k)
    for (const auto& way : rectified[k].ways) {
      const auto first = std::ranges::find_if(
          rectified[0].ways, [&](const auto& other) { return way_name(other.rest) == way_name(way.rest); });
      if (first == rectified[0].ways.end()) continue;
      const std::size_t a = raw.coefficient[k][way.column], b = raw.coefficient[0][first->column];
      std::vector<double> gradient(raw.value.size(), 0.0);
      gradient[a] = 1.0, gradient[b] = -1.0;
      builder.add(data.units[rectified[k].unit].prefix + "rectification_difference" +
                      (rectified[k].ways.size() > 1 ? "_" + way_name(way.rest) : ""),
                  "d K_2", "ug/g^2", raw.value[a] - raw.value[b], std::move(gradient),
                  "vibration_rectification less that of " + data.units[rectified[0].unit].name,
                  {data.units[rectified[k].unit].name, data.units[rectified[0].unit].name});
    }
}

/// Covariance, budget and degrees of freedom (Welch and Satterthwaite) of all parameters.
void propagate(Builder& builder) {
  Estimate& estimate = builder.estimate;
  const std::size_t p = estimate.parameters.size();
  std::vector<ErrorLine> lines;
  std::vector<std::map<std::size_t, std::pair<double, double>>> groups(p);
  for (const auto& component : builder.raw.components) {
    Matrix moved(p, 1);
    for (std::size_t i = 0; i < p; ++i) {
      moved(i, 0) = dot(builder.gradients[i], component.shift);
      if (!std::isfinite(component.degrees_of_freedom)) continue;
      auto& group = groups[i][component.group];
      group.first += moved(i, 0) * moved(i, 0);
      group.second = component.degrees_of_freedom;
    }
    lines.push_back(from_shifts(component.source, std::move(moved)));
  }
  settle(estimate, lines);
  // A group is one estimate of a variance, for all sources that share it.
  for (std::size_t i = 0; i < p; ++i) {
    double fourth = 0.0;
    for (const auto& [group, part] : groups[i]) fourth += part.first * part.first / part.second;
    const double total = estimate.covariance(i, i);
    const double dof = fourth > 0.0 ? total * total / fourth : forever;
    estimate.parameters[i].degrees_of_freedom = dof < most_freedom ? std::max(1.0, dof) : forever;
  }
}

/// An amplitude of unknown uncertainty is taken as commanded.
void report_unknown_level(const Evidence& evidence, const Measured& measured, Findings& findings) {
  if (measured.reference || rig_sd(evidence.plan, names::shake_amplitude)) return;
  findings.push_back({Finding::Severity::warning, "amplitude_uncertainty_unknown", {}});
}

}  // namespace

std::string way_name(double rest) {
  if (std::isnan(rest)) return "any";
  return rest > 0.5 * standard_gravity ? "up" : rest < -0.5 * standard_gravity ? "down" : "level";
}

Estimate describe(const Evidence& evidence, const vibration::Data& data, const Measured& measured,
                  const std::vector<Rectification>& rectified) {
  const Raw raw = raw_of(evidence, data, measured, rectified);
  Builder builder{raw, {}, {}};
  for (std::size_t k = 0; k < rectified.size(); ++k) add_rectification(data, rectified[k], raw.coefficient[k], builder);
  compare_rectifications(data, rectified, builder);
  compare_gains(data, measured, builder);
  for (std::size_t u = 0; u < data.units.size(); ++u) add_gains(data, measured, u, builder);
  propagate(builder);
  Estimate& estimate = builder.estimate;
  report_unknown_level(evidence, measured, estimate.findings);
  for (const auto& point : measured.points) estimate.fit.observations += point.line.samples;
  for (const auto& rest : measured.rests) estimate.fit.observations += rest.line.samples;
  for (const auto& r : rectified) {
    estimate.fit.chi_square += r.fit.chi_square;
    estimate.fit.degrees_of_freedom += r.fit.degrees_of_freedom;
    estimate.fit.condition = std::max(estimate.fit.condition, r.fit.condition);
  }
  return std::move(builder.estimate);
}

}  // namespace tumble::sine_vibration
