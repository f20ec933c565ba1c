#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "tumble/math/shaped_noise.hpp"
#include "tumble/rigs/chain/carrier.hpp"
#include "tumble/rigs/chain/encoder.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::rigs::shaker {
namespace {

using namespace chain;

using Kind = Motion::Kind;

constexpr double slack = 1.0 + 1e-12;  ///< a limit is not exceeded by a rounding of the units

std::vector<Imperfection> imperfections() {
  return joined({base_imperfections(),
                 mount_imperfections(),
                 {{quantity("amplitude_sd", "%")
                       .at_least(0)
                       .otherwise("1 %")
                       .says("relative error of the commanded acceleration"),
                   {error_names::shake_amplitude}},
                  {quantity("cross_motion_sd", "%")
                       .at_least(0)
                       .otherwise("2 %")
                       .says("ratio of the motion across the shake to the shake, in each direction"),
                   {error_names::cross_motion_y, error_names::cross_motion_z}},
                  {quantity("distortion_sd", "%")
                       .at_least(0)
                       .otherwise("1 %")
                       .says("ratio of the second and third harmonic to the fundamental"),
                   {error_names::second_harmonic, error_names::third_harmonic}},
                  {quantity("reference_gain_sd", "%")
                       .at_least(0)
                       .otherwise("0.5 %")
                       .says("relative error of the reference accelerometer's gain"),
                   {error_names::reference_gain}}}});
}

std::vector<Axis> axes() {
  std::vector<Axis> axes = mount_axes();
  axes.insert(axes.begin(), {"shake",
                             "m/s^2",
                             {Kind::hold, Kind::sine, Kind::sweep, Kind::random},
                             "acceleration along the fixture's x axis; hold only at 0"});
  return axes;
}

std::vector<Option> options() {
  std::vector<Option> options{
      quantity("shake_elevation", "deg").otherwise("90 deg").says("elevation of the shake; 90 deg: upwards"),
      quantity("shake_azimuth", "deg").otherwise("90 deg").says("azimuth of the shake, from north to the east"),
      quantity("max_acceleration", "g")
          .above(0)
          .otherwise("100 g")
          .says("greatest peak; of random vibration, 3 standard deviations"),
      quantity("max_rms", "g").above(0).otherwise("40 g").says("greatest standard deviation of random vibration"),
      quantity("max_velocity", "m/s")
          .above(0)
          .otherwise("2 m/s")
          .says("greatest peak; of random vibration, 3 standard deviations"),
      quantity("stroke", "mm")
          .above(0)
          .otherwise("50 mm")
          .says("greatest displacement from peak to peak; of random vibration, 6 standard deviations"),
      quantity("lowest_frequency", "Hz").above(0).otherwise("5 Hz").says("lowest frequency of the shaker"),
      quantity("highest_frequency", "Hz").above(0).otherwise("3 kHz").says("highest frequency of the shaker"),
      quantity("reference_noise", "mg")
          .at_least(0)
          .otherwise("1 mg")
          .says("standard deviation of one reading of the reference accelerometer"),
      word("reference_output", {"instant", "mean"})
          .otherwise("instant")
          .says("a reading of the reference is the acceleration in the middle of a sample, or the mean over it")};
  for (auto& option : laboratory_options()) options.push_back(std::move(option));
  for (const auto& imperfection : imperfections()) options.push_back(imperfection.option);
  return options;
}

std::vector<RigError> errors(const Settings& options, const std::optional<Site>& site) {
  return errors_of(imperfections(), options, site);
}

/// What a vibration needs of the shaker.
struct Demand {
  double acceleration, velocity, stroke;  ///< peaks, and peak to peak
  double lowest, highest;                 ///< [Hz]
};

/// The density of the n-th integral.
SpectralDensity integrated(SpectralDensity psd, int n) {
  for (std::size_t i = 0; i < psd.frequency.size(); ++i) psd.density[i] /= std::pow(two_pi * psd.frequency[i], 2 * n);
  return psd;
}

Demand demand_of(const Motion& motion) {
  if (motion.kind == Kind::random) {
    const SpectralDensity psd{motion.psd_frequency, motion.psd};
    return {3.0 * std::sqrt(variance(psd)), 3.0 * std::sqrt(variance(integrated(psd, 1))),
            6.0 * std::sqrt(variance(integrated(psd, 2))), psd.frequency.front(), psd.frequency.back()};
  }
  const bool sweep = motion.kind == Kind::sweep;
  const double low = sweep ? std::min(motion.frequency, motion.to_frequency) : motion.frequency,
               high = sweep ? std::max(motion.frequency, motion.to_frequency) : motion.frequency;
  const double a = std::abs(motion.amplitude), w = two_pi * low;
  return {a, a / w, 2.0 * a / (w * w), low, high};
}

bool spectrum_is_sound(const Motion& motion) {
  const auto& f = motion.psd_frequency;
  return f.size() >= 2 && f.size() == motion.psd.size() && f.front() > 0.0 && std::isfinite(f.back()) &&
         std::adjacent_find(f.begin(), f.end(), std::greater_equal<>()) == f.end() &&
         std::all_of(motion.psd.begin(), motion.psd.end(), [](double s) { return s > 0.0 && std::isfinite(s); });
}

/// What one segment asks beyond the shaker.
void check(const Segment& segment, const Motion& motion, const Settings& options, Problems& problems) {
  const auto refuse = [&](const Sentence& text) { problems.push_back(within(place_of_segment(segment.label), text)); };
  if (motion.kind == Kind::hold) {
    if (motion.value != 0.0) refuse("shake cannot hold an acceleration: only 0, at rest");
    return;
  }
  if (motion.kind == Kind::random && !spectrum_is_sound(motion))
    return refuse("shake needs two or more frequencies that rise, and as many densities above zero");
  if (motion.kind != Kind::random &&
      !(motion.frequency > 0.0 && (motion.kind == Kind::sine || motion.to_frequency > 0.0)))
    return refuse("shake needs frequencies above zero");
  const Demand needed = demand_of(motion);
  const auto limit = [&](const char* option, const char* unit, double value, const char* what) {
    if (value <= options.number(option) * slack) return;
    const Unit shown = Unit::parse(unit);
    refuse(say("{} {:.4g} {} is more than the shaker's {} of {:.4g} {}", what, shown.from_si(value), Name{unit},
               Name{option}, shown.from_si(options.number(option)), Name{unit}));
  };
  limit("max_acceleration", "g", needed.acceleration, "an acceleration of");
  if (motion.kind == Kind::random) limit("max_rms", "g", needed.acceleration / 3.0, "a standard deviation of");
  limit("max_velocity", "m/s", needed.velocity, "a velocity of");
  limit("stroke", "mm", needed.stroke, "a way of");
  const double lowest = options.number("lowest_frequency"), highest = options.number("highest_frequency");
  if (needed.lowest * slack < lowest || needed.highest > highest * slack)
    refuse(needed.lowest == needed.highest
               ? say("{:.4g} Hz is not within the shaker's {:.4g} to {:.4g} Hz", needed.lowest, lowest, highest)
               : say("{:.4g} to {:.4g} Hz are not within the shaker's {:.4g} to {:.4g} Hz", needed.lowest,
                     needed.highest, lowest, highest));
  if (motion.kind != Kind::random && 2.0 / motion.frequency > segment.duration)
    refuse(say("two periods of {:.4g} Hz, in which the shake fades in, are longer than the segment", motion.frequency));
}

Problems refusals(const Schedule& schedule, const Settings& options) {
  Problems problems;
  if (!check_axes(axes(), schedule, problems)) return problems;
  for (const auto& segment : schedule)
    if (const auto shake = segment.axes.find("shake"); shake != segment.axes.end())
      check(segment, shake->second, options, problems);
  return problems;
}

/// The shake of one segment, and of those that continue it.
struct Shaking {
  double begin, end;  ///< [s]
  Motion motion;      ///< hold: at rest
  std::shared_ptr<const ShapedNoise> random;
};

/// Everything about one run that its samples need.
struct Shaker {
  std::vector<Shaking> segments;
  double amplitude = 1.0;
  Vector3 direction;  ///< of the shake, x being 1
  double second = 0.0, third = 0.0;
  Chain chain;  ///< the fixture at rest
};

double oscillation(const Shaker& shaker, const Shaking& s, double time) {
  const double since = time - s.begin, f = s.motion.frequency;
  double cycles = f * since;
  if (s.motion.kind == Kind::sweep) {
    const double end = s.motion.lasts > 0.0 ? s.begin + s.motion.lasts : s.end;
    const double growth = std::log(s.motion.to_frequency / f) / (end - s.begin);
    if (growth != 0.0) cycles = f * std::expm1(growth * since) / growth;
  }
  const double psi = two_pi * cycles + s.motion.phase, fade = 0.5 * f * since;
  const double shape = std::sin(psi) + shaker.second * std::sin(2.0 * psi) + shaker.third * std::sin(3.0 * psi);
  return s.motion.amplitude * (fade < 1.0 ? smooth_step(fade, 1.0).angle : 1.0) * shape;
}

/// Acceleration along the shake at first, first + step, ...
void shake(const Shaker& shaker, double first, double step, std::span<double> out) {
  std::size_t segment = 0;
  for (std::size_t i = 0; i < out.size();) {
    const auto time = [&](std::size_t n) { return first + static_cast<double>(n) * step; };
    while (segment + 1 < shaker.segments.size() && shaker.segments[segment].end <= time(i)) ++segment;
    const Shaking& now = shaker.segments[segment];
    std::size_t end = i + 1;
    while (end < out.size() && time(end) < now.end) ++end;
    const auto part = out.subspan(i, end - i);
    if (now.motion.kind == Kind::hold || time(i) >= now.end)
      std::fill(part.begin(), part.end(), 0.0);
    else if (now.random)
      now.random->values(time(i) - now.begin, step, part);
    else
      for (std::size_t n = 0; n < part.size(); ++n) part[n] = oscillation(shaker, now, time(i + n));
    for (double& a : part) a *= shaker.amplitude;
    i = end;
  }
}

/// The fastest that a motion is [Hz]; with what the shaker adds to a sine.
double fastest(const Motion& motion) {
  if (motion.kind == Kind::random) return motion.psd_frequency.back();
  return motion.kind == Kind::hold ? 0.0 : 3.0 * std::max(motion.frequency, motion.to_frequency);
}

/// Means over windows of length `step` about first, first + step, ..., by Gauss' rule of two points on parts of a
/// quarter of the shortest period: for a sine of that period to 1e-4 of it.
void mean_shake(const Shaker& shaker, double first, double step, std::span<double> out) {
  double highest = 0.0;
  for (const auto& segment : shaker.segments) highest = std::max(highest, fastest(segment.motion));
  const auto parts = static_cast<std::size_t>(std::ceil(4.0 * highest * step) + 1.0);
  const double part = step / static_cast<double>(parts), off = 0.5 * part / std::sqrt(3.0);
  constexpr std::size_t together = 64;
  std::vector<double> a;
  for (std::size_t i = 0; i < out.size(); i += together) {
    const std::size_t windows = std::min(together, out.size() - i);
    const double begin = first + (static_cast<double>(i) - 0.5) * step;
    for (std::size_t w = 0; w < windows; ++w) out[i + w] = 0.0;
    a.resize(windows * parts);
    for (const double side : {-off, off}) {
      shake(shaker, begin + 0.5 * part + side, part, a);
      for (std::size_t k = 0; k < a.size(); ++k) out[i + k / parts] += 0.5 * a[k] / static_cast<double>(parts);
    }
  }
}

Shaker shaker_of(const RigRun& run) {
  const auto list = errors(run.options, run.site);
  const ErrorValues error(list, run.errors);
  Shaker shaker;
  for (const AxisCommand& command : commands_to(run.segments, "shake")) {
    Shaking one{command.begin, command.begin + command.duration, command.motion ? *command.motion : Motion{}, nullptr};
    if (one.motion.kind == Kind::random)
      one.random = std::make_shared<const ShapedNoise>(SpectralDensity{one.motion.psd_frequency, one.motion.psd},
                                                       run.random.split("random vibration").split(command.segment));
    shaker.segments.push_back(std::move(one));
  }
  shaker.amplitude = 1.0 + error(error_names::shake_amplitude);
  shaker.direction = {1.0, error(error_names::cross_motion_y), error(error_names::cross_motion_z)};
  shaker.second = error(error_names::second_harmonic);
  shaker.third = error(error_names::third_harmonic);
  const Rotation fixture =
      about_y(-run.options.number("shake_elevation")) * about_z(two_pi / 4.0 - run.options.number("shake_azimuth"));
  shaker.chain.base = fixture * base_from_level(error);
  shaker.chain.ground =
      seen_in(shaker.chain.base, ground_of(run.site, error(error_names::gravity), error(error_names::latitude)));
  shaker.chain.poses = poses_of(run.segments, error);
  shaker.chain.temperature = run.options.number("temperature");
  return shaker;
}

double until(const Shaker& shaker, double time) {
  double until = steady_until(shaker.chain, time);
  for (const auto& segment : shaker.segments)
    if (segment.end > time && segment.motion.kind != Kind::hold) until = std::min(until, std::max(time, segment.begin));
  return until;
}

void felt_on(const Shaker& shaker, double first, double step, std::span<Felt> out) {
  std::array<double, 512> a;
  const auto& poses = shaker.chain.poses;
  std::size_t pose = 0;
  Felt rest;
  Vector3 direction;
  const auto take_pose = [&] {
    felt(shaker.chain, std::max(first, poses[pose].begin), step, std::span(&rest, 1));
    direction = poses[pose].instrument_from_fixture * shaker.direction;
  };
  take_pose();
  for (std::size_t done = 0; done < out.size();) {
    const auto part = std::span(a).first(std::min(a.size(), out.size() - done));
    shake(shaker, first + static_cast<double>(done) * step, step, part);
    for (std::size_t i = 0; i < part.size(); ++i) {
      const double time = first + static_cast<double>(done + i) * step;
      while (pose + 1 < poses.size() && poses[pose + 1].begin <= time) {
        ++pose;
        take_pose();
      }
      Felt& felt = out[done + i];
      felt = rest;
      felt.since_power_on = time;
      felt.specific_force = rest.specific_force + part[i] * direction;
    }
    done += part.size();
  }
}

const Shaking& shaking_at(const Shaker& shaker, double time) {
  const auto after = std::upper_bound(shaker.segments.begin(), shaker.segments.end(), time,
                                      [](double t, const Shaking& shaking) { return t < shaking.begin; });
  return after == shaker.segments.begin() ? shaker.segments.front() : *(after - 1);
}

/// When a sine or a sweep has its full amplitude [s].
double faded_in(const Shaking& shaking) {
  const bool fades = shaking.motion.kind == Kind::sine || shaking.motion.kind == Kind::sweep;
  return fades ? std::min(shaking.end, shaking.begin + 2.0 / shaking.motion.frequency) : shaking.begin;
}

/// When each segment has its motion [s].
std::vector<double> settled_of(const RigRun& run, const Shaker& shaker) {
  std::vector<double> settled;
  double begin = 0.0;
  for (const auto& segment : run.segments) {
    const Shaking& shaking = shaking_at(shaker, begin);
    const double end = begin + segment.duration;
    settled.push_back(std::clamp(faded_in(shaking), begin, end));
    begin = end;
  }
  return settled;
}

/// The reference accelerometer of the shaker.
Sensor accelerometer_of(const RigRun& run, std::shared_ptr<const Shaker> shaker) {
  const auto list = errors(run.options, run.site);
  const double gain = 1.0 + ErrorValues(list, run.errors)(error_names::reference_gain);
  const double noise = run.options.flag("ideal") ? 0.0 : run.options.number("reference_noise");
  Sensor sensor{{"reference", QuantityKind::specific_force, Unit::parse("g"), {0.0, run.rate, nullptr}, {}}, nullptr};
  const bool mean = run.options.word("reference_output") == "mean";
  sensor.read = [=, rate = run.rate, random = run.random.split("reference")](double first, double step,
                                                                             std::span<double> readings) {
    if (mean)
      mean_shake(*shaker, first, step, readings);
    else
      shake(*shaker, first, step, readings);
    for (double& reading : readings) reading *= gain;
    add_reading_noise(noise, rate, random, first, step, readings);
  };
  return sensor;
}

Reference reference(const RigRun& run) {
  const auto shaker = std::make_shared<const Shaker>(shaker_of(run));
  Reference out;
  out.felt = [shaker](double first, double step, std::span<Felt> samples) { felt_on(*shaker, first, step, samples); };
  out.steady_until = [shaker](double time) { return until(*shaker, time); };
  out.settled = settled_of(run, *shaker);
  out.drives.push_back({"shake", [shaker](double time) {
                          const Shaking& shaking = shaking_at(*shaker, time);
                          const bool still = shaking.motion.kind == Kind::hold || time >= shaking.end;
                          return DriveState{still ? 0.0 : shaking.motion.amplitude, 0.0, time >= faded_in(shaking)};
                        }});
  for (const auto& axis : mount_axes())
    out.drives.push_back({axis.name, [last = last_value(run.segments, axis.name)](double time) {
                            return DriveState{last(time), 0.0, true};
                          }});
  out.parts = {{"shake",
                {1.0, 0.0, 0.0},
                true,
                [shaker](double) {
                  return PartPlacement{shaker->chain.base, {}};
                }},
               {"instrument", {}, false, [shaker](double time) { return instrument_at(shaker->chain, time); }}};
  out.sensors.push_back(accelerometer_of(run, shaker));
  return out;
}

}  // namespace

extern const Rig shaker{.name = "shaker",
                        .summary = "electrodynamic shaker: sine, sweep, random vibration from a power spectral density",
                        .axes = axes,
                        .options = options,
                        .errors = errors,
                        .reference = reference,
                        .refusals = refusals};

}  // namespace tumble::rigs::shaker
