#include "tumble/methods/dtg_centrifuge/reference_line.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "tumble/math/golden_section.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/dtg_centrifuge/lag.hpp"

namespace tumble::dtg_centrifuge {
namespace {

/// Least eigenvalue of the columns of unit length, with which rates and specific force of the levels are distinguished.
constexpr double weakest_of_levels = 1e-8;
/// Fall of chi-square by what the line shows beside the true rate: 5 sd, p = 6e-7.
constexpr double fall_of_cause = 25.0;
/// Difference of chi-square from which on one cause explains the line and another does not: 3 sd.
constexpr double causes_apart = 9.0;
/// Greatest lag that is looked for [s], and turn of the fastest line from one that is tried to the next [rad].
constexpr double farthest_late = 0.35, turn_of_try = 0.1;
/// Fall of chi-square by an amplitude that falls with the rate, from which on it is one: p = 3e-4. Greatest loss that is looked for
/// [1] at the fastest line, and its last step.
constexpr double fall_of_droop = 13.0, most_droop = 0.5, droop_settled = 1e-4;
/// [s] of a lag: a change of the rotation by less is rounding.
constexpr double late_settled = 1e-8;
/// Low passes that are tried: lags from one to the other [s], each greater by this factor.
constexpr double shortest_pass = 0.02, longest_pass = 0.8, next_pass = 1.1;
/// [1] of the sensitivity of the reference, below which that of the gyro is none: no gyro of this kind is so good.
constexpr double share_of_exchanged = 0.2;
constexpr double exchanged_sd = 5.0;  ///< [sd] of the reference's sensitivity: p = 6e-7

double spin_up_of(const Measured& m) { return m.stretch->spin_up; }

/// A regression of the lines of one gyro over the levels, with more and more columns: rates of arm and table for each
/// orientation of the spin axis, then one that is real.
struct Rows {
  Matrix rates;                      ///< [n x 2 orientations], weighted
  std::vector<double> force, one;    ///< weighted: a, and 1
  std::vector<double> weight, turn;  ///< turn: rate by which a lag turns the line as it is seen [rad/s]
  std::vector<Complex> line;         ///< weighted, as with the spin axis up
  double pure = 0.0;                 ///< density of the noise of each component, by the parts of the levels
  std::size_t levels = 0;
  double step = 0.0;  ///< [s] between the samples
};

Rows rows_of(const std::vector<Measured>& measured, const Reduction& reduction, Signal signal) {
  std::map<double, std::size_t> sides;
  for (const Measured& m : measured) sides.try_emplace(spin_up_of(m), 2 * sides.size());
  Rows rows{.rates = Matrix(measured.size(), 2 * sides.size())};
  rows.levels = std::set<std::size_t>(reduction.level_of.begin(), reduction.level_of.end()).size();
  double squares = 0.0, freedom = 0.0;
  rows.step = measured.front().of[signal].step;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const Measured& m = measured[i];
    const Lines& lines = m.of[signal];
    const double weight = std::sqrt(lines.samples * lines.step), spin = spin_up_of(m);
    const Complex z = lines.value.line[0];
    rows.rates(i, sides[spin]) = weight * m.arm_rate;
    rows.rates(i, sides[spin] + 1) = weight * m.table_rate;
    rows.force.push_back(weight * std::abs(force_of(reduction.nominal[i], m.arm_rate, 0.0, 0.0)));
    rows.one.push_back(weight);
    rows.weight.push_back(weight);
    rows.turn.push_back(spin < 0.0 ? -m.theta_rate() : m.theta_rate());
    rows.line.push_back(weight * (spin < 0.0 ? std::conj(z) : z));
    for (std::size_t k = 0; k < lines.part.size(); ++k)
      squares += lines.weight[k] * lines.step * std::norm(lines.part[k].line[0] - z);
    freedom += 2.0 * (static_cast<double>(lines.part.size()) - 1.0);
  }
  rows.pure = freedom > 0.0 ? squares / freedom : 0.0;
  return rows;
}

/// Least squares of the lines, and what remains.
struct LineFit {
  Complex last;          ///< coefficient of the last column
  double inverse = 0.0;  ///< of its information
  double squares = 0.0;  ///< that remain
  double freedom = 0.0;  ///< of them
  bool determined = false;
};

LineFit fit_lines(const Matrix& design, const std::vector<Complex>& line) {
  const std::size_t n = design.rows, p = design.columns;
  LineFit fit;
  if (n <= p) return fit;
  Matrix both(n, 2);
  for (std::size_t i = 0; i < n; ++i) both(i, 0) = line[i].real(), both(i, 1) = line[i].imag();
  const auto scale = inverses(column_norms(design));
  const Matrix unit = scaled_columns(design, scale), normal = gram(unit);
  if (eigenvalues_symmetric(normal)[0] < weakest_of_levels) return fit;
  const Matrix b = solve_symmetric(normal, transposed_product(unit, both)), residual = both - unit * b;
  fit.last = Complex(b(p - 1, 0), b(p - 1, 1)) * scale[p - 1];
  fit.inverse = solve_symmetric(normal, block(identity(p), 0, p, p - 1, 1)).values.back() * scale[p - 1] * scale[p - 1];
  fit.squares = dot(residual.values, residual.values);
  fit.freedom = static_cast<double>(2 * (n - p));
  fit.determined = true;
  return fit;
}

Matrix with_column(const Matrix& design, const std::vector<double>& more) {
  Matrix out(design.rows, design.columns + 1);
  for (std::size_t i = 0; i < design.rows; ++i) {
    for (std::size_t k = 0; k < design.columns; ++k) out(i, k) = design(i, k);
    out(i, design.columns) = more[i];
  }
  return out;
}

/// Factor by which a line at the rate [rad/s] is shown.
Complex response_of(double late, double droop, double rate) {
  return std::polar(1.0 / (1.0 + droop * rate * rate), -rate * late);
}

std::vector<Complex> without_turn(const Rows& rows, double late, double droop) {
  std::vector<Complex> line;
  for (std::size_t i = 0; i < rows.line.size(); ++i)
    line.push_back(rows.line[i] / response_of(late, droop, rows.turn[i]));
  return line;
}

/// The lag that leaves least, and what it leaves.
struct LateFit {
  double late = 0.0, droop = 0.0, squares = 0.0, curvature = 0.0;  ///< curvature: of the squares over the lag [.../s^2]
  Filter filter = {};
};

double fastest_of(const Rows& rows) {
  double fastest = 0.0;
  for (const double turn : rows.turn) fastest = std::max(fastest, std::abs(turn));
  return fastest;
}

/// The lag near another one, with the droop given.
LateFit late_near(const Rows& rows, double near, double droop) {
  const double step = turn_of_try / fastest_of(rows);
  const auto left = [&](double late) { return fit_lines(rows.rates, without_turn(rows, late, droop)).squares; };
  const auto search = golden_section_search(
      near - step, near + step, left, [](double length) { return length > late_settled; },
      [](double a, double b) { return a < b; });
  LateFit best{0.5 * (search.a + search.b), droop, 0.0, 0.0};
  best.squares = left(best.late);
  best.curvature =
      (left(best.late + 0.1 * step) + left(best.late - 0.1 * step) - 2.0 * best.squares) / (0.01 * step * step);
  return best;
}

/// A lag that takes nothing from the amplitude.
LateFit late_fit(const Rows& rows) {
  const double step = turn_of_try / fastest_of(rows);
  const auto left = [&](double late) { return fit_lines(rows.rates, without_turn(rows, late, 0.0)).squares; };
  double best = 0.0, least = left(0.0);
  for (double late = step; late < farthest_late; late += step)
    for (const double here : {late, -late})
      if (const double squares = left(here); squares < least) best = here, least = squares;
  return late_near(rows, best, 0.0);
}

/// A lag by a filter, which takes something from the amplitude of the fastest line.
LateFit filter_fit(const Rows& rows, const LateFit& plain) {
  const double unit = 1.0 / (fastest_of(rows) * fastest_of(rows));
  LateFit best = plain;
  const auto left = [&](double droop) {
    const LateFit here = late_near(rows, best.late, droop * unit);
    if (here.squares < best.squares) best = here;
    return here.squares;
  };
  golden_section_search(
      0.0, most_droop, left, [](double length) { return length > droop_settled; },
      [](double a, double b) { return a < b; });
  return best;
}

double left_without(const Rows& rows, const Filter& filter) {
  std::vector<Complex> line = rows.line;
  for (std::size_t i = 0; i < line.size(); ++i) line[i] /= filter.response(rows.turn[i]);
  return fit_lines(rows.rates, line).squares;
}

/// The low pass that leaves least: phase and amplitude belong together, however far the lines turn.
LateFit low_pass_fit(const Rows& rows) {
  LateFit best{.squares = std::numeric_limits<double>::infinity()};
  for (const double each_step : {0.0, rows.step})
    for (const std::size_t stages : {1, 2})
      for (double lag = shortest_pass; lag < longest_pass; lag *= next_pass) {
        const Filter filter{lag, stages, each_step};
        if (const double left = left_without(rows, filter); left < best.squares)
          best = {.late = lag, .squares = left, .filter = filter};
      }
  const auto left = [&](double lag) { return left_without(rows, {lag, best.filter.stages, best.filter.step}); };
  const auto search = golden_section_search(
      best.late / next_pass, best.late * next_pass, left, [](double length) { return length > late_settled; },
      [](double a, double b) { return a < b; });
  const double lag = best.filter.lag = best.late = 0.5 * (search.a + search.b), step = 0.01 * lag;
  best.squares = left(lag);
  best.curvature = (left(lag + step) + left(lag - step) - 2.0 * best.squares) / (step * step);
  return best;
}

Sensitivity sensitivity_of(const Rows& rows, const LineFit& fit) {
  if (!fit.determined || rows.levels < rows.rates.columns + 3) return {};
  return {fit.last, std::sqrt(fit.squares / fit.freedom * fit.inverse), true};
}

}  // namespace

