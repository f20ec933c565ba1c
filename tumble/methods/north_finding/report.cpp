#include "tumble/methods/north_finding/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tumble/core/columns.hpp"
#include "tumble/earth/earth.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::north_finding {
namespace {

constexpr double least_shown = 1e-6;  ///< [1] of the variance: a thousandth of the uncertainty is the least line

/// Name, unit and description of a quantity in the result.
struct Face {
  std::string name, symbol, unit, description;
};

Face face_of(const Bench& bench, Quantity quantity) {
  const auto scale = [&](Channel channel) {
    return fmt::format("{}/({})", bench.records[channel].unit.text(), channel == gyro ? "deg/h" : "m/s^2");
  };
  switch (quantity) {
    case azimuth:
      return {"azimuth", "A", "deg", "heading of the body's x axis at index 0, from north to the east, in the horizon"};
    case pitch:
      return {"pitch", "p", "deg", "elevation of x at index 0: tilt of the turning axis towards -x"};
    case roll:
      return {"roll", "r", "deg", "turn of the base about its x: y up"};
    case gyro_bias:
      return {"bias", "eps", "deg/h", "output of the gyro at no rate, in the middle of the test"};
    case gyro_drift:
      return {"drift", "d", "deg/h/h", "change of the bias with time"};
    case gyro_scale:
      return {"scale_factor", "K", bench.records[gyro].pulses ? "pulse/arcsec" : scale(gyro),
              "of the gyro, from w_ie cos(latitude)"};
    case gyro_z:
      return {"misalignment_z", "gamma_z", "arcsec", "of the gyro's axis towards z, from the rates of the table"};
    default:
      return {quantity == x_bias ? "accelerometer_x.bias" : "accelerometer_y.bias", "b", "ug",
              "output of the accelerometer at no specific force"};
  }
}

void add_parameters(const Bench& bench, const Solution& solution, Estimate& estimate) {
  for (std::size_t k = 0; k < solution.free.size(); ++k) {
    const auto face = face_of(bench, solution.free[k]);
    const double value = solution.state[solution.free[k]];
    estimate.parameters.push_back({face.name, face.symbol, Unit::parse(face.unit), k == 0 ? wrapped(value) : value,
                                   face.description, solution.degrees_of_freedom[k]});
  }
  settle(estimate, solution.lines);
  estimate.fit = solution.fit;
}

Table budget_of(const Estimate& estimate) {
  struct Line {
    std::string source;
    double variance;
  };
  const double total = estimate.covariance(0, 0);
  std::vector<Line> rows;
  for (const auto& line : estimate.budget)
    if (line.variance(0) > least_shown * total) rows.push_back({line.source, line.variance(0)});
  std::ranges::stable_sort(rows, std::greater{}, &Line::variance);
  rows.push_back({"all together", total});
  return tabulate("azimuth_budget", "what the uncertainty of the azimuth is made of", rows,
                  {{"source", &Line::source},
                   {"sd", "arcsec", [](const Line& r) { return std::sqrt(r.variance); }},
                   {"share", "%", [&](const Line& r) { return r.variance / total; }}});
}

/// Means over the rows of each position of the gyro, as rates.
/// Sums over the rows of a stay or a revolution, weighted by seconds: [rad] of the gyro, [m/s] along x.
struct SumsOfStay {
  const Position& position;
  double seconds = 0.0, measured = 0.0, modelled = 0.0, force = 0.0;
};

std::vector<SumsOfStay> sums_of(const Signal& signal, const State& state) {
  std::vector<SumsOfStay> all;
  State plain = state;
  plain[x_scale] = 1.0;
  plain[x_bias] = plain[x_y] = plain[x_z] = 0.0;
  std::size_t r = 0;
  for (std::size_t p = 0; p < signal.positions.size(); ++p) {
    SumsOfStay sums{signal.positions[p]};
    for (; r < signal.rows.size() && signal.rows[r].position == p; ++r) {
      const Row& row = signal.rows[r];
      Row along = row;
      along.channel = accelerometer_x;
      sums.seconds += row.seconds;
      sums.measured += row.seconds * row.output / state[gyro_scale];
      sums.modelled += row.seconds * output_of(state, row) / state[gyro_scale];
      sums.force += row.seconds * output_of(plain, along);
    }
    if (sums.seconds > 0.0) all.push_back(sums);
  }
  return all;
}

Table positions_of(const Bench& bench, const Reduction& reduction, bool predicted) {
  const State& state = reduction.solution.state;
  const auto noise = [&](const SumsOfStay& s) {
    return std::sqrt(reduction.noise.front().white / s.seconds) / state[gyro_scale];
  };
  std::vector<ColumnOf<SumsOfStay>> columns{
      {"label", [](const SumsOfStay& s) { return s.position.label; }},
      {"run", [](const SumsOfStay& s) { return s.position.run; }},
      {"index_angle", "deg", [](const SumsOfStay& s) { return wrapped(s.position.angle); }},
      {"duration", "s", &SumsOfStay::seconds},
      {"f_x", "mg", [](const SumsOfStay& s) { return s.force / s.seconds; }},
      {"predicted", "deg/h", [](const SumsOfStay& s) { return s.modelled / s.seconds; }},
      {"noise_sd", "deg/h", noise}};
  if (!predicted) {
    columns.emplace_back("measured", "deg/h", [](const SumsOfStay& s) { return s.measured / s.seconds; });
    columns.emplace_back("residual", "deg/h",
                         [](const SumsOfStay& s) { return (s.measured - s.modelled) / s.seconds; });
  }
  return tabulate("positions", "the gyro at each index angle; of a table that turns, revolution by revolution",
                  sums_of(bench.signals.front(), state), columns);
}

double apart(double a, double b) { return std::remainder(a - b, two_pi); }

Table methods_of(const Bench& bench, const Reduction& reduction) {
  const auto forms = closed_forms(bench, reduction);
  const double joint = reduction.solution.state[azimuth];
  using Form = std::pair<const char*, double>;
  const std::vector<Form> rows{{"as if level", forms.uncorrected},
                               {"tilt to first order (2.9)", forms.first_order},
                               {"tilt exact (2.12)", forms.exact},
                               {"joint fit", joint}};
  return tabulate("methods", "the azimuth by the closed forms, and how far they are from the joint fit", rows,
                  {{"method", &Form::first},
                   {"azimuth", "deg", [](const Form& r) { return wrapped(r.second); }},
                   {"difference", "arcsec", [&](const Form& r) { return apart(r.second, joint); }}});
}

Table before_after(const Bench& bench, const Reduction& reduction, const Reduction& nominal) {
  const auto& settings = bench.plan->settings;
  const auto value = [](const Reduction* r) { return r->solution.state[azimuth]; };
  std::vector<ColumnOf<const Reduction*>> columns{
      {"instrument", [&](const Reduction* r) { return r == &nominal ? "nominal" : "identified"; }},
      {"azimuth", "deg", [&](const Reduction* r) { return wrapped(value(r)); }},
      {"sd", "arcsec", [](const Reduction* r) { return std::sqrt(r->solution.covariance(0, 0)); }},
      {"gamma_y", "arcsec", [](const Reduction* r) { return r->solution.state[gyro_y]; }}};
  if (settings.has("reference_azimuth"))
    columns.emplace_back("error", "arcsec",
                         [&](const Reduction* r) { return apart(value(r), settings.number("reference_azimuth")); });
  const double moved = Unit::parse("arcsec").from_si(apart(value(&reduction), value(&nominal)));
  return tabulate("before_after",
                  fmt::format("the same test with the nominal instrument and with the identified one; the calibration "
                              "moves the azimuth by {:.4g} arcsec",
                              moved),
                  std::vector{&nominal, &reduction}, columns);
}

}  // namespace

