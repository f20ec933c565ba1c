#include <algorithm>
#include <utility>

#include "tumble/rehearsal/soak.hpp"
#include "tumble/rehearsal/virtual_rig/bench.hpp"
#include "tumble/units/error.hpp"

namespace tumble::virtual_rig {
namespace {

/// The number of a power-up and the samples that the plan has for it; beyond the plan, as long as the longest.
PlannedRun planned_run(const std::vector<PlannedRun>& planned, int power_up, double begin) {
  PlannedRun run{power_up, begin, 0, {}};
  const auto index = static_cast<std::size_t>(power_up - 1);
  if (index < planned.size()) {
    run.run = planned[index].run;
    run.samples = planned[index].samples;
  } else if (!planned.empty()) {
    run.run = planned.back().run + power_up - static_cast<int>(planned.size());
    for (const auto& one : planned) run.samples = std::max(run.samples, one.samples);
  }
  run.samples = std::max<std::size_t>(1, run.samples);
  return run;
}

bool mentions(const std::vector<PlannedRun>& planned, int run, const std::string& axis) {
  return std::ranges::any_of(planned, [&](const PlannedRun& one) {
    return one.run == run && std::ranges::any_of(one.segments, [&](const Segment& s) { return s.axes.contains(axis); });
  });
}

}  // namespace

void Bench::start_course(double time, int run) {
  Segment first{"", 0.0, run, {}};
  for (const auto& [name, controller] : axes)
    if (controller.told) first.axes.emplace(name, standstill(time, name));
  // an oven that will be used regulates from the beginning
  if (axes.contains("temperature") && !control("temperature").told && mentions(planned, run, "temperature"))
    first.axes.emplace("temperature", Motion{.value = plan->rig.number("temperature")});
  for (auto& [name, controller] : axes) {  // it begins where all turns are counted
    const double turns = std::exchange(controller.whole_turns, 0.0);
    if (controller.demand.kind == Motion::Kind::slew) controller.demand.to += turns;
    if (controller.demand.kind == Motion::Kind::hold) controller.demand.value += turns;
  }
  const std::size_t id = courses.empty() ? 0 : courses.rbegin()->first + 1;
  courses.emplace(id, Course(plan, random, run, time, std::move(first)));
  std::erase_if(courses, [&](const auto& entry) {
    return entry.first != id &&
           std::ranges::none_of(units, [&](const Powered& unit) { return unit.course == entry.first; });
  });
}

/// Whether instruments that were off have the temperature of the air.
bool Bench::is_soaked(double time) const {
  constexpr double within = 0.05;  // [K]
  return time - soaks_since >= soak_time_of(*plan, within);
}

void Bench::place(double time, const std::map<std::string, double>& values) {
  advance(time);
  if (on) throw Error(Error::Kind::bad_input, "axes are placed while the instruments are off");
  for (const auto& [axis, value] : values) {
    AxisControl& controller = control(axis);
    ++controller.commands;
    controller.demand = {.kind = controller.is_air() ? Motion::Kind::dwell : Motion::Kind::hold, .value = value};
    controller.told = true;
  }
  soaks_since = -HUGE_VAL;
  start_course(time, 0);
}

void Bench::power(double time, bool to) {
  advance(time);
  if (to == on) return;
  on = to;
  if (!on) {
    soaks_since = time;
    return units.back().unit.end(time);
  }
  ++power_ups;
  const PlannedRun run = planned_run(planned, power_ups, time);
  const bool stands = std::ranges::all_of(axes, [&](const auto& entry) {
    const DriveState state = drive(time, entry.first);
    return state.reached && state.rate == 0.0;
  });
  if (stands && is_soaked(time)) start_course(time, run.run);
  units.push_back({Unit(plan, random, run, power_ups, time - course().begin()), courses.rbegin()->first});
}

std::vector<VirtualSamples> Bench::samples(double time, std::size_t most) {
  advance(time);
  std::vector<VirtualSamples> out;
  for (auto& [unit, id] : units) {
    if (most == 0) break;
    auto block = unit.take(courses.at(id), std::min(unit.known(time, timing), unit.given() + most));
    most -= block.size();
    if (block.size() > 0) out.push_back(std::move(block));
    if (!unit.exhausted()) break;
  }
  while (!units.empty() && units.front().unit.exhausted() && (units.size() > 1 || !on)) units.pop_front();
  return out;
}

}  // namespace tumble::virtual_rig
