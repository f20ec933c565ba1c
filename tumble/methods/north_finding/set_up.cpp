#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "tumble/earth/earth.hpp"
#include "tumble/math/regression/mixed_model.hpp"
#include "tumble/methods/north_finding/solve.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::north_finding {
namespace {

/// Of tilts and biases: a weaker combination is made of errors of the angles.
constexpr double greatest_condition = 1e3;

/// [rad/s] between the rates of positions, from which on they show a bias by rate.
constexpr double turning_apart = 1e-6;
constexpr double greatest_tilt = 0.75;  ///< square of its sine: 60 deg

constexpr std::size_t least_positions_for_drift = 6;

/// Which of (u_x, u_y, b_x, b_y) the accelerometers show.
struct Level {
  bool pitch = false, roll = false;
  std::vector<Quantity> biases;  ///< estimated with the tilt
};

/// Derivatives of the rows of these signals by u_x, u_y and a bias each [rows x 2 + signals].
Matrix tilt_design(const std::vector<const Signal*>& signals) {
  std::size_t rows = 0;
  for (const auto* signal : signals) rows += signal->rows.size();
  Matrix design(rows, 2 + signals.size());
  std::size_t i = 0;
  for (std::size_t s = 0; s < signals.size(); ++s)
    for (const auto& row : signals[s]->rows) {
      std::tie(design(i, 0), design(i, 1)) = sensitivity_in_base(row);
      design(i++, 2 + s) = 1.0;
    }
  return design;
}

Level level_of(const Bench& bench, const Instrument& instrument, Findings& findings) {
  std::vector<const Signal*> signals;
  for (const auto& signal : bench.signals)
    if (signal.channel != gyro) signals.push_back(&signal);
  if (signals.empty()) return {};
  const Matrix design = tilt_design(signals);
  std::vector<std::size_t> preference;
  for (std::size_t k = 2; k < design.columns; ++k) preference.push_back(k);
  preference.push_back(1);
  const auto dropped = unobservable_columns(design, std::vector<double>(design.rows, 1.0),
                                            std::vector<double>(design.columns, 1.0), preference, greatest_condition);
  const auto observable = [&](std::size_t column) {
    return std::ranges::find(dropped, column, &Dropped::column) == dropped.end();
  };
  Level level{observable(0), observable(1), {}};
  for (std::size_t s = 0; s < signals.size(); ++s) {
    const Channel channel = signals[s]->channel;
    if (observable(2 + s))
      level.biases.push_back(bias_of(channel));
    else if (!instrument.bias_known[channel])
      findings.push_back({Finding::Severity::warning, "bias_taken_as_zero", {}, role_of(channel)});
  }
  return level;
}

bool drift_wanted(const Bench& bench, const Shown& shown) {
  const auto& word = bench.plan->settings.word("drift");
  if (word == "no") return false;
  if (word == "yes" && !shown.drift)
    throw Error(Error::Kind::bad_data,
                "[settings] drift = \"yes\", but this order of the index angles cannot distinguish a drift from the "
                "azimuth: visit the positions forwards and back");
  return shown.drift && (word == "yes" || bench.signals.front().positions.size() >= least_positions_for_drift);
}

void refuse_unshown(const Bench& bench, const Instrument& instrument, const Shown& shown) {
  Problems problems;
  const auto& signal = bench.signals.front();
  if (shown.none)
    problems.push_back(
        say("all {} use the same index angle: they cannot distinguish the Earth's rate from the bias; "
            "turn the table to angles 90 or 180 deg apart",
            signal.positions.size() == 1 ? "samples" : "positions"));
  else if (!shown.both && !instrument.scale_known[gyro])
    problems.push_back(
        "index angles 180 deg apart alone give the azimuth from the size of the rate, which needs the gyro's scale "
        "factor: [settings] gyro_scale_factor or a calibration; or add positions at 90 deg to these");
  for (const Channel channel : {accelerometer_x, accelerometer_y})
    if (bench.records[channel].present && !instrument.scale_known[channel])
      problems.push_back(
          say("the output of {} is in {}: [settings] accelerometer_scale_factor or a calibration "
              "must say its scale factor",
              tumble::Name{role_of(channel)}, tumble::Name{bench.records[channel].unit.text()}));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

void choose_free(const Bench& bench, const Instrument& instrument, Setup& setup) {
  const Level level = level_of(bench, instrument, setup.findings);
  setup.free = {azimuth};
  if (level.pitch) setup.free.push_back(pitch);
  if (level.roll) setup.free.push_back(roll);
  setup.free.push_back(gyro_bias);
  if (setup.drift) setup.free.push_back(gyro_drift);
  if (!instrument.scale_known[gyro]) setup.free.push_back(gyro_scale);
  double low = INFINITY, high = -INFINITY;
  for (const auto& position : bench.signals.front().positions) {
    low = std::min(low, position.rate);
    high = std::max(high, position.rate);
  }
  if (high - low > turning_apart) setup.free.push_back(gyro_z);
  setup.free.insert(setup.free.end(), level.biases.begin(), level.biases.end());
}

/// Tilt of the rig as the plan has it.
void start_from_rig(const Bench& bench, Setup& setup) {
  const Rotation& base = bench.index.base_from_level;
  const Vector3 up = base * Vector3{0.0, 0.0, 1.0};
  setup.start[pitch] = std::asin(std::clamp(up.x, -1.0, 1.0));
  setup.start[roll] = std::atan2(up.y, up.z);
  setup.start[azimuth] = std::atan2(base.x.x, base.x.y);
}

/// Tilt from the accelerometers, their biases.
void start_tilt(const Bench& bench, Setup& setup) {
  double x = 0.0, y = 0.0, count = 0.0;
  for (const auto& signal : bench.signals) {
    if (signal.channel == gyro) continue;
    const Shown shown = shown_by(signal);
    const double unit = setup.start[scale_of(signal.channel)] * setup.start[gravity_here];
    if (!shown.both) continue;
    const auto tilt = harmonics_of(signal, outputs_of(signal), shown, false);
    x += tilt.x / unit;
    y += tilt.y / unit;
    count += 1.0;
  }
  if (count == 0.0) return;
  x /= count;
  y /= count;
  if (const double square = x * x + y * y; square > greatest_tilt)
    throw Error(Error::Kind::bad_data,
                say("the accelerometers show a tilt of {:.3g} g: their scale factor or unit (g or m/s^2) is "
                    "wrong, or their axes are not level",
                    std::sqrt(square)));
  setup.start[pitch] = std::asin(x);
  setup.start[roll] = std::atan2(y, std::sqrt(1.0 - x * x - y * y));
}

void start_azimuth(const Bench& bench, const Instrument& instrument, Setup& setup) {
  const Signal& signal = bench.signals.front();
  const auto rates = harmonics_of(signal, outputs_of(signal), setup.shown, setup.drift);
  const Vector3 up = directions_of(0.0, setup.start[pitch], setup.start[roll]).up;
  const double horizontal = earth_rate * std::cos(setup.start[latitude]);
  State& s = setup.start;
  if (setup.shown.both && !instrument.scale_known[gyro]) {
    const double size = std::hypot(rates.x, rates.y);
    if (!(size > 0.0)) throw Error(Error::Kind::bad_data, "the gyro shows no rate that changes with the index angle");
    s[gyro_scale] = size / horizontal;
  }
  const double k = s[gyro_scale];
  if (setup.shown.both) {
    s[azimuth] = exact_azimuth(rates.x / k, rates.y / k, up.x, up.y, s[latitude]) + s[gyro_y];
  } else {
    // (2.11): the rate along the one direction, less what tilt gives of the vertical rate
    const double tilt = std::cos(setup.shown.along) * up.x + std::sin(setup.shown.along) * up.y;
    const double c = (rates.x / k - earth_rate * std::sin(s[latitude]) * tilt) / horizontal;
    const double off = std::acos(std::clamp(c, -1.0, 1.0));
    double near = setup.shown.along + off, other = setup.shown.along - off;
    const auto& settings = bench.plan->settings;
    const auto apart = [&](double a) {
      return settings.has("azimuth_about") ? std::abs(std::remainder(a - settings.number("azimuth_about"), two_pi))
                                           : std::abs(std::remainder(a, two_pi));
    };
    if (apart(other) < apart(near)) std::swap(near, other);
    s[azimuth] = near;
    setup.other_azimuth = other;
  }
  s[gyro_bias] = rates.offset / k;
}

Setup begin(const Bench& bench, const Instrument& instrument) {
  Setup setup;
  setup.start = instrument.state;
  setup.shown = shown_by(bench.signals.front());
  refuse_unshown(bench, instrument, setup.shown);
  setup.drift = drift_wanted(bench, setup.shown);
  choose_free(bench, instrument, setup);
  start_from_rig(bench, setup);
  return setup;
}

}  // namespace

Setup set_up(const Bench& bench, const Instrument& instrument) {
  Setup setup = begin(bench, instrument);
  if (contains(setup.free, pitch) && contains(setup.free, roll)) start_tilt(bench, setup);
  start_azimuth(bench, instrument, setup);
  return setup;
}

Setup set_up_prediction(const Bench& bench, const Instrument& instrument) { return begin(bench, instrument); }

}  // namespace tumble::north_finding