std::vector<Measured> without_lag(std::vector<Measured> measured, const ReferenceLine& line) {
  if (line.filter.stages > 0) return without_filter(std::move(measured), reference, line.filter);
  for (Measured& m : measured) {
    const auto corrected = [&](Phasors& phasors) {
      for (std::size_t h = 0; h < 3; ++h)
        phasors.line[h] /= response_of(line.late, line.droop, static_cast<double>(h + 1) * m.theta_rate());
      phasors.earth /= response_of(line.late, line.droop, m.beta_rate());
    };
    Lines& lines = m.of[reference];
    corrected(lines.value);
    for (Phasors& part : lines.part) corrected(part);
  }
  return measured;
}

Sensitivity sensitivity_of(const std::vector<Measured>& measured, const Reduction& reduction, Signal signal) {
  const Rows rows = rows_of(measured, reduction, signal);
  return sensitivity_of(rows, fit_lines(with_column(rows.rates, rows.force), rows.line));
}

ReferenceLine reference_line_of(const std::vector<Measured>& measured, const Reduction& reduction) {
  const Rows rows = rows_of(measured, reduction, reference);
  const LineFit plain = fit_lines(rows.rates, rows.line);
  const LineFit by_force = fit_lines(with_column(rows.rates, rows.force), rows.line);
  const LineFit by_constant = fit_lines(with_column(rows.rates, rows.one), rows.line);
  ReferenceLine out{.sensitivity = sensitivity_of(rows, by_force)};
  if (!out.sensitivity.known || !plain.determined) return out;
  const LateFit by_delay = late_fit(rows), by_filter = filter_fit(rows, by_delay), by_pass = low_pass_fit(rows);
  const double of_lag = std::min(std::min(by_delay.squares, by_pass.squares) / (plain.freedom - 1.0),
                                 by_filter.squares / (plain.freedom - 2.0)),
               of_force = by_force.squares / by_force.freedom;
  const double of_constant =
      by_constant.determined ? by_constant.squares / by_constant.freedom : std::numeric_limits<double>::infinity();
  const double noise = std::max(rows.pure, std::min({of_lag, of_force, of_constant}));
  if (!(noise > 0.0)) return out;
  // late stamps take nothing from the amplitude
  const LateFit& of_two = by_delay.squares - by_filter.squares < fall_of_droop * noise ? by_delay : by_filter;
  const LateFit& by_lag = of_two.squares - by_pass.squares < fall_of_droop * noise ? of_two : by_pass;
  out.droop = by_lag.droop;
  out.filter = by_lag.filter;
  out.late = by_lag.late;
  out.late_sd = std::sqrt(2.0 * noise / std::max(by_lag.curvature, std::numeric_limits<double>::min()));
  out.beside = by_constant.last;
  const double least =
      std::min({by_lag.squares, by_force.squares, by_constant.determined ? by_constant.squares : INFINITY});
  if (plain.squares - least < fall_of_cause * noise) return out;
  using Cause = ReferenceLine::Cause;
  const auto explains = [&](double squares) { return squares - least < causes_apart * noise; };
  if (explains(by_lag.squares))
    out.cause = explains(by_force.squares) ? Cause::either : Cause::late;
  else if (explains(by_force.squares))
    out.cause = Cause::sensitive;
  else
    out.cause = Cause::beside;
  return out;
}

void check_exchange(const ReferenceLine& line, const std::vector<Measured>& measured, const Reduction& reduction,
                    Findings& findings) {
  const Sensitivity own = line.sensitivity;
  if (!own.known || std::abs(own.v) < exchanged_sd * own.sd) return;
  const Sensitivity tested = sensitivity_of(measured, reduction, gyro);
  if (!tested.known || std::abs(tested.v) > share_of_exchanged * std::abs(own.v)) return;
  const Unit unit = Unit::parse("deg/h/g");
  findings.push_back({Finding::Severity::error,
                      "gyro_and_reference_exchanged",
                      {{"reference", std::abs(own.v), unit}, {"gyro", std::abs(tested.v), unit}},
                      "reference_gyro"});
}

}  // namespace tumble::dtg_centrifuge
