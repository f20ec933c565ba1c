#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tumble/core/budget.hpp"
#include "tumble/core/columns.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/gyro_scale_factor/departures.hpp"
#include "tumble/methods/gyro_scale_factor/screen.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/models/sagnac.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/output_model.hpp"
#include "tumble/units/error.hpp"

// Output E of a gyro whose input axis feels w (the table, and what the Earth gives along it), W the greatest rate:
//   E = K [ w + B + (A/2)|w| + k_3 W (u^3 - b_3 u) + k_5 W (u^5 - b_5 u) ],   u = w/W,
// b_n = sum u^(n+1)/sum u^2 over the segments, so that K stays the slope of the least-squares line. Linear in K, K B,
// K A, K k_n: the engine of linear identification finds these with their covariance.

namespace tumble::gyro_scale_factor {
namespace {
using Severity = Finding::Severity;

constexpr double follows_rate = 5.0;  ///< [sd] of the scale factor, below which the output does not follow the rate
/// [1] of the greatest rate, from which on the ratio of output and rate is compared; [1] that it may differ from the
/// middle of all by. Chosen: 2 % is beyond the nonlinearity of any gyro that is calibrated; a doubling misses wrong
/// rates of 3 %.
constexpr double large_rate = 0.1, unexpected_share = 0.02;

std::vector<Role> roles() {
  return {{"gyro", "", true, "output of the gyro: a rate, a current, a voltage, counts or angle increments"}};
}

std::vector<Option> options() {
  auto options = linear::options("2 s", "10 s");
  options.push_back(linear::bias_instability_option("deg/h"));
  options.push_back(
      integer("order").between(1, 5).otherwise("3").says("highest odd power of the rate in the model: 1, 3 or 5"));
  return options;
}

double power_of(double u, int n) { return n == 3 ? u * u * u : u * u * u * u * u; }

/// Share of u in u^n over the schedule's rates.
double own_slope(const Plan& plan, double range, int n) {
  double with = 0.0, squares = 0.0;
  for (const Segment& segment : plan.schedule) {
    const double u = commanded_rate(segment) / range;
    with += power_of(u, n) * u;
    squares += u * u;
  }
  return squares > 0.0 ? with / squares : 0.0;
}

/// An odd power of the rate over full range [rad/s], less its own slope.
struct OddPower {
  int power = 3;
  double range = 1.0, slope = 0.0;
};

std::vector<OddPower> odd_powers(const Plan& plan, int order) {
  double range = 0.0;
  for (const Segment& segment : plan.schedule) range = std::max(range, std::abs(commanded_rate(segment)));
  if (!(range > 0.0)) range = 1.0;
  std::vector<OddPower> powers;
  for (int n = 3; n <= order; n += 2) powers.push_back({n, range, own_slope(plan, range, n)});
  return powers;
}

std::vector<Term> terms_of(const std::vector<OddPower>& powers) {
  std::vector<Term> terms{
      {"bias", "B", "1", "output at rest, as a rate", 1.0},
      {"scale_factor", "K", "1", "slope of the least-squares line", Input::rate_x},
      {"scale_factor_asymmetry", "A", "1", "scale factor of positive less that of negative rates, over their mean",
       0.5 * magnitude(Input::rate_x)}};
  for (const auto& [n, range, own] : powers)
    terms.push_back({n == 3 ? "third_order_coefficient" : "fifth_order_coefficient", fmt::format("k_{}", n), "1",
                     fmt::format("power {} of rate over full range, less its own slope", n),
                     std::pow(range, 1 - n) * power(Input::rate_x, n) - own * Regressor(Input::rate_x)});
  return terms;
}

linear::Problem problem_of(const Plan& plan) {
  linear::Problem problem;
  problem.role = "gyro";
  linear::set_options(plan.settings, problem);
  problem.stated_per = "scale_factor";
  const int order = plan.settings.integer("order");
  if (order % 2 == 0) throw Error(Error::Kind::bad_input, "[settings] order must be 1, 3 or 5");
  problem.columns = terms_of(odd_powers(plan, order));
  problem.leave_out_first = {"fifth_order_coefficient", "third_order_coefficient", "scale_factor_asymmetry"};
  problem.advice = {"distinguish_by_rates"};
  return problem;
}

/// Unit of the scale factor of an output.
Unit scale_unit_of(const Channel& channel) {
  switch (channel.kind) {
    case QuantityKind::angular_rate:
    case QuantityKind::angle:
      return {};
    case QuantityKind::count:
      return Unit::parse("pulse/arcsec");
    case QuantityKind::other:
      return Unit::parse(channel.unit.text() + "/(deg/s)");
    default:
      break;
  }
  throw Error(Error::Kind::bad_data,
              say("'{}' is in {}: the output of a gyro is a rate, an angle, counts, a current or a voltage",
                  channel.name, Name{channel.unit.text()}));
}

Unit scale_unit_of(const Evidence& evidence) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "gyro_scale_factor needs at least one recording");
  const Channel& channel = require_channel(evidence, evidence.recordings.front(), "gyro");
  for (const Recording& recording : evidence.recordings)
    if (!(require_channel(evidence, recording, "gyro").unit.dimension() == channel.unit.dimension()))
      throw Error(Error::Kind::bad_data, "the recordings hold gyro outputs in different units");
  for (const Recording& recording : evidence.recordings)
    for (const double v : require_channel(evidence, recording, "gyro").values)
      if (std::isinf(v)) throw Error(Error::Kind::bad_data, say("'{}' holds infinite samples", channel.name));
  return scale_unit_of(channel);
}

