#include "tumble/methods/imu_ferraris/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/math/median.hpp"
#include "tumble/methods/imu_ferraris/leaning.hpp"
#include "tumble/methods/imu_ferraris/turn_causes.hpp"
#include "tumble/reduce/imu/axes_check.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::imu_ferraris {
namespace {

using imu::Kind;
using imu::letters;

constexpr double turns_apart = 0.1;           ///< by which the gyros' outputs for the three turns may differ
constexpr double restless = 25.0;             ///< variance of a pose over the median of all
constexpr double gravity_apart = 5e-3;        ///< relative
constexpr double greatest_scale_error = 0.2;  ///< of an output in units of its input

bool is_si(const Recorded& recorded, std::size_t output) {
  return recorded.kind[output] == (output < 3 ? QuantityKind::specific_force : QuantityKind::angular_rate);
}

/// Output over input: "LSB/(deg/s)", or a plain number where the output is in units of the input.
Unit per(const Recorded& recorded, std::size_t output, const char* input) {
  const auto& text = recorded.unit[output].text();
  const bool compound = text.find_first_of("/* ") != std::string::npos;
  return Unit::parse(fmt::format("{}/({})", compound ? "(" + text + ")" : text, input));
}

Unit scale_unit(const Recorded& recorded, std::size_t output) {
  return is_si(recorded, output) ? Unit() : per(recorded, output, output < 3 ? "m/s^2" : "deg/s");
}

Unit sensitivity_unit(const Recorded& recorded, std::size_t output) {
  return is_si(recorded, output) ? Unit::parse("deg/s/g") : per(recorded, output, "m/s^2");
}

double middle(Vector3 k) { return median({k.x, k.y, k.z}); }

Vector3 force_of(const Calibration& c, Vector3 output) { return inverse(response(c.k_a, c.r_a)) * (output - c.b_a); }

}  // namespace

std::vector<Parameter> named_parameters(const Recorded& recorded) {
  std::vector<Parameter> all;
  const auto add = [&](const std::string& name, std::string symbol, Unit unit, std::string description) {
    all.push_back({name, std::move(symbol), std::move(unit), 0.0, std::move(description)});
  };
  const Unit degree = Unit::parse("deg");
  for (std::size_t k = 0; k < (recorded.gyros ? outputs : 3); ++k) {
    const std::size_t i = k % 3;
    const char a = k < 3 ? 'a' : 'g';
    const std::string role = imu::role_of(k < 3 ? Kind::accelerometer : Kind::gyro, i);
    const std::size_t before = all.size();
    add(role + "_scale_factor", fmt::format("K_{},{}", a, letters[i]), scale_unit(recorded, k),
        "output for a unit along the input axis");
    add(role + "_bias", fmt::format("b_{},{}", a, letters[i]), recorded.unit[k], "output at no input");
    for (std::size_t j = 0; j < 3; ++j)
      if (j != i)
        add(fmt::format("{}_misalignment_{}", role, letters[j]), fmt::format("R_{},{}{}", a, letters[i], letters[j]),
            degree, fmt::format("the input axis leans toward {} (direction cosine)", letters[j]));
    for (std::size_t j = 0; k >= 3 && j < 3; ++j)
      add(fmt::format("{}_acceleration_sensitivity_{}", role, letters[j]),
          fmt::format("K_ga,{}{}", letters[i], letters[j]), sensitivity_unit(recorded, k),
          fmt::format("output for specific force along {}", letters[j]));
    for (std::size_t p = before; p < all.size(); ++p) all[p].channels = {role};
  }
  return all;
}

Table matrices(const Calibration& c, const Recorded& recorded) {
  struct Row {
    const char* matrix;
    std::string row;
    Unit unit;
    Vector3 v;  ///< [SI]
  };
  std::vector<Row> rows;
  const auto row = [&](const char* name, std::size_t i, const Unit& unit, Vector3 v) {
    rows.push_back({name, i < 3 ? std::string(1, letters[i]) : "", unit, v});
  };
  const auto diagonal = [&](const char* name, std::size_t first, Vector3 k) {
    for (std::size_t i = 0; i < 3; ++i)
      row(name, i, scale_unit(recorded, first + i), {i == 0 ? k.x : 0.0, i == 1 ? k.y : 0.0, i == 2 ? k.z : 0.0});
  };
  const auto full = [&](const char* name, const Matrix3& m, const auto& unit) {
    for (std::size_t i = 0; i < 3; ++i) row(name, i, unit(i), m[i]);
  };
  const auto pure = [](std::size_t) { return Unit(); };
  diagonal("K_a", 0, c.k_a);
  full("R_a", c.r_a, pure);
  row("b_a", 3, recorded.unit[0], c.b_a);
  if (c.gyros) {
    diagonal("K_g", 3, c.k_g);
    full("R_g", c.r_g, pure);
    row("b_g", 3, recorded.unit[3], c.b_g);
    full("K_ga", c.k_ga, [&](std::size_t i) { return sensitivity_unit(recorded, 3 + i); });
  }
  return tabulate(
      "matrices",
      "output = K R input + K_ga f + b, in the units of the column 'unit'; input = R^-1 K^-1 (output - K_ga f - b)",
      rows,
      {{"matrix", &Row::matrix},
       {"row", &Row::row},
       {"unit", [](const Row& r) { return r.unit.text().empty() ? "1" : r.unit.text(); }},
       {"x", [](const Row& r) { return r.v.x / r.unit.factor(); }},
       {"y", [](const Row& r) { return r.v.y / r.unit.factor(); }},
       {"z", [](const Row& r) { return r.v.z / r.unit.factor(); }}});
}

