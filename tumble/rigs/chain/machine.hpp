#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/rigs/chain/carrier.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::chain {

/// A driven axis of a machine.
struct MachineAxis {
  std::string name;
  std::string description;
  std::vector<Motion::Kind> motions;
  const char* max_rate;  ///< default, as a user writes it
  const char* max_acceleration;
  bool stops = true;  ///< may be given limits of travel
};

/// A rig made of turning axes that carries the instrument on a fixture. From this description follow its axes, options,
/// errors, refusals and what is felt.
struct Machine {
  std::vector<MachineAxis> axes;
  std::vector<Option> geometry;
  std::vector<Imperfection> imperfections;
  /// From the base to the fixture, with the errors of the geometry; index, scale and wobble are added to them.
  std::vector<Joint> (*joints)(const Settings& options, const ErrorValues& errors);
  bool oven = false;  ///< an oven about the instrument: axis and channel `temperature`
};

/// Index zero, positioning and wobble of each of these axes.
std::vector<Imperfection> axis_imperfections(const std::vector<std::string>& axes);
/// Rate error and rate ripple of each of these axes.
std::vector<Imperfection> drive_imperfections(const std::vector<std::string>& axes);
/// Amplitude of the oscillations of each of these axes.
std::vector<Imperfection> oscillation_imperfections(const std::vector<std::string>& axes);

std::vector<Axis> axes_of(const Machine& machine);
std::vector<Option> options_of(const Machine& machine);
std::vector<RigError> errors_of(const Machine& machine, const Settings& options, const std::optional<Site>& site);
Problems refusals_of(const Machine& machine, const Schedule& schedule, const Settings& options);
Reference reference_of(const Machine& machine, const RigRun& run);

/// The catalogue entry of a machine.
template <const Machine& (*machine)()>
constexpr Rig rig_of(const char* name, const char* summary) {
  return {.name = name,
          .summary = summary,
          .axes = [] { return axes_of(machine()); },
          .options = [] { return options_of(machine()); },
          .errors = [](const Settings& options,
                       const std::optional<Site>& site) { return errors_of(machine(), options, site); },
          .reference = [](const RigRun& run) { return reference_of(machine(), run); },
          .refusals = [](const Schedule& schedule,
                         const Settings& options) { return refusals_of(machine(), schedule, options); }};
}

}  // namespace tumble::chain
