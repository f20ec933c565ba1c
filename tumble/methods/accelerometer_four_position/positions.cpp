#include "tumble/methods/accelerometer_four_position/positions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/methods/accelerometer_four_position/cells.hpp"
#include "tumble/methods/accelerometer_four_position/counts.hpp"
#include "tumble/methods/accelerometer_four_position/halves.hpp"
#include "tumble/reduce/accelerometer/samples.hpp"
#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer_four_position {
namespace {

constexpr double near_axis = 0.05;  ///< [rad] by which an axis may lean and still count as vertical
constexpr double one_row = 1e9;     ///< [s] longer than any segment: one row for each

linear::Problem problem_of(const Settings& settings, const std::string& role) {
  linear::Problem problem;
  problem.role = role;
  problem.input = Input::specific_force_x;
  problem.settling = settings.number("settling");
  problem.averaging = one_row;
  return problem;
}

/// Commanded temperature over a stretch: its mean, and that of the second half minus that of the first.
void set_commanded_temperature(const PowerUp& power_up, const Stretch& stretch, Position& position) {
  constexpr std::size_t points = 16;
  std::vector<Felt> felt(points);
  const double length = stretch.duration(), step = length / points;
  power_up.reference.felt(stretch.first + 0.5 * step, step, felt);
  double halves[2] = {0.0, 0.0};
  for (std::size_t k = 0; k < points; ++k) halves[2 * k / points] += 2.0 / points * felt[k].temperature;
  position.temperature = 0.5 * (halves[0] + halves[1]);
  position.temperature_drift = halves[1] - halves[0];
}

/// Measured temperature over a stretch, likewise. Returned: false where the channel has no samples there.
bool set_measured_temperature(const Channel& channel, const Stretch& stretch, Position& position) {
  const Halves read = halves_of(channel, channel.values, stretch);
  if (!std::isfinite(read.mean)) return false;
  position.temperature = read.mean;
  position.temperature_drift = read.change;
  return true;
}

void set_place(const Felt& felt, Position& position) {
  const Vector3 f = felt.specific_force;
  position.gravity = norm(f);
  const double lean = std::cos(near_axis) * position.gravity;
  if (std::abs(f.x) > lean) position.place = f.x > 0.0 ? Place::up : Place::down;
  for (const bool o : {false, true}) {
    const double along = o ? f.z : f.y;
    if (!(std::abs(along) > lean)) continue;
    position.place = Place::level;
    position.o_level = o;
    position.upwards = along > 0.0;
  }
}

/// Scatter of the averages within a stretch, as a density.
void set_scatter(const Stretch& stretch, double averaging, Position& position) {
  const auto wanted = static_cast<std::size_t>(std::llround(averaging / stretch.step));
  const std::size_t each = std::max<std::size_t>(1, std::min(wanted, stretch.values.size() / 4));
  position.averaging = static_cast<double>(each) * stretch.step;
  std::vector<double> means;
  for (std::size_t first = 0; first + each <= stretch.values.size(); first += each) {
    double sum = 0.0;
    for (std::size_t i = first; i < first + each; ++i) sum += stretch.values[i];
    if (std::isfinite(sum)) means.push_back(sum / static_cast<double>(each));
  }
  if (means.size() < 2) return;
  double mean = 0.0;
  for (const double m : means) mean += m / static_cast<double>(means.size());
  for (const double m : means) position.squares += (m - mean) * (m - mean);
  position.squares *= position.averaging;
  position.freedom = static_cast<double>(means.size() - 1);
}

/// Whether a segment commands the temperature alone, for the instrument to soak.
bool is_soak(const Segment& segment) { return segment.axes.size() == 1 && segment.axes.contains("temperature"); }

void add_positions(const Evidence* measured, double averaging, Bench& bench) {
  std::map<std::size_t, std::size_t> power_ups;
  std::vector<std::string> skipped;
  bench.measured_temperature = measured != nullptr;
  for (std::size_t g = 0; g < bench.evidence.test.stretches.size(); ++g) {
    const auto& stretch = bench.evidence.test.stretches[g];
    const auto& power_up = bench.evidence.test.power_ups[stretch.power_up];
    const auto& segment = power_up.rig.segments[stretch.segment];
    if (is_soak(segment)) continue;
    Position position{.stretch = g, .label = stretch.label, .run = stretch.run};
    position.commands_temperature = segment.axes.contains("temperature");
    position.power_up = power_ups.try_emplace(stretch.start, power_ups.size()).first->second;
    position.output = bench.rows.segments[g].measured;
    position.seconds = bench.rows.segments[g].duration;
    set_place(bench.rows.segments[g].felt, position);
    set_commanded_temperature(power_up, stretch, position);
    position.set_point = position.temperature;
    const Channel* thermometer =
        measured ? channel_for(*measured, measured->recordings[stretch.recording], "temperature") : nullptr;
    if (!thermometer || !set_measured_temperature(*thermometer, stretch, position)) bench.measured_temperature = false;
    set_scatter(stretch, averaging, position);
    if (position.place == Place::none) {
      skipped.push_back(stretch.label);
      continue;
    }
    bench.positions.push_back(std::move(position));
  }
  if (!skipped.empty())
    bench.findings.push_back({Finding::Severity::warning,
                              "no_axis_vertical",
                              {{"segments", accelerometer::all_quoted(skipped)}},
                              "",
                              {skipped.size(), {}, {}}});
}

/// Level of the white noise: the scatter of the averages, from which the rounding to pulses, of variance 1/6 pulse^2
/// each, is subtracted (3.14).
void set_white(Bench& bench) {
  double squares = 0.0, rounding = 0.0;
  for (const auto& position : bench.positions) {
    if (!(position.freedom > 0.0)) continue;
    squares += position.squares;
    bench.white_freedom += position.freedom;
    // n roundings correlated by -1/2 with their neighbours: squares about the mean of (n - 1/n) variances
    const double n = position.freedom + 1.0;
    rounding += (n - 1.0 / n) * position.averaging * pulses::rounding_variance(bench.pulse, position.averaging);
  }
  if (bench.white_freedom > 0.0) bench.white = std::max(0.0, (squares - rounding) / bench.white_freedom);
}

/// Whether a finding speaks of a segment in which the instrument soaks: no sample of it is needed.
bool about_soak(const Bench& bench, const Finding& finding) {
  if (finding.code != "segment_not_used") return false;
  const auto* label = std::get_if<std::string>(&finding.values.front().value);
  const auto soaks = [&](const Segment& segment) { return is_soak(segment) && label && segment.label == *label; };
  return std::ranges::any_of(bench.evidence.test.power_ups, [&](const PowerUp& power_up) {
    return std::ranges::any_of(power_up.rig.segments, soaks);
  });
}

/// The positions and cells of a bench whose output, scale factor and `evidence` are set.
void complete(const Settings& settings, const Evidence* measured, Bench& bench) {
  bench.rows = linear::rows_of(bench.evidence, bench.problem);
  for (const auto& finding : bench.evidence.test.findings)
    if (!about_soak(bench, finding)) bench.findings.push_back(finding);
  bench.self_heating = settings.number("self_heating");
  add_positions(measured, settings.number("averaging"), bench);
  drop_soaks(settings.number("same_temperature"), bench);
  if (measured) refuse_overflow(bench);
  add_cells(settings, bench);
  if (measured) set_white(bench);
}

void set_scale(double reference, const accelerometer::Output& output, Bench& bench) {
  bench.output = output;
  bench.reference_scale_factor = reference;
  if (output.pulses) bench.pulse = 1.0 / std::abs(reference);
}

}  // namespace

