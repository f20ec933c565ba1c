#include "tumble/methods/imu_multi_position/describe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tumble/core/columns.hpp"
#include "tumble/earth/earth.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/imu_multi_position/bias_changes.hpp"
#include "tumble/methods/imu_multi_position/turning.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/linear/slow.hpp"

namespace tumble::imu_multi_position {
namespace {

using Severity = Finding::Severity;

constexpr std::size_t wanted_rests = 18;  ///< twice the nine coefficients of the accelerometers; the faces and edges

/// A parameter of the result with its derivative by those of the fit.
struct Entry {
  Parameter parameter;
  std::vector<double> slope;
  std::size_t main = 0;  ///< the parameter of the fit that it is, apart from a scale
};

/// The three channels of a kind: A or W, bias, and the positions of their entries among the parameters of the fit.
struct Channels {
  std::string kind, symbol;
  const char *bias_unit, *scale_unit;
  bool counts = false;
  Linear linear;
  /// Column 3: the bias; null: not sought.
  std::optional<std::size_t> (*index)(std::size_t row, std::size_t column);
};

std::size_t accelerometer_index(std::size_t row, std::size_t column) {
  return column == 3 ? 6 + row : row * (row + 1) / 2 + column;
}

std::optional<std::size_t> index_of_accelerometer(std::size_t row, std::size_t column) {
  if (column > row && column != 3) return {};
  return accelerometer_index(row, column);
}
std::optional<std::size_t> index_of_gyro(std::size_t row, std::size_t column) { return gyro_index(row, column); }

Parameter parameter(std::string name, std::string symbol, const char* unit, double value, std::string description) {
  Parameter p;
  p.name = std::move(name), p.symbol = std::move(symbol), p.unit = Unit::parse(unit), p.value = value;
  p.description = std::move(description);
  return p;
}

Entry entry(Parameter p, std::size_t main, std::size_t size) {
  Entry e{std::move(p), std::vector<double>(size), main};
  e.slope[main] = 1.0;
  return e;
}

/// Divides by the scale factor of the row: raw counts have misalignments relative to it.
void make_relative(const Channels& of, std::size_t row, Entry& e) {
  const double scale = of.linear.matrix(row, row), value = e.parameter.value;
  e.parameter.value = value / scale;
  e.slope = scaled(1.0 / scale, e.slope);
  e.slope[*of.index(row, row)] -= value / (scale * scale);
}

void add_channel(const Channels& of, std::size_t row, std::size_t size, std::vector<Entry>& all) {
  const char letter = letters[row];
  const std::string channel = fmt::format("{}_{}", of.kind, letter);
  const std::size_t before = all.size();
  all.push_back(entry(parameter(channel + "_bias", fmt::format("b_{}{}", of.symbol, letter), of.bias_unit,
                                of.linear.bias[row], "output for zero input"),
                      *of.index(row, 3), size));
  const double scale = of.linear.matrix(row, row);
  const std::string symbol = fmt::format("{}_{}{}", of.counts ? "K" : "k", of.symbol, letter);
  all.push_back(entry(of.counts ? parameter(channel + "_scale_factor", symbol, of.scale_unit, scale, "scale factor")
                                : parameter(channel + "_scale_factor_error", symbol, "ppm", scale - 1.0,
                                            "relative error of the scale factor"),
                      *of.index(row, row), size));
  for (std::size_t column = 0; column < 3; ++column) {
    const auto index = of.index(row, column);
    if (column == row || !index) continue;
    const char other = letters[column];
    Entry e = entry(
        parameter(fmt::format("{}_misalignment_{}", channel, other), fmt::format("m_{}{}{}", of.symbol, letter, other),
                  "arcsec", of.linear.matrix(row, column), fmt::format("the input axis leans toward {}", other)),
        *index, size);
    if (of.counts) make_relative(of, row, e);
    all.push_back(std::move(e));
  }
  for (std::size_t i = before; i < all.size(); ++i) all[i].parameter.channels = {channel};
}

void add_sensitivity(const Channels& of, const Matrix3& sensitivity, std::size_t row, std::size_t size,
                     std::vector<Entry>& all) {
  for (std::size_t column = 0; column < 3; ++column) {
    const char letter = letters[row], other = letters[column];
    Entry e = entry(parameter(fmt::format("gyro_{}_acceleration_sensitivity_{}", letter, other),
                              fmt::format("g_{}{}", letter, other), "deg/h/g", sensitivity(row, column),
                              fmt::format("drift with the specific force along {}", other)),
                    gyro_index(row, 4 + column), size);
    if (of.counts) make_relative(of, row, e);
    e.parameter.channels = {fmt::format("gyro_{}", letter)};
    all.push_back(std::move(e));
  }
}

std::vector<Entry> entries_of(const std::vector<Session>& sessions, const Fit& fit) {
  const auto& c = fit.calibration;
  const bool counts = sessions[0].accelerometer.counts, gyro_counts = sessions[0].gyro.counts;
  std::vector<Entry> all;
  const Channels forces{"accelerometer",       "a", counts ? "LSB" : "mg", "LSB/(m/s^2)", counts, c.accelerometer,
                        index_of_accelerometer};
  for (std::size_t row = 0; row < 3; ++row) add_channel(forces, row, fit.parameters, all);
  if (fit.parameters == of_accelerometers) return all;
  const Channels rates{"gyro", "g", gyro_counts ? "LSB" : "deg/h", "LSB/(rad/s)", gyro_counts, c.gyro, index_of_gyro};
  for (std::size_t row = 0; row < 3; ++row) {
    add_channel(rates, row, fit.parameters, all);
    if (fit.parameters == with_sensitivity) add_sensitivity(rates, c.sensitivity, row, fit.parameters, all);
  }
  return all;
}

/// Error of the fit's parameters where gravity is greater by one standard uncertainty: A and G are relative to it.
std::vector<double> by_gravity(const Fit& fit, const Surroundings& surroundings) {
  const double share = surroundings.gravity_sd / surroundings.gravity;
  std::vector<double> d(fit.parameters);
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column <= row; ++column)
      d[accelerometer_index(row, column)] = share * fit.calibration.accelerometer.matrix(row, column);
  if (fit.parameters == with_sensitivity)
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t column = 0; column < 3; ++column)
        d[gyro_index(row, 4 + column)] = share * fit.calibration.sensitivity(row, column);
  return d;
}