/// Parameters as functions of the coefficients: K itself, the others over K.
struct Answer {
  Estimate estimate;
  std::vector<std::vector<double>> gradients;
};

Answer answer_of(const linear::Solution& solution, const Unit& scale_unit) {
  Answer answer;
  const auto& b = solution.fit.parameters;
  const std::size_t p = b.size();
  std::size_t slope = p, offset = p;
  for (std::size_t j = 0; j < p; ++j) {
    if (solution.columns[j].name == "scale_factor") slope = j;
    if (solution.columns[j].name == "bias") offset = j;
  }
  if (slope == p || offset == p)
    throw Error(Error::Kind::bad_data,
                "one rate only: it cannot distinguish scale factor and bias; add the opposite rate, or rest");
  const double k = b[slope];
  if (!(std::abs(k) > follows_rate * std::sqrt(solution.fit.covariance(slope, slope))) || !std::isfinite(k))
    throw Error(Error::Kind::bad_data,
                "the output does not follow the rate: the method cannot determine a scale factor");
  std::vector<std::size_t> sequence{slope, offset};
  for (std::size_t j = 0; j < p; ++j)
    if (j != slope && j != offset) sequence.push_back(j);
  for (const std::size_t j : sequence) {
    const Term& term = solution.columns[j];
    std::vector<double> gradient(p, 0.0);
    gradient[j] = j == slope ? 1.0 : 1.0 / k;
    if (j != slope) gradient[slope] = -b[j] / (k * k);
    const Unit unit = j == slope ? scale_unit : Unit::parse(j == offset ? "deg/h" : "ppm");
    const auto meaning = solution.stands_for.find(term.name);
    answer.estimate.parameters.push_back(
        {term.name, term.symbol, unit, j == slope ? k : b[j] / k,
         term.description + (meaning == solution.stands_for.end() ? "" : "; means " + meaning->second),
         degrees_of_freedom(solution.fit, gradient)});
    if (const auto found = solution.contains.find(term.name); found != solution.contains.end())
      for (const auto& [name, of, weight] : found->second)
        answer.estimate.parameters.back().contains.push_back(
            {name, name == solution.columns[offset].name ? Unit::parse("deg/h") : Unit::parse("ppm"),
             j == slope ? weight * k : weight});
    answer.gradients.push_back(std::move(gradient));
  }
  return answer;
}

void propagate(const linear::Solution& solution, Answer& answer) {
  Estimate& estimate = answer.estimate;
  const std::size_t n = answer.gradients.size();
  Matrix gradients(n, solution.fit.parameters.size());
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < gradients.columns; ++j) gradients(i, j) = answer.gradients[i][j];
  settle(estimate, carried(gradients, lines_of(solution.fit.sources)));
  gather_small(estimate);
  estimate.fit = {solution.observations, solution.fit.degrees_of_freedom, solution.fit.chi_square,
                  solution.fit.condition};
}

/// A parameter from the scatter of segment means: independent of the others, with a line of the budget of its own.
void add_from_scatter(Estimate& estimate, const char* name, const char* symbol, const char* unit, double value,
                      double sd, double dof, const std::string& description) {
  append_parameter(estimate, {name, symbol, Unit::parse(unit), value, description, dof}, "scatter of segment means",
                   sd * sd);
}

