#include "tumble/methods/dtg_centrifuge/describe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "tumble/core/columns.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/stability/allan_fit.hpp"
#include "tumble/methods/dtg_centrifuge/curves.hpp"
#include "tumble/methods/dtg_centrifuge/lag.hpp"
#include "tumble/methods/dtg_centrifuge/levels.hpp"
#include "tumble/methods/dtg_centrifuge/residuals.hpp"

namespace tumble::dtg_centrifuge {
namespace {

using Severity = Finding::Severity;

/// [sd] below it the size of a level is not significant: noise makes sizes, too.
constexpr double significant_size = 3.0;
/// [1] of the variance within power-ups, that the variance between them must exceed: a smaller one is not
/// distinguished.
constexpr double least_between = 0.05;

Group group_of(const Quantities& quantities) {
  return {quantities.value.size(), quantities.fit.sources,
          [fit = quantities.fit](const std::vector<double>& function) { return degrees_of_freedom(fit, function); }};
}

void add_levels(const Outcome& outcome, const std::vector<Level>& levels, std::size_t group, Ledger& ledger,
                Findings& findings) {
  const Levels of(outcome, levels);
  Occurrences insignificant{.count = 0, .first = {}, .worst = {}};
  double least = INFINITY;  // K over its uncertainty
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const Function K = of.K(l);
    const std::string where = fmt::format(
        "{:.4g} g{}", levels[l].force / si(1.0, "g"),
        outcome.polynomial.both_orientations ? (levels[l].spin_up > 0.0 ? ", spin axis up" : ", spin axis down") : "");
    const std::size_t number = levels[l].number;
    ledger.add({fmt::format("sensitive_term_{}", number), fmt::format("K_{}", number), sensitivity(), K.value,
                "vector sum of the first-order specific-force-sensitive drift at " + where},
               {{group, K.gradient}});
    const double sd = std::sqrt(ledger.variance({{group, K.gradient}}));
    if (!(K.value < significant_size * sd)) continue;
    const Place level(fmt::format("sensitive_term_{}", number));
    if (insignificant.count++ == 0) insignificant.first = level;
    if (K.value / sd < least) least = K.value / sd, insignificant.worst = level;
  }
  if (insignificant.count > 0)
    findings.push_back({Severity::warning, "sensitive_term_not_significant", {{"ratio", least}}, "", insignificant});
  for (std::size_t l = 0; l < levels.size(); ++l) {
    if (of.first(l) == l) continue;
    const bool by_polynomial = outcome.corrected && of.bends();
    const Function zeta = by_polynomial ? of.zeta_fitted(l) : of.zeta(l);
    if (!std::isfinite(zeta.value)) continue;
    const std::size_t number = levels[l].number;
    ledger.add({fmt::format("nonlinearity_{}", number), fmt::format("zeta_{}", number), Unit::parse("%"), zeta.value,
                fmt::format("K_{0} over K_{1} less one{2}", number, levels[of.first(l)].number,
                            by_polynomial ? ", by the polynomial through all levels" : "")},
               {{group, zeta.gradient}});
  }
}

/// Coefficients of the drift from the polynomial and the third harmonic.
struct Coefficients {
  const Outcome& outcome;
  std::size_t levels, third;  ///< groups
  std::string prefix, symbol;

