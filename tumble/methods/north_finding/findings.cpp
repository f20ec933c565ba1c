#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/say.hpp"
#include "tumble/earth/earth.hpp"
#include "tumble/methods/north_finding/report.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::north_finding {
namespace {

using Severity = Finding::Severity;

double arcsec(double angle) { return Unit::parse("arcsec").from_si(angle); }
double hourly(double rate) { return Unit::parse("deg/h").from_si(rate); }

bool found(const Solution& solution, Quantity quantity) {
  return std::ranges::find(solution.free, quantity) != solution.free.end();
}

std::vector<double> measured(const Signal& signal) {
  std::vector<double> out;
  for (const auto& row : signal.rows) out.push_back(row.output);
  return out;
}

std::vector<double> modelled(const Signal& signal, const State& state) {
  std::vector<double> out;
  for (const auto& row : signal.rows) out.push_back(output_of(state, row));
  return out;
}

std::string suspects(double ratio) {
  if (ratio < 0.1)
    return "the gyro hardly sees the Earth turn: is its laser locked in for want of dither, its input axis vertical, "
           "its output the right column?";
  for (const double factor : {minute, hour})
    for (const double power : {factor, 1.0 / factor})
      if (std::abs(ratio / power - 1.0) < 0.1) return "the unit of the gyro's rate looks wrong (h, min, s)";
  if (std::abs(ratio - degrees_per_radian) < 3.0 || std::abs(ratio - degree) < 1e-3)
    return "the unit of the gyro's rate looks wrong (deg, rad)";
  return "the scale factor, the unit or the latitude is wrong, or the positions are not where the plan says";
}

/// The size of the horizontal rate against w_ie cos(latitude).
void check_size(const Bench& bench, const Reduction& reduction, Findings& out) {
  const auto& setup = reduction.setup;
  if (!setup.shown.both || found(reduction.solution, gyro_scale)) return;
  const Signal& signal = bench.signals.front();
  const State& s = reduction.solution.state;
  const auto seen = harmonics_of(signal, measured(signal), setup.shown, setup.drift);
  const auto due = harmonics_of(signal, modelled(signal, s), setup.shown, setup.drift);
  const double size = std::hypot(seen.x, seen.y), expected = std::hypot(due.x, due.y);
  const double sd = expected * std::sqrt(reduction.solution.covariance(0, 0));
  if (std::abs(size - expected) < 6.0 * sd || std::abs(size - expected) < 0.02 * expected) return;
  out.push_back({Severity::error,
                 fmt::format("over the index angles the gyro shows a horizontal rate of {:.4g} deg/h where the Earth "
                             "gives {:.4g} deg/h at this latitude and tilt: {}",
                             hourly(size / s[gyro_scale]), hourly(expected / s[gyro_scale]), suspects(size / expected)),
                 ""});
}

/// Both accelerometers show the same tilt; exchanged, reversed or turned the other way they show the opposite.
void check_accelerometers(const Bench& bench, const Reduction& reduction, Findings& out) {
  const Signal *x = signal_of(bench, accelerometer_x), *y = signal_of(bench, accelerometer_y);
  if (!x || !y) return;
  const Shown of_x = shown_by(*x), of_y = shown_by(*y);
  if (!of_x.both || !of_y.both) return;
  const State& s = reduction.solution.state;
  const auto tilt = [&](const Signal& signal, const Shown& shown) {
    const auto h = harmonics_of(signal, measured(signal), shown, false);
    const double unit = s[scale_of(signal.channel)] * s[gravity_here];
    return Vector3{h.x / unit, h.y / unit, 0.0};
  };
  const Vector3 a = tilt(*x, of_x), b = tilt(*y, of_y);
  double sd = 0.0;
  for (std::size_t k = 0; k < reduction.solution.free.size(); ++k)
    if (reduction.solution.free[k] == pitch) sd = std::sqrt(reduction.solution.covariance(k, k));
  const double apart = norm(a - b);
  if (apart < std::max({10.0 * sd, 1e-4, 0.02 * norm(a)})) return;
  const bool opposite = norm(a + b) < 0.2 * apart;
  out.push_back(
      {Severity::error,
       fmt::format(
           "the accelerometers contradict each other: by accelerometer_x the base is tilted by ({:.4g}, {:.4g}) "
           "arcsec along its x and y, by accelerometer_y by ({:.4g}, {:.4g}) arcsec. {}",
           arcsec(a.x), arcsec(a.y), arcsec(b.x), arcsec(b.y),
           opposite ? "They are opposite: one of them is reversed (the sign of gravity), the two are exchanged, "
                      "or the table turns the other way than the plan says"
                    : "Is one of them in another unit (g against m/s^2), or its scale factor wrong?"),
       ""});
}

/// Places that do not follow the circle; whether exchanging two of them mends it.
// NOLINTNEXTLINE(readability-function-size): 43 lines; to be split when it changes
void check_order(const Bench& bench, const Reduction& reduction, Findings& out) {
  const Signal& signal = bench.signals.front();
  const auto& setup = reduction.setup;
  const bool stays = std::ranges::all_of(signal.places, [](const Place& place) { return place.steady; });
  if (!stays || !setup.shown.both || signal.rows.size() < 5 || signal.rows.size() > 200) return;
  const auto squares = [](const Harmonics& h) {
    double sum = 0.0;
    for (const double r : h.residuals) sum += r * r;
    return sum;
  };
  auto outputs = measured(signal);
  const double before = squares(harmonics_of(signal, outputs, setup.shown, setup.drift));
  double white = 0.0;
  for (const auto& row : signal.rows)
    white += reduction.noise.front().white / row.seconds + row.rounding_sd * row.rounding_sd;
  const double horizontal = reduction.solution.state[gyro_scale] * earth_rate;
  const auto n = static_cast<double>(signal.rows.size());
  if (before < 100.0 * white || before < n * std::pow(1e-3 * horizontal, 2)) return;
  double best = before;
  std::pair<std::size_t, std::size_t> exchanged;
  for (std::size_t a = 0; a < outputs.size(); ++a)
    for (std::size_t b = a + 1; b < outputs.size(); ++b) {
      std::swap(outputs[a], outputs[b]);
      const double now = squares(harmonics_of(signal, outputs, setup.shown, setup.drift));
      std::swap(outputs[a], outputs[b]);
      if (now < best) {
        best = now;
        exchanged = {a, b};
      }
    }
  const auto label = [&](std::size_t row) { return signal.places[signal.rows[row].place].label; };
  const std::string mend = best < 0.02 * before
                               ? fmt::format(
                                     ". With '{}' and '{}' exchanged they would follow it: were these two recorded in "
                                     "the other order?",
                                     label(exchanged.first), label(exchanged.second))
                               : ": are the positions in the order and at the angles of the plan?";
  out.push_back({best < 0.02 * before ? Severity::error : Severity::warning,
                 fmt::format("the rates at the index angles do not follow a circle: they are off by {:.3g} deg/h rms, "
                             "{:.0f} times what the noise within the stays explains{}",
                             hourly(std::sqrt(before / n) / reduction.solution.state[gyro_scale]),
                             std::sqrt(before / white), mend),
                 ""});
}

/// Stays whose averages scatter far more than those of the others.
void check_rest(const Bench& bench, Findings& out) {
  for (const auto& signal : bench.signals) {
    std::vector<double> mean_square(signal.places.size(), 0.0), count(signal.places.size(), 0.0);
    for (std::size_t b = 0; b < signal.row_of.size(); ++b) {
      if (signal.row_of[b] == npos || !signal.places[signal.rows[signal.row_of[b]].place].steady) continue;
      const Row& row = signal.rows[signal.row_of[b]];
      const double off = signal.blocks.output[b] - row.output;
      mean_square[row.place] += signal.blocks.weights[b] * off * off;
      count[row.place] += 1.0;
    }
    std::vector<double> densities;
    for (std::size_t p = 0; p < count.size(); ++p)
      if (count[p] > 2.0) densities.push_back(mean_square[p] / (count[p] - 1.0));
    if (densities.size() < 4) continue;
    std::ranges::nth_element(densities, densities.begin() + static_cast<std::ptrdiff_t>(densities.size() / 2));
    const double usual = densities[densities.size() / 2];
    for (std::size_t p = 0; p < count.size(); ++p)
      if (count[p] > 2.0 && usual > 0.0 && mean_square[p] / (count[p] - 1.0) > 30.0 * usual)
        out.push_back(
            {Severity::warning,
             fmt::format("{} is {:.0f} times as unsteady in this stay as in the others: had the table come to "
                         "rest? A longer settling drops the beginning of every stay",
                         signal.problem.role, std::sqrt(mean_square[p] / (count[p] - 1.0) / usual)),
             fmt::format("{}, run {}", signal.places[p].label, signal.places[p].run)});
  }
}

void say_drift(const Bench& bench, const Reduction& reduction, Findings& out) {
  const Signal& signal = bench.signals.front();
  if (reduction.setup.drift || signal.places.size() < 2) return;
  double shift = 0.0;
  const Matrix& gain = reduction.solution.gain;
  for (std::size_t r = 0; r < signal.rows.size(); ++r)
    shift += gain(0, r) * reduction.solution.state[gyro_scale] * signal.rows[r].time;
  shift *= si(0.01, "deg/h/h");
  if (std::abs(arcsec(shift)) < 0.05) return;
  out.push_back({Severity::info,
                 fmt::format("in this order a drift of the bias of 0.01 deg/h in an hour moves the azimuth by {:.3g} "
                             "arcsec; gone through forwards and back (0, 90, 180, 270, 270, 180, 90, 0 deg) it cancels",
                             arcsec(shift)),
                 ""});
}

void say_tilt(const Bench& bench, const Reduction& reduction, Findings& out) {
  const auto& solution = reduction.solution;
  if (found(solution, pitch) && found(solution, roll)) return;
  const bool none = !found(solution, pitch) && !found(solution, roll);
  out.push_back(
      {Severity::info,
       fmt::format("{}: it is taken as the rig has it, with the rig's level_sd. A tilt across the heading moves "
                   "the azimuth by tan(latitude) = {:.3g} of it",
                   none ? bench.signals.size() > 1 ? "the positions do not let the accelerometers show the tilt"
                                                   : "no accelerometer shows the tilt of the base"
                        : "the accelerometers show the tilt of the base in one direction alone",
                   std::tan(solution.state[latitude])),
       ""});
}

void say_ambiguity(const Bench& bench, const Reduction& reduction, Findings& out) {
  const auto& setup = reduction.setup;
  const auto& settings = bench.plan->settings;
  const double value = wrapped(reduction.solution.state[azimuth]);
  const auto degrees = [](double angle) { return Unit::parse("deg").from_si(wrapped(angle)); };
  if (setup.other_azimuth && !settings.has("azimuth_about"))
    out.push_back(
        {Severity::error,
         fmt::format("index angles 180 deg apart show how far x is from north, not to which side: the azimuth "
                     "is {:.4f} deg or {:.4f} deg. Say which with [settings] azimuth_about, or add a position "
                     "at 90 deg",
                     degrees(value), degrees(*setup.other_azimuth)),
         ""});
  if (settings.has("azimuth_about") &&
      std::abs(std::remainder(value - settings.number("azimuth_about"), two_pi)) > 0.25 * two_pi)
    out.push_back({Severity::warning,
                   "the azimuth found is more than 90 deg off azimuth_about: is the sign of the gyro's scale factor "
                   "right, and the sense in which the table turns?",
                   ""});
}

void say_uncertain(const Bench& bench, const Reduction& reduction, bool predicted, Findings& out) {
  const auto& solution = reduction.solution;
  const double sd = std::sqrt(solution.covariance(0, 0));
  if (sd > 0.2)
    out.push_back({Severity::error,
                   fmt::format("the azimuth is uncertain by {:.2g} deg: this test does not find north{}",
                               Unit::parse("deg").from_si(sd),
                               reduction.setup.shown.both ? ""
                                                          : " (x points near north or south, where two positions "
                                                            "show nothing; turn the first by 90 deg)"),
                   ""});
  if (const double c = std::cos(solution.state[latitude]); c < 0.17)
    out.push_back({Severity::warning,
                   fmt::format("near the pole: the horizontal part of the Earth's rate is only {:.3g} of it, and every "
                               "error of a rate counts {:.3g} times",
                               c, 1.0 / c),
                   ""});
  if (predicted) return;
  if (!reduction.noise.front().slow_shown && !reduction.noise.front().slow_known)
    out.push_back(
        {Severity::warning,
         "there are no more positions than unknowns: what the bias does from one to the next does not show and "
         "is not in the uncertainty. State gyro_bias_instability, or add positions",
         ""});
  if (!bench.plan->calibration.result && !(bench.plan->settings.number("gyro_misalignment_sd") > 0.0))
    out.push_back({Severity::info,
                   "the gyro's axis is taken to lie along x exactly: its angle gamma_y towards y enters the azimuth in "
                   "full. Give a calibration, or state gyro_misalignment_sd",
                   ""});
  if (bench.plan->settings.has("reference_azimuth")) {
    const double off =
        std::remainder(solution.state[azimuth] - bench.plan->settings.number("reference_azimuth"), two_pi);
    out.push_back({Severity::info,
                   fmt::format("the azimuth is {:.4g} arcsec off reference_azimuth: {:.2g} of its standard uncertainty",
                               arcsec(off), std::abs(off) / sd),
                   ""});
  }
}

}  // namespace

Findings findings_of(const Bench& bench, const Reduction& reduction, bool predicted) {
  Findings out{{Severity::info, scheme_of(bench), ""}};
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
