#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

#include "tumble/rigs/chain/carrier.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rigs::thermal_chamber {
namespace {

using namespace chain;

using Kind = Motion::Kind;

std::vector<Axis> axes() {
  return {{"chamber", "degC", {Kind::hold, Kind::dwell, Kind::ramp}, "set point of the air temperature"}};
}

std::vector<Option> options() {
  return {quantity("lowest", "degC").above(-273.15).otherwise("-60 degC").says("coldest set point"),
          quantity("highest", "degC").above(-273.15).otherwise("90 degC").says("hottest set point"),
          quantity("ramp_limit", "K/min").above(0).otherwise("5 K/min").says("fastest change of the air"),
          quantity("stability_sd", "K")
              .at_least(0)
              .otherwise("0.1 K")
              .says("standard deviation of the air about its set point, correlated over 20 min"),
          quantity("top_time", "min")
              .above(0)
              .otherwise("10 min")
              .says("time constant with which the top of the instrument follows the air"),
          quantity("side_time", "min")
              .above(0)
              .otherwise("14 min")
              .says("time constant with which its side follows the air"),
          quantity("top_self_heating", "K")
              .otherwise("4 K")
              .says("final rise of the top above the air by the instrument's own power"),
          quantity("side_self_heating", "K").otherwise("3 K").says("final rise of the side"),
          quantity("draught_sd", "K")
              .at_least(0)
              .otherwise("0.5 K")
              .says("standard deviation of the air's difference between top and side"),
          quantity("draught_time", "min").above(0).otherwise("15 min").says("correlation time of this difference"),
          quantity("sensor_lag", "s").at_least(0).otherwise("0 s").says("first-order lag of the sensors"),
          quantity("sensor_noise", "K").at_least(0).otherwise("0.02 K").says("standard deviation of one reading"),
          quantity("sensor_quantum", "K").at_least(0).otherwise("0.0625 K").says("step of the readings; 0: none")};
}

Problems refusals(const Schedule& schedule, const Settings& options) {
  Problems problems;
  check_order(options, "lowest", "highest", problems);
  const double lowest = options.number("lowest"), highest = options.number("highest");
  const Unit celsius = Unit::parse("degC"), ramp_unit = Unit::parse("K/min");
  const auto check_temperature = [&](const Segment& segment, double temperature) {
    if (temperature < lowest || temperature > highest)
      problems.push_back(within(place_of_segment(segment.label),
                                say("{:.6g} degC is outside of the chamber's {:.6g} to {:.6g} degC",
                                    celsius.from_si(temperature), celsius.from_si(lowest), celsius.from_si(highest))));
  };
  int run = 0;
  for (const auto& segment : schedule) {
    const auto found = segment.axes.find("chamber");
    const bool first = segment.run != run;
    run = segment.run;
    if (found == segment.axes.end()) {
      if (first)
        problems.push_back(say("segment '{}' begins run {} without a chamber temperature", segment.label, run));
      continue;
    }
    const Motion& motion = found->second;
    if (motion.kind == Kind::ramp) {
      check_temperature(segment, motion.to);
      if (first)
        problems.push_back(
            say("segment '{}' begins run {} with a ramp: dwell at the start temperature first", segment.label, run));
      if (motion.value > options.number("ramp_limit") * (1 + 1e-12))
        problems.push_back(
            within(place_of_segment(segment.label),
                   say("{:.6g} K/min is more than the chamber's ramp_limit of {:.6g} K/min",
                       ramp_unit.from_si(motion.value), ramp_unit.from_si(options.number("ramp_limit")))));
    } else {
      check_temperature(segment, motion.value);
    }
  }
  return problems;
}

/// Temperature of the air at the samples of one run [K]: it goes to each set point at the ramp's rate, or as fast as
/// the chamber can.
std::vector<double> set_points(const Schedule& run, double ramp_limit, double rate) {
  std::vector<double> air;
  double target = run.front().axes.at("chamber").value, now = target, end = 0.0;
  double step = 0.0;
  for (const auto& segment : run) {
    end += segment.duration;
    const auto samples = static_cast<std::size_t>(std::llround(end * rate));
    const auto found = segment.axes.find("chamber");
    if (found != segment.axes.end()) {
      const bool ramp = found->second.kind == Kind::ramp;
      target = ramp ? found->second.to : found->second.value;
      step = (ramp ? found->second.value : ramp_limit) / rate;
    }
    while (air.size() < samples) {
      air.push_back(now);
      now += std::clamp(target - now, -step, step);
    }
  }
  return air;
}

/// Stationary first-order Gauss-Markov process.
std::vector<double> markov(std::size_t count, double sd, double time, double rate, const RandomStream& random) {
  std::vector<double> x(count);
  random.normal(0, x);
  const double phi = std::exp(-1.0 / (time * rate)), drive = std::sqrt(1.0 - phi * phi);
  double state = count ? x[0] : 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    if (k) state = phi * state + drive * x[k];
    x[k] = sd * state;
  }
  return x;
}

