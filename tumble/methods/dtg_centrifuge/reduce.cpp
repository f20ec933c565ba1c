#include "tumble/methods/dtg_centrifuge/reduce.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::dtg_centrifuge {
namespace {

/// [1] of the square of a line of the reference, below which scatter is rounding.
constexpr double reference_rounding = 1e-26;
/// [1] and [rad] of the relation between gyro and reference. Without other evidence the relation counts as known to
/// this; beyond it the relation is a finding, and contradicts no statement.
constexpr double poorly_known = 0.1;
/// [rad] nearer to another axis than to the stated.
constexpr double other_axis = 0.25 * pi, other_direction = 0.75 * pi;
constexpr double differs_sd = 5.0;  ///< [sd] beyond the greatest error: p = 6e-7

double spin_of(const Measured& m) { return m.stretch->spin_up; }

/// Rates are alike that would give the same level in words.
long key_of(double rate) { return std::lround(rate * 1e3); }

/// Spin axis up before down, then by the rates.
using Key = std::tuple<int, long, long>;
Key key_of(const Spin& s) {
  return {s.spin_up > 0.0 ? 0 : 1, key_of(std::abs(s.arm_rate)), key_of(std::abs(s.table_rate))};
}

/// Mean lines of one power-up (or one level, where no encoder says the heading) in two gyros.
struct Pair {
  Complex output, reference;  ///< weighted sums
  double weight = 0.0;
  std::vector<std::pair<Complex, Complex>> part;
  std::vector<double> part_weight;
};

double variance_of_mean(const Pair& pair, Complex c, bool of_reference) {
  double sum = 0.0, weight = 0.0, count = 0.0;
  const Complex mean = of_reference ? pair.reference / pair.weight : (pair.output - c * pair.reference) / pair.weight;
  for (std::size_t k = 0; k < pair.part.size(); ++k) {
    const Complex one = of_reference ? pair.part[k].second : pair.part[k].first - c * pair.part[k].second;
    sum += pair.part_weight[k] * std::norm(one - mean);
    weight += pair.part_weight[k];
    count += 1.0;
  }
  return count > 1.0 ? sum / (2.0 * weight * (count - 1.0)) : 0.0;  // of each of two components
}

std::vector<Pair> pairs_of(const std::vector<Measured>& measured, Signal output, bool encoders) {
  std::map<std::pair<std::size_t, double>, Pair> pairs;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const Measured& m = measured[i];
    const auto group = encoders ? std::pair(m.stretch->start, spin_of(m)) : std::pair(i, 0.0);
    const Lines &a = m.of[output], &b = m.of[reference];
    if (!a.present || !b.present) continue;
    Pair& pair = pairs[group];
    const bool down = spin_of(m) < 0.0;
    const auto facing = [down](Complex z) { return down ? std::conj(z) : z; };
    for (std::size_t k = 0; k < a.part.size(); ++k) {
      const double weight = std::min(a.weight[k] * a.step, b.weight[k] * b.step);
      if (!(weight > 0.0)) continue;
      pair.part.emplace_back(facing(a.part[k].earth), facing(b.part[k].earth));
      pair.part_weight.push_back(weight);
      pair.output += weight * pair.part.back().first;
      pair.reference += weight * pair.part.back().second;
      pair.weight += weight;
    }
  }
  std::vector<Pair> out;
  for (auto& [key, pair] : pairs)
    if (pair.weight > 0.0) out.push_back(std::move(pair));
  return out;
}

/// c = sum w E_g conj(E_f) / sum w |E_f|^2, less what the noise alone gives the denominator.
struct Ratio {
  Complex c = 1.0;
  double sd = 0.0;  ///< of each part of ln c
  bool known = false;
};

Ratio ratio_of(const std::vector<Pair>& pairs) {
  Ratio out;
  for (int round = 0; round < 3; ++round) {
    Complex above = 0.0;
    double below = 0.0, information = 0.0;
    for (const Pair& pair : pairs) {
      const Complex e = pair.output / pair.weight, f = pair.reference / pair.weight;
      const double scatter = variance_of_mean(pair, out.c, false), own = 2.0 * variance_of_mean(pair, out.c, true);
      const double weight = 1.0 / std::max(scatter, reference_rounding * std::norm(f));
      above += weight * e * std::conj(f);
      below += weight * (std::norm(f) - own);
      information += weight * std::norm(e);
    }
    if (!(below > 0.0) || std::abs(above) == 0.0) return {};
    out.c = above / below;
    out.sd = std::sqrt(1.0 / information);
    out.known = true;
  }
  return out;
}

