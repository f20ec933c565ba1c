#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "tumble/earth/earth.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/north_finding/report.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::north_finding {
namespace {

using Severity = Finding::Severity;

/// Ratios [1] of measured and expected rate that suspect a fault: no rate at all; a unit of time within 10 %; radians
/// for degrees within 5 %, degrees for radians within 6 %.
constexpr double no_earth_rate = 0.1, wrong_time_unit = 0.1, degrees_taken = 3.0, radians_taken = 1e-3;
constexpr double rate_differs_sd = 6.0;  ///< [sd] p = 2e-9
/// [1] where nothing is stated of the scale factor. Chosen: beyond usual errors.
constexpr double rate_differs_share = 0.02;
/// Two tilts differ by [sd of one direction by both], four of their difference, p = 3e-4; and by [rad] 1 arcsec of what turns one
/// of them alone; an error from [1] of the tilt on, as no scale factor is off by. Opposite within [1] of it.
constexpr double tilts_differ_sd = 8.0, tilts_differ_angle = 5e-6, tilts_differ_share = 0.02, tilts_opposite = 0.2;
constexpr double leans = 2e-3;  ///< [rad] 0.1 deg: a smaller tilt of the plan is an error of levelling
/// Positions: with fewer any order fits; all pairs are tried.
constexpr std::size_t fewest_to_order = 5, most_to_order = 200;
/// Positions that do not follow the circle: [1] of the white variance, ten times its sd, and [1] of the Earth's rate,
/// rms.
constexpr double off_circle = 100.0, off_circle_rate = 1e-3;
constexpr double mended_by_exchange = 0.02;  ///< [1] of the squares that may remain after two positions are exchanged
constexpr double noisy_stay = 30.0;  ///< [1] of the usual density: five times its deviation, a shock or work nearby
constexpr double usual_drift = 0.01, moves_azimuth = 0.05;  ///< [deg/h/h] of a gyro, and [arcsec] by it that matter
constexpr double far_from_rough = 0.25 * two_pi;            ///< [rad] the other azimuth would be nearer
constexpr double north_not_found = 0.2;                     ///< [rad] sd, 11 deg: linear propagation ends there
constexpr double near_pole = 0.17;  ///< cosine of the latitude: beyond 80 deg the azimuth is six times less certain

std::vector<double> modelled(const Signal& signal, const State& state) {
  std::vector<double> out;
  for (const auto& row : signal.rows) out.push_back(output_of(state, row));
  return out;
}

/// Kind of the test.
void say_scheme(const Bench& bench, Findings& out) {
  const auto& positions = bench.signals.front().positions;
  const auto stays = std::ranges::count(positions, true, &Position::steady);
  if (stays < std::ssize(positions)) {
    out.push_back({Severity::info, stays > 0 ? "stays_and_turning" : "continuous_turning", {}});
    return;
  }
  std::set<long> angles;
  constexpr long cells = 10L * 360;  // of a tenth of a degree
  for (const auto& position : positions) angles.insert(std::lround(wrapped(position.angle) / two_pi * cells) % cells);
  out.push_back({Severity::info, "positions_and_stays", {{"positions", angles.size()}, {"stays", positions.size()}}});
}

/// Fault that makes a rate that many times too large.
Phrase suspicion(double ratio) {
  if (ratio < no_earth_rate) return Phrase{"gyro_misses_earth_rate"};
  for (const double factor : {minute, hour})
    for (const double power : {factor, 1.0 / factor})
      if (std::abs(ratio / power - 1.0) < wrong_time_unit) return Phrase{"rate_in_wrong_time_unit"};
  if (std::abs(ratio - degrees_per_radian) < degrees_taken || std::abs(ratio - degree) < radians_taken)
    return Phrase{"rate_in_wrong_angle_unit"};
  return Phrase{"wrong_scale_factor_or_latitude"};
}

/// Relative standard uncertainty of scale factor times cos(latitude) by what is stated of both; null: nothing is stated
/// of the scale factor.
std::optional<double> stated_size_sd(const Reduction& reduction) {
  const State& s = reduction.solution.state;
  double variance = 0.0;
  bool scale_stated = false;
  for (const auto& prior : reduction.instrument.priors) {
    std::vector<double> slope(prior.of.size());
    for (std::size_t k = 0; k < prior.of.size(); ++k) {
      if (prior.of[k] == gyro_scale) slope[k] = 1.0 / s[gyro_scale], scale_stated = true;
      if (prior.of[k] == latitude) slope[k] = -std::tan(s[latitude]);
    }
    variance += quadratic_form(slope, prior.covariance);
  }
  if (!scale_stated) return std::nullopt;
  return std::sqrt(variance);
}

/// Size of the horizontal rate that these outputs show [SI of the channel].
double size_of(const Signal& signal, const std::vector<double>& outputs, const Setup& setup) {
  const auto harmonics = harmonics_of(signal, outputs, setup.shown, setup.drift);
  return std::hypot(harmonics.x, harmonics.y);
}

/// An angle in the wrong unit is named as such.
void say_unit(double ratio, Findings& out) {
  const bool degrees = std::abs(ratio - degrees_per_radian) < degrees_taken;
  if (!degrees && !(std::abs(ratio - degree) < radians_taken)) return;
  out.push_back({Severity::error,
                 "unit_mistaken",
                 {{"sensors", Phrase{"gyros"}},
                  {"ratio", ratio},
                  {"unit", degrees ? "deg/s" : "rad/s"},
                  {"read_as", degrees ? "rad/s" : "deg/s"}}});
}

/// The size of the horizontal rate against w_ie cos(latitude): within six standard uncertainties of noise and of what
/// is stated of scale factor and latitude; within 2 % where nothing is stated of the scale factor.
void check_size(const Bench& bench, const Reduction& reduction, Findings& out) {
  const auto& setup = reduction.setup;
  if (!setup.shown.both || contains(setup.free, gyro_scale)) return;
  const Signal& signal = bench.signals.front();
  const State& s = reduction.solution.state;
  const double size = size_of(signal, outputs_of(signal), setup),
               expected = size_of(signal, modelled(signal, s), setup);
  const auto stated = stated_size_sd(reduction);
  const double sd = expected * std::hypot(std::sqrt(reduction.solution.covariance(0, 0)), stated.value_or(0.0));
  if (std::abs(size - expected) < std::max(rate_differs_sd * sd, stated ? 0.0 : rate_differs_share * expected)) return;
  out.push_back({Severity::error,
                 "wrong_horizontal_rate",
                 {{"measured", size / s[gyro_scale], "deg/h"},
                  {"expected", expected / s[gyro_scale], "deg/h"},
                  {"suspicion", suspicion(size / expected)}}});
  say_unit(size / expected, out);
}

/// Tilt [rad] along x and y of the base that the rig has by the plan.
Vector3 planned_tilt(const Bench& bench, const Reduction& reduction) {
  const State planned = set_up_prediction(bench, reduction.instrument).start;
  const Vector3 up = directions_of(planned[azimuth], planned[pitch], planned[roll]).up;
  return {up.x, up.y, 0.0};
}

/// Which of the two accelerometers it is: by the ratio of what they show, and where the plan says how the rig leans also by the
/// direction. One that is reversed shows the opposite tilt; two that are exchanged show it a quarter turn apart, each to
/// another side.
void say_channels(Vector3 a, Vector3 b, Vector3 planned, Findings& out) {
  const double ratio = norm(a) / norm(b);
  for (const bool larger : {true, false})
    if (const double times = larger ? ratio : 1.0 / ratio; std::abs(times / standard_gravity - 1.0) < wrong_time_unit)
      out.push_back({Severity::error,
                     "channel_unit_mistaken",
                     {{"channel", role_of(larger ? accelerometer_x : accelerometer_y)},
                      {"ratio", times},
                      {"unit", "m/s^2"},
                      {"read_as", "g"}}});
  const double near = tilts_opposite * norm(planned);
  if (norm(planned) < leans) return;
  const Vector3 quarter{-planned.y, planned.x, 0.0};
  if (norm(a + planned) < near && norm(b - planned) < near)
    out.push_back({Severity::error, "accelerometer_reversed", {{"channel", role_of(accelerometer_x)}}});
  if (norm(b + planned) < near && norm(a - planned) < near)
    out.push_back({Severity::error, "accelerometer_reversed", {{"channel", role_of(accelerometer_y)}}});
  if (std::min(norm(a - quarter) + norm(b + quarter), norm(a + quarter) + norm(b - quarter)) < 2.0 * near)
    out.push_back({Severity::error, "accelerometers_exchanged", {}});
}

/// Both accelerometers show the same tilt; exchanged, reversed or turned the other way they show the opposite.
void check_accelerometers(const Bench& bench, const Reduction& reduction, Findings& out) {
  const Signal *x = signal_of(bench, accelerometer_x), *y = signal_of(bench, accelerometer_y);
  if (!x || !y) return;
  const Shown of_x = shown_by(*x), of_y = shown_by(*y);
  if (!of_x.both || !of_y.both) return;
  const State& s = reduction.solution.state;
  const auto tilt = [&](const Signal& signal, const Shown& shown) {
    const auto h = harmonics_of(signal, outputs_of(signal), shown, false);
    const double unit = s[scale_of(signal.channel)] * s[gravity_here];
    return Vector3{h.x / unit, h.y / unit, 0.0};
  };
  const Vector3 a = tilt(*x, of_x), b = tilt(*y, of_y);
  double sd = 0.0;
  for (std::size_t k = 0; k < reduction.solution.free.size(); ++k)
    if (reduction.solution.free[k] == pitch) sd = std::sqrt(reduction.solution.covariance(k, k));
  const double difference = norm(a - b);
  if (difference < std::max(tilts_differ_sd * sd, tilts_differ_angle)) return;
  const bool opposite = norm(a + b) < tilts_opposite * difference;
  say_channels(a, b, planned_tilt(bench, reduction), out);
  out.push_back({difference < tilts_differ_share * norm(a) ? Severity::warning : Severity::error,
                 opposite ? "opposite_tilts" : "different_tilts",
                 {{"x_along_x", a.x, "arcsec"},
                  {"x_along_y", a.y, "arcsec"},
                  {"y_along_x", b.x, "arcsec"},
                  {"y_along_y", b.y, "arcsec"}}});
}

double sum_of_squares(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return sum;
}

/// The two rows whose exchange brings the rates nearest to a circle.
struct Exchange {
  std::size_t first = 0, second = 0;
  double squares = 0.0;  ///< of the residuals after it
};

Exchange best_exchange(const Signal& signal, const Setup& setup, double squares) {
  Exchange best{0, 0, squares};
  auto outputs = outputs_of(signal);
  for (std::size_t a = 0; a < outputs.size(); ++a)
    for (std::size_t b = a + 1; b < outputs.size(); ++b) {
      std::swap(outputs[a], outputs[b]);
      const double now = sum_of_squares(harmonics_of(signal, outputs, setup.shown, setup.drift).residuals);
      std::swap(outputs[a], outputs[b]);
      if (now < best.squares) best = {a, b, now};
    }
  return best;
}

/// Positions that do not follow the circle; whether exchanging two of them mends it.
void check_order(const Bench& bench, const Reduction& reduction, Findings& out) {
  const Signal& signal = bench.signals.front();
  const auto& setup = reduction.setup;
  const bool stays = std::ranges::all_of(signal.positions, &Position::steady);
  if (!stays || !setup.shown.both || signal.rows.size() < fewest_to_order || signal.rows.size() > most_to_order) return;
  const double squares = sum_of_squares(harmonics_of(signal, outputs_of(signal), setup.shown, setup.drift).residuals);
  double white = 0.0;
  for (const auto& row : signal.rows)
    white += reduction.noise.front().white / row.seconds + row.rounding_sd * row.rounding_sd;
  const double scale = reduction.solution.state[gyro_scale];
  const auto n = static_cast<double>(signal.rows.size());
  if (squares < off_circle * white || squares < n * std::pow(off_circle_rate * scale * earth_rate, 2)) return;
  const Exchange exchange = best_exchange(signal, setup, squares);
  const FindingValue rms{"rms", std::sqrt(squares / n) / scale, "deg/h"}, ratio{"ratio", std::sqrt(squares / white)};
  const auto label = [&](std::size_t row) { return signal.positions[signal.rows[row].position].label; };
  if (exchange.squares < mended_by_exchange * squares)
    out.push_back({Severity::error,
                   "positions_exchanged",
                   {rms, ratio, {"position", label(exchange.first)}, {"other", label(exchange.second)}}});
  else
    out.push_back({Severity::warning, "positions_off_circle", {rms, ratio}});
}

/// White noise of each stay, by the scatter of its averages [SI of the channel, squared, times s]; NaN: too few.
std::vector<double> densities_of(const Signal& signal) {
  std::vector<double> density(signal.positions.size(), 0.0), count(signal.positions.size(), 0.0);
  for (std::size_t b = 0; b < signal.row_of.size(); ++b) {
    if (signal.row_of[b] == npos) continue;
    const Row& row = signal.rows[signal.row_of[b]];
    if (!signal.positions[row.position].steady) continue;
    const double off = signal.blocks.output[b] - row.output;
    density[row.position] += signal.blocks.weights[b] * off * off;
    count[row.position] += 1.0;
  }
  for (std::size_t p = 0; p < count.size(); ++p) density[p] = count[p] > 2.0 ? density[p] / (count[p] - 1.0) : NAN;
  return density;
}

/// Stays whose averages scatter far more than those of the others.
void check_rest(const Bench& bench, Findings& out) {
  for (const auto& signal : bench.signals) {
    const auto densities = densities_of(signal);
    std::vector<double> sorted;
    std::ranges::copy_if(densities, std::back_inserter(sorted), [](double d) { return std::isfinite(d); });
    if (sorted.size() < 4) continue;
    std::ranges::sort(sorted);
    const double usual = sorted[sorted.size() / 2];
    Occurrences stays{0, {}, {}};
    double worst = 0.0;
    for (std::size_t p = 0; p < densities.size(); ++p) {
      if (!(usual > 0.0 && densities[p] > noisy_stay * usual)) continue;
      const Place stay(signal.positions[p].label + ", run " + std::to_string(signal.positions[p].run));
      if (stays.count++ == 0) stays.first = stay;
      if (densities[p] > worst) stays.worst = stay, worst = densities[p];
    }
    if (stays.count > 0)
      out.push_back(
          {Severity::warning, "unsteady_stay", {{"ratio", std::sqrt(worst / usual)}}, signal.problem.role, stays});
  }
}

void say_drift(const Bench& bench, const Reduction& reduction, Findings& out) {
  const Signal& signal = bench.signals.front();
  if (reduction.setup.drift || signal.positions.size() < 2) return;
  double shift = 0.0;
  const Matrix& gain = reduction.solution.gain;
  for (std::size_t r = 0; r < signal.rows.size(); ++r)
    shift += gain(0, r) * reduction.solution.state[gyro_scale] * signal.rows[r].time;
  const double drift = si(usual_drift, "deg/h/h");
  shift *= drift;
  if (std::abs(shift) < si(moves_azimuth, "arcsec")) return;
  out.push_back({Severity::info, "drift_moves_azimuth", {{"drift", drift, "deg/h/h"}, {"shift", shift, "arcsec"}}});
}

void say_tilt(const Bench& bench, const Reduction& reduction, Findings& out) {
  const auto& free = reduction.solution.free;
  const bool by_pitch = contains(free, pitch), by_roll = contains(free, roll);
  if (by_pitch && by_roll) return;
  const Phrase reason = by_pitch || by_roll        ? Phrase{"accelerometers_show_one_direction"}
                        : bench.signals.size() > 1 ? Phrase{"positions_hide_tilt"}
                                                   : Phrase{"no_accelerometer_shows_tilt"};
  out.push_back({Severity::info,
                 "tilt_of_the_rig",
                 {{"reason", reason}, {"factor", std::tan(reduction.solution.state[latitude])}}});
}

void say_ambiguity(const Bench& bench, const Reduction& reduction, Findings& out) {
  const auto& setup = reduction.setup;
  const auto& settings = bench.plan->settings;
  const double value = wrapped(reduction.solution.state[azimuth]);
  if (setup.other_azimuth && !settings.has("azimuth_about"))
    out.push_back({Severity::error,
                   "two_azimuths",
                   {{"azimuth", value, "deg"}, {"other", wrapped(*setup.other_azimuth), "deg"}}});
  if (!settings.has("azimuth_about")) return;
  const double difference = std::remainder(value - settings.number("azimuth_about"), two_pi);
  if (std::abs(difference) > far_from_rough)
    out.push_back({Severity::warning, "azimuth_far_from_rough_azimuth", {{"difference", difference, "deg"}}});
}

void say_uncertain(const Bench& bench, const Reduction& reduction, bool predicted, Findings& out) {
  const auto& solution = reduction.solution;
  const auto& settings = bench.plan->settings;
  const double sd = std::sqrt(solution.covariance(0, 0));
  if (sd > north_not_found)
    out.push_back({Severity::error,
                   reduction.setup.shown.both ? "north_not_found" : "north_not_found_by_two_positions",
                   {{"sd", sd, "deg"}}});
  if (const double c = std::cos(solution.state[latitude]); c < near_pole)
    out.push_back({Severity::warning, "near_pole", {{"horizontal", c}, {"factor", 1.0 / c}}});
  if (predicted) return;
  const Noise& noise = reduction.noise.front();
  if (!noise.slow_shown && !noise.slow_known) out.push_back({Severity::warning, "too_few_positions_for_drift", {}});
  if (!bench.plan->calibration.result && !(settings.number("gyro_misalignment_sd") > 0.0))
    out.push_back({Severity::info, "gyro_axis_taken_as_x", {}});
  if (!settings.has("reference_azimuth")) return;
  const double difference = std::remainder(solution.state[azimuth] - settings.number("reference_azimuth"), two_pi);
  out.push_back({Severity::info,
                 "difference_from_reference_azimuth",
                 {{"difference", difference, "arcsec"}, {"ratio", std::abs(difference) / sd}}});
}

}  // namespace