Table pose_table(const Means& means, const Calibration& calibration, const Recorded& recorded) {
  const auto residual = [&](std::size_t p) { return norm(force_of(calibration, means.force[p])) - means.gravity; };
  return tabulate("poses", "the calibrated specific force of each pose; the residual is its size less gravity", poses,
                  {{"section", [](std::size_t p) { return labels()[p]; }},
                   {"samples", [&](std::size_t p) { return recorded.section[p].samples; }},
                   {"time", "s", [&](std::size_t p) { return recorded.section[p].time; }},
                   {"residual", "mg", residual}});
}

Extremes greatest(const Calibration& c, const Recorded& recorded) {
  Extremes out;
  const Matrix3 of_force = inverse(response(c.k_a, c.r_a));
  const Matrix3 of_rate = c.gyros ? inverse(response(c.k_g, c.r_g)) : Matrix3{};
  const auto widen = [](Vector3& by, Vector3 with) {
    for (std::size_t i = 0; i < 3; ++i) by[i] = std::max(by[i], std::abs(with[i]));
  };
  for (std::size_t s = 0; s < (c.gyros ? sections : poses); ++s)
    for (const auto* extremes : {&recorded.section[s].least, &recorded.section[s].greatest}) {
      const auto& v = *extremes;
      widen(out.force, of_force * (Vector3{v[0], v[1], v[2]} - c.b_a));
      if (c.gyros) widen(out.rate, of_rate * (Vector3{v[3], v[4], v[5]} - c.b_g));
    }
  return out;
}

Table covered(const Calibration& c, const Recorded& recorded) {
  const auto [rate, force] = greatest(c, recorded);
  return tabulate(
      "covered", "the greatest rates and specific forces of the session: beyond them a compensation is extrapolated", 3,
      {{"axis", [](std::size_t i) { return std::string(1, letters[i]); }},
       {"rate", "deg/s", [&rate = rate](std::size_t i) { return rate[i]; }},
       {"specific_force", "g", [&force = force](std::size_t i) { return force[i]; }}});
}