/// Mean of two values with their standard deviations; an sd of 0 or infinity decides.
void combine(double& value, double& sd, double other, double other_sd) {
  if (!std::isfinite(other_sd)) return;
  if (!std::isfinite(sd) || other_sd == 0.0) {
    value = other;
    sd = other_sd;
    return;
  }
  const double share = sd * sd / (sd * sd + other_sd * other_sd);
  value += share * (other - value);
  sd = std::sqrt(share) * other_sd;
}

/// [1] of the rates, within which a level is carried out as planned, or as another one is.
constexpr double same_rate_of_level = 0.01;

bool turns_as(const Measured& m, const Spin& planned) {
  return std::abs(m.arm_rate / planned.arm_rate - 1.0) < same_rate_of_level &&
         std::abs(m.table_rate / planned.table_rate - 1.0) < same_rate_of_level;
}

}  // namespace

void assign_levels(Test& test, std::vector<Measured>& measured, Findings& findings) {
  Occurrences others{0, {}, {}};
  std::string other;
  for (Measured& m : measured) {
    Spin& spin = test.levels[static_cast<std::size_t>(m.stretch - test.levels.data())];
    if (turns_as(m, spin)) continue;
    const auto as = std::ranges::find_if(test.planned, [&](const Spin& planned) {
      return planned.spin_up == spin.spin_up && planned.arm_rate * spin.arm_rate > 0.0 && turns_as(m, planned);
    });
    if (as == test.planned.end()) continue;
    if (others.count++ == 0) others.first = where_of(spin), other = as->label;
    spin.arm_rate = as->arm_rate;
    spin.table_rate = as->table_rate;
  }
  if (others.count > 0)
    findings.push_back({Finding::Severity::warning, "level_turns_as_another", {{"other", other}}, "", others});
}

Reduction reduction_of(const Test& test, const std::vector<Measured>& measured) {
  Reduction out;
  std::map<Key, std::vector<std::size_t>> cells;
  for (const Spin& planned : test.planned) cells[key_of(planned)];
  for (std::size_t i = 0; i < measured.size(); ++i) cells[key_of(*measured[i].stretch)].push_back(i);
  out.level_of.resize(measured.size());
  out.nominal.resize(measured.size());
  std::size_t number = 0;
  for (const auto& [key, members] : cells) {
    ++number;
    if (members.empty()) continue;
    Level level{.spin_up = measured[members.front()].stretch->spin_up,
                .label = measured[members.front()].stretch->label,
                .number = number};
    std::map<std::pair<const Plan*, double>, std::size_t> first_of;  // alike in every power-up
    for (const std::size_t i : members) {
      const Measured& m = measured[i];
      const Plan* plan = test.power_ups[m.stretch->power_up].plan;
      const auto [known, fresh] = first_of.try_emplace({plan, m.stretch->arm_rate}, i);
      out.nominal[i] = fresh ? rig_lines_of(test, *m.stretch) : out.nominal[known->second];
      out.level_of[i] = out.levels.size();
      const double share = 1.0 / static_cast<double>(members.size());
      level.arm_rate += share * std::abs(m.arm_rate);
      level.table_rate += share * m.table_rate * (m.arm_rate < 0.0 ? -1.0 : 1.0);
      level.force += share * std::abs(force_of(out.nominal[i], m.arm_rate, 0.0, 0.0));
      level.force_along += share * out.nominal[i].force_along;
    }
    out.levels.push_back(level);
  }
  return out;
}

Relation relation_of(const std::vector<Measured>& measured, Signal output, const Settings& settings, bool encoders,
                     Findings& findings) {
  constexpr double unknown = std::numeric_limits<double>::infinity();
  const double right_angle = output == gyro_y ? -half_pi : 0.0;  // the reference lies beside X
  Relation out{.log_gain_sd = unknown, .azimuth_sd = unknown, .from_earth = false, .earth_sd = unknown};
  if (const Ratio ratio = ratio_of(pairs_of(measured, output, encoders)); ratio.known) {
    out.log_gain = std::log(std::abs(ratio.c));
    out.azimuth = -std::arg(ratio.c);
    out.earth_log_gain = out.log_gain;
    out.earth_azimuth = out.azimuth;
    out.log_gain_sd = out.azimuth_sd = out.earth_sd = ratio.sd;
    out.from_earth = true;
  }
  const bool gain_known = settings.has("reference_gain_sd"), azimuth_known = settings.has("reference_azimuth_sd");
  if (gain_known)
    combine(out.log_gain, out.log_gain_sd, -std::log(settings.number("reference_gain")),
            settings.number("reference_gain_sd"));
  if (azimuth_known) {
    const double known = settings.number("reference_azimuth") + right_angle;
    const double turns = std::round((out.azimuth - known) / two_pi);
    out.azimuth -= two_pi * turns;
    combine(out.azimuth, out.azimuth_sd, known, settings.number("reference_azimuth_sd"));
  }
  if (!std::isfinite(out.log_gain_sd)) out.log_gain = 0.0, out.log_gain_sd = poorly_known;
  if (!std::isfinite(out.azimuth_sd)) out.azimuth = right_angle, out.azimuth_sd = poorly_known;
  if (std::max(out.log_gain_sd, out.azimuth_sd) > poorly_known || !out.from_earth)
    if (!gain_known || !azimuth_known)
      findings.push_back({Finding::Severity::warning,
                          "reference_poorly_known",
                          {{"sd", std::min(1.0, out.earth_sd), "%"}},
                          output == gyro_y ? "gyro_y" : "gyro"});
  return out;
}

