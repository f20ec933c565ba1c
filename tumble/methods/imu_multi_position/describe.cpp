#include "tumble/methods/imu_multi_position/describe.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>

#include "tumble/core/say.hpp"
#include "tumble/earth/earth.hpp"
#include "tumble/math/eigen/view.hpp"
#include "tumble/methods/imu_multi_position/compensate.hpp"
#include "tumble/methods/imu_multi_position/guidance.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/linear/slow.hpp"

namespace tumble::imu_multi_position {
namespace {

using Severity = Finding::Severity;

/// A parameter with its derivative by those of the fit.
struct Shown {
  Parameter parameter;
  Eigen::VectorXd slope;
  Eigen::Index main = 0;  ///< the parameter of the fit it is first of all
};

/// The three channels of a kind: m = A or W, bias, and where their entries stand among the parameters of the fit.
struct Channels {
  std::string kind, symbol;
  const char *bias_unit, *scale_unit;
  bool counts = false;
  Matrix3d matrix;
  Vector3d bias;
  Eigen::Index (*index)(int row, int column);  ///< column 3: the bias; negative: not sought
};

Eigen::Index accelerometer_index(int row, int column) {
  if (column == 3) return 6 + row;
  return column > row ? -1 : row * (row + 1) / 2 + column;
}
Eigen::Index index_of_gyro(int row, int column) { return gyro_index(row, column); }

Parameter parameter(std::string name, std::string symbol, const char* unit, double value, std::string description) {
  Parameter p;
  p.name = std::move(name), p.symbol = std::move(symbol), p.unit = Unit::parse(unit), p.value = value;
  p.description = std::move(description);
  return p;
}

Shown shown(Parameter p, Eigen::Index main, Eigen::Index size) {
  Shown s{std::move(p), Eigen::VectorXd::Zero(size), main};
  s.slope[main] = 1.0;
  return s;
}

/// entry over the scale factor of its row: relative to what one LSB is.
void make_relative(const Channels& of, int row, double entry, Shown& s) {
  const double scale = of.matrix(row, row);
  s.parameter.value = entry / scale;
  s.slope /= scale;
  s.slope[of.index(row, row)] -= entry / (scale * scale);
}

void add_channel(const Channels& of, int row, Eigen::Index size, std::vector<Shown>& all) {
  const char letter = letters[static_cast<std::size_t>(row)];
  const std::string channel = fmt::format("{}_{}", of.kind, letter);
  all.push_back(shown(parameter(channel + "_bias", fmt::format("b_{}{}", of.symbol, letter), of.bias_unit, of.bias[row],
                                "output for zero input"),
                      of.index(row, 3), size));
  const double scale = of.matrix(row, row);
  const std::string symbol = fmt::format("{}_{}{}", of.counts ? "K" : "k", of.symbol, letter);
  all.push_back(shown(of.counts ? parameter(channel + "_scale_factor", symbol, of.scale_unit, scale, "scale factor")
                                : parameter(channel + "_scale_factor_error", symbol, "ppm", scale - 1.0,
                                            "relative error of the scale factor"),
                      of.index(row, row), size));
  for (int column = 0; column < 3; ++column) {
    const Eigen::Index index = of.index(row, column);
    if (column == row || index < 0) continue;
    const char other = letters[static_cast<std::size_t>(column)];
    Shown s = shown(
        parameter(fmt::format("{}_misalignment_{}", channel, other), fmt::format("m_{}{}{}", of.symbol, letter, other),
                  "arcsec", of.matrix(row, column), fmt::format("the input axis leans toward {}", other)),
        index, size);
    if (of.counts) make_relative(of, row, of.matrix(row, column), s);
    all.push_back(std::move(s));
  }
}

void add_sensitivity(const Channels& of, const Matrix3d& sensitivity, int row, Eigen::Index size,
                     std::vector<Shown>& all) {
  for (int column = 0; column < 3; ++column) {
    const char letter = letters[static_cast<std::size_t>(row)], other = letters[static_cast<std::size_t>(column)];
    Shown s = shown(parameter(fmt::format("gyro_{}_acceleration_sensitivity_{}", letter, other),
                              fmt::format("g_{}{}", letter, other), "deg/h/g", sensitivity(row, column),
                              fmt::format("drift with the specific force along {}", other)),
                    gyro_index(row, 4 + column), size);
    if (of.counts) make_relative(of, row, sensitivity(row, column), s);
    all.push_back(std::move(s));
  }
}

std::vector<Shown> all_shown(const std::vector<Session>& sessions, const Fit& fit) {
  const auto& c = fit.calibration;
  const bool counts = sessions[0].accelerometer.counts, gyro_counts = sessions[0].gyro.counts;
  std::vector<Shown> all;
  const Channels forces{"accelerometer",
                        "a",
                        counts ? "LSB" : "mg",
                        "LSB/(m/s^2)",
                        counts,
                        c.accelerometer.matrix,
                        c.accelerometer.bias,
                        accelerometer_index};
  for (int row = 0; row < 3; ++row) add_channel(forces, row, fit.parameters, all);
  if (fit.parameters == of_accelerometers) return all;
  const Channels rates{"gyro",        "g",          gyro_counts ? "LSB" : "deg/h",
                       "LSB/(rad/s)", gyro_counts,  c.gyro.matrix,
                       c.gyro.bias,   index_of_gyro};
  for (int row = 0; row < 3; ++row) {
    add_channel(rates, row, fit.parameters, all);
    if (fit.parameters == with_sensitivity) add_sensitivity(rates, c.sensitivity, row, fit.parameters, all);
  }
  return all;
}

/// Change of the fit's parameters by one standard uncertainty of gravity: A and G are taken relative to it.
Eigen::VectorXd by_gravity(const Fit& fit, const Surroundings& around) {
  const double share = -around.gravity_sd / around.gravity;
  Eigen::VectorXd d = Eigen::VectorXd::Zero(fit.parameters);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column <= row; ++column)
      d[accelerometer_index(row, column)] = share * fit.calibration.accelerometer.matrix(row, column);
  if (fit.parameters == with_sensitivity)
    for (int j = 0; j < 3; ++j) d.segment<3>(gyro_index(0, 4 + j)) = share * fit.calibration.sensitivity.col(j);
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

/// Covariance of the fit's parameters by the level that the bias instabilities stated leave in all rests.
Eigen::MatrixXd by_level(const Fit& fit, const Rests& rests, const Surroundings& around, double step) {
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(fit.parameters, fit.parameters);
  if (!(around.accelerometer_instability > 0.0) && !(around.gyro_instability > 0.0)) return covariance;
  const double level = shared_level(rests, step);
  const auto add = [&](Eigen::Index index, double instability, double scale) {
    covariance(index, index) = level * std::pow(instability * scale, 2);
  };
  for (int row = 0; row < 3; ++row) {
    add(accelerometer_index(row, 3), around.accelerometer_instability, fit.calibration.accelerometer.matrix(row, row));
    if (fit.parameters > of_accelerometers)
      add(gyro_index(row, 3), around.gyro_instability, fit.calibration.gyro.matrix(row, row));
  }
  return covariance;
}

void add_parameters(const std::vector<Shown>& all, const Fit& fit, const Rests& rests, double step,
                    const Surroundings& around, Estimate& estimate) {
  const auto n = static_cast<Eigen::Index>(all.size());
  Eigen::MatrixXd map(n, fit.parameters);
  for (Eigen::Index i = 0; i < n; ++i) map.row(i) = all[static_cast<std::size_t>(i)].slope.transpose();
  std::vector<ErrorLine> lines;
  const auto add = [&](const std::string& source, const Eigen::MatrixXd& covariance) {
    lines.push_back(from_covariance(source, plain(map * covariance * map.transpose())));
  };
  for (std::size_t s = 0; s < sources.size(); ++s) add(sources[s], fit.shares[s]);
  lines.push_back(from_shifts("gravity", plain(map * by_gravity(fit, around))));
  add(linear::stated_source, by_level(fit, rests, around, step));
  for (const Shown& shown : all) estimate.parameters.push_back(shown.parameter);
  settle(estimate, lines);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double from_fit = fit.covariance(all[i].main, all[i].main) * std::pow(all[i].slope[all[i].main], 2);
    const double widening = std::max(1.0, estimate.covariance(i, i) / from_fit);
    estimate.parameters[i].degrees_of_freedom = fit.degrees_of_freedom[all[i].main] * widening * widening;
  }
}

Vector3d calibrated(const Fit& fit, const Rest& rest) {
  const auto& linear = fit.calibration.accelerometer;
  return linear.matrix.inverse() * (rest.force - linear.bias);
}

Table rests_table(const Rests& rests, const Fit& fit, double gravity, bool several) {
  const Unit seconds = Unit::parse("s"), force = Unit::parse("m/s^2"), one = Unit::parse("1");
  Table table{"rests",
              "what was found at rest, with the calibration found; residual: |f| less gravity",
              {{"rest", one},
               {"begin", seconds},
               {"duration", seconds},
               {"f_x", force},
               {"f_y", force},
               {"f_z", force},
               {"up", one},
               {"residual", Unit::parse("ug")},
               {"used", one}},
              {},
              false};
  for (std::size_t k = 0; k < rests.all.size(); ++k) {
    const Rest& rest = rests.all[k];
    const Vector3d f = calibrated(fit, rest);
    const std::string label =
        several ? fmt::format("{} of recording {}", k + 1, rest.session + 1) : fmt::format("{}", k + 1);
    table.rows.push_back({label, rest.begin, rest.end - rest.begin, f[0], f[1], f[2], facing(f.normalized()),
                          f.norm() - gravity, rest.used() ? "yes" : "no: " + rest.why_not});
  }
  return table;
}

/// Angle between the direction that a turn leads to and that of the rest after it [rad].
double misfit(const Group& group) { return group.residual.norm(); }

Table moves_table(const Fit& fit) {
  const Unit degree = Unit::parse("deg"), one = Unit::parse("1");
  Table table{"moves",
              "turns between rests; residual: between the direction of gravity that the gyros lead to and that found",
              {{"rests", one}, {"duration", Unit::parse("s")}, {"turned", degree}, {"residual", degree}, {"used", one}},
              {},
              false};
  std::vector<double> residual(fit.moves.size(), std::nan(""));
  for (const Group& group : fit.groups)
    if (group.part == Part::turn) residual[group.index] = misfit(group);
  for (std::size_t m = 0; m < fit.moves.size(); ++m)
    table.rows.push_back({fmt::format("{} to {}", fit.moves[m].from + 1, fit.moves[m].to + 1), fit.moves[m].duration,
                          fit.turns[m].path, residual[m], fit.moves[m].used() ? "yes" : "no: " + fit.moves[m].why_not});
  return table;
}

void add_curves(const Rests& rests, const Fit& fit, double gravity, Estimate& estimate) {
  Curve force{.name = "|f| less gravity",
              .figure = "residual at rest",
              .x = {"time", Unit::parse("s"), {}},
              .y = {"residual", Unit::parse("ug"), {}}};
  force.points = true;
  for (const Rest& rest : rests.all) {
    if (!rest.used()) continue;
    force.x.values.push_back(0.5 * (rest.begin + rest.end));
    force.y.values.push_back(calibrated(fit, rest).norm() - gravity);
  }
  estimate.curves.push_back(std::move(force));
  Curve turn{.name = "direction after a move",
             .figure = "residual of the moves",
             .x = {"angle turned", Unit::parse("deg"), {}},
             .y = {"residual", Unit::parse("deg"), {}}};
  turn.points = true;
  for (const Group& group : fit.groups) {
    if (group.part != Part::turn || !group.used) continue;
    turn.x.values.push_back(fit.turns[group.index].path);
    turn.y.values.push_back(misfit(group));
  }
  if (!turn.x.values.empty()) estimate.curves.push_back(std::move(turn));
}

void add_left_out(const Rests& rests, const Fit& fit, Findings& findings) {
  std::size_t used = 0;
  for (const Rest& rest : rests.all) used += rest.used() ? 1 : 0;
  findings.push_back({Severity::info,
                      fmt::format("{} found, {} used: at rest is where the variance stays below {:g} times "
                                  "that of the quietest fifth",
                                  say_count(rests.all.size(), "rest"), used, rests.multiplier),
                      ""});
  for (std::size_t k = 0; k < rests.all.size(); ++k)
    if (!rests.all[k].used())
      findings.push_back({Severity::warning, "not used: " + rests.all[k].why_not,
                          fmt::format("rest {} at {}", k + 1, say_instant(rests.all[k].begin))});
  for (const Move& move : fit.moves)
    if (!move.used())
      findings.push_back({Severity::warning, "not used: " + move.why_not,
                          fmt::format("move from rest {} to rest {}", move.from + 1, move.to + 1)});
  if (used < 18)
    findings.push_back({Severity::warning,
                        fmt::format("only {} rests for nine coefficients of the accelerometers: 20 to 40 "
                                    "make the scatter and the uncertainties sure",
                                    used),
                        ""});
}

void add_scatter(const Fit& fit, Findings& findings) {
  const auto say = [&](Part part, const char* what, const char* unit) {
    const auto i = static_cast<std::size_t>(part);
    findings.push_back({Severity::info,
                        fit.scatter_seen[i] ? fmt::format("{}: {} besides their noise", what,
                                                          say_difference(std::sqrt(fit.scatter[i]), Unit::parse(unit)))
                                            : fmt::format("{}: none besides their noise", what),
                        ""});
  };
  say(Part::force, "scatter of the accelerometers from rest to rest", "ug");
  if (fit.parameters == of_accelerometers) return;
  say(Part::rate, "scatter of the gyros from rest to rest", "deg/h");
  say(Part::turn, "scatter of the moves, of the angle turned", "%");
}

void add_surroundings(const Fit& fit, const Surroundings& around, Findings& findings) {
  findings.push_back(
      {Severity::info,
       fmt::format("gravity {:.6g} m/s^2 ({}), +- {}: all scale factors of accelerometers are "
                   "relative to it",
                   around.gravity, around.gravity_from, say_difference(around.gravity_sd, Unit::parse("ug"))),
       ""});
  if (fit.parameters == of_accelerometers) return;
  findings.push_back(
      {Severity::info,
       around.latitude ? fmt::format("rotation of the Earth: taken off about the vertical ({}); its level part, whose "
                                     "direction is not known, is in the uncertainty",
                                     say_difference(earth_rate * std::sin(*around.latitude), Unit::parse("deg/h")))
                       : "rotation of the Earth: neglected, 15 deg/h at most, and in the uncertainty; state the "
                         "latitude to take off its part about the vertical",
       ""});
}

}  // namespace