std::optional<Finding> shown_by_another(const Bench& bench, const Reduction& reduction, const Bench& with_other,
                                        const std::string& other) {
  const auto& setup = reduction.setup;
  const Signal &signal = bench.signals.front(), &of_other = with_other.signals.front();
  if (!setup.shown.both || contains(setup.free, gyro_scale) || of_other.rows.size() != signal.rows.size()) return {};
  const double expected = size_of(signal, modelled(signal, reduction.solution.state), setup);
  const double size = size_of(of_other, outputs_of(of_other), setup);
  // The azimuth of a gyro that shows no rate is any, and so is the part of the vertical rate across a table that leans.
  const State& s = reduction.solution.state;
  const double lean = std::acos(std::min(1.0, directions_of(s[azimuth], s[pitch], s[roll]).up.z));
  if (std::abs(size / expected - 1.0) > rate_differs_share + 2.0 * lean * std::abs(std::tan(s[latitude]))) return {};
  return Finding{Severity::error, "another_gyro_shows_rate", {{"channel", other}}};
}

Findings findings_of(const Bench& bench, const Reduction& reduction, bool predicted) {
  Findings out;
  say_scheme(bench, out);
  if (!predicted) {
    check_size(bench, reduction, out);
    check_accelerometers(bench, reduction, out);
    check_order(bench, reduction, out);
    check_rest(bench, out);
  }
  say_ambiguity(bench, reduction, out);
  say_uncertain(bench, reduction, predicted, out);
  say_tilt(bench, reduction, out);
  say_drift(bench, reduction, out);
  return out;
}

}  // namespace tumble::north_finding
