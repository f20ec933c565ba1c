#include "tumble/tasks/identity.hpp"

#include <algorithm>

#include "tumble/core/unit_facts.hpp"
#include "tumble/language/say.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// The unit that a recording says it is of.
struct RecordedUnit {
  std::string serial;
  const Recording* recording = nullptr;
};

std::string given_as(const Plan& plan, const char* key) {
  const auto found = plan.command_line.find(key);
  return found == plan.command_line.end() ? "" : found->second;
}

/// Recordings by a plan for another instrument are of parts of the unit, which have numbers of their own.
std::vector<const Recording*> of_the_unit(const Evidence& evidence) {
  std::vector<const Recording*> recordings;
  for (std::size_t i = 0; i < evidence.recordings.size(); ++i) {
    const Plan& plan = plan_of(evidence, i);
    const bool same = plan.instrument_model == evidence.plan.instrument_model &&
                      plan.instrument_serial == evidence.plan.instrument_serial;
    if (&plan == &evidence.plan || same) recordings.push_back(&evidence.recordings[i]);
  }
  return recordings;
}

void refuse_other_slots(const std::string& slot, const std::vector<const Recording*>& recordings) {
  if (slot.empty()) return;
  Problems problems;
  for (const Recording* recording : recordings)
    if (const auto slots = recorded_slots(*recording); !slots.empty() && !std::ranges::count(slots, slot))
      problems.push_back(
          say("{} is of slot {}, and not of {}", Name{recording->origin.file}, Name{slots.front()}, Name{slot}));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

}  // namespace

UnitIdentity unit_of(const Evidence& evidence) {
  const Plan& plan = evidence.plan;
  const std::string given = given_as(plan, serial_key), slot = given_as(plan, slot_key);
  const auto recordings = of_the_unit(evidence);
  refuse_other_slots(slot, recordings);
  RecordedUnit first;
  for (const Recording* recording : recordings) {
    const std::string serial = recorded_serial(*recording, slot);
    if (serial.empty()) continue;
    if (!given.empty() && serial != given)
      throw Error(Error::Kind::bad_input,
                  say("--unit {}: {} is of unit {}", Name{given}, Name{recording->origin.file}, Name{serial}));
    if (first.recording != nullptr && serial != first.serial)
      throw Error(Error::Kind::bad_data, say("the recordings are of different units: {} is of {}, and {} of {}",
                                             Name{first.recording->origin.file}, Name{first.serial},
                                             Name{recording->origin.file}, Name{serial}));
    first = {serial, recording};
  }
  if (first.serial.empty()) return {plan.instrument_serial, {}};
  UnitIdentity unit{first.serial, {}};
  if (!plan.instrument_serial.empty() && plan.instrument_serial != unit.serial &&
      !was_run_by(*first.recording, plan.sha256))
    unit.findings.push_back({Finding::Severity::warning,
                             "serial_of_recording",
                             {{"recorded", unit.serial}, {"planned", plan.instrument_serial}},
                             first.recording->origin.file});
  return unit;
}

}  // namespace tumble
