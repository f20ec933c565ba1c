#include "tumble/reduce/compensation/inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <set>
#include <utility>

#include "tumble/core/evidence.hpp"
#include "tumble/core/roles.hpp"
#include "tumble/core/sampling_rate.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/units/error.hpp"

namespace tumble::compensation {
namespace {

constexpr std::size_t acceleration = 3, force = 6, temperature = 9, since_power_on = 13;

const Channel* alone_after_dot(const Recording& recording, const std::string& name) {
  const Channel* match = nullptr;
  for (const Channel& channel : recording.channels) {
    if (!channel.name.ends_with("." + name)) continue;
    if (match) return nullptr;
    match = &channel;
  }
  return match;
}

QuantityKind kind_of_input(std::size_t input) {
  if (input < acceleration) return QuantityKind::angular_rate;
  if (input >= force && input < temperature) return QuantityKind::specific_force;
  return input == temperature ? QuantityKind::temperature : QuantityKind::other;
}

/// The channel that measures an input. Null where there is none, or what is so called is of another kind.
const Channel* channel_of(const Estimate& estimate, const Recording& recording, const Channel& output,
                          std::size_t input) {
  const std::string role = inputs()[input].name;
  std::vector<std::string> names{role};
  if (const auto given = estimate.provenance.settings.find("channels." + role);
      given != estimate.provenance.settings.end())
    names.insert(names.begin(), given->second);
  const auto play = [&](const std::string& sensor) {
    for (auto& name : names_of_role(sensor + role.substr(role.size() - 1))) names.push_back(std::move(name));
  };
  if (input < acceleration) play("gyro_");
  if (input >= force && input < temperature) play("accelerometer_");
  for (const auto& name : names) {
    const Channel* channel = find_channel(recording, name);
    if (!channel) channel = alone_after_dot(recording, name);
    if (channel && channel != &output && channel->kind == kind_of_input(input)) return channel;
  }
  return nullptr;
}

/// Between the samples on both sides; the first and last value beyond the ends.
double value_at(const Channel& channel, double time) {
  if (channel.values.empty()) return std::nan("");
  const std::size_t i = index_at(channel, time);
  if (i >= channel.values.size()) return channel.values.back();
  const double after = channel.time(i);
  if (after == time || i == 0) return channel.values[i];
  const double before = channel.time(i - 1), share = (time - before) / (after - before);
  return (1.0 - share) * channel.values[i - 1] + share * channel.values[i];
}

/// Difference quotient over one sample to each side.
double slope_at(const Channel& channel, double time) {
  const std::size_t n = channel.values.size();
  if (n < 2) return std::nan("");
  const std::size_t i = std::min(index_at(channel, time), n - 1);
  const std::size_t a = i == 0 ? 0 : i - 1, b = std::min(i + 1, n - 1);
  return (channel.values[b] - channel.values[a]) / (channel.time(b) - channel.time(a));
}

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
  Felt felt;
  for (const auto& input : inputs()) input.of(felt) = std::nan("");
  return felt;
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

}  // namespace

const std::array<Input, input_count>& inputs() {
  static constexpr std::array<Input, input_count> all{
      {{"rate_x", [](Felt& f) -> double& { return f.rate.x; }},
       {"rate_y", [](Felt& f) -> double& { return f.rate.y; }},
       {"rate_z", [](Felt& f) -> double& { return f.rate.z; }},
       {"angular_acceleration_x", [](Felt& f) -> double& { return f.angular_acceleration.x; }},
       {"angular_acceleration_y", [](Felt& f) -> double& { return f.angular_acceleration.y; }},
       {"angular_acceleration_z", [](Felt& f) -> double& { return f.angular_acceleration.z; }},
       {"specific_force_x", [](Felt& f) -> double& { return f.specific_force.x; }},
       {"specific_force_y", [](Felt& f) -> double& { return f.specific_force.y; }},
       {"specific_force_z", [](Felt& f) -> double& { return f.specific_force.z; }},
       {"temperature", [](Felt& f) -> double& { return f.temperature; }},
       {"temperature_gradient", [](Felt& f) -> double& { return f.temperature_gradient; }},
       {"temperature_rate", [](Felt& f) -> double& { return f.temperature_rate; }},
       {"start_temperature", [](Felt& f) -> double& { return f.start_temperature; }},
       {"since_power_on", [](Felt& f) -> double& { return f.since_power_on; }}}};
  return all;
}

std::array<bool, input_count> needs(const Term& term) {
  constexpr double sizes[input_count] = {0.7, 0.5, 0.9, 1.1, 0.6, 0.8, 9.0, 7.0, 11.0, 300.0, 3.0, 0.02, 290.0, 400.0};
  constexpr double signs[4][3] = {{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}};
  std::array<bool, input_count> needed{};
  for (const auto& sign : signs) {
    Felt felt;
    for (std::size_t k = 0; k < input_count; ++k)
      inputs()[k].of(felt) = sizes[k] * (k < temperature ? sign[k % 3] : 1.0);
    const double before = term.regressor(felt);
    for (std::size_t k = 0; k < input_count; ++k) {
      Felt changed = felt;
      inputs()[k].of(changed) *= 1.3;
      if (term.regressor(changed) != before) needed[k] = true;
    }
  }
  return needed;
}

Inputs inputs_of(const Estimate& estimate, const Recording& recording, const Channel& output, const Plan* plan) {
  Inputs out;
  std::array<const Channel*, input_count> channels{};
  for (std::size_t k = 0; k < input_count; ++k) {
    channels[k] = channel_of(estimate, recording, output, k < acceleration || k >= force ? k : k - acceleration);
    if (channels[k]) out.from[k] = "channel " + channels[k]->name;
    if (channels[k] && k >= acceleration && k < force) out.from[k] = "slope of " + out.from[k];
    if (!channels[k] && plan) out.from[k] = "schedule of the plan";
  }
  if (out.from[since_power_on].empty()) out.from[since_power_on] = "time of the samples";
  std::shared_ptr<const Planned> test;
  if (plan) test = std::make_shared<const Planned>(planned_for(*plan, recording, output));
  const double step = 1.0 / sampling_rate(output);
  out.fill = [channels, test, step, &recording, &output](std::size_t first, std::span<Felt> felt) {
    for (std::size_t i = 0; i < felt.size(); ++i) {
      const double time = output.time(first + i);
      felt[i] = test ? felt_at(test->stages, time, step) : Felt{};
      if (!test) felt[i].since_power_on = time - power_on(recording, output, time) + 0.5 * step;
      for (std::size_t k = 0; k < input_count; ++k)
        if (channels[k])
          inputs()[k].of(felt[i]) =
              k >= acceleration && k < force ? slope_at(*channels[k], time) : value_at(*channels[k], time);
    }
  };
  return out;
}

}  // namespace tumble::compensation