/// First-order lag driven by an input that runs straight from sample to sample: exact at the samples.
class Lag {
 public:
  Lag(double time, double step)
      : keep_(std::exp(-step / time)), now_(1.0 - time / step * (1.0 - keep_)), before_(1.0 - keep_ - now_) {}
  double next(double state, double input_before, double input_now) const {
    return keep_ * state + before_ * input_before + now_ * input_now;
  }

 private:
  double keep_, now_, before_;
};

/// Temperature and its rate at one spot of the instrument: it follows the air with a first-order lag and warms itself
/// after power-on.
struct Spot {
  std::vector<double> temperature, rate;
};

Spot follow(const std::vector<double>& air, double soaked, double time, double self_heating, double sample_rate) {
  Spot spot{std::vector<double>(air.size()), std::vector<double>(air.size())};
  const Lag lag(time, 1.0 / sample_rate);
  double now = soaked;
  for (std::size_t k = 0; k < air.size(); ++k) {
    if (k) now = lag.next(now, air[k - 1] + self_heating, air[k] + self_heating);
    spot.temperature[k] = now;
    spot.rate[k] = (air[k] + self_heating - now) / time;
  }
  return spot;
}

/// What a sensor at a spot shows: lag, noise, quantum.
Channel sensor(const std::string& name, const std::vector<double>& spot, double begin, double rate,
               const Settings& options, const RandomStream& random) {
  Channel channel{name, QuantityKind::temperature, Unit::parse("degC"), {begin, rate, nullptr}, {}};
  channel.values.resize(spot.size());
  random.normal(0, channel.values);
  const double lag = options.number("sensor_lag"), noise = options.number("sensor_noise"),
               quantum = options.number("sensor_quantum");
  const Lag behind(std::max(lag, 1e-9), 1.0 / rate);
  double shown = spot.empty() ? 0.0 : spot.front();
  for (std::size_t k = 0; k < spot.size(); ++k) {
    shown = lag > 0.0 && k > 0 ? behind.next(shown, spot[k - 1], spot[k]) : spot[k];
    double reading = channel.unit.from_si(shown + noise * channel.values[k]);
    if (quantum > 0.0) reading = std::round(reading / quantum) * quantum;
    channel.values[k] = channel.unit.to_si(reading);
  }
  return channel;
}

/// One power-up, sample by sample.
struct History {
  double rate;
  std::vector<Felt> felt;
  Channel top, side;
  std::vector<double> air, set_point;  ///< [K]
};