void add_size(Estimate& estimate, const Size& size, const char* name, const char* symbol, const char* unit, double dof,
              const std::string& description, bool only_if_significant = false) {
  const bool significant = size.significant && size.value > 0.0 && size.sd > 0.0;
  if (!significant) {
    estimate.findings.push_back(
        {Severity::info, "not_significant", {{"parameter", name}, {"limit", size.limit, unit}}});
    estimate.findings.back().hidden = {{name}};
  }
  if (!significant && (only_if_significant || !(size.limit > 0.0))) return;
  // A size that is not significant may be as large as its limit.
  add_from_scatter(estimate, name, symbol, unit, size.value, significant ? size.sd : 0.5 * (size.limit - size.value),
                   significant ? dof : INFINITY, description);
}

void add_bracket(Estimate& estimate, const Bracket& bracket, const char* name, const char* symbol,
                 const std::string& description) {
  if (bracket.bounded)
    add_from_scatter(estimate, name, symbol, "deg/h", bracket.value, bracket.sd, INFINITY, description);
  else if (bracket.tried)
    estimate.findings.push_back(
        {Severity::info, "below_smallest_input", {{"parameter", name}, {"smallest", bracket.smallest, "deg/h"}}});
}

void add_shape(const linear::Solution& solution, const Line& line, Estimate& estimate) {
  const double dof = line.degrees_of_freedom;
  if (line.departures.size() > 2) {
    add_size(estimate, line.greatest, "nonlinearity", "N_L", "ppm", dof,
             "largest departure of the segment means from the least-squares line, over full range; scatter from " +
                 line.scatter_from);
    add_size(estimate, line.rms, "nonlinearity_rms", "N_rms", "ppm", dof,
             "their root mean square; the noise is subtracted");
  } else {
    estimate.findings.push_back({Severity::warning, "two_rates_only", {}});
  }
  if (line.both_ways >= 3)
    add_size(estimate, line.hysteresis, "hysteresis", "h", "ppm", dof,
             "largest difference between means reached from below and from above, over full range");
  add_bracket(estimate, threshold_of(solution, line), "threshold", "w_t",
              "smallest rate that gives half of the output due, between the rates tried");
  add_bracket(estimate, resolution_of(solution, line), "resolution", "w_r",
              "smallest change of a rate that gives half of the change due, between those tried");
  const Repeatability repeat = repeatability_of(solution, line);
  if (repeat.runs < 3) return;
  const double runs_dof = static_cast<double>(repeat.runs) - 1.0;
  add_size(estimate, repeat.bias, "turn_on_repeatability", "s_B", "deg/h", runs_dof,
           "standard deviation of the bias between power-ups, the noise within them is subtracted", true);
  add_size(estimate, repeat.slope, "scale_factor_repeatability", "s_K", "ppm", runs_dof,
           "standard deviation of the scale factor between power-ups, the noise within them is subtracted", true);
}

/// Findings for segments far from the value that the others predict.
void judge_segments(const linear::Solution& solution, const Line& line, Estimate& estimate) {
  std::vector<double> ratios;
  const auto ratio_of = [&](const linear::SegmentSummary& s) { return (s.measured - line.offset) / s.felt.rate.x; };
  const auto large = [&](const linear::SegmentSummary& s) {
    return std::abs(s.felt.rate.x) > large_rate * line.range && !std::isnan(s.measured);
  };
  for (const auto& s : solution.segments)
    if (large(s)) ratios.push_back(ratio_of(s));
  if (ratios.size() < 3) return;
  std::ranges::sort(ratios);
  const double middle = ratios[ratios.size() / 2];
  for (const auto& s : solution.segments) {
    if (!large(s) || std::abs(ratio_of(s) / middle - 1.0) < unexpected_share) continue;
    estimate.findings.push_back(
        {Severity::error, "unexpected_output", {{"share", ratio_of(s) / middle, "%"}}, s.label});
  }
}

Table residuals_table(const Line& line) {
  return tabulate("residuals",
                  "departures of the segment means at each rate from the least-squares line, over full range",
                  line.departures,
                  {{"rate", "deg/s", &Departure::rate},
                   {"residual", "ppm", &Departure::value},
                   {"sd", "ppm", &Departure::sd},
                   {"segments", &Departure::segments}});
}

Curve residuals_curve(const Line& line) {
  Curve curve{.name = "residuals",
              .figure = "residuals",
              .x = {"rate", Unit::parse("deg/s")},
              .y = {"departure from the line, over full range", Unit::parse("ppm")},
              .band = "95 % confidence",
              .points = true};
  const double t = student_quantile(two_sided_95, line.degrees_of_freedom);
  for (const Departure& d : line.departures) add_point(curve, d.rate, d.value, t * d.sd);
  return curve;
}

