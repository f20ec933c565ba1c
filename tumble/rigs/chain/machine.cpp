#include "tumble/rigs/chain/machine.hpp"

#include <algorithm>

#include "tumble/rigs/chain/encoder.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::chain {
namespace {

using Kind = Motion::Kind;

/// "max_rate" on a rig with one axis, "outer_max_rate" on one with several.
std::string option_of(const Machine& machine, const MachineAxis& axis, const char* what) {
  return machine.axes.size() == 1 ? what : axis.name + "_" + what;
}

std::vector<Imperfection> present(const Machine& machine) {
  return joined({base_imperfections(), lever_imperfections("0.2 mm"), mount_imperfections(), machine.imperfections,
                 machine.oven ? oven_imperfections() : std::vector<Imperfection>{}});
}

AxisLimits limits_of(const Machine& machine, const MachineAxis& axis, const Settings& options) {
  AxisLimits limits{axis.name, options.number(option_of(machine, axis, "max_rate")),
                    options.number(option_of(machine, axis, "max_acceleration"))};
  const auto low = option_of(machine, axis, "lowest"), high = option_of(machine, axis, "highest");
  if (options.has(low)) limits.lowest = options.number(low);
  if (options.has(high)) limits.highest = options.number(high);
  return limits;
}

Profile driven(const RigRun& run, const AxisLimits& limits, const ErrorValues& errors) {
  DriveErrors drive{.rate = errors.where_present(error_names::rate_error_of + limits.axis),
                    .amplitude = errors.where_present(error_names::oscillation_amplitude_of + limits.axis)};
  for (std::size_t s = 0; s < run.segments.size(); ++s)
    drive.positioning.push_back(errors.where_present(error_names::positioning_of + limits.axis, s));
  return profile_of(run.segments, limits, drive, nullptr);
}

/// The two small turns by which the direction of an axis goes round, in the frame in which it would stand still.
std::vector<Joint> wobble(const Joint& joint, const std::string& axis, const ErrorValues& errors) {
  const std::string name = error_names::wobble_of + axis;
  std::vector<Harmonic> first, second;
  for (const int order : {1, 2}) {
    const std::string per_turn = order == 1 ? " once per turn, " : " twice per turn, ";
    const double c = errors.where_present(name + per_turn + "cosine"),
                 s = errors.where_present(name + per_turn + "sine");
    if (c == 0.0 && s == 0.0) continue;
    first.push_back({order, c, s});
    second.push_back({order, -s, c});
  }
  if (first.empty()) return {};
  const auto next = [](About about) { return about == About::x ? About::y : about == About::y ? About::z : About::x; };
  Joint a{.axis = joint.axis, .about = next(joint.about), .share = 0.0, .harmonics = first};
  Joint b{.axis = joint.axis, .about = next(a.about), .share = 0.0, .harmonics = second};
  return {a, b};
}

/// The joint of an axis with the errors of its scale, behind its wobble.
std::vector<Joint> with_axis_errors(Joint joint, const std::string& axis, int ripple_order, const ErrorValues& errors) {
  joint.zero = errors.where_present(error_names::index_zero_of + axis);
  const auto add = [&](int order, double cosine, double sine) {
    if (cosine != 0.0 || sine != 0.0) joint.harmonics.push_back({order, cosine, sine});
  };
  for (const int order : {1, 2}) {
    const std::string name =
        error_names::angle_error_of + axis + (order == 1 ? " once per turn, " : " twice per turn, ");
    add(order, errors.where_present(name + "cosine"), errors.where_present(name + "sine"));
  }
  // d(th')/th' = c cos(n th) + s sin(n th) is an angle of (c sin(n th) - s cos(n th))/n
  const double c = errors.where_present(error_names::rate_ripple_of + axis + ", cosine"),
               s = errors.where_present(error_names::rate_ripple_of + axis + ", sine");
  add(ripple_order, -s / ripple_order, c / ripple_order);
  std::vector<Joint> out = wobble(joint, axis, errors);
  if (!out.empty()) {
    std::swap(out.front().offset, joint.offset);
    std::swap(out.front().stretch, joint.stretch);
    std::swap(out.front().fixed, joint.fixed);
  }
  out.push_back(joint);
  return out;
}

Chain chain_of(const Machine& machine, const RigRun& run, const ErrorValues& errors) {
  Chain chain;
  chain.base = base_from_level(errors);
  chain.ground = seen_in(chain.base, ground_of(run.site, errors(error_names::gravity), errors(error_names::latitude)));
  for (const auto& axis : machine.axes)
    chain.axes.push_back(driven(run, limits_of(machine, axis, run.options), errors));
  const int ripple_order = run.options.has("ripple_order") ? run.options.integer("ripple_order") : 1;
  for (const auto& joint : machine.joints(run.options, errors)) {
    if (joint.axis < 0) {
      chain.joints.push_back(joint);
      continue;
    }
    const auto& axis = machine.axes[static_cast<std::size_t>(joint.axis)].name;
    for (const auto& part : with_axis_errors(joint, axis, ripple_order, errors)) chain.joints.push_back(part);
  }
  // The first joint's constant part belongs to the base.
  chain.base = chain.joints.front().fixed * chain.base;
  chain.ground = seen_in(chain.joints.front().fixed, chain.ground);
  chain.joints.front().fixed = {};
  chain.lever = {run.options.number("lever_x") + errors(error_names::lever_x),
                 run.options.number("lever_y") + errors(error_names::lever_y),
                 run.options.number("lever_z") + errors(error_names::lever_z)};
  chain.poses = poses_of(run.segments, errors);
  chain.temperature = run.options.number("temperature");
  if (machine.oven) chain.oven = oven_of(run.segments, run.options, errors);
  return chain;
}

/// The axes of the machine and its oven as their controllers know them.
std::vector<Drive> drives_of(const Machine& machine, const RigRun& run, const std::shared_ptr<const Chain>& chain) {
  std::vector<Drive> drives;
  const auto segment = segment_at(run.segments);
  for (std::size_t a = 0; a < machine.axes.size(); ++a)
    drives.push_back({machine.axes[a].name, [=](double time) {
                        std::size_t piece = 0;
                        const Turn turn = at(chain->axes[a], time, piece);
                        return DriveState{turn.angle, turn.rate, time >= chain->axes[a].settled[segment(time)]};
                      }});
  for (const auto& axis : mount_axes())
    drives.push_back({axis.name, [last = last_value(run.segments, axis.name)](double time) {
                        return DriveState{last(time), 0.0, true};
                      }});
  if (!machine.oven) return drives;
  drives.push_back({oven_axis().name, [chain, segment](double time) {
                      const Oven& oven = chain->oven;
                      if (oven.pieces.empty()) return DriveState{chain->temperature, 0.0, true};
                      std::size_t piece = 0;
                      const Warmth now = at(oven, time, piece);
                      return DriveState{shown_by(oven, now.temperature), now.rate, time >= oven.settled[segment(time)]};
                    }});
  return drives;
}

/// What each axis turns, and the instrument.
std::vector<RigPart> parts_of(const Machine& machine, const std::shared_ptr<const Chain>& chain) {
  std::vector<RigPart> parts;
  for (std::size_t j = 0; j < chain->joints.size(); ++j) {
    const Joint& joint = chain->joints[j];
    if (joint.axis < 0 || joint.share == 0.0) continue;
    parts.push_back({machine.axes[static_cast<std::size_t>(joint.axis)].name, direction_of(joint.about), false,
                     [chain, j](double time) { return joint_at(*chain, j, time); }});
  }
  parts.push_back({"instrument", {}, false, [chain](double time) { return instrument_at(*chain, time); }});
  return parts;
}

void check_options(const Machine& machine, const Settings& options, Problems& problems) {
  for (const auto& axis : machine.axes) {
    const auto low = option_of(machine, axis, "lowest"), high = option_of(machine, axis, "highest");
    if (options.has(low) && options.has(high)) check_order(options, low, high, problems);
  }
  if (machine.oven) check_oven(options, problems);
}

}  // namespace