  std::vector<double> of(std::size_t part, std::size_t index) const {
    const Polynomial& p = outcome.polynomial;
    std::vector<double> row(outcome.levels.value.size());
    for (std::size_t n = 0; n < row.size(); ++n) row[n] = p.of_levels(part * p.each() + index, n);
    return row;
  }
  double value(std::size_t part, std::size_t index) const {
    return outcome.polynomial.value[part * outcome.polynomial.each() + index];
  }
  Parameter named(const std::string& letters, const std::string& unit, double value, const std::string& words) const {
    return {prefix + "D_" + letters, symbol + letters, Unit::parse(unit), value, words};
  }
};

/// D_x and D_y; with both orientations of the spin axis D_xz and D_yz.
void add_linear(const Coefficients& c, double force_along, Ledger& ledger, Findings& findings) {
  const bool both = c.outcome.polynomial.both_orientations;
  const std::string up = force_along > 0.0 ? "+1 g" : "-1 g";
  const char* letters[] = {"x", "y"};
  for (std::size_t part = 0; part < 2; ++part) {
    const std::string x = letters[part], X = part == 0 ? "X" : "Y";
    ledger.add(c.named(x, "deg/h/g", c.value(part, 0),
                       both ? "drift per f_" + X : fmt::format("means D_{0} + D_{0}z f_Z with f_Z = {1}", x, up)),
               {{c.levels, c.of(part, 0)}});
    if (both)
      ledger.add(c.named(x + "z", "deg/h/g^2", c.value(part, 1), "drift per f_" + X + " f_Z"),
                 {{c.levels, c.of(part, 1)}});
  }
  if (!both)
    findings.push_back(
        {Severity::info,
         force_along > 0.0 ? "only_spin_axis_up" : "only_spin_axis_down",
         {{"x", c.prefix + "D_x"}, {"y", c.prefix + "D_y"}, {"force", si(force_along > 0.0 ? 1.0 : -1.0, "g"), "g"}}});
}

/// D_xxx and D_xyy, or D_yyy and D_yxx. Third harmonic: D_xxx - D_xyy = -4 C_3/a^3, D_yyy - D_yxx = 4 S_3/a^3; first:
/// 3/4 D_xxx + 1/4 D_xyy = p_2.
void add_cubic(const Coefficients& c, std::size_t part, Ledger& ledger) {
  const Polynomial& p = c.outcome.polynomial;
  const std::size_t cubic = p.both_orientations ? 2 : 1;
  const HarmonicPart of_third = harmonic_part(*c.outcome.third, part, c.outcome.levels, p);
  const double sign = part == 0 ? -1.0 : 1.0, t = 4.0 * sign * of_third.value;
  const auto gradient = [&](double factor) {
    const double times = 4.0 * sign * factor;
    return Ledger::Gradient{{c.levels, scaled_sum(c.of(part, cubic), times, of_third.by_levels)},
                            {c.third, scaled(times, of_third.by_harmonic)}};
  };
  const double p2 = c.value(part, cubic);
  const char* description = "from the first and third harmonic over specific force";
  ledger.add(c.named(part == 0 ? "xxx" : "yyy", "deg/h/g^3", p2 + 0.25 * t, description), gradient(0.25));
  ledger.add(c.named(part == 0 ? "xyy" : "yxx", "deg/h/g^3", p2 - 0.75 * t, description), gradient(-0.75));
  if (p.powers > 1)
    ledger.add({c.prefix + (part == 0 ? "p_4" : "q_4"), part == 0 ? "p_4" : "q_4", Unit::parse("deg/h/g^5"),
                c.value(part, cubic + 1),
                "coefficient of a^4 in the first-order term along " + std::string(part == 0 ? "X" : "Y")},
               {{c.levels, c.of(part, cubic + 1)}});
}

constexpr const char* order_names[] = {"constant", "cubic", "quintic"};

/// Says which lower order the levels would do with, where the order was not stated.
void add_order(const Polynomial& polynomial, const std::string& prefix, Findings& findings) {
  const auto lowest = std::ranges::min_element(polynomial.tried, {}, &Order::aicc);
  if (!polynomial.automatic || lowest->powers >= polynomial.powers) return;
  findings.push_back({Severity::info,
                      "lower_order_is_enough",
                      {{"x", prefix + "D_x"}, {"y", prefix + "D_y"}, {"order", order_names[lowest->powers]}}});
}

void add_coefficients(const Coefficients& c, double force_along, Ledger& ledger, Findings& findings) {
  add_linear(c, force_along, ledger, findings);
  add_order(c.outcome.polynomial, c.prefix, findings);
  if (c.outcome.polynomial.powers == 0) {
    findings.push_back(
        {Severity::info, "drift_is_linear_in_force", {{"x", c.prefix + "D_x"}, {"y", c.prefix + "D_y"}}});
    return;
  }
  for (std::size_t part = 0; part < 2; ++part) add_cubic(c, part, ledger);
}

void add_second(const Outcome& outcome, const std::string& prefix, const std::string& symbol, std::size_t levels,
                std::size_t group, Ledger& ledger) {
  const auto add = [&](std::size_t part, Parameter parameter) {
    const HarmonicPart half = harmonic_part(*outcome.second, part, outcome.levels, outcome.polynomial);
    parameter.value = 2.0 * half.value;
    ledger.add(std::move(parameter), {{levels, scaled(2.0, half.by_levels)}, {group, scaled(2.0, half.by_harmonic)}});
  };
  const Unit unit = Unit::parse("deg/h/g^2");
  add(0, {prefix + "D_xx_less_D_yy", symbol + "xx - " + symbol + "yy", unit, 0.0, "from the second harmonic"});
  add(1, {prefix + "D_xy", symbol + "xy", unit, 0.0, "drift per f_X f_Y, from the second harmonic"});
}

void add_relation(const Relation& relation, double by_lag, Ledger& ledger) {
  Matrix covariance(2, 2), of_lag(2, 2);
  covariance(0, 0) = std::pow(relation.log_gain_sd, 2);
  covariance(1, 1) = std::pow(relation.azimuth_sd, 2);
  of_lag(1, 1) = by_lag * by_lag;
  const std::size_t group =
      ledger.add(Group{2, {{relation_source, covariance}, {lag_source, of_lag}}, [](const std::vector<double>&) {
                         return std::numeric_limits<double>::infinity();
                       }});
  if (!(covariance(0, 0) > 0.0) || !(covariance(1, 1) > 0.0)) return;
  const double gain = std::exp(-relation.log_gain);
  ledger.add({"reference_gain", "S_f/S_g", Unit(), gain, "scale factor of the reference gyro over that of the gyro"},
             {{group, {-gain, 0.0}}});
  ledger.add({"reference_azimuth", "eta", Unit::parse("deg"), relation.azimuth,
              "input axis of the reference gyro from X toward Y"},
             {{group, {0.0, 1.0}}});
}

/// The lag of a loop that nobody stated, and what it does to the answer.
void add_lag(const Outcome& outcome, const std::string& prefix, std::size_t group, Ledger& ledger, Findings& findings) {
  const Lag& lag = outcome.lag;
  if (lag.stated || !outcome.corrected) return;
  const Unit unit = Unit::parse("ms");
  const std::string whose = prefix.empty() ? "gyro" : "gyro_y";
  const bool shown = lag.quantity && lag.sd < 0.5 * usual_lag;
  findings.push_back({shown ? Severity::info : Severity::warning,
                      shown ? "loop_lag_estimated" : "loop_lag_unknown",
                      {{"lag", lag.value, unit}, {"sd", lag.sd, unit}},
                      whose});
  if (!shown) return;
  const LagFit fit = lag_of(outcome.levels, outcome.polynomial);
  ledger.add({prefix + "loop_lag", "T", unit, lag.value + fit.value,
              "lag of the capture loop, by its pattern over the levels and senses"},
             {{group, fit.gradient}});
}

/// The size of the shift from power-up to power-up, with an interval; a finding where it is not significant.
void add_repeatability(const Outcome& outcome, const std::string& prefix, Ledger& ledger, Findings& findings) {
  if (outcome.levels.fit.slow_variance.empty()) {
    if (prefix.empty() && outcome.power_ups < 2) findings.push_back({Severity::info, "single_power_up", {}});
    return;
  }
  const double parts = static_cast<double>(outcome.polynomial.parts);
  const double dof = parts * (static_cast<double>(outcome.power_ups) - 1.0);
  double weight = 0.0;  // of one power-up
  for (const Observation& one : outcome.observations)
    for (const double w : one.weight) weight += w / static_cast<double>(outcome.power_ups);
  const double variance = outcome.levels.fit.slow_variance.front();
  const double within = outcome.levels.fit.white_variance / weight, between = variance + within;
  const Unit unit = sensitivity();
  if (!(variance > least_between * within)) {
    const double limit = std::sqrt(std::max(0.0, within * dof / chi_square_quantile(missed_by_95, dof) - within));
    findings.push_back({Severity::info,
                        "repeatability_not_significant",
                        {{"parameter", prefix + "turn_on_repeatability"}, {"limit", limit, unit}}});
    findings.back().hidden = {{prefix + "turn_on_repeatability"}};
    return;
  }
  Matrix covariance(1, 1);
  covariance(0, 0) = 2.0 * between * between / dof / (4.0 * variance);
  const double nu = root_interval_degrees_of_freedom(dof, variance / between);
  const std::size_t group = ledger.add(
      Group{1, {{outcome.levels.fit.sources[1].source, covariance}}, [nu](const std::vector<double>&) { return nu; }});
  Parameter repeatability{prefix + "turn_on_repeatability", "s_D", unit, std::sqrt(variance),
                          parts > 1
                              ? "standard deviation of each of D_x and D_y from power-up to power-up, without noise"
                              : "standard deviation of K from power-up to power-up, without noise"};
  const double of_within = std::max(1.0, outcome.levels.fit.degrees_of_freedom - dof);
  const SdInterval interval = interval_of_excess_sd(between, dof, within, of_within);
  repeatability.lower = interval.lower;
  repeatability.upper = interval.upper;
  ledger.add(std::move(repeatability), {{group, {1.0}}});
}

/// A and B of a level with the table's angle counted from the arm [rad/s]; NaN where they are not known.
std::array<double, 2> parts_of(const Outcome& outcome, const Levels& of, const Level& level, std::size_t l) {
  const double a = level.force, sigma = level.spin_up;
  if (outcome.take == Take::both_parts) return {-a * of.part(l, 0).value, -a * sigma * of.part(l, 1).value};
  if (outcome.corrected) return {std::nan(""), std::nan("")};
  Complex sum = 0.0;
  double count = 0.0;
  for (const Observation& o : outcome.observations)
    if (o.level == l) sum += o.value, count += 1.0;
  return {-a * sum.real() / count, -a * sigma * sum.imag() / count};
}

Table nonlinearity(const Outcome& outcome, const std::vector<Level>& levels, std::size_t group, const Ledger& ledger) {
  const Levels of(outcome, levels);
  const auto sd = [&](const Function& f) { return std::sqrt(ledger.variance({{group, f.gradient}})); };
  const auto part = [&](std::size_t which) {
    return [&, which](std::size_t l) { return parts_of(outcome, of, levels[l], l)[which]; };
  };
  return tabulate("nonlinearity",
                  "sensitive term over specific force; A and B as with the table's angle counted from the arm",
                  levels.size(),
                  {{"level", [&](std::size_t l) { return levels[l].number; }},
                   {"arm_rate", "deg/s", [&](std::size_t l) { return levels[l].arm_rate; }},
                   {"acceleration", "g", [&](std::size_t l) { return levels[l].force; }},
                   {"spin_axis", [&](std::size_t l) { return levels[l].spin_up > 0.0 ? "up" : "down"; }},
                   {"A", "deg/h", part(0)},
                   {"B", "deg/h", part(1)},
                   {"K", sensitivity(), [&](std::size_t l) { return of.K(l).value; }},
                   {"K_sd", sensitivity(), [&](std::size_t l) { return sd(of.K(l)); }},
                   {"zeta", "%", [&](std::size_t l) { return of.zeta(l).value; }},
                   {"zeta_sd", "%", [&](std::size_t l) { return sd(of.zeta(l)); }},
                   {"zeta_fitted", "%", [&](std::size_t l) { return of.zeta_fitted(l).value; }},
                   {"zeta_fitted_sd", "%", [&](std::size_t l) { return sd(of.zeta_fitted(l)); }}});
}

Table segments(const Outcome& outcome, const std::vector<Measured>& measured, const std::vector<Level>& levels) {
  const auto of = [&](const Observation& o) -> const Measured& { return measured[o.measured]; };
  const auto tilt = [&](const Observation& o) { return std::abs(o.true_rate / of(o).arm_rate); };
  return for_programs(
      tabulate("segments", "what each level showed in each power-up", outcome.observations,
               {{"run", [&](const Observation& o) { return of(o).stretch->run; }},
                {"segment", [&](const Observation& o) { return of(o).stretch->label; }},
                {"level", [&](const Observation& o) { return levels[o.level].number; }},
                {"arm_rate", "deg/s", [&](const Observation& o) { return of(o).arm_rate; }},
                {"table_rate", "deg/s", [&](const Observation& o) { return of(o).table_rate; }},
                {"net_rate", "deg/s", [&](const Observation& o) { return of(o).beta_rate(); }},
                {"true_rate", "deg/h", [](const Observation& o) { return std::abs(o.true_rate); }},
                {"tilt", "arcsec", tilt},
                {"K", sensitivity(), [](const Observation& o) { return std::abs(o.value); }},
                {"gyro_noise", "deg/h", [&](const Observation& o) { return of(o).of[gyro].residual_sd; }},
                {"reference_noise", "deg/h", [&](const Observation& o) { return of(o).of[reference].residual_sd; }},
                {"missing", [&](const Observation& o) { return of(o).of[gyro].lost; }}}));
}

Table orders(const Polynomial& polynomial) {
  return tabulate("models", "p and q over specific force", polynomial.tried,
                  {{"order", [](const Order& order) { return order_names[order.powers]; }},
                   {"chi_square", &Order::chi_square},
                   {"AICc", &Order::aicc},
                   {"chosen", [](const Order& order) { return order.chosen ? "yes" : ""; }}});
}

}  // namespace

