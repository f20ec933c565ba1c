#include "tumble/rehearsal/virtual_rig/bench.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/units/error.hpp"

namespace tumble::virtual_rig {
namespace {

constexpr double freezing = 273.15;
constexpr double room_temperature = freezing + 20.0;  ///< [K] of a chamber that nobody has told anything
constexpr double window = 0.2;                        ///< [s] over which a rate is read
constexpr std::size_t readings = 11;                  ///< in this window

void refuse_incomplete_plan(const Plan& plan) {
  Problems problems;
  if (plan.instrument_model.empty()) problems.emplace_back("a virtual rig needs [instrument] model = \"...\"");
  if (plan.rig_kind.empty()) problems.emplace_back("a virtual rig needs [rig] kind = \"...\"");
  if (!(plan.sample_rate > 0.0)) problems.emplace_back("a virtual rig needs [instrument] rate = \"1 Hz\" or the like");
  if (!plan.instrument_model.empty() && plan.truth.texts().empty())
    problems.emplace_back("a virtual rig needs [truth]");
  if (!plan.file.empty())
    for (auto& problem : problems) problem = in_file(plan.file, problem);
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

/// The slope of readings that are `step` apart.
double slope_of(const std::vector<double>& y, double step) {
  const double middle = 0.5 * static_cast<double>(y.size() - 1);
  double sum = 0.0, square = 0.0;
  for (std::size_t k = 0; k < y.size(); ++k) {
    const double x = static_cast<double>(k) - middle;
    sum += x * y[k];
    square += x * x;
  }
  return sum / (square * step);
}

const Sensor* sensor_of(const Reference& reference, const std::string& axis) {
  for (const auto& sensor : reference.sensors)
    if (sensor.channel.name == axis + "_angle" || sensor.channel.name == axis) return &sensor;
  return nullptr;
}

}  // namespace

bool AxisControl::turns() const { return std::ranges::find(axis.motions, Motion::Kind::rate) != axis.motions.end(); }

Bench::Bench(const Plan& given, std::uint64_t seed, SampleTiming when)
    : plan(std::make_shared<const Plan>(given)), random(seed), timing(when) {
  refuse_incomplete_plan(*plan);
  rig = &find_rig(plan->rig_kind);
  planned = tumble::power_ups(plan->schedule, plan->sample_rate);
  for (auto& axis : rig->axes()) {
    AxisControl control{.axis = axis};
    if (axis.name == "chamber") {  // a chamber always has a set point
      control.demand = {.kind = Motion::Kind::dwell, .value = room_temperature};
      control.told = true;
    }
    axes.emplace(axis.name, std::move(control));
  }
  start_course(0.0, 0);
}

AxisControl& Bench::control(const std::string& axis) {
  const auto found = axes.find(axis);
  if (found != axes.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& [name, control] : axes) names.push_back(name);
  throw Error(Error::Kind::bad_input, say("there is no axis '{}'; the rig has {}", axis, fmt::join(names, ", ")));
}

DriveState Bench::drive(double time, const std::string& axis) {
  const double since = time - course().begin();
  for (const auto& drive : course().reference(since).drives)
    if (drive.axis == axis) return drive.at(since);
  return {control(axis).demand.value, 0.0, true};
}

void Bench::advance(double time) {
  if (!(time >= now)) throw Error(Error::Kind::bad_input, say("time goes back from {} s to {} s", now, time));
  while (!later.empty() && later.begin()->first <= time) {
    const auto [when, what] = *later.begin();
    later.erase(later.begin());
    now = std::max(now, when);
    if (what.commands == control(what.axis).commands) carry(now, what);
  }
  now = time;
}

AxisReading Bench::reading(double time, const std::string& axis) {
  advance(time);
  const AxisControl& controller = control(axis);
  if (controller.frozen) return *controller.frozen;
  const DriveState state = drive(time, axis);
  AxisReading out{state.value,   state.rate,         !state.reached || state.rate != 0.0,
                  state.reached, controller.enabled, controller.fault};
  const double since = time - course().begin();
  const Sensor* sensor = sensor_of(course().reference(since), axis);
  if (!sensor) return out;
  const double step = std::min(window, since) / static_cast<double>(readings - 1);
  std::vector<double> shown(readings);
  if (step > 0.0) {
    sensor->read(since - step * static_cast<double>(readings - 1), step, shown);
    out.rate = slope_of(shown, step);
  }
  sensor->read(since, 1.0, std::span(shown).first(1));
  out.value = shown.front();
  if (controller.is_air()) out.rate = state.rate;  // a thermometer shows no slope in so short a time
  return out;
}

}  // namespace tumble::virtual_rig
