#include "tumble/methods/sine_vibration/raw.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/reduce/rig_effects.hpp"
#include "tumble/rigs/error_names.hpp"

namespace tumble::sine_vibration {
namespace {

namespace names = error_names;

/// Harmonics and motion across the shake of a shaker, over the shake [1], where the plan has no rig that gives them.
constexpr double usual_distortion = 0.01;

/// Sources of one rectification as independent components.
void add_fit(const Rectification& r, const std::vector<std::size_t>& at, Raw& raw) {
  const std::size_t group = raw.groups++, p = at.size();
  const double dof = degrees_of_freedom(r.fit, unit_vector(r.fit.parameters.size(), 0));
  for (const auto& source : r.fit.sources) {
    const Matrix covariance = block(source.covariance, 0, p, 0, p);
    std::vector<double> sd;
    for (const double variance : diagonal_of(covariance)) sd.push_back(std::sqrt(std::max(variance, 1e-300)));
    const auto eigen = eigen_symmetric(scaled_rows(inverses(sd), scaled_columns(covariance, inverses(sd))));
    for (std::size_t k = 0; k < p; ++k) {
      Component component{source.source, std::vector<double>(raw.value.size(), 0.0), group, dof};
      for (std::size_t i = 0; i < p; ++i)
        component.shift[at[i]] = sd[i] * eigen.vectors(i, k) * std::sqrt(std::max(0.0, eigen.values[k]));
      raw.components.push_back(std::move(component));
    }
  }
}

void add_gain_noise(const Measured& measured, Raw& raw) {
  std::map<std::size_t, std::vector<std::size_t>> motions;
  for (std::size_t i = 0; i < measured.points.size(); ++i) {
    const Point& p = measured.points[i];
    raw.add("output noise", p.line.noise_degrees_of_freedom).shift[raw.first_gain + i] = std::sqrt(p.line.log_variance);
    if (p.rounding_log_variance > 0.0)
      raw.add("rounding to whole pulses").shift[raw.first_gain + i] = std::sqrt(p.rounding_log_variance);
    motions[p.motion].push_back(i);
  }
  for (const auto& [motion, points] : motions) {
    const Point& first = measured.points[points.front()];
    if (!(first.level_log_variance > 0.0)) continue;
    Component& component = raw.add("reference noise", first.level_degrees_of_freedom);
    for (const std::size_t i : points) component.shift[raw.first_gain + i] = -std::sqrt(first.level_log_variance);
  }
}

/// Effect on the gain of a harmonic that falls upon the line, over the size of the harmonic: it is part of the
/// amplitude of unit and reference, at any phase. Windows show sinc(k f H)/sinc(f H) of it, instants all of it. Where
/// both are windows, unit and reference differ only by the unit's gain at the harmonic, taken to differ by 30 % from
/// that at the line.
double share_of_harmonic(const vibration::Data& data, const Measured& measured, const Point& point) {
  const double turns = point.line.frequency * point.window;
  const double of_unit = vibration::sinc(point.hidden_harmonic * turns) / vibration::sinc(turns);
  const double of_reference = !measured.reference ? 0.0 : data.reference_integrated ? of_unit : 1.0;
  return std::hypot(of_unit - of_reference, 0.3 * of_unit);
}

void add_harmonics(const Evidence& evidence, const vibration::Data& data, const Measured& measured, Raw& raw) {
  std::map<std::size_t, std::vector<std::size_t>> motions;
  for (std::size_t i = 0; i < measured.points.size(); ++i)
    if (measured.points[i].hidden_harmonic > 0) motions[measured.points[i].motion].push_back(i);
  for (const auto& [motion, points] : motions) {
    const bool second = measured.points[points.front()].hidden_harmonic == 2;
    const double sd =
        rig_sd(evidence.plan, second ? names::second_harmonic : names::third_harmonic).value_or(usual_distortion);
    if (!(sd > 0.0)) continue;
    Component& component = raw.add("harmonic of the shake on the line");
    for (const std::size_t i : points)
      component.shift[raw.first_gain + i] = sd * share_of_harmonic(data, measured, measured.points[i]);
  }
}

/// A relative error of the level moves ln gain by -1 and A^2 by 2 of it.
void add_level(const Evidence& evidence, const Measured& measured, const std::vector<Rectification>& rectified,
               Raw& raw) {
  const double sd = measured.reference
                        ? evidence.plan.settings.number("reference_gain_sd")
                        : rig_sd(evidence.plan, names::shake_amplitude).value_or(0.0);  // a finding says so
  if (!(sd > 0.0)) return;
  Component& component = raw.add(measured.reference ? "reference gain" : "shake amplitude");
  for (std::size_t i = 0; i < measured.points.size(); ++i) component.shift[raw.first_gain + i] = -sd;
  for (std::size_t k = 0; k < rectified.size(); ++k)
    for (std::size_t j = 0; j < raw.coefficient[k].size(); ++j) {
      const std::size_t at = raw.coefficient[k][j];
      component.shift[at] = (j < rectified[k].ways.size() ? -2.0 : -4.0) * sd * raw.value[at];
    }
}

void add_scales(const vibration::Data& data, const Measured& measured, const std::vector<Rectification>& rectified,
                Raw& raw) {
  for (std::size_t u = 0; u < data.units.size(); ++u) {
    const double sd = data.units[u].scale_relative_sd;
    if (!(sd > 0.0)) continue;
    Component& component = raw.add("scale factor");
    for (std::size_t i = 0; i < measured.points.size(); ++i)
      if (measured.points[i].unit == u) component.shift[raw.first_gain + i] = sd;
    for (std::size_t k = 0; k < rectified.size(); ++k)
      if (rectified[k].unit == u)
        for (const std::size_t at : raw.coefficient[k]) component.shift[at] = sd * raw.value[at];
  }
}

/// Motion across the input axis: K_ip A_i A_p/2 is K_ip A_p/A_i of K_2,eff. A second harmonic of phase p: (3/4) K_3
/// A_1^2 A_2 cos p is (3/2) K_3 A_2 cos p of it.
void add_motion(const Evidence& evidence, const Measured& measured, const std::vector<Rectification>& rectified,
                Raw& raw) {
  const Settings& settings = evidence.plan.settings;
  double level = 0.0, distortion = 0.0, tones = 0.0;
  for (const Point& p : measured.points) {
    level += p.level / static_cast<double>(measured.points.size());
    if (std::isnan(p.distortion)) continue;
    distortion += p.distortion * p.distortion;
    ++tones;
  }
  distortion = tones > 0.0 ? std::sqrt(distortion / tones)
                           : rig_sd(evidence.plan, names::second_harmonic).value_or(usual_distortion);
  const double third = settings.number("third_order") * 1.5 * distortion * level / std::sqrt(2.0);
  for (std::size_t k = 0; k < rectified.size(); ++k) {
    for (const char* direction : {names::cross_motion_y, names::cross_motion_z}) {
      const double sd =
          settings.number("cross_coupling") * rig_sd(evidence.plan, direction).value_or(vibration::usual_cross_motion);
      if (!(sd > 0.0)) continue;
      Component& component = raw.add("motion across the input axis");
      for (const auto& way : rectified[k].ways) component.shift[raw.coefficient[k][way.column]] = sd;
    }
    if (!(third > 0.0)) continue;
    Component& component = raw.add("distortion of the shake");
    for (const auto& way : rectified[k].ways) component.shift[raw.coefficient[k][way.column]] = third;
  }
}

}  // namespace

std::vector<double> unit_vector(std::size_t size, std::size_t at) {
  std::vector<double> v(size, 0.0);
  v[at] = 1.0;
  return v;
}

Raw raw_of(const Evidence& evidence, const vibration::Data& data, const Measured& measured,
           const std::vector<Rectification>& rectified) {
  Raw raw;
  for (const auto& r : rectified) {
    raw.coefficient.emplace_back();
    for (std::size_t j = 0; j < r.ways.size() + (r.quartic ? 1 : 0); ++j) {
      raw.coefficient.back().push_back(raw.value.size());
      raw.value.push_back(r.fit.parameters[j]);
    }
  }
  raw.first_gain = raw.value.size();
  for (const auto& point : measured.points) raw.value.push_back(std::log(point.gain));
  for (std::size_t k = 0; k < rectified.size(); ++k) add_fit(rectified[k], raw.coefficient[k], raw);
  add_gain_noise(measured, raw);
  add_harmonics(evidence, data, measured, raw);
  add_level(evidence, measured, rectified, raw);
  add_scales(data, measured, rectified, raw);
  add_motion(evidence, measured, rectified, raw);
  return raw;
}

}  // namespace tumble::sine_vibration