History history_of(const RigRun& run) {
  const Settings& options = run.options;
  const auto set_point = set_points(run.segments, options.number("ramp_limit"), run.rate);
  const std::size_t count = set_point.size();
  const auto unrest =
      markov(count, options.number("stability_sd"), 1200.0, run.rate, run.random.split("chamber stability"));
  const auto draught = markov(count, options.number("draught_sd"), options.number("draught_time"), run.rate,
                              run.random.split("draught"));
  std::vector<double> at_top(count), at_side(count);
  for (std::size_t k = 0; k < count; ++k) {
    at_top[k] = set_point[k] + unrest[k] + 0.5 * draught[k];
    at_side[k] = set_point[k] + unrest[k] - 0.5 * draught[k];
  }
  const double soaked = count ? set_point[0] : 0.0;
  const Spot top = follow(at_top, soaked, options.number("top_time"), options.number("top_self_heating"), run.rate);
  const Spot side = follow(at_side, soaked, options.number("side_time"), options.number("side_self_heating"), run.rate);
  History out{run.rate, std::vector<Felt>(count), {}, {}};
  const Kinematics ground = ground_of(run.site, 0.0, 0.0);  // x east, y north, z up
  for (std::size_t k = 0; k < count; ++k) {
    Felt& felt = out.felt[k];
    felt.rate = ground.rate;
    felt.specific_force = ground.specific_force;
    felt.temperature = 0.5 * (top.temperature[k] + side.temperature[k]);
    felt.temperature_gradient = top.temperature[k] - side.temperature[k];
    felt.temperature_rate = 0.5 * (top.rate[k] + side.rate[k]);
    felt.since_power_on = static_cast<double>(k) / run.rate;
  }
  // The start temperature is the mean over the first two minutes.
  const auto window = std::min(count, static_cast<std::size_t>(std::llround(120.0 * run.rate)));
  double start = 0.0;
  for (std::size_t k = 0; k < window; ++k) start += out.felt[k].temperature / static_cast<double>(window);
  for (auto& felt : out.felt) felt.start_temperature = start;
  out.top = sensor("temperature_top", top.temperature, 0.0, run.rate, options, run.random.split("top sensor"));
  out.side = sensor("temperature_side", side.temperature, 0.0, run.rate, options, run.random.split("side sensor"));
  out.air = set_point;
  for (std::size_t k = 0; k < count; ++k) out.air[k] += unrest[k];
  out.set_point = set_point;
  return out;
}

/// Values of a history at first, first + step, ...: those of the interval that each instant lies in.
template <class Value>
void look_up(const std::vector<Value>& history, double rate, double first, double step, std::span<Value> out) {
  for (std::size_t k = 0; k < out.size(); ++k) {
    const double at = std::floor((first + static_cast<double>(k) * step) * rate);
    out[k] = history[std::min(history.size() - 1, static_cast<std::size_t>(std::max(0.0, at)))];
  }
}

/// The temperature that the chamber goes to, as a function of time [s].
std::function<double(double)> target_of(const Schedule& run) {
  std::vector<double> targets;
  double target = 0.0;
  for (const auto& segment : run) {
    if (const auto found = segment.axes.find("chamber"); found != segment.axes.end())
      target = found->second.kind == Kind::ramp ? found->second.to : found->second.value;
    targets.push_back(target);
  }
  return [targets, at = segment_at(run)](double time) { return targets[at(time)]; };
}

/// What the controller of the chamber knows: its air.
Drive chamber_of(const std::shared_ptr<const History>& history, const RigRun& run) {
  return {"chamber", [history, target = target_of(run.segments)](double time) {
            double now = 0.0, air = 0.0;
            look_up(history->set_point, history->rate, time, 0.0, std::span(&now, 1));
            look_up(history->air, history->rate, time, 0.0, std::span(&air, 1));
            double before = now;
            look_up(history->set_point, history->rate, time - 1.0 / history->rate, 0.0, std::span(&before, 1));
            return DriveState{air, (now - before) * history->rate, now == target(time)};
          }};
}

Reference reference(const RigRun& run) {
  const auto history = std::make_shared<const History>(history_of(run));
  const auto reader = [history](const Channel& channel) {
    Channel header{channel.name, channel.kind, channel.unit, channel.timeline, {}};
    return Sensor{header, [history, &channel](double first, double step, std::span<double> out) {
                    look_up(channel.values, history->rate, first, step, out);
                  }};
  };
  Reference out;
  out.felt = [history](double first, double step, std::span<Felt> felt) {
    look_up(history->felt, history->rate, first, step, felt);
  };
  out.steady_until = [](double time) { return time; };
  for (double end = 0.0; const auto& segment : run.segments) {
    out.settled.push_back(end);
    end += segment.duration;
  }
  out.sensors = {reader(history->top), reader(history->side)};
  out.drives = {chamber_of(history, run)};
  out.parts = {{"instrument", {}, false, [](double) { return PartPlacement{}; }}};
  return out;
}

}  // namespace

extern const Rig thermal_chamber{
    .name = "thermal_chamber",
    .summary = "thermal chamber: set points, ramps and dwells; the instrument follows at its top and side",
    .axes = axes,
    .options = options,
    .errors = [](const Settings&, const std::optional<Site>&) { return std::vector<RigError>{}; },
    .reference = reference,
    .refusals = refusals};

}  // namespace tumble::rigs::thermal_chamber
