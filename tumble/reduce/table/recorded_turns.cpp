#include "tumble/reduce/table/recorded_turns.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tumble/reduce/table/axis_record.hpp"
#include "tumble/reduce/table/encoders.hpp"

namespace tumble::table {
namespace {

/// A method that has this option compares the angles at which the axes stand by itself, see with_recorded_angles.
constexpr const char* compares_stands = "angle_tolerance";

/// All axes of a recording that have an encoder.
AxisFound found_in(const Plan& plan, const Conducted& test, const std::vector<Encoder>& encoders,
                   const std::vector<MarkedSegment>& marks) {
  AxisFound all;
  const auto places = places_of(marks, settled_after(test));
  for (const auto& encoder : encoders) {
    AxisFound one = found_of({plan, test, encoder, places}, !plan.settings.has(compares_stands));
    std::ranges::move(one.turned, std::back_inserter(all.turned));
    std::ranges::move(one.findings, std::back_inserter(all.findings));
  }
  return all;
}

/// Recordings that can share a plan.
struct Sharing {
  const Plan* plan = nullptr;
  std::vector<std::size_t> recordings = {};
  std::vector<Turned> turned = {};
  Findings findings = {};

  bool admits(const std::vector<Turned>& more) const {
    return std::ranges::none_of(more, [&](const Turned& one) {
      return std::ranges::any_of(turned, [&](const Turned& other) {
        return one.segment == other.segment && one.axis == other.axis && (one.motion || other.motion);
      });
    });
  }
};

void share(const Plan& plan, std::size_t recording, const AxisFound& found, std::vector<Sharing>& all) {
  auto sharing =
      std::ranges::find_if(all, [&](const Sharing& one) { return one.plan == &plan && one.admits(found.turned); });
  if (sharing == all.end()) sharing = all.insert(all.end(), Sharing{&plan});
  sharing->recordings.push_back(recording);
  sharing->turned.insert(sharing->turned.end(), found.turned.begin(), found.turned.end());
  sharing->findings.insert(sharing->findings.end(), found.findings.begin(), found.findings.end());
}

Plan with_turns(const Sharing& sharing) {
  Plan plan = *sharing.plan;
  for (const auto& turned : sharing.turned)
    if (turned.motion) plan.schedule[turned.segment].axes[turned.axis] = *turned.motion;
  return plan;
}

/// Motions that are other than planned in one way: how many, the first, and the one that departs most.
struct Others {
  Occurrences found{0, {}, {}};
  const Turned* worst = nullptr;
  const Plan* plan = nullptr;
  bool beyond_rig = false;

  void add(const Plan& of, const Turned& turned) {
    const std::string& label = of.schedule[turned.segment].label;
    if (found.count++ == 0) found.first = label;
    beyond_rig = beyond_rig || turned.beyond_rig;
    if (worst != nullptr && std::abs(turned.departure) <= std::abs(worst->departure)) return;
    worst = &turned;
    plan = &of;
    found.worst = label;
  }
};

/// What is said of them. A warning where neither the rig, as the plan states it, nor two clocks explain it.
Finding said_of(Turned::Other other, const Others& others) {
  using Severity = Finding::Severity;
  const Severity severity = others.beyond_rig ? Severity::warning : Severity::info;
  const Turned& worst = *others.worst;
  const Motion& planned = others.plan->schedule[worst.segment].axes.at(worst.axis);
  const std::string& label = others.found.worst.label;
  switch (other) {
    case Turned::Other::rate:
      return {severity,
              "turn_rate_recorded",
              {{"segment", label},
               {"axis", worst.axis},
               {"recorded", worst.motion->value, "deg/s"},
               {"planned", planned.value, "deg/s"},
               {"departure", worst.departure, "ppm"}},
              "",
              others.found};
    case Turned::Other::oscillation:
      return {severity,
              "oscillation_recorded",
              {{"segment", label},
               {"axis", worst.axis},
               {"recorded", std::abs(worst.motion->amplitude), "deg"},
               {"planned", std::abs(planned.amplitude), "deg"},
               {"recorded_frequency", worst.motion->frequency, "Hz"},
               {"planned_frequency", planned.frequency, "Hz"}},
              "",
              others.found};
    case Turned::Other::angle:
      return {severity,
              "angle_off_plan",
              {{"segment", label},
               {"axis", worst.axis},
               {"recorded", worst.motion->value, "deg"},
               {"commanded", planned.value, "deg"}},
              "",
              others.found};
    case Turned::Other::phase:
      break;
  }
  return {Severity::info, "turn_phase_recorded", {{"segment", others.found.first.label}}, "", others.found};
}

/// The axis that a finding names.
std::string axis_of(const Finding& finding) {
  for (const FindingValue& value : finding.values)
    if (value.name == "axis") return std::get<std::string>(value.value);
  return {};
}

/// Each code once for an axis.
void add_once(const Findings& each, Findings& findings) {
  for (const Finding& one : each) {
    const auto same = std::ranges::find_if(
        findings, [&](const Finding& other) { return other.code == one.code && axis_of(other) == axis_of(one); });
    if (same == findings.end()) findings.push_back(one);
  }
}

Findings said_of(const std::vector<Sharing>& all) {
  std::map<Turned::Other, Others> found;
  Findings findings;
  for (const auto& sharing : all) {
    for (const auto& turned : sharing.turned)
      if (turned.motion) found[turned.other].add(*sharing.plan, turned);
    add_once(sharing.findings, findings);
  }
  for (const auto& [other, others] : found) findings.push_back(said_of(other, others));
  return findings;
}

}  // namespace

RecordedTurns recorded_turns(const Evidence& evidence) {
  ConductedTests tests;
  std::vector<Sharing> all;
  const auto marks = marked_segments(evidence);
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    const Plan& plan = plan_of(evidence, r);
    const auto encoders = plan.rig_kind.empty() ? std::vector<Encoder>{} : encoders_of(evidence, r);
    if (encoders.empty()) continue;
    const Conducted& test = tests.of(plan, marks[r], recorded_alone(evidence, r));
    share(plan, r, found_in(plan, test, encoders, marks[r]), all);
  }
  RecordedTurns out{{}, {}, said_of(all)};
  if (out.findings.empty()) return out;
  out.plan = evidence.plan;
  out.plans = evidence.plans;
  out.plans.resize(evidence.recordings.size());
  bool first = true;
  for (const auto& sharing : all) {
    if (std::ranges::none_of(sharing.turned, [](const Turned& turned) { return turned.motion.has_value(); })) continue;
    const bool of_test = sharing.plan == &evidence.plan && std::exchange(first, false);
    if (of_test) {
      out.plan = with_turns(sharing);
      continue;
    }
    const auto own = std::make_shared<const Plan>(with_turns(sharing));
    for (const std::size_t r : sharing.recordings) out.plans[r] = own;
  }
  return out;
}

}  // namespace tumble::table
