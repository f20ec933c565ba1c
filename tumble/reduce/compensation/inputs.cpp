#include "tumble/reduce/compensation/inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <set>
#include <utility>

#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/core/roles.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/compensate.hpp"
#include "tumble/reduce/compensation/outputs.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/reduce/thermal/thermal.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/units/error.hpp"

namespace tumble::compensation {
namespace {

constexpr auto index(Input input) { return static_cast<std::size_t>(input); }
constexpr std::size_t acceleration = index(Input::angular_acceleration_x), force = index(Input::specific_force_x),
                      temperature = index(Input::temperature), since_power_on = index(Input::since_power_on);

bool is_acceleration(std::size_t slot) { return slot >= acceleration && slot < force; }

const Channel* alone_after_dot(const Recording& recording, const std::string& name) {
  const Channel* match = nullptr;
  for (const Channel& channel : recording.channels) {
    if (!channel.name.ends_with("." + name)) continue;
    if (match) return nullptr;
    match = &channel;
  }
  return match;
}

QuantityKind kind_of_input(Input input) {
  if (index(input) < acceleration) return QuantityKind::angular_rate;
  if (index(input) >= force && index(input) < temperature) return QuantityKind::specific_force;
  if (input == Input::angle) return QuantityKind::angle;
  return input == Input::temperature ? QuantityKind::temperature : QuantityKind::other;
}

/// The channel that measures an input. Null where there is none, or what is so called is of another kind.
const Channel* channel_of(const Estimate& estimate, const Recording& recording, const Channel& output,
                          const Slot& slot) {
  const bool other = slot.input == Input::channel;
  const std::string role = other ? slot.role : name(slot.input);
  std::vector<std::string> names{role};
  if (const auto given = estimate.provenance.settings.find("channels." + role);
      given != estimate.provenance.settings.end())
    names.insert(names.begin(), given->second);
  const auto play = [&](const std::string& sensor) {
    for (auto& one : names_of_role(sensor + role.substr(role.size() - 1))) names.push_back(std::move(one));
  };
  if (index(slot.input) < acceleration) play("gyro_");
  if (index(slot.input) >= force && index(slot.input) < temperature) play("accelerometer_");
  for (const auto& one : names) {
    const Channel* channel = find_channel(recording, one);
    if (!channel) channel = alone_after_dot(recording, one);
    if (channel && channel != &output && (other || channel->kind == kind_of_input(slot.input))) return channel;
  }
  return nullptr;
}

}  // namespace

double value_at(const Channel& channel, double time) {
  if (channel.values.empty()) return std::nan("");
  const std::size_t i = index_at(channel, time);
  if (i >= channel.values.size()) return channel.values.back();
  const double after = channel.time(i);
  if (after == time || i == 0) return channel.values[i];
  const double before = channel.time(i - 1), share = (time - before) / (after - before);
  return (1.0 - share) * channel.values[i - 1] + share * channel.values[i];
}

double slope_at(const Channel& channel, double time) {
  const std::size_t n = channel.values.size();
  if (n < 2) return std::nan("");
  const std::size_t i = std::min(index_at(channel, time), n - 1);
  const std::size_t a = i == 0 ? 0 : i - 1, b = std::min(i + 1, n - 1);
  return (channel.values[b] - channel.values[a]) / (channel.time(b) - channel.time(a));
}

namespace {

constexpr double forever = std::numeric_limits<double>::infinity();

/// From when on which part of the schedule was carried out.
struct Stage {
  double by_clock = 0.0;            ///< [s, recording's clock]
  double since = 0.0;               ///< [s since power-on] of the same instant
  double until = forever;           ///< [s since power-on] where the next segment begins that has a mark of its own
  const Reference* felt = nullptr;  ///< of the power-up; null: the schedule does not say what was done
};

/// The conducted test of a recording, by its plan.
struct Planned {
  std::vector<PowerUp> power_ups;
  std::vector<Stage> stages;  ///< by time
};

/// Power-up of a segment of the schedule, and its number in it.
std::pair<std::size_t, std::size_t> place_in(const std::vector<PowerUp>& power_ups, std::size_t index) {
  std::size_t r = 0;
  for (; index >= power_ups[r].rig.segments.size(); ++r) index -= power_ups[r].rig.segments.size();
  return {r, index};
}

void require_schedule(const Plan& plan) {
  Problems problems;
  if (plan.rig_kind.empty()) problems.emplace_back("the plan needs [rig] kind = \"...\" that says what was felt");
  if (plan.schedule.empty()) problems.emplace_back("the plan needs at least one [[schedule]]");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

/// Without marks the schedule begins with the data, and one power-up follows the other.
std::vector<Stage> unmarked(const std::vector<PowerUp>& power_ups, const Channel& output) {
  std::vector<Stage> stages;
  double begin = output.values.empty() ? 0.0 : output.time(0);
  for (const auto& power_up : power_ups) {
    stages.push_back({.by_clock = begin, .felt = &power_up.reference});
    begin += power_up.begins.back();
  }
  return stages;
}

/// Each mark begins the segment of its label, as marked_segments() places it.
std::vector<Stage> marked(const Plan& plan, const std::vector<PowerUp>& power_ups, const Recording& recording) {
  Recording marks;
  marks.marks = recording.marks;
  std::vector<Stage> stages;
  const Evidence evidence{plan, {std::move(marks)}};
  const auto of_recordings = marked_segments(evidence);
  std::set<std::size_t> begun;
  for (const auto& mark : of_recordings.front())
    if (mark.planned != nullptr) begun.insert(mark.index);
  for (const auto& mark : of_recordings.front()) {
    Stage stage{.by_clock = mark.begin};
    if (mark.planned != nullptr) {
      const auto [r, segment] = place_in(power_ups, mark.index);
      stage.since = power_ups[r].begins[segment];
      if (begun.contains(mark.index + 1)) stage.until = power_ups[r].begins[segment + 1];
      stage.felt = &power_ups[r].reference;
    }
    stages.push_back(stage);
  }
  if (std::ranges::none_of(stages, [](const Stage& stage) { return stage.felt != nullptr; }))
    throw Error(Error::Kind::bad_data, "the recording holds no segment of the plan's schedule");
  return stages;
}

Planned planned_for(const Plan& plan, const Recording& recording, const Channel& output) {
  require_schedule(plan);
  Planned out{power_ups_of(plan, sampling_rate(output)), {}};
  out.stages = recording.marks.empty() ? unmarked(out.power_ups, output) : marked(plan, out.power_ups, recording);
  return out;
}

/// No input is known: the sample cannot be compensated.
Felt unknown() {
  std::array<double, felt_inputs> all;
  all.fill(std::nan(""));
  return std::bit_cast<Felt>(all);
}

/// A time that lies in the segment of the stage [s since power-on]: a segment that took longer than planned goes on as
/// it ended if nothing changed in it there, and else what was felt is not known (NaN). The instant of its end belongs
/// to the next segment.
double within(const Stage& stage, double time) {
  constexpr double before = 1e-6;  // [s] the begin of the next motion is rounded
  if (time < stage.until) return time;
  const double last = stage.until - before;
  const auto& steady_until = stage.felt->steady_until;
  return !steady_until || steady_until(last) > last + 0.5 * before ? last : std::nan("");
}

/// Input at one sample by the plan.
Felt felt_at(const std::vector<Stage>& stages, double time, double step) {
  const auto next = std::ranges::upper_bound(stages, time, {}, &Stage::by_clock);
  const Stage& stage = next == stages.begin() ? stages.front() : *std::prev(next);
  if (stage.felt == nullptr) return unknown();
  const double since = within(stage, std::max(0.0, stage.since + (time - stage.by_clock)) + 0.5 * step);
  if (std::isnan(since)) return unknown();
  Felt felt;
  stage.felt->felt(since, step, std::span(&felt, 1));
  return felt;
}

double power_on(const Recording& recording, const Channel& output, double time) {
  double begin = output.time(0);
  int run = 0;
  for (const Mark& mark : recording.marks)
    if (mark.run != run && mark.begin <= time) {
      run = mark.run;
      begin = mark.begin;
    }
  return begin;
}

/// Temperature, gradient and rate.
using Temperatures = std::array<double, 3>;

/// Their means over intervals [s] from power-on on.
std::vector<Temperatures> means_over(const thermal::Thermal& felt, double interval) {
  std::vector<Temperatures> means;
  std::size_t k = 0;
  while (k < felt.felt.size()) {
    const double end = interval * static_cast<double>(means.size() + 1);
    Temperatures& mean = means.emplace_back();
    double count = 0.0;
    for (; k < felt.felt.size() && felt.felt[k].since_power_on < end; ++k) {
      const Felt& now = felt.felt[k];
      if (std::isnan(now.temperature)) continue;
      mean[0] += now.temperature, mean[1] += now.temperature_gradient, mean[2] += now.temperature_rate;
      count += 1.0;
    }
    for (double& part : mean) part /= count;
  }
  return means;
}

/// Temperatures by the sensors that a thermal model was found with: those of one power-up at a time.
struct ThermalRuns {
  std::vector<Run> runs;
  thermal::Sensors sensors;
  ThermalReading reading;
  std::string from;
  std::size_t run = SIZE_MAX;  ///< whose temperatures these are
  thermal::Thermal felt = {};
  std::vector<Temperatures> means = {};  ///< empty: samples are compared

  void enter(double time) {
    std::size_t r = 0;
    while (r + 1 < runs.size() && time >= runs[r].end) ++r;
    if (r == run) return;
    run = r;
    felt = thermal::thermal_of(sensors, runs[r].begin, runs[r].end, reading);
    if (reading.averaging > 0.0) means = means_over(felt, reading.averaging);
  }

  void fill(double time, std::span<double> values) {
    enter(time);
    const auto now = std::bit_cast<std::array<double, felt_inputs>>(thermal::felt_at(felt, time));
    for (std::size_t k = temperature; k < felt_inputs; ++k) values[k] = now[k];
  }

  void average(double time, std::span<double> values) {
    enter(time);
    if (means.empty()) return;
    const auto at = static_cast<std::size_t>(std::max(0.0, values[since_power_on]) / reading.averaging);
    std::ranges::copy(means[std::min(at, means.size() - 1)], values.begin() + temperature);
  }
};

thermal::Sensors sensors_of(const Estimate& estimate, const Recording& recording) {
  const thermal::Sensors two{tumble::channel_of(estimate, recording, "temperature_top"),
                             tumble::channel_of(estimate, recording, "temperature_side")};
  if (two.top && two.side) return two;
  return {tumble::channel_of(estimate, recording, "temperature"), nullptr};
}

std::shared_ptr<ThermalRuns> thermal_runs(const Estimate& estimate, const Recording& recording,
                                          const ThermalReading& reading) {
  const thermal::Sensors sensors = sensors_of(estimate, recording);
  Problems problems;
  for (const Channel* sensor : {sensors.top, sensors.side}) require_dimension(sensor, "degC", problems);
  refuse(recording, problems);
  for (const Channel* sensor : {sensors.top, sensors.side})
    if (sensor) thermal::refuse_backward(*sensor);
  ThermalRuns all{runs_of({recording}), sensors, reading, "channel " + sensors.top->name};
  if (sensors.side) all.from += ", channel " + sensors.side->name;
  return std::make_shared<ThermalRuns>(std::move(all));
}

/// Everything that `Inputs::fill` asks.
struct Sources {
  const Recording* recording;
  const Channel* output;
  std::vector<const Channel*> channels;  ///< by slot
  std::shared_ptr<const Planned> test;
  std::shared_ptr<ThermalRuns> warm;
  double step = 0.0;

  void operator()(std::size_t i, std::span<double> values) const {
    const double time = output->time(i);
    Felt felt = test ? felt_at(test->stages, time, step) : Felt{};
    if (!test) felt.since_power_on = time - power_on(*recording, *output, time) + 0.5 * step;
    std::ranges::copy(std::bit_cast<std::array<double, felt_inputs>>(felt), values.begin());
    for (std::size_t k = 0; k < channels.size(); ++k)
      if (channels[k]) values[k] = is_acceleration(k) ? slope_at(*channels[k], time) : value_at(*channels[k], time);
    if (warm) warm->fill(time, values);
  }
};

}  // namespace

bool needs(const OutputModel& model, Input input) {
  return std::ranges::any_of(model.terms, [&](const ModelTerm& term) {
    return std::ranges::any_of(term.regressor, [&](const Product& product) {
      return std::ranges::find(product.factors, input, &TermFactor::input) != product.factors.end();
    });
  });
}

void require_sensors(const Estimate& estimate, const Recording& recording, const OutputModel& model) {
  if (!model.thermal) return;
  const thermal::Sensors sensors = sensors_of(estimate, recording);
  Problems problems;
  if (!sensors.top)
    problems.emplace_back("the recording has no channel for temperature (or temperature_top and temperature_side)");
  if (!sensors.side && needs(model, Input::temperature_gradient))
    problems.emplace_back(
        "the result uses the temperature gradient: the recording needs temperature_top and temperature_side");
  refuse(recording, problems);
}

std::vector<Slot> common_slots() {
  std::vector<Slot> all(common_slot_count);
  for (std::size_t k = 0; k < all.size(); ++k) all[k].input = static_cast<Input>(k);
  return all;
}

Inputs inputs_of(const Estimate& estimate, const Recording& recording, const Channel& output, const Plan* plan,
                 const std::vector<Slot>& slots, const std::optional<ThermalReading>& thermal) {
  Inputs out;
  out.from.resize(slots.size());
  out.planned.resize(slots.size());
  Sources sources{&recording, &output, std::vector<const Channel*>(slots.size()),
                  nullptr,    nullptr, 1.0 / sampling_rate(output)};
  for (std::size_t k = 0; k < slots.size(); ++k) {
    if (slots[k].base != SIZE_MAX) continue;
    sources.channels[k] =
        channel_of(estimate, recording, output, is_acceleration(k) ? slots[k - acceleration] : slots[k]);
    if (sources.channels[k])
      out.from[k] = (is_acceleration(k) ? "slope of channel " : "channel ") + sources.channels[k]->name;
    out.planned[k] = !sources.channels[k] && plan && k < felt_inputs;
    if (out.planned[k]) out.from[k] = "schedule of the plan";
  }
  if (out.from[since_power_on].empty()) out.from[since_power_on] = "time of the samples";
  if (plan) sources.test = std::make_shared<const Planned>(planned_for(*plan, recording, output));
  if (thermal) sources.warm = thermal_runs(estimate, recording, *thermal);
  for (std::size_t k = temperature; sources.warm && k < felt_inputs; ++k) out.from[k] = sources.warm->from;
  if (sources.warm && !sources.warm->sensors.side) out.from[index(Input::temperature_gradient)].clear();
  for (std::size_t k = 0; k < slots.size(); ++k)
    if (slots[k].base != SIZE_MAX) out.from[k] = out.from[slots[k].base];
  if (sources.warm && sources.warm->reading.averaging > 0.0)
    out.average = [warm = sources.warm, &output](std::size_t i, std::span<double> values) {
      warm->average(output.time(i), values);
    };
  out.fill = std::move(sources);
  return out;
}

}  // namespace tumble::compensation