void check_relation(const Relation& relation, Signal output, const Settings& settings, Findings& findings) {
  constexpr double greatest_gain_error = 0.2;  // [1] of any gyro and its electronics
  if (!relation.from_earth || relation.earth_sd > poorly_known) return;
  const char* channel = output == gyro_y ? "gyro_y" : "gyro";
  const double right_angle = output == gyro_y ? -half_pi : 0.0;
  const double stated = settings.number("reference_azimuth"), shown = relation.earth_azimuth - right_angle;
  const double off = std::abs(std::remainder(shown - stated, two_pi));
  if (off > other_axis)
    findings.push_back(
        {Finding::Severity::error,
         off > other_direction ? "gyro_reversed" : "gyro_axis_is_another",
         {{"output", channel}, {"azimuth", std::remainder(shown, two_pi), "deg"}, {"stated", stated, "deg"}},
         channel});
  const double gain = std::exp(-relation.earth_log_gain);
  if (std::abs(std::log(gain / settings.number("reference_gain"))) >
      std::log1p(greatest_gain_error) + differs_sd * relation.earth_sd)
    findings.push_back({Finding::Severity::error,
                        "gyro_gain_far_from_stated",
                        {{"output", channel}, {"gain", gain}, {"stated", settings.number("reference_gain")}},
                        channel});
}

Complex force_of(const RigLines& nominal, double arm_rate, Complex true_rate, double gravity) {
  const double ratio = arm_rate / nominal.arm_rate;
  return nominal.force[0].line[0] * ratio * ratio + (gravity == 0.0 ? 0.0 : gravity / arm_rate * true_rate);
}

Observation observe(const Measured& m, const Reduction& reduction, std::size_t index, Signal output,
                    const Relation& relation, Complex sensitivity, bool phase_known) {
  Observation out;
  const RigLines& nominal = reduction.nominal[index];
  const double sigma = spin_of(m), gravity = std::abs(nominal.force_along);
  const Complex c = std::conj(relation.c(sigma));
  const Lines &g = m.of[output], &f = m.of[reference];
  const double a = std::abs(force_of(nominal, m.arm_rate, 0.0, 0.0));
  const Complex own = a * (sigma < 0.0 ? std::conj(sensitivity) : sensitivity);
  out.measured = index;
  out.level = reduction.level_of[index];
  out.power_up = m.stretch->start;
  out.raw = g.value.line[0];
  out.true_rate = c * (f.value.line[0] - own);
  // first_of from X: the output Y shows what is fixed to the arm a right angle later
  const Complex along_x = output == gyro_y ? Complex(0.0, sigma) : 1.0;
  out.force = force_of(nominal, m.arm_rate, out.true_rate * along_x, phase_known ? gravity : 0.0);
  const auto facing = [sigma](Complex y) { return Complex(y.real(), -sigma * y.imag()); };
  const Complex turn = -out.force / std::abs(out.force);
  const double size = std::abs(out.force);
  const bool both = output == gyro;  // the reference lies along X: what both see there is true rate
  const double gain = both ? std::exp(relation.log_gain) : 0.0;
  const auto term = [&](const Phasors& x, const Phasors& y) {
    return facing((x.line[0] - c * (y.line[0] - own)) / out.force);
  };
  const auto harmonic = [&](const Phasors& x, const Phasors& y, int h) {
    return facing((x.line[static_cast<std::size_t>(h - 1)] - gain * y.line[static_cast<std::size_t>(h - 1)]) /
                  std::pow(turn, h) / std::pow(size, h));
  };
  out.value = term(g.value, f.value);
  out.second = harmonic(g.value, f.value, 2);
  out.third = harmonic(g.value, f.value, 3);
  for (std::size_t k = 0; k < g.part.size(); ++k) {
    const double weight = std::min(g.weight[k] * g.step, f.weight[k] * f.step);
    if (!(weight > 0.0)) continue;
    out.part.push_back(term(g.part[k], f.part[k]));
    out.second_part.push_back(harmonic(g.part[k], f.part[k], 2));
    out.third_part.push_back(harmonic(g.part[k], f.part[k], 3));
    out.weight.push_back(weight * size * size);
  }
  return out;
}

}  // namespace tumble::dtg_centrifuge