std::vector<Axis> axes_of(const Machine& machine) {
  std::vector<Axis> axes;
  for (const auto& axis : machine.axes) axes.push_back({axis.name, "deg", axis.motions, axis.description});
  for (auto& axis : mount_axes()) axes.push_back(std::move(axis));
  if (machine.oven) axes.push_back(oven_axis());
  return axes;
}

std::vector<Option> options_of(const Machine& machine) {
  std::vector<Option> options = machine.geometry;
  for (const auto& axis : machine.axes) {
    const auto named = [&](const char* what) { return option_of(machine, axis, what); };
    options.push_back(
        quantity(named("max_rate"), "deg/s").above(0).otherwise(axis.max_rate).says("highest rate of " + axis.name));
    options.push_back(quantity(named("max_acceleration"), "deg/s^2")
                          .above(0)
                          .otherwise(axis.max_acceleration)
                          .says("acceleration with which " + axis.name + " changes its rate"));
    if (!axis.stops) continue;
    options.push_back(quantity(named("lowest"), "deg").says("stop of " + axis.name + "; absent: none"));
    options.push_back(quantity(named("highest"), "deg").says("stop of " + axis.name + "; absent: none"));
  }
  for (auto& option : lever_options("0 mm", "0 mm", "0 mm")) options.push_back(std::move(option));
  for (auto& option : laboratory_options()) options.push_back(std::move(option));
  for (const auto& imperfection : present(machine)) options.push_back(imperfection.option);
  if (std::any_of(options.begin(), options.end(), [](const Option& o) { return o.name == "rate_ripple_sd"; }))
    options.push_back(
        integer("ripple_order").between(1, 10000).otherwise("12").says("periods of the rate ripple in one turn"));
  options.push_back(quantity("encoder_noise", "arcsec")
                        .at_least(0)
                        .otherwise("0.1 arcsec")
                        .says("standard deviation of one reading"));
  options.push_back(
      quantity("encoder_quantum", "deg").at_least(0).otherwise("0.0001 deg").says("step of the readings; 0: none"));
  if (machine.oven)
    for (auto& option : oven_options()) options.push_back(std::move(option));
  return options;
}