Estimate describe(const std::vector<Session>& sessions, const Rests& rests, const Fit& fit,
                  const Surroundings& around) {
  Estimate estimate;
  estimate.method = "imu_multi_position";
  const auto all = all_shown(sessions, fit);
  add_parameters(all, fit, rests, sessions.front().accelerometer.step, around, estimate);
  estimate.fit.observations = fit.observations;
  estimate.fit.degrees_of_freedom = static_cast<double>(fit.observations) - static_cast<double>(fit.parameters) -
                                    2.0 * static_cast<double>(fit.chain.size());
  estimate.fit.chi_square = fit.chi_square;
  estimate.fit.condition = fit.condition;
  std::vector<std::string> names(static_cast<std::size_t>(fit.parameters));
  for (const auto& s : all) names[static_cast<std::size_t>(s.main)] = s.parameter.name;
  Guidance guidance = guidance_of(fit, names, around.gravity);
  estimate.tables.push_back(rests_table(rests, fit, around.gravity, sessions.size() > 1));
  if (!fit.moves.empty()) estimate.tables.push_back(moves_table(fit));
  estimate.tables.push_back(std::move(guidance.poses));
  if (!guidance.turns.rows.empty()) estimate.tables.push_back(std::move(guidance.turns));
  estimate.tables.push_back(covered(sessions, rests, fit, estimate));
  add_curves(rests, fit, around.gravity, estimate);
  add_left_out(rests, fit, estimate.findings);
  add_scatter(fit, estimate.findings);
  add_surroundings(fit, around, estimate.findings);
  estimate.findings.push_back({Severity::info, guidance.advice, ""});
  if (sessions[0].gyro.empty())
    estimate.findings.push_back({Severity::info, "no gyros: the accelerometers alone are calibrated", ""});
  if (!fit.no_gyros.empty()) estimate.findings.push_back({Severity::error, "not calibrated: " + fit.no_gyros, "gyros"});
  return estimate;
}

}  // namespace tumble::imu_multi_position