/// Mean covariance between two rests of flicker of unit bias instability: the level that all rests share. Their scatter
/// shows what they differ by, never this.
double shared_level(const Rests& rests, double step) {
  std::vector<linear::Interval> intervals;
  for (const Rest& rest : rests.all)
    if (rest.used()) intervals.push_back({rest.session, rest.begin, rest.end - rest.begin});
  NoiseModel unit;
  unit.bias_instability = 1.0;
  const Matrix kernel = linear::known_slow_noise(intervals, unit, 0.0, step).front().kernel;
  double sum = 0.0;
  for (std::size_t a = 0; a < kernel.rows; ++a)
    for (std::size_t b = 0; b < a; ++b) sum += kernel(a, b);
  const auto pairs = static_cast<double>(kernel.rows * (kernel.rows - 1)) / 2.0;
  return pairs > 0.0 ? sum / pairs : 0.0;
}

/// Covariance of the fit's parameters by the level that all rests share by the stated bias instabilities.
Matrix by_level(const Fit& fit, const Rests& rests, const Surroundings& surroundings, double step) {
  Matrix covariance(fit.parameters, fit.parameters);
  if (!(surroundings.accelerometer_instability > 0.0) && !(surroundings.gyro_instability > 0.0)) return covariance;
  const double level = shared_level(rests, step);
  const auto add = [&](std::size_t index, double instability, double scale) {
    covariance(index, index) = level * std::pow(instability * scale, 2);
  };
  for (std::size_t row = 0; row < 3; ++row) {
    add(accelerometer_index(row, 3), surroundings.accelerometer_instability,
        fit.calibration.accelerometer.matrix(row, row));
    if (fit.parameters > of_accelerometers)
      add(gyro_index(row, 3), surroundings.gyro_instability, fit.calibration.gyro.matrix(row, row));
  }
  return covariance;
}