std::vector<RigError> errors_of(const Machine& machine, const Settings& options, const std::optional<Site>& site) {
  return errors_of(present(machine), options, site);
}

Problems refusals_of(const Machine& machine, const Schedule& schedule, const Settings& options) {
  Problems problems;
  check_options(machine, options, problems);
  const bool bounded = problems.empty();
  if (!check_axes(axes_of(machine), schedule, problems) || !bounded) return problems;
  for (const auto& run : runs_of(schedule))
    for (const auto& axis : machine.axes) profile_of(run, limits_of(machine, axis, options), {}, &problems);
  if (machine.oven) check_oven_schedule(schedule, options, problems);
  return problems;
}

Reference reference_of(const Machine& machine, const RigRun& run) {
  const auto list = errors_of(machine, run.options, run.site);
  const ErrorValues errors(list, run.errors);
  const auto chain = std::make_shared<const Chain>(chain_of(machine, run, errors));
  Reference out;
  out.felt = [chain](double first, double step, std::span<Felt> samples) { felt(*chain, first, step, samples); };
  out.steady_until = [chain](double time) { return steady_until(*chain, time); };
  for (std::size_t s = 0; s < run.segments.size(); ++s) {
    double settled = 0.0;
    for (const auto& axis : chain->axes) settled = std::max(settled, axis.settled[s]);
    if (s < chain->oven.settled.size()) settled = std::max(settled, chain->oven.settled[s]);
    out.settled.push_back(settled);
  }
  out.drives = drives_of(machine, run, chain);
  out.parts = parts_of(machine, chain);
  const bool ideal = run.options.flag("ideal");
  for (std::size_t a = 0; a < machine.axes.size(); ++a)
    out.sensors.push_back(encoder(machine.axes[a].name + "_angle", chain, a,
                                  ideal ? 0.0 : run.options.number("encoder_noise"),
                                  ideal ? 0.0 : run.options.number("encoder_quantum"), run.rate, run.random));
  if (machine.oven)
    out.sensors.push_back(thermometer(chain, ideal ? 0.0 : run.options.number("thermometer_noise"),
                                      ideal ? 0.0 : run.options.number("thermometer_quantum"), run.rate, run.random));
  return out;
}

}  // namespace tumble::chain
