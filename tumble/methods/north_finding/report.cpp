#include "tumble/methods/north_finding/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/earth/earth.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::north_finding {
namespace {

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

Unit arcsec() { return Unit::parse("arcsec"); }
Unit degrees() { return Unit::parse("deg"); }

Table budget_of(const Estimate& estimate) {
  Table table{"azimuth_budget", "what the uncertainty of the azimuth is made of", {}, {}};
  table.columns = {{"source", Unit()}, {"sd", arcsec()}, {"share", Unit::parse("%")}};
  std::vector<const Contribution*> lines;
  for (const auto& line : estimate.budget) lines.push_back(&line);
  std::ranges::stable_sort(lines, std::greater{}, [](const auto* line) { return line->variance(0); });
  const double total = estimate.covariance(0, 0);
  for (const auto* line : lines)
    if (line->variance(0) > 1e-6 * total)
      table.rows.push_back({line->source, std::sqrt(line->variance(0)), line->variance(0) / total});
  table.rows.push_back({std::string("all together"), std::sqrt(total), 1.0});
  return table;
}

/// Means over the rows of each position of the gyro, as rates.
Table positions_of(const Bench& bench, const Reduction& reduction, bool predicted) {
  const Signal& signal = bench.signals.front();
  const State& state = reduction.solution.state;
  const Unit rate = Unit::parse("deg/h");
  Table table{"positions", "the gyro at each index angle; of a table that turns, revolution by revolution", {}, {}};
  table.columns = {
      {"label", Unit()},          {"run", Unit()},     {"index_angle", degrees()}, {"duration", Unit::parse("s")},
      {"f_x", Unit::parse("mg")}, {"predicted", rate}, {"noise_sd", rate}};
  if (!predicted) table.columns.insert(table.columns.end(), {{"measured", rate}, {"residual", rate}});
  std::size_t r = 0;
  for (std::size_t p = 0; p < signal.positions.size(); ++p) {
    const auto& position = signal.positions[p];
    double seconds = 0.0, measured = 0.0, modelled = 0.0, force = 0.0;
    for (; r < signal.rows.size() && signal.rows[r].position == p; ++r) {
      const Row& row = signal.rows[r];
      Row along = row;
      along.channel = accelerometer_x;
      State plain = state;
      plain[x_scale] = 1.0;
      plain[x_bias] = plain[x_y] = plain[x_z] = 0.0;
      seconds += row.seconds;
      measured += row.seconds * row.output / state[gyro_scale];
      modelled += row.seconds * output_of(state, row) / state[gyro_scale];
      force += row.seconds * output_of(plain, along);
    }
    if (!(seconds > 0.0)) continue;
    std::vector<Table::Cell> cells{position.label,
                                   static_cast<double>(position.run),
                                   wrapped(position.angle),
                                   seconds,
                                   force / seconds,
                                   modelled / seconds,
                                   std::sqrt(reduction.noise.front().white / seconds) / state[gyro_scale]};
    if (!predicted) cells.insert(cells.end(), {measured / seconds, (measured - modelled) / seconds});
    table.rows.push_back(std::move(cells));
  }
  return table;
}

double apart(double a, double b) { return std::remainder(a - b, two_pi); }

Table methods_of(const Bench& bench, const Reduction& reduction) {
  const auto forms = closed_forms(bench, reduction);
  const double joint = reduction.solution.state[azimuth];
  Table table{"methods", "the azimuth by the closed forms, and how far they are from the joint fit", {}, {}};
  table.columns = {{"method", Unit()}, {"azimuth", degrees()}, {"difference", arcsec()}};
  const auto add = [&](const char* name, double value) {
    table.rows.push_back({std::string(name), wrapped(value), apart(value, joint)});
  };
  add("as if level", forms.uncorrected);
  add("tilt to first order (2.9)", forms.first_order);
  add("tilt exact (2.12)", forms.exact);
  add("joint fit", joint);
  return table;
}

Table before_after(const Bench& bench, const Reduction& reduction, const Reduction& nominal) {
  const auto& settings = bench.plan->settings;
  const bool has_reference = settings.has("reference_azimuth");
  Table table{"before_after", "the same test with the nominal instrument and with the identified one", {}, {}};
  table.columns = {{"instrument", Unit()}, {"azimuth", degrees()}, {"sd", arcsec()}, {"gamma_y", arcsec()}};
  if (has_reference) table.columns.push_back({"error", arcsec()});
  const auto add = [&](const char* name, const Reduction& some) {
    const double value = some.solution.state[azimuth], sd = std::sqrt(some.solution.covariance(0, 0));
    table.rows.push_back({std::string(name), wrapped(value), sd, some.solution.state[gyro_y]});
    if (has_reference) table.rows.back().emplace_back(apart(value, settings.number("reference_azimuth")));
  };
  add("nominal", nominal);
  add("identified", reduction);
  const double difference = apart(reduction.solution.state[azimuth], nominal.solution.state[azimuth]);
  table.caption += fmt::format("; the calibration moves the azimuth by {:.4g} arcsec", arcsec().from_si(difference));
  return table;
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
  estimate.method = "north_finding";
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