void describe(const Outcome& outcome, const std::vector<Measured>& measured, const Reduction& reduction, Ledger& ledger,
              Estimate& estimate) {
  const bool first = outcome.output == gyro;
  const std::string prefix = first ? "" : "y_", symbol = first ? "D(X)_" : "D(Y)_";
  const std::size_t group = ledger.add(group_of(outcome.levels));
  if (first) add_levels(outcome, reduction.levels, group, ledger, estimate.findings);
  if (outcome.take == Take::both_parts) {
    const std::size_t second = ledger.add(group_of(*outcome.second)), third = ledger.add(group_of(*outcome.third));
    add_coefficients({outcome, group, third, prefix, symbol}, reduction.levels.front().spin_up, ledger,
                     estimate.findings);
    add_second(outcome, prefix, symbol, group, second, ledger);
  }
  if (first && outcome.corrected) add_relation(outcome.relation, outcome.feigned_azimuth, ledger);
  add_lag(outcome, prefix, group, ledger, estimate.findings);
  add_repeatability(outcome, prefix, ledger, estimate.findings);
  if (!first) return;
  const MixedFit& fit = outcome.levels.fit;
  for (const Observation& o : outcome.observations)
    estimate.fit.observations += outcome.polynomial.parts * o.part.size();
  estimate.fit.degrees_of_freedom = fit.degrees_of_freedom;
  estimate.fit.chi_square = fit.chi_square;
  estimate.fit.condition = fit.condition;
  estimate.tables.push_back(nonlinearity(outcome, reduction.levels, group, ledger));
  if (outcome.corrected) estimate.tables.push_back(orders(outcome.polynomial));
  estimate.tables.push_back(segments(outcome, measured, reduction.levels));
  add_curves(outcome, reduction.levels, group, ledger, estimate);
  add_residuals(outcome, reduction.levels, estimate);
}

}  // namespace tumble::dtg_centrifuge