void add_parameters(const std::vector<Entry>& all, const Fit& fit, const Rests& rests, double step,
                    const Surroundings& surroundings, const std::vector<BiasChange>& changes, Estimate& estimate) {
  Matrix slopes(all.size(), fit.parameters);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t p = 0; p < fit.parameters; ++p) slopes(i, p) = all[i].slope[p];
    estimate.parameters.push_back(all[i].parameter);
  }
  std::vector<ErrorLine> lines;
  const auto add = [&](const std::string& source, const Matrix& covariance) {
    lines.push_back(from_covariance(source, sandwich(slopes, covariance)));
  };
  for (std::size_t s = 0; s < sources.size(); ++s) add(sources[s], fit.shares[s]);
  lines.push_back(from_shifts("gravity", as_column(slopes * by_gravity(fit, surroundings)), surroundings.gravity_key));
  add(linear::stated_source, by_level(fit, rests, surroundings, step));
  for (const BiasChange& change : changes)
    lines.push_back(from_shifts("term that the model may lack", as_column(slopes * change.shift)));
  settle(estimate, lines);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double from_fit = fit.covariance(all[i].main, all[i].main) * std::pow(all[i].slope[all[i].main], 2);
    const double widening = std::max(1.0, estimate.covariance(i, i) / from_fit);
    estimate.parameters[i].degrees_of_freedom = fit.degrees_of_freedom[all[i].main] * widening * widening;
  }
}

/// "yes", or why not.
std::string used(const std::optional<Finding>& rejection) { return rejection ? "no: " + rejection->message : "yes"; }

Table rests_table(const Rests& rests, const Fit& fit, double gravity, bool several) {
  const Inverse felt(fit.calibration.accelerometer);
  const auto label = [&](std::size_t k) {
    return several ? fmt::format("{} of recording {}", k + 1, rests.all[k].session + 1) : fmt::format("{}", k + 1);
  };
  const auto force = [&](std::size_t k) { return felt(rests.all[k].force); };
  return tabulate("rests", "specific force at rest by this calibration; residual: |f| less gravity", rests.all.size(),
                  {{"rest", label},
                   {"begin", "s", [&](std::size_t k) { return rests.all[k].begin; }},
                   {"duration", "s", [&](std::size_t k) { return rests.all[k].end - rests.all[k].begin; }},
                   {"f_x", "m/s^2", [&](std::size_t k) { return force(k).x; }},
                   {"f_y", "m/s^2", [&](std::size_t k) { return force(k).y; }},
                   {"f_z", "m/s^2", [&](std::size_t k) { return force(k).z; }},
                   {"up", [&](std::size_t k) { return facing(normalised(force(k))); }},
                   {"residual", "ug", [&](std::size_t k) { return norm(force(k)) - gravity; }},
                   {"used", [&](std::size_t k) { return used(rests.all[k].rejection); }}});
}

/// Angle between the direction that a turn leads to and that of the rest after it [rad].
double misfit(const Group& group) { return std::hypot(group.rows[0].residual, group.rows[1].residual); }

Table moves_table(const Fit& fit) {
  std::vector<double> residual(fit.moves.size(), std::nan(""));
  for (const Group& group : fit.groups)
    if (group.part == Part::turn) residual[group.index] = misfit(group);
  const auto label = [&](std::size_t m) { return fmt::format("{} to {}", fit.moves[m].from + 1, fit.moves[m].to + 1); };
  return tabulate("moves",
                  "turns between rests; residual: between the directions of gravity by the gyros and by the fit",
                  fit.moves.size(),
                  {{"rests", label},
                   {"duration", "s", [&](std::size_t m) { return fit.moves[m].duration; }},
                   {"turned", "deg", [&](std::size_t m) { return fit.turns[m].path; }},
                   {"residual", "deg", [&](std::size_t m) { return residual[m]; }},
                   {"used", [&](std::size_t m) { return used(fit.moves[m].rejection); }}});
}

void add_curves(const Rests& rests, const Fit& fit, double gravity, Estimate& estimate) {
  Curve force{.name = "|f| less gravity",
              .figure = "residual at rest",
              .x = {"time", Unit::parse("s")},
              .y = {"residual", Unit::parse("ug")},
              .points = true};
  const Inverse felt(fit.calibration.accelerometer);
  for (const Rest& rest : rests.all)
    if (rest.used()) add_point(force, 0.5 * (rest.begin + rest.end), norm(felt(rest.force)) - gravity);
  estimate.curves.push_back(std::move(force));
  Curve turn{.name = "direction after a move",
             .figure = "residual of the moves",
             .x = {"angle turned", Unit::parse("deg")},
             .y = {"residual", Unit::parse("deg")},
             .points = true};
  for (const Group& group : fit.groups)
    if (group.part == Part::turn && group.used) add_point(turn, fit.turns[group.index].path, misfit(group));
  if (!turn.x.values.empty()) estimate.curves.push_back(std::move(turn));
}