std::string in_words(double temperature) {
  return fmt::format("{:.1f} degC", std::round(10.0 * (temperature - 273.15)) / 10.0 + 0.0);
}

Bench bench_of(const Evidence& evidence, const std::string& role) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording to identify from");
  const Settings& settings = evidence.plan.settings;
  const Channel& channel = require_channel(evidence, evidence.recordings.front(), role);
  Bench bench;
  set_scale(accelerometer::required_scale_factor(settings, channel), accelerometer::output_of(channel), bench);
  bench.problem = problem_of(settings, role);
  bench.problem.scale = 1.0 / bench.reference_scale_factor;
  bench.problem.pulse = bench.pulse;
  bench.measured = &evidence;
  bench.rates = std::make_shared<const Evidence>(per_second(evidence, role, bench.findings));
  if (bench.output.pulses) bench.problem.settling += 1.0 / sampling_rate(channel);  // its stamp may be that of its end
  bench.evidence = linear::evidence_of(*bench.rates, bench.problem);
  complete(settings, &evidence, bench);
  return bench;
}

Bench bench_of(const Plan& plan) {
  Bench bench;
  set_scale(accelerometer::scale_factor_of(plan.truth), accelerometer::output_of(plan.truth, plan.sample_rate), bench);
  bench.problem = problem_of(plan.settings, "accelerometer");
  if (bench.output.pulses) bench.problem.settling += 1.0 / plan.sample_rate;
  bench.evidence = linear::evidence_of(plan, bench.problem);
  complete(plan.settings, nullptr, bench);
  return bench;
}

}  // namespace tumble::accelerometer_four_position