namespace {

/// What is said of the segments of a plan, said of the sections of a session.
Finding of_section(Finding finding) {
  if (finding.code == "segment_reads_as_another") return {finding.severity, "section_reads_as_another", finding.values};
  if (finding.code == "segment_reads_as_none") return {finding.severity, "section_reads_as_none", finding.values};
  if (finding.code == "more_segments_deviate") return {finding.severity, "more_sections_deviate", finding.values};
  return finding;
}

/// Adds the findings about a triad with this severity, and after them what could be their reason as well.
void take(Findings from, Finding::Severity severity, const char* other_reason, Findings& to) {
  if (from.empty()) return;
  for (auto& finding : from) {
    finding.severity = severity;
    to.push_back(of_section(std::move(finding)));
  }
  to.push_back({severity, other_reason, {}});
}

/// Raw outputs are compared with each other, those in units of the input with it.
double size_of(const Recorded& recorded, std::size_t first, Vector3 k) {
  return is_si(recorded, first) ? 1.0 : middle(k);
}

void about_accelerometers(const Means& means, const Calibration& c, const Recorded& recorded,
                          Finding::Severity severity, Findings& findings) {
  std::vector<Vector3> felt, shown;
  std::vector<std::string> names;
  const double size = size_of(recorded, 0, c.k_a);
  for (std::size_t p = 0; p < poses; ++p) {
    const double g = sign_of(p) * means.gravity;
    felt.push_back({axis_of(p) == 0 ? g : 0.0, axis_of(p) == 1 ? g : 0.0, axis_of(p) == 2 ? g : 0.0});
    shown.push_back((1.0 / size) * means.force[p]);
    names.push_back(labels()[p]);
  }
  take(imu::about_triad(Kind::accelerometer, felt, imu::without_offsets(felt, shown), names,
                        {recorded.channel[0], recorded.channel[1], recorded.channel[2]}),
       severity, "labels_may_be_exchanged", findings);
}

void about_gyros(const Calibration& c, const Recorded& recorded, Finding::Severity severity, Findings& findings) {
  const Matrix3 shown = response(c.k_g, c.r_g) / size_of(recorded, 3, c.k_g);
  take(imu::about_axes(Kind::gyro, imu::axes_seen(dense(shown)),
                       {recorded.channel[3], recorded.channel[4], recorded.channel[5]}),
       severity, "turns_may_be_reversed", findings);
}

/// The angle by which the turns were made if the gyros count rightly: a simple multiple of the stated angle, where that
/// explains what they show. Outputs in units of the input alone show it.
void about_all_turns(const Means& means, const Calibration& c, const Recorded& recorded, Findings& findings) {
  if (!is_si(recorded, 3)) return;
  const Matrix3 m = response(c.k_g, c.r_g);
  const double ratio = median({norm(column(m, 0)), norm(column(m, 1)), norm(column(m, 2))});
  if (ratio < 0.5 || ratio > 2.0 || std::abs(ratio - 1.0) <= greatest_scale_error) return;  // beyond: a wrong unit
  const double quarter = std::round(4.0 * ratio * means.angle[0] / two_pi) * 0.25 * two_pi;
  findings.push_back({Finding::Severity::error,
                      "turns_of_another_angle",
                      {{"ratio", ratio}, {"angle", quarter, "deg"}, {"stated", means.angle[0], "deg"}}});
}

/// A turn of 270 deg taken for 360 looks like a scale factor of 0.75: the other turns show the difference.
void about_turns(const Means& means, const Calibration& c, Findings& findings) {
  const Matrix3 m = response(c.k_g, c.r_g);
  std::vector<double> shown;
  for (std::size_t t = 0; t < turns; ++t) shown.push_back(norm(column(m, t)));
  const double usual = median(shown);
  for (std::size_t t = 0; t < turns; ++t) {
    const double ratio = shown[t] / usual;
    if (std::abs(ratio - 1.0) <= turns_apart) continue;
    findings.push_back({Finding::Severity::error,
                        "turn_differs_from_others",
                        {{"section", labels()[poses + t]},
                         {"ratio", ratio},
                         {"angle", ratio * means.angle[t], "deg"},
                         {"stated", means.angle[t], "deg"},
                         {"gyro", imu::role_of(Kind::gyro, t)}},
                        labels()[poses + t]});
  }
}

/// The bias at the ends of a turn that are at rest is another than in the poses.
void about_bias(const Means& means, const Calibration& c, const Recorded& recorded, Findings& findings) {
  const auto changes = bias_changes(means, c, recorded);
  for (std::size_t t = 0; t < turns; ++t)
    for (std::size_t k = 0; k < 3; ++k)
      if (changes[t][k] != 0.0)
        findings.push_back({Finding::Severity::warning,
                            "bias_in_turn_differs",
                            {{"channel", recorded.channel[3 + k]},
                             {"change", changes[t][k], recorded.unit[3 + k]},
                             {"share", std::abs(changes[t][k] * means.turn_time[t] / means.turned[t][t]), "%"}},
                            labels()[poses + t]});
}

void about_rests(const Recorded& recorded, Findings& findings) {
  for (std::size_t k = 0; k < (recorded.gyros ? outputs : 3); ++k) {
    std::vector<double> densities;
    for (std::size_t p = 0; p < poses; ++p) densities.push_back(recorded.section[p].density[k]);
    const double usual = median(densities);
    for (std::size_t p = 0; p < poses; ++p)
      if (densities[p] > restless * usual && usual > 0.0)
        findings.push_back({Finding::Severity::warning,
                            "pose_not_at_rest",
                            {{"channel", recorded.channel[k]}, {"times", std::sqrt(densities[p] / usual)}},
                            labels()[p]});
  }
}

void about_gravity(const Means& means, const Calibration& calibration, Findings& findings) {
  for (std::size_t p = 0; p < poses; ++p) {
    const double share = norm(force_of(calibration, means.force[p])) / means.gravity - 1.0;
    if (std::abs(share) > gravity_apart)
      findings.push_back({Finding::Severity::warning,
                          "force_differs_from_gravity",
                          {{"share", share, "%"}, {"lean", std::sqrt(2.0 * std::abs(share)), "deg"}},
                          labels()[p]});
  }
}

}  // namespace

Findings faults(const Plan& plan, const Means& means, const Calibration& calibration, const Recorded& recorded) {
  const auto severity = plan.settings.word("axes") == "any" ? Finding::Severity::warning : Finding::Severity::error;
  Findings findings;
  about_accelerometers(means, calibration, recorded, severity, findings);
  if (calibration.gyros) {
    about_gyros(calibration, recorded, severity, findings);
    about_turns(means, calibration, findings);
    about_all_turns(means, calibration, recorded, findings);
    about_bias(means, calibration, recorded, findings);
  }
  about_rests(recorded, findings);
  about_gravity(means, calibration, findings);
  for (auto& finding : leaning_poses(means, calibration)) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace tumble::imu_ferraris