void add_rejections(const Rests& rests, const Fit& fit, Findings& findings) {
  const auto used_rests = static_cast<std::size_t>(std::ranges::count_if(rests.all, &Rest::used));
  findings.push_back({Severity::info,
                      "rests_used",
                      {{"rests", rests.all.size()}, {"used", used_rests}, {"multiplier", rests.multiplier}}});
  const auto add = [&](const std::optional<Finding>& rejection, const std::string& where) {
    if (!rejection) return;
    findings.push_back(*rejection);
    findings.back().where = where;
  };
  for (std::size_t k = 0; k < rests.all.size(); ++k)
    add(rests.all[k].rejection, fmt::format("rest {} at {}", k + 1, say_instant(rests.all[k].begin)));
  for (const Move& move : fit.moves)
    add(move.rejection, fmt::format("move from rest {} to rest {}", move.from + 1, move.to + 1));
  if (used_rests < wanted_rests) findings.push_back({Severity::warning, "few_rests", {{"used", used_rests}}});
}

void add_scatter(const Fit& fit, Findings& findings) {
  const auto add = [&](Part part, const char* what, const char* unit) {
    const auto i = static_cast<std::size_t>(part);
    if (fit.scatter_significant[i])
      findings.push_back({Severity::info,
                          "scatter_beyond_noise",
                          {{"scatter", Phrase{what}}, {"sd", std::sqrt(fit.scatter[i]), unit}}});
    else
      findings.push_back({Severity::info, "scatter_not_significant", {{"scatter", Phrase{what}}}});
  };
  add(Part::force, "accelerometers_between_rests", "ug");
  if (fit.parameters == of_accelerometers) return;
  add(Part::rate, "gyros_between_rests", "deg/h");
  add(Part::turn, "angles_of_moves", "%");
}

void add_surroundings(const Fit& fit, const Surroundings& surroundings, Findings& findings) {
  findings.push_back({Severity::info,
                      "gravity_used",
                      {{"gravity", surroundings.gravity, "m/s^2"},
                       {"from", surroundings.gravity_from},
                       {"sd", surroundings.gravity_sd, "ug"}}});
  if (fit.parameters == of_accelerometers) return;
  if (surroundings.latitude)
    findings.push_back(
        {Severity::info, "earth_subtracted", {{"vertical", earth_rate * std::sin(*surroundings.latitude), "deg/h"}}});
  else
    findings.push_back({Severity::info, "earth_neglected", {{"rate", earth_rate, "deg/h"}}});
}

}  // namespace

Estimate describe(const std::vector<Session>& sessions, const Rests& rests, const Fit& fit,
                  const Surroundings& surroundings) {
  Estimate estimate;
  const auto all = entries_of(sessions, fit);
  const auto changes = bias_changes(rests, fit, surroundings.gyro_instability);
  add_parameters(all, fit, rests, sessions.front().accelerometer.step, surroundings, changes, estimate);
  estimate.fit.observations = fit.observations;
  estimate.fit.degrees_of_freedom = static_cast<double>(fit.observations) - static_cast<double>(fit.parameters) -
                                    2.0 * static_cast<double>(fit.chain.size());
  estimate.fit.chi_square = fit.chi_square;
  estimate.fit.condition = fit.condition;
  std::vector<std::string> names(fit.parameters);
  for (const Entry& entry : all) names[entry.main] = entry.parameter.name;
  Guidance guidance = guidance_of(fit, names, surroundings.gravity);
  estimate.tables.push_back(rests_table(rests, fit, surroundings.gravity, sessions.size() > 1));
  if (!fit.moves.empty()) estimate.tables.push_back(moves_table(fit));
  estimate.tables.push_back(std::move(guidance.poses));
  if (!guidance.turns.rows.empty()) estimate.tables.push_back(std::move(guidance.turns));
  estimate.models = models_of(sessions, rests, fit, estimate);
  add_curves(rests, fit, surroundings.gravity, estimate);
  add_rejections(rests, fit, estimate.findings);
  std::ranges::move(turning_rests(sessions, rests, fit), std::back_inserter(estimate.findings));
  std::ranges::move(about_changes(changes, fit, rests, sessions[0].gyro.names), std::back_inserter(estimate.findings));
  add_scatter(fit, estimate.findings);
  add_surroundings(fit, surroundings, estimate.findings);
  std::ranges::move(guidance.advice, std::back_inserter(estimate.findings));
  if (sessions[0].gyro.empty()) estimate.findings.push_back({Severity::info, "accelerometers_alone", {}});
  if (fit.gyros_without_turns) estimate.findings.push_back({Severity::error, "gyros_without_turns", {}, "gyros"});
  return estimate;
}

}  // namespace tumble::imu_multi_position