/// y = K (w + B + A |w|/2 + ...)
OutputModel model_of(const Estimate& estimate, const linear::Solution& solution, const Line& line) {
  OutputModel model =
      output_model(estimate, "gyro", Input::rate_x, "deg/s", {solution.columns, solution.least, solution.greatest});
  set_scale(estimate, "scale_factor", model);
  for (std::size_t j = 0; j < solution.columns.size(); ++j)
    if (solution.columns[j].name == "scale_factor")
      model.covered = {{{{Input::rate_x, 1.0}}, solution.least[j], solution.greatest[j]}};
  if (line.departures.size() < 3) return model;
  MeasuredDepartures& measured = model.measured.emplace();
  measured.slope = line.slope;
  measured.offset = line.offset;
  for (const Departure& departure : line.departures) {
    measured.input.push_back(departure.rate);
    measured.departure.push_back(line.slope * line.range * departure.value);
  }
  return model;
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  report(progress, 0.0, "scale factor");
  const Unit unit = scale_unit_of(evidence);
  Findings screening;
  const linear::Solution solution = linear::identify(screened(evidence, "gyro", screening), problem_of(evidence.plan));
  Answer answer = answer_of(solution, unit);
  propagate(solution, answer);
  Estimate& estimate = answer.estimate;
  estimate.findings = screening;
  estimate.findings.insert(estimate.findings.end(), solution.findings.begin(), solution.findings.end());
  const Line line = line_of(solution, solution.fit.parameters.size());
  judge_segments(solution, line, estimate);
  for (auto& finding : about_order(solution, line)) estimate.findings.push_back(std::move(finding));
  for (auto& finding : about_drift(solution, line)) estimate.findings.push_back(std::move(finding));
  add_shape(solution, line, estimate);
  estimate.tables = {residuals_table(line)};
  estimate.curves = {residuals_curve(line)};
  estimate.models = {model_of(estimate, solution, line)};
  report(progress, 1.0, "done");
  return std::move(answer.estimate);
}

/// Counts [1/rad] that the model of the plan gives; none: its output is a rate.
std::optional<double> counts_of(const Plan& plan) {
  if (plan.instrument_model != "ring_laser_gyro" || plan.truth.word("output") != "count") return {};
  return ring_laser_scale_factor(plan.truth) * plan.truth.integer("edges");
}

/// The same instrument, whose output is `size` for each unit of the rate.
linear::Truth with_output_of(linear::Truth truth, double size) {
  for (auto& [name, value] : truth.coefficients)
    if (name == "scale_factor" || name == "bias") value *= size;
  NoiseModel& noise = truth.noise;
  for (double* part : {&noise.quantization_noise, &noise.angle_random_walk, &noise.bias_instability,
                       &noise.rate_random_walk, &noise.rate_ramp, &noise.markov_sd, &truth.turn_on_sd})
    *part *= size;
  return truth;
}

/// With the output taken as a rate, or as counts a second without their rounding: relative uncertainties are those of any
/// other output.
Estimate predict(const Plan& plan) {
  linear::Truth truth = linear::truth_of(plan, "gyro");
  truth.coefficients["scale_factor"] = 1.0 + truth.coefficients["scale_factor_error"];
  for (const char* name : {"scale_factor_asymmetry", "third_order_coefficient", "fifth_order_coefficient"})
    truth.coefficients.try_emplace(name, 0.0);
  const auto counts = counts_of(plan);
  const linear::Solution solution =
      linear::predict(plan, problem_of(plan), with_output_of(truth, counts.value_or(1.0)));
  Answer answer = answer_of(solution, counts ? Unit::parse("pulse/arcsec") : Unit());
  propagate(solution, answer);
  answer.estimate.findings = solution.findings;
  return std::move(answer.estimate);
}

}  // namespace

extern const Method gyro_scale_factor{
    .name = "gyro_scale_factor",
    .summary = "scale factor of a gyro, its bias, asymmetry, nonlinearity, hysteresis, threshold and resolution",
    .source =
        "IEEE Std 528 terms; two-sided rates as in Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, "
        "2015, slide 41; whole revolutions as in CN113175941B, eq. (1)",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify,
    .compensates = true,
    .predict = predict,
    .takes_prior = true};

}  // namespace tumble::gyro_scale_factor