double wrapped(double angle) {
  const double inside = std::fmod(angle, two_pi);
  return inside < 0.0 ? inside + two_pi : inside;
}

ClosedForms closed_forms(const Bench& bench, const Reduction& reduction) {
  const Signal& signal = bench.signals.front();
  const State& s = reduction.solution.state;
  std::vector<double> outputs;
  for (const auto& row : signal.rows) outputs.push_back(std::isnan(row.output) ? output_of(s, row) : row.output);
  const auto h = harmonics_of(signal, outputs, reduction.setup.shown, reduction.setup.drift);
  const double x = h.x / s[gyro_scale], y = h.y / s[gyro_scale];
  const Vector3 up = directions_of(0.0, s[pitch], s[roll]).up;
  const double vertical = earth_rate * std::sin(s[latitude]);
  return {std::atan2(y, x) + s[gyro_y], std::atan2(y - vertical * up.y, x - vertical * up.x) + s[gyro_y],
          exact_azimuth(x, y, up.x, up.y, s[latitude]) + s[gyro_y]};
}

Estimate described(const Bench& bench, const Reduction& reduction, const Reduction* nominal, bool predicted) {
  Estimate estimate;
  add_parameters(bench, reduction.solution, estimate);
  estimate.findings = bench.findings;
  for (const auto& more : {reduction.setup.findings, findings_of(bench, reduction, predicted)})
    estimate.findings.insert(estimate.findings.end(), more.begin(), more.end());
  estimate.tables.push_back(budget_of(estimate));
  if (nominal) estimate.tables.push_back(before_after(bench, reduction, *nominal));
  if (reduction.setup.shown.both) estimate.tables.push_back(methods_of(bench, reduction));
  estimate.tables.push_back(positions_of(bench, reduction, predicted));
  return estimate;
}

}  // namespace tumble::north_finding
